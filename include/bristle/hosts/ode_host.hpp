/// @file
/// Sensors in an ODE simulation. Opt-in: needs ODE in double, and the target bristle::ode.
///
///     OdeHost<> host(world);
///     host.mirror(part);
///     const PatchId left = host.add_patch(finger, pad);
///     for (;;) host.step(dt);  // in the place of dWorldStep
///
/// Apply forces and make contact joints first. To step in another way, call `host.sense(dt)` and
/// then `dWorldQuickStep(world, dt)`.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/hosts/engine_host.hpp>
#include <bristle/hosts/ode_response.hpp>
#include <bristle/hosts/ode_shapes.hpp>

#include <ode/ode.h>
#include <optional>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// An ODE simulation as `HostSensors` sees it.
///
/// ODE has no mass matrix. The host finds the motion that a body's joints leave free, if the other
/// side of the joint is the world or a kinematic body. It knows ball, hinge, slider, fixed,
/// universal, piston and plane joints. It leaves out other joints, joints between two dynamic
/// bodies, contacts, limits and motors of joints, damping and joint error correction. A body moves
/// as if they were not there. The next step meets their effect, which is of first order in the
/// step.
template <typename Backend = AnalyticBackend>
class OdeHost : public EngineHost<void*, Backend> {
  using Base = EngineHost<void*, Backend>;

 public:
  using Base::world;

  /// The world must outlive the host, and so must mirrored bodies that are not forgotten.
  explicit OdeHost(dWorldID engine) : ode_(engine) {
    static_assert(sizeof(dReal) == sizeof(double), "ODE must be used in double");
  }

  /// Mirrors a body with its present geoms for sensors. ODE's collision filters do not matter. The
  /// body's frame is ODE's, with the centre of mass as its origin. Rays among the geoms are left
  /// out.
  /// @return The same id again for a body that is mirrored already.
  /// @throws InvalidArgument naming the class of a geom that is no box, sphere, capsule, cylinder
  /// or
  ///         mesh, or when a mesh is open. ODE does not disclose the points of convex geoms, nor
  ///         the heights of height fields.
  BodyId mirror(dBodyID body) {
    if (const auto known = this->find(body)) return *known;
    return mirror(body, detail::ode_shapes(body));
  }
  /// Mirrors a body with other shapes than its geoms: the hull of a convex geom.
  /// @return The same id again for a body that is mirrored already, with the shapes that it has.
  /// @throws InvalidArgument when a shape is refused.
  BodyId mirror(dBodyID body, std::vector<ShapeDef<double>> shapes) {
    if (const auto known = this->find(body)) return *known;
    return this->insert(body, Motion::kinematic, detail::ode_pose(body),
                        detail::zero<Vec3<double>>(), std::move(shapes));
  }
  /// Mirrors a geom without a body, as a fixed body at its present pose. The mirrored body of a
  /// plane has the world's frame.
  /// @return The same id again for a geom that is mirrored already.
  /// @throws InvalidArgument when the geom has a body, or as `mirror`.
  BodyId mirror_ground(dGeomID geom) {
    if (const auto known = this->find(geom)) return *known;
    return mirror_ground(geom, {detail::ode_shape(geom, {})});
  }
  /// Mirrors a geom without a body with other shapes than its own: a height field as an
  /// `extruded_mesh`.
  /// @throws InvalidArgument when the geom has a body, or a shape is refused.
  BodyId mirror_ground(dGeomID geom, std::vector<ShapeDef<double>> shapes) {
    if (const auto known = this->find(geom)) return *known;
    detail::require(dGeomGetBody(geom) == nullptr, "geom", detail::ode_class_name(geom),
                    "must have no body: mirror the body that it has");
    Transform<double> X_WG;
    // A plane has no pose in ODE.
    if (dGeomGetClass(geom) != dPlaneClass) {
      dQuaternion q;
      dGeomGetQuaternion(geom, q);
      X_WG = detail::ode_transform(q, dGeomGetPosition(geom));
    }
    return this->insert(geom, Motion::fixed, X_WG, detail::zero<Vec3<double>>(), std::move(shapes));
  }

  /// Adds sensors to a body, in its frame. Mirrors it if needed.
  PatchId add_patch(dBodyID body, const PatchDef<double>& def) {
    return this->add_patch_to(body, def, [&] { return mirror(body); });
  }

  /// A step of ODE with sensors, in the place of `dWorldStep`.
  /// @param dt  [s] Length of the step.
  void step(double dt) {
    sense(dt);
    dWorldStep(ode_, dt);
  }
  /// Runs the sensors alone. They add forces to ODE's bodies, which act in the next step.
  /// @param dt  [s] Length of that step.
  void sense(double dt) {
    dt_ = dt;
    this->sensors().step(*this, dt);
  }

  // Interface that `HostSensors` queries.

  /// State of a body, with its acceleration by gravity and its present forces.
  [[nodiscard]] std::optional<HostBody<double>> body(BodyId id) const {
    if (!this->key_of(id)) return {};
    const dBodyID from = body_of(id);
    HostBody<double> body;
    body.pose = detail::ode_pose(from);
    body.center = body.pose.translation;
    const Vec6<double> now = detail::ode_twist(from);
    body.twist = {now.head<3>(), now.tail<3>()};
    const Vec6<double> gain = (detail::ode_response(from, dt_).twist - now) / dt_;
    body.acceleration = {gain.head<3>(), gain.tail<3>()};
    return body;
  }
  /// [1/kg, 1/(kg m^2)] Mobility that a body's joints leave free. Bodies are queried one at a time.
  [[nodiscard]] Mat6<double> mobility(BodyId i, BodyId j) const {
    return i == j ? detail::ode_response(body_of(i), dt_).mobility : detail::zero<Mat6<double>>();
  }
  /// Adds a wrench [N, N m] about the centre of mass until the end of the next step. Wakes the
  /// body.
  void apply_wrench(BodyId id, const Wrench<double>& wrench) {
    const dBodyID body = body_of(id);
    dBodyAddForce(body, wrench.force.x(), wrench.force.y(), wrench.force.z());
    dBodyAddTorque(body, wrench.torque.x(), wrench.torque.y(), wrench.torque.z());
    dBodyEnable(body);
  }

 private:
  /// Mirrored geoms without body are fixed, never queried.
  [[nodiscard]] dBodyID body_of(BodyId id) const { return static_cast<dBodyID>(*this->key_of(id)); }

  dWorldID ode_;
  /// [s] Length of the sensed step.
  double dt_ = 1e-3;
};

}  // namespace bristle::inline BRISTLE_ABI
