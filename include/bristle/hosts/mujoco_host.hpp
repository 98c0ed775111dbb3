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

#include <bristle/hosts/engine_host.hpp>
#include <bristle/hosts/mujoco_shapes.hpp>

#include <cstdint>
#include <mujoco/mujoco.h>
#include <optional>
#include <string>
#include <unordered_map>
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
    require_body(number);
    if (const auto known = this->find(number)) return *known;
    return mirror(number, detail::mujoco_shapes(*model_, number));
  }
  /// Mirrors a body with other shapes than MuJoCo's, by name: a mesh in the place of its hull.
  /// @return The same id again for a body that is mirrored already, with the shapes that it has.
  /// @throws InvalidArgument when there is no such body, or a shape is refused.
  BodyId mirror(const std::string& body, std::vector<ShapeDef<double>> shapes) {
    return mirror(number_of(mjOBJ_BODY, body), std::move(shapes));
  }
  /// The same by MuJoCo's index of the body.
  BodyId mirror(int number, std::vector<ShapeDef<double>> shapes) {
    require_body(number);
    if (const auto known = this->find(number)) return *known;
    // A body welded to the world stands still, unless mocap leads what it is welded to.
    const bool is_still = model_->body_weldid[number] == 0 && !is_led(model_->body_rootid[number]);
    return this->insert(number, is_still ? Motion::fixed : Motion::kinematic,
                        detail::mujoco_pose(data_->xpos, data_->xquat, number),
                        detail::mujoco_vector(model_->body_ipos + 3 * number), std::move(shapes));
  }
  /// Sets the velocity of a body that mocap leads, and of all that hangs on it: of its centre of
  /// mass [m/s], and [rad/s], world axes, until the next call. For MuJoCo such a body jumps from
  /// place to place without a velocity, and that is what sensors take it for without this call:
  /// what it holds then lags by the damping of the sensors.
  /// @throws InvalidArgument when there is no such body, mocap does not lead it, or a number is not
  ///         finite.
  void set_velocity(const std::string& body, const Twist<double>& velocity) {
    const int number = number_of(mjOBJ_BODY, body);
    detail::require(is_led(number), "body", body.c_str(), "must be one that mocap leads");
    detail::require_all_finite("velocity.linear", velocity.linear);
    detail::require_all_finite("velocity.angular", velocity.angular);
    led_[number] = velocity;
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
    SensorLayout<double> sensors = detail::mujoco_pad(*model_, number, rows, columns);
    const int body = model_->site_bodyid[number];
    return this->add_patch_to(body, tuned_for<double>(spec).patch(std::move(sensors)),
                              [&] { return mirror(body); });
  }

  /// Turns a mesh geom into sensors of its body, as `sensors_from_mesh` places them: a ray on each
  /// face by default, along its normal.
  /// @throws InvalidArgument when there is no such geom, it is no mesh, or as `sensors_from_mesh`.
  PatchId add_skin(const std::string& geom, const PlacementDef<double>& def,
                   const GripSpec<double>& spec) {
    const int number = number_of(mjOBJ_GEOM, geom);
    const int body = model_->geom_bodyid[number];
    return this->add_patch_to(
        body, tuned_for<double>(spec).patch(detail::mujoco_skin(*model_, number, def)),
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
    body.pose = detail::mujoco_pose(data_->xpos, data_->xquat, number);
    body.center = detail::mujoco_vector(data_->xipos + 3 * number);
    body.twist = {detail::mujoco_vector(velocity + 3), detail::mujoco_vector(velocity)};
    const int root = model_->body_rootid[number];
    if (const auto led = led_.find(root); led != led_.end()) {
      // MuJoCo has the motion relative to the body that mocap leads.
      const Vec3<double> arm = body.center - detail::mujoco_vector(data_->xipos + 3 * root);
      body.twist = body.twist + led->second.shifted(arm);
    }
    // MuJoCo's accelerations are relative to a frame that falls with gravity.
    body.acceleration = {
        detail::mujoco_vector(acceleration + 3) + detail::mujoco_vector(model_->opt.gravity),
        detail::mujoco_vector(acceleration)};
    // All bodies of a kinematic tree move each other.
    body.mechanism = static_cast<std::uint32_t>(root);
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
  void require_body(int number) const {
    detail::require(number >= 0 && number < model_->nbody, "body", number,
                    "must be the index of one in the model");
  }
  /// Returns whether mocap leads a body.
  [[nodiscard]] bool is_led(int number) const { return model_->body_mocapid[number] >= 0; }
  [[nodiscard]] int number_of(mjtObj kind, const std::string& name) const {
    const int number = mj_name2id(model_, kind, name.c_str());
    const char* const what = kind == mjOBJ_SITE ? "site" : kind == mjOBJ_GEOM ? "geom" : "body";
    detail::require(number >= 0, what, name.c_str(), "must be the name of one in the model");
    return number;
  }

  const mjModel* model_;
  mjData* data_;
  /// The caller's entries of `data.xfrc_applied`.
  std::vector<mjtNum> own_;
  /// [m/s, rad/s] Velocities of bodies that mocap leads.
  std::unordered_map<int, Twist<double>> led_;
};

}  // namespace bristle::inline BRISTLE_ABI
