// ODE in double precision.
// SPDX-License-Identifier: BSD-3-Clause
#include "benchmarks/work_precision/drivers/features.hpp"
#include "benchmarks/work_precision/drivers/slab.hpp"
#include "benchmarks/work_precision/engines.hpp"

#include <array>
#include <cstdarg>
#include <ode/ode.h>

namespace bristle::work_precision {

using namespace bristle::detail;

namespace {

using scenes::Scene;
using scenes::SceneBody;
using scenes::Vector;

Vector from_ode(const dReal* v) { return {v[0], v[1], v[2]}; }

/// Settings: `def` QuickStep with 20 iterations, `it100` with 100 of them, `step` the direct solver
/// of dWorldStep.
class OdeEngine : public scenes::Engine {
 public:
  OdeEngine(const Scene& scene, double dt, const std::string& setting)
      : dt_(dt), restitution_(scene.restitution), is_direct_(setting == "step") {
    dInitODE2(0);
    // The direct solver tells of every step that it finds singular; the error shows it better.
    dSetMessageHandler([](int, const char*, va_list) {});
    world_ = dWorldCreate();
    space_ = dHashSpaceCreate(nullptr);
    contacts_ = dJointGroupCreate(0);
    dWorldSetGravity(world_, scene.gravity.x(), scene.gravity.y(), scene.gravity.z());
    if (setting == "it100") iterations_ = 100;
    dWorldSetQuickStepNumIterations(world_, iterations_);
    frictions_.reserve(scene.bodies.size());
    for (const SceneBody& body : scene.bodies) add(body);
    for (const scenes::SceneJoint& joint : scene.joints) {
      const dJointID ball = dJointCreateBall(world_, nullptr);
      const dBodyID a = joint.a < 0 ? nullptr : bodies_[static_cast<std::size_t>(joint.a)];
      const dBodyID b = bodies_[static_cast<std::size_t>(joint.b)];
      if (a == nullptr) {
        dJointAttach(ball, b, nullptr);
      } else {
        dJointAttach(ball, a, b);
      }
      dJointSetBallAnchor(ball, joint.anchor.x(), joint.anchor.y(), joint.anchor.z());
    }
  }
  ~OdeEngine() override {
    dJointGroupDestroy(contacts_);
    dSpaceDestroy(space_);
    dWorldDestroy(world_);
    for (const dTriMeshDataID mesh : meshes_) dGeomTriMeshDataDestroy(mesh);
  }

  void step() override {
    dSpaceCollide(space_, this, &OdeEngine::meet);
    if (is_direct_) {
      dWorldStep(world_, dt_);
    } else {
      dWorldQuickStep(world_, dt_);
    }
    dJointGroupEmpty(contacts_);
  }
  [[nodiscard]] scenes::BodyState state(std::size_t i) const override {
    const dBodyID body = bodies_[i];
    const dReal* q = dBodyGetQuaternion(body);
    return {from_ode(dBodyGetPosition(body)), scenes::Rotation(q[0], q[1], q[2], q[3]),
            from_ode(dBodyGetLinearVel(body)), from_ode(dBodyGetAngularVel(body))};
  }
  void push(std::size_t i, const Vector& force) override {
    dBodyAddForce(bodies_[i], force.x(), force.y(), force.z());
  }
  [[nodiscard]] scenes::StepCounters counters() const override {
    return {is_direct_ ? 0u : static_cast<std::uint64_t>(iterations_), 0};
  }

 private:
  static void meet(void* self, dGeomID a, dGeomID b) {
    auto& engine = *static_cast<OdeEngine*>(self);
    const dBodyID body_a = dGeomGetBody(a);
    const dBodyID body_b = dGeomGetBody(b);
    if (body_a == nullptr && body_b == nullptr) return;
    std::array<dContact, 16> contacts{};
    const int count = dCollide(a, b, static_cast<int>(contacts.size()), &contacts[0].geom,
                               static_cast<int>(sizeof(dContact)));
    const double friction =
        *static_cast<double*>(dGeomGetData(a)) * *static_cast<double*>(dGeomGetData(b));
    for (int i = 0; i < count; ++i) {
      dSurfaceParameters& surface = contacts[static_cast<std::size_t>(i)].surface;
      surface.mode = dContactApprox1;
      surface.mu = friction;
      if (engine.restitution_ > 0) {
        surface.mode |= dContactBounce;
        surface.bounce = engine.restitution_;
        surface.bounce_vel = 0.01;
      }
      dJointAttach(dJointCreateContact(engine.world_, engine.contacts_,
                                       &contacts[static_cast<std::size_t>(i)]),
                   body_a, body_b);
    }
  }

  dGeomID shape_of(const SceneBody& body) {
    if (const auto* ball = std::get_if<Sphere<double>>(&body.shape)) {
      return dCreateSphere(space_, ball->radius);
    }
    if (const auto* box = std::get_if<Box<double>>(&body.shape)) {
      const Vector size = 2 * box->half_extents;
      return dCreateBox(space_, size.x(), size.y(), size.z());
    }
    if (const auto* disk = std::get_if<Cylinder<double>>(&body.shape)) {
      return dCreateCylinder(space_, disk->radius, 2 * disk->half_length);
    }
    if (const auto* ground = std::get_if<HalfSpace<double>>(&body.shape)) {
      return dCreatePlane(space_, ground->normal.x(), ground->normal.y(), ground->normal.z(),
                          ground->offset);
    }
    return mesh_shape(std::get<TriangleMesh<double>>(body.shape));
  }

  dGeomID mesh_shape(const TriangleMesh<double>& mesh) {
    // ODE reads these as long as the shape lives.
    std::vector<dReal>& points = *points_.emplace_back(std::make_unique<std::vector<dReal>>());
    std::vector<dTriIndex>& numbers =
        *numbers_.emplace_back(std::make_unique<std::vector<dTriIndex>>());
    for (const Vector& v : mesh.vertices) points.insert(points.end(), {v.x(), v.y(), v.z()});
    for (const auto& t : mesh.triangles) numbers.insert(numbers.end(), t.begin(), t.end());
    const dTriMeshDataID data = dGeomTriMeshDataCreate();
    dGeomTriMeshDataBuildDouble(data, points.data(), 3 * sizeof(dReal),
                                static_cast<int>(mesh.vertices.size()), numbers.data(),
                                static_cast<int>(numbers.size()), 3 * sizeof(dTriIndex));
    meshes_.push_back(data);
    return dCreateTriMesh(space_, data, nullptr, nullptr, nullptr);
  }

  void add(const SceneBody& body) {
    const dGeomID shape = shape_of(body);
    frictions_.push_back(body.friction);
    dGeomSetData(shape, &frictions_.back());
    constexpr unsigned long fixed = 1;
    constexpr unsigned long moving = 2;
    dGeomSetCategoryBits(shape, body.moves() ? moving : fixed);
    if (body.meets == scenes::Meets::fixed_bodies) dGeomSetCollideBits(shape, fixed);
    if (body.meets == scenes::Meets::nothing) {
      dGeomSetCategoryBits(shape, 0);
      dGeomSetCollideBits(shape, 0);
    }
    const scenes::Rotation& q = body.orientation;
    const dQuaternion turn = {q.w(), q.x(), q.y(), q.z()};
    if (!body.moves()) {
      bodies_.push_back(nullptr);
      if (std::holds_alternative<HalfSpace<double>>(body.shape)) return;
      dGeomSetPosition(shape, body.position.x(), body.position.y(), body.position.z());
      dGeomSetQuaternion(shape, turn);
      return;
    }
    const dBodyID added = dBodyCreate(world_);
    bodies_.push_back(added);
    const Vector inertia = scenes::principal_inertia(body);
    dMass mass;
    dMassSetParameters(&mass, body.mass, 0, 0, 0, inertia.x(), inertia.y(), inertia.z(), 0, 0, 0);
    dBodySetMass(added, &mass);
    dGeomSetBody(shape, added);
    dBodySetPosition(added, body.position.x(), body.position.y(), body.position.z());
    dBodySetQuaternion(added, turn);
    dBodySetLinearVel(added, body.velocity.x(), body.velocity.y(), body.velocity.z());
    dBodySetAngularVel(added, body.angular_velocity.x(), body.angular_velocity.y(),
                       body.angular_velocity.z());
    dBodySetAutoDisableFlag(added, 0);
    if (body.slides_along_x) {
      const dJointID slider = dJointCreateSlider(world_, nullptr);
      dJointAttach(slider, added, nullptr);
      dJointSetSliderAxis(slider, 1, 0, 0);
    }
  }

  double dt_;
  double restitution_;
  bool is_direct_;
  int iterations_ = 20;
  dWorldID world_ = nullptr;
  dSpaceID space_ = nullptr;
  dJointGroupID contacts_ = nullptr;
  std::vector<dBodyID> bodies_;
  std::vector<double> frictions_;
  std::vector<dTriMeshDataID> meshes_;
  std::vector<std::unique_ptr<std::vector<dReal>>> points_;
  std::vector<std::unique_ptr<std::vector<dTriIndex>>> numbers_;
};

}  // namespace

std::vector<EngineFamily> engine_families() {
  return {{"ode",
           {"def", "it100", "step"},
           [](const Scene& scene, double dt,
              const std::string& setting) -> std::unique_ptr<scenes::Engine> {
             require_known(scene, {.has_cylinders = true});
             return std::make_unique<OdeEngine>(scene, dt, setting);
           }}};
}

}  // namespace bristle::work_precision
