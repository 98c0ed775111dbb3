// MuJoCo. The scene is written as the XML it reads.
// SPDX-License-Identifier: BSD-3-Clause
#include "benchmarks/work_precision/drivers/features.hpp"
#include "benchmarks/work_precision/drivers/slab.hpp"
#include "benchmarks/work_precision/engines.hpp"

#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <mujoco/mujoco.h>
#include <numbers>
#include <sstream>
#include <stdexcept>

namespace bristle::work_precision {

using namespace bristle::detail;

namespace {

using scenes::Rotation;
using scenes::Scene;
using scenes::SceneBody;
using scenes::Vector;

std::string attribute(const char* name, std::initializer_list<double> values) {
  std::ostringstream text;
  text.precision(17);
  text << ' ' << name << "='";
  const char* separator = "";
  for (const double value : values) {
    text << separator << value;
    separator = " ";
  }
  text << '\'';
  return text.str();
}
std::string attribute(const char* name, const Vector& v) {
  return attribute(name, {v.x(), v.y(), v.z()});
}
std::string attribute(const char* name, const Rotation& q) {
  return attribute(name, {q.w(), q.x(), q.y(), q.z()});
}

/// Writes a scene as a model.
///
/// Settings: `def` Newton with a pyramidal cone; `ell` elliptic cone and impratio 10; `nosl` that
/// and 10 no-slip iterations; `hard` impratio 100, contacts as stiff as the step allows and no-slip
/// iterations; `rk4` Runge-Kutta; `cg` conjugate gradients, elliptic.
class ModelWriter {
 public:
  ModelWriter(const Scene& scene, double dt, const std::string& setting)
      : scene_(scene), dt_(dt), setting_(setting) {}

  [[nodiscard]] std::string write() {
    const bool is_hard = setting_ == "hard";
    const bool is_elliptic = is_hard || setting_ == "ell" || setting_ == "nosl" || setting_ == "cg";
    text_ << "<mujoco><compiler angle='radian' boundmass='0'/><option"
          << attribute("timestep", {dt_}) << attribute("gravity", scene_.gravity) << " solver='"
          << (setting_ == "cg" ? "CG" : "Newton") << "' integrator='"
          << (setting_ == "rk4" ? "RK4" : "Euler") << "' cone='"
          << (is_elliptic ? "elliptic" : "pyramidal") << '\''
          << attribute("impratio", {is_hard       ? 100.0
                                    : is_elliptic ? 10.0
                                                  : 1.0});
    if (is_hard || setting_ == "nosl") text_ << " noslip_iterations='10'";
    text_ << "/>";
    if (scene_.is_large) text_ << "<size njmax='9000' nconmax='3000' nstack='60000000'/>";
    text_ << "<default><geom condim='3'" << contact_attributes(is_hard) << "/></default>";
    write_meshes();
    text_ << "<worldbody>";
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      if (!scene_.bodies[i].moves()) {
        write_geom(i, true);
      } else if (parent_of(i) < 0) {
        write_body(i);
      }
    }
    text_ << "</worldbody></mujoco>";
    return text_.str();
  }

 private:
  [[nodiscard]] std::string contact_attributes(bool is_hard) const {
    if (scene_.restitution > 0) {
      // There is no restitution: a spring and damper that returns this part of the speed, as stiff
      // as the step allows.
      const double stiffness = std::fmin(1e6, std::pow(0.25 / dt_, 2));
      const double decay = std::log(scene_.restitution);
      const double ratio = -decay / std::hypot(std::numbers::pi, decay);
      return attribute("solimp", {0.9999, 0.9999, 0.001}) +
             attribute("solref", {-stiffness, -2 * ratio * std::sqrt(stiffness)});
    }
    if (!is_hard) return {};
    return attribute("solimp", {0.99, 0.9999, 0.001}) + attribute("solref", {2 * dt_, 1});
  }

  void write_meshes() {
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      const auto* mesh = std::get_if<TriangleMesh<double>>(&scene_.bodies[i].shape);
      if (mesh == nullptr) continue;
      text_ << "<asset><mesh name='mesh" << i << "' vertex='";
      text_.precision(17);
      for (const Vector& v : mesh->vertices) text_ << v.x() << ' ' << v.y() << ' ' << v.z() << ' ';
      text_ << "'/></asset>";
    }
  }

  [[nodiscard]] const scenes::SceneJoint* joint_of(std::size_t body) const {
    for (const scenes::SceneJoint& joint : scene_.joints) {
      if (joint.b == static_cast<int>(body)) return &joint;
    }
    return nullptr;
  }
  [[nodiscard]] int parent_of(std::size_t body) const {
    const scenes::SceneJoint* joint = joint_of(body);
    return joint != nullptr ? joint->a : -1;
  }

  void write_body(std::size_t i) {
    const SceneBody& body = scene_.bodies[i];
    const scenes::SceneJoint* joint = joint_of(i);
    Vector position = body.position;
    Rotation turn = body.orientation;
    if (joint != nullptr && joint->a >= 0) {
      const SceneBody& parent = scene_.bodies[static_cast<std::size_t>(joint->a)];
      position = parent.orientation.conjugate() * Vector(body.position - parent.position);
      turn = parent.orientation.conjugate() * body.orientation;
    }
    text_ << "<body name='body" << i << '\'' << attribute("pos", position)
          << attribute("quat", turn) << '>';
    if (joint != nullptr) {
      const Vector anchor = body.orientation.conjugate() * Vector(joint->anchor - body.position);
      text_ << "<joint type='ball'" << attribute("pos", anchor) << "/>";
    } else if (body.slides_along_x) {
      text_ << "<joint type='slide' axis='1 0 0'/>";
    } else {
      text_ << "<freejoint/>";
    }
    text_ << "<inertial pos='0 0 0'" << attribute("mass", {body.mass})
          << attribute("diaginertia", scenes::principal_inertia(body)) << "/>";
    write_geom(i, false);
    for (std::size_t k = i + 1; k < scene_.bodies.size(); ++k) {
      if (parent_of(k) == static_cast<int>(i)) write_body(k);
    }
    text_ << "</body>";
  }

  void write_geom(std::size_t i, bool is_placed) {
    const SceneBody& body = scene_.bodies[i];
    const double friction = body.friction_if_maximum.value_or(body.friction * body.friction);
    text_ << "<geom" << attribute("friction", {friction, 0, 0});
    Vector position = body.position;
    Rotation turn = body.orientation;
    if (const auto* ball = std::get_if<Sphere<double>>(&body.shape)) {
      text_ << " type='sphere'" << attribute("size", {ball->radius});
    } else if (const auto* box = std::get_if<Box<double>>(&body.shape)) {
      text_ << " type='box'" << attribute("size", box->half_extents);
    } else if (const auto* disk = std::get_if<Cylinder<double>>(&body.shape)) {
      text_ << " type='cylinder'" << attribute("size", {disk->radius, disk->half_length});
    } else if (const auto* ground = std::get_if<HalfSpace<double>>(&body.shape)) {
      text_ << " type='plane' size='0 0 1'";
      position = ground->offset * ground->normal;
      turn = slab_of(*ground).orientation;
    } else {
      text_ << " type='mesh' mesh='mesh" << i << '\'';
    }
    // Two shapes touch when the type of one is in the affinity of the other.
    if (body.meets == scenes::Meets::fixed_bodies) text_ << " contype='0' conaffinity='1'";
    if (body.meets == scenes::Meets::nothing) text_ << " contype='0' conaffinity='0'";
    if (is_placed) text_ << attribute("pos", position) << attribute("quat", turn);
    text_ << "/>";
  }

  const Scene& scene_;
  double dt_;
  std::string setting_;
  std::ostringstream text_;
};

/// A model and its state.
class MujocoEngine : public scenes::Engine {
 public:
  MujocoEngine(const Scene& scene, double dt, const std::string& setting) {
    // Warnings would be written to a file in the current folder.
    mju_user_warning = [](const char*) {};
    const std::string xml = ModelWriter(scene, dt, setting).write();
    const auto files = std::make_unique<mjVFS>();
    mj_defaultVFS(files.get());
    mj_makeEmptyFileVFS(files.get(), "scene.xml", static_cast<int>(xml.size()));
    std::memcpy(files->filedata[0], xml.data(), xml.size());
    std::array<char, 1000> message{};
    model_ = mj_loadXML("scene.xml", files.get(), message.data(), static_cast<int>(message.size()));
    mj_deleteVFS(files.get());
    if (model_ == nullptr) throw std::runtime_error(message.data());
    data_ = mj_makeData(model_);
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      const SceneBody& body = scene.bodies[i];
      const int id =
          body.moves() ? mj_name2id(model_, mjOBJ_BODY, ("body" + std::to_string(i)).c_str()) : 0;
      ids_.push_back(id);
      if (body.moves()) set_velocity(id, body);
    }
  }
  ~MujocoEngine() override {
    mj_deleteData(data_);
    mj_deleteModel(model_);
  }

  void step() override {
    mj_step(model_, data_);
    is_fresh_ = false;
  }
  [[nodiscard]] scenes::BodyState state(std::size_t i) const override {
    if (!is_fresh_) {
      // A step leaves the positions of bodies where it started.
      mj_kinematics(model_, data_);
      mj_comPos(model_, data_);
      mj_comVel(model_, data_);
      is_fresh_ = true;
    }
    std::array<double, 6> velocity{};
    mj_objectVelocity(model_, data_, mjOBJ_BODY, ids_[i], velocity.data(), 0);
    const double* p = data_->xipos + 3 * ids_[i];
    const double* q = data_->xquat + 4 * ids_[i];
    return {Vector(p[0], p[1], p[2]), Rotation(q[0], q[1], q[2], q[3]),
            Vector(velocity[3], velocity[4], velocity[5]),
            Vector(velocity[0], velocity[1], velocity[2])};
  }
  void push(std::size_t i, const Vector& force) override {
    std::copy(force.data(), force.data() + 3, data_->xfrc_applied + 6 * ids_[i]);
  }
  [[nodiscard]] scenes::StepCounters counters() const override {
    return {static_cast<std::uint64_t>(data_->solver_iter), 0};
  }

 private:
  void set_velocity(int id, const SceneBody& body) {
    const int joint = model_->body_jntadr[id];
    if (model_->jnt_type[joint] != mjJNT_FREE) return;
    double* velocity = data_->qvel + model_->jnt_dofadr[joint];
    const Vector spin = body.orientation.conjugate() * body.angular_velocity;
    std::copy(body.velocity.data(), body.velocity.data() + 3, velocity);
    std::copy(spin.data(), spin.data() + 3, velocity + 3);
  }

  mjModel* model_ = nullptr;
  mjData* data_ = nullptr;
  std::vector<int> ids_;
  mutable bool is_fresh_ = false;
};

}  // namespace

std::vector<EngineFamily> engine_families() {
  return {{"mujoco",
           {"def", "ell", "nosl", "hard", "rk4", "cg"},
           [](const Scene& scene, double dt,
              const std::string& setting) -> std::unique_ptr<scenes::Engine> {
             // Its buffers are sized by int: 1000 bodies in a heap do not fit.
             if (scene.bodies.size() > 500) throw scenes::Unsupported("too many bodies");
             require_known(scene, {.has_cylinders = true});
             return std::make_unique<MujocoEngine>(scene, dt, setting);
           }}};
}

}  // namespace bristle::work_precision
