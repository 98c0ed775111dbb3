/// @file
/// Sensors in a MuJoCo simulation. Opt-in: needs MuJoCo, and the target bristle::mujoco.
///
///     MujocoHost<> host(*model, *data);
///     host.mirror("part");
///     const PatchId left = host.add_pad("left_pad", 6, 6, spec);  // a site of type box
///     for (;;) host.step();  // in the place of mj_step
///
/// docs/hosts.md explains the resulting order of MuJoCo's step.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/meshes/terrain.hpp>
#include <bristle/geometry/shapes/quickhull.hpp>
#include <bristle/hosts/engine_host.hpp>
#include <bristle/sensors/placement.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <mujoco/mujoco.h>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// A MuJoCo simulation as `HostSensors` sees it. All in double, MuJoCo's default.
///
/// Bodies are mirrored in their own frames. The content of `data.xfrc_applied` stays. Sensors'
/// wrenches are added during a step.
template <typename Backend = AnalyticBackend>
class MujocoHost : public EngineHost<int, Backend> {
  using Base = EngineHost<int, Backend>;

 public:
  using Base::world;

  /// Both must outlive the host. Copies of the simulation need their own host.
  MujocoHost(const mjModel& model, mjData& data) : model_(&model), data_(&data) {
    static_assert(sizeof(mjtNum) == sizeof(double), "MuJoCo must be built in double");
  }

  /// Mirrors a body with its geoms for the sensors. MuJoCo's collision filters do not matter.
  /// Meshes are seen as their convex hulls, as MuJoCo collides them. Height fields are seen as they
  /// are now, as thick all over as MuJoCo has them below their zero.
  /// @return The same id again for a body that is mirrored already.
  /// @throws InvalidArgument when there is no such body, or a geom is of a kind that has no shape.
  BodyId mirror(const std::string& body) { return mirror(number_of(mjOBJ_BODY, body)); }
  /// Mirrors all bodies of the model.
  /// @throws InvalidArgument when a geom is of a kind that has no shape.
  void mirror_all() {
    for (int i = 0; i < model_->nbody; ++i) (void)mirror(i);
  }
  /// The same by MuJoCo's index of the body.
  /// @throws InvalidArgument when there is none with it, or as above.
  BodyId mirror(int number) {
    detail::require(number >= 0 && number < model_->nbody, "body", number,
                    "must be the index of one in the model");
    if (const auto known = this->find(number)) return *known;
    BodyDef<double> def;
    // A body welded to the world stands still, unless mocap leads it.
    const bool is_still = model_->body_weldid[number] == 0 && model_->body_mocapid[number] < 0;
    def.motion = is_still ? Motion::fixed : Motion::kinematic;
    def.center_of_mass = vector(model_->body_ipos + 3 * number);
    const Transform<double> X_WB = pose_of(data_->xpos, data_->xquat, number);
    def.position = X_WB.translation;
    def.orientation = X_WB.rotation;
    const int first = model_->body_geomadr[number];
    for (int i = 0; i < model_->body_geomnum[number]; ++i) def.shapes.push_back(shape(first + i));
    return this->insert(number, def);
  }

  /// Adds sensors to a body, in its frame. Mirrors it if needed.
  PatchId add_patch(const std::string& body, const PatchDef<double>& def) {
    const int number = number_of(mjOBJ_BODY, body);
    return this->add_patch_to(number, def, [&] { return mirror(number); });
  }
  /// Turns a site of type box into sensors of its body: `rows` x `columns` rays over its x and y,
  /// from its lower face to its upper one along z. The lower face belongs inside of the body, the
  /// upper one outside.
  /// @throws InvalidArgument when there is no such site, or it is no box.
  PatchId add_pad(const std::string& site, std::uint32_t rows, std::uint32_t columns,
                  const GripSpec<double>& spec) {
    const int number = number_of(mjOBJ_SITE, site);
    detail::require(model_->site_type[number] == mjGEOM_BOX, "site", site.c_str(),
                    "must be of type box");
    const Transform<double> X_BS = pose_of(model_->site_pos, model_->site_quat, number);
    const Vec3<double> half = vector(model_->site_size + 3 * number);
    SensorLayout<double> sensors;
    for (std::uint32_t i = 0; i < rows; ++i) {
      for (std::uint32_t j = 0; j < columns; ++j) {
        const double x = half.x() * ((2.0 * i + 1) / rows - 1);
        const double y = half.y() * ((2.0 * j + 1) / columns - 1);
        sensors.add(X_BS * Vec3<double>(x, y, -half.z()), X_BS * Vec3<double>(x, y, half.z()));
      }
    }
    const int body = model_->site_bodyid[number];
    return this->add_patch_to(body, tuned_for<double>(spec).patch(std::move(sensors)),
                              [&] { return mirror(body); });
  }

  /// A step of MuJoCo with sensors, in the place of `mj_step`. It calls `mj_step1` and `mj_step2`,
  /// so it uses MuJoCo's Euler or implicit integrator.
  void step() {
    mj_step1(model_, data_);
    // Acceleration that MuJoCo adds by itself: motors, springs, gravity and gyroscopic terms,
    // without constraints.
    mj_fwdActuation(model_, data_);
    mj_fwdAcceleration(model_, data_);
    mju_copy(data_->qacc, data_->qacc_smooth, model_->nv);
    mj_rnePostConstraint(model_, data_);
    own_.assign(data_->xfrc_applied, data_->xfrc_applied + 6 * model_->nbody);
    this->sensors().step(*this, model_->opt.timestep);
    mj_step2(model_, data_);
    mju_copy(data_->xfrc_applied, own_.data(), 6 * model_->nbody);
  }

  // Interface that `HostSensors` queries.

  /// State of a body, with its unconstrained acceleration; nothing if not mirrored.
  [[nodiscard]] std::optional<HostBody<double>> body(BodyId id) const {
    if (!this->key_of(id)) return {};
    const int number = *this->key_of(id);
    mjtNum velocity[6], acceleration[6];
    mj_objectVelocity(model_, data_, mjOBJ_BODY, number, velocity, 0);
    mj_objectAcceleration(model_, data_, mjOBJ_BODY, number, acceleration, 0);
    HostBody<double> body;
    body.pose = pose_of(data_->xpos, data_->xquat, number);
    body.center = vector(data_->xipos + 3 * number);
    body.twist = {vector(velocity + 3), vector(velocity)};
    // MuJoCo's accelerations are relative to a frame that falls with gravity.
    body.acceleration = {vector(acceleration + 3) + vector(model_->opt.gravity),
                         vector(acceleration)};
    // All bodies of a kinematic tree move each other.
    body.mechanism = static_cast<std::uint32_t>(model_->body_rootid[number]);
    return body;
  }
  /// [1/kg, 1/(kg m^2)] Mobility between two bodies of one kinematic tree.
  [[nodiscard]] Mat6<double> mobility(BodyId i, BodyId j) const {
    using Jacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor>;
    const auto jacobian = [this](BodyId id) {
      Jacobian J(6, model_->nv);
      mj_jacBodyCom(model_, data_, J.data(), J.data() + 3 * model_->nv, *this->key_of(id));
      return J;
    };
    const Jacobian J = jacobian(j);
    Jacobian moved(6, model_->nv);
    mj_solveM(model_, data_, moved.data(), J.data(), 6);
    return jacobian(i) * moved.transpose();
  }
  /// Adds a wrench [N, N m] about the centre of mass to `data.xfrc_applied`.
  void apply_wrench(BodyId id, const Wrench<double>& wrench) {
    mjtNum* applied = data_->xfrc_applied + 6 * *this->key_of(id);
    for (int k = 0; k < 3; ++k) {
      applied[k] += wrench.force[k];
      applied[3 + k] += wrench.torque[k];
    }
  }

 private:
  [[nodiscard]] static Vec3<double> vector(const mjtNum* x) { return {x[0], x[1], x[2]}; }
  [[nodiscard]] static Transform<double> pose_of(const mjtNum* positions, const mjtNum* rotations,
                                                 int i) {
    const mjtNum* q = rotations + 4 * i;
    return {Quat<double>(q[0], q[1], q[2], q[3]).normalized(), vector(positions + 3 * i)};
  }
  [[nodiscard]] int number_of(mjtObj kind, const std::string& name) const {
    const int number = mj_name2id(model_, kind, name.c_str());
    detail::require(number >= 0, kind == mjOBJ_SITE ? "site" : "body", name.c_str(),
                    "must be the name of one in the model");
    return number;
  }
  [[nodiscard]] ShapeDef<double> shape(int geom) const {
    const Vec3<double> size = vector(model_->geom_size + 3 * geom);
    ShapeDef<double> def;
    def.X_BS = pose_of(model_->geom_pos, model_->geom_quat, geom);
    switch (model_->geom_type[geom]) {
      case mjGEOM_PLANE:
        def.shape = HalfSpace<double>{};
        break;
      case mjGEOM_SPHERE:
        def.shape = Sphere<double>{size.x()};
        break;
      case mjGEOM_CAPSULE:
        def.shape = Capsule<double>{size.x(), size.y()};
        break;
      case mjGEOM_CYLINDER:
        def.shape = Cylinder<double>{size.x(), size.y()};
        break;
      case mjGEOM_ELLIPSOID:
        def.shape = Ellipsoid<double>{size};
        break;
      case mjGEOM_BOX:
        def.shape = Box<double>{size};
        break;
      case mjGEOM_MESH: {
        const int mesh = model_->geom_dataid[geom];
        std::vector<Vec3<double>> points(static_cast<std::size_t>(model_->mesh_vertnum[mesh]));
        const float* next = model_->mesh_vert + 3 * model_->mesh_vertadr[mesh];
        for (Vec3<double>& point : points) {
          for (int k = 0; k < 3; ++k) point[k] = static_cast<double>(*next++);
        }
        def.shape = convex_hull<double>(points);
        break;
      }
      case mjGEOM_HFIELD: {
        const int field = model_->geom_dataid[geom];
        const mjtNum* sizes = model_->hfield_size + 4 * field;
        const int rows = model_->hfield_nrow[field];
        const int columns = model_->hfield_ncol[field];
        std::vector<double> heights(static_cast<std::size_t>(rows * columns));
        const float* next = model_->hfield_data + model_->hfield_adr[field];
        for (double& height : heights) height = sizes[2] * static_cast<double>(*next++);
        const std::array<std::uint32_t, 2> cells{static_cast<std::uint32_t>(columns - 1),
                                                 static_cast<std::uint32_t>(rows - 1)};
        def.shape = extruded_mesh<double>(
            height_field_mesh<double>({2 * sizes[0], 2 * sizes[1]}, cells, heights),
            {0, 0, -sizes[3]});
        break;
      }
      default:
        detail::require(false, "geom", geom, "must be of a kind that has a shape");
    }
    return def;
  }

  const mjModel* model_;
  mjData* data_;
  std::vector<mjtNum> own_;
};

}  // namespace bristle::inline BRISTLE_ABI
