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
#include <bristle/math/spatial.hpp>

#include <ode/ode.h>
#include <optional>

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
  /// @throws InvalidArgument naming the class of a geom that is no box, sphere, capsule or
  ///         cylinder. ODE does not disclose the points of convex geoms.
  BodyId mirror(dBodyID body) {
    if (const auto known = this->find(body)) return *known;
    BodyDef<double> def;
    def.motion = Motion::kinematic;
    const Transform<double> X_WB = pose_of(body);
    def.position = X_WB.translation;
    def.orientation = X_WB.rotation;
    for (dGeomID geom = dBodyGetFirstGeom(body); geom != nullptr; geom = dBodyGetNextGeom(geom)) {
      if (dGeomGetClass(geom) == dRayClass) continue;
      dQuaternion q;
      dGeomGetOffsetQuaternion(geom, q);
      def.shapes.push_back(shape(geom, transform(q, dGeomGetOffsetPosition(geom))));
    }
    return this->insert(body, def);
  }
  /// Mirrors a geom without a body, as a fixed body at its present pose. The mirrored body of a
  /// plane has the world's frame.
  /// @return The same id again for a geom that is mirrored already.
  /// @throws InvalidArgument when the geom has a body, or as `mirror`.
  BodyId mirror_ground(dGeomID geom) {
    if (const auto known = this->find(geom)) return *known;
    detail::require(dGeomGetBody(geom) == nullptr, "geom", name_of_class(geom),
                    "must have no body: mirror the body that it has");
    BodyDef<double> def;
    def.motion = Motion::fixed;
    def.shapes.push_back(shape(geom, {}));
    // A plane has no pose in ODE.
    if (dGeomGetClass(geom) != dPlaneClass) {
      dQuaternion q;
      dGeomGetQuaternion(geom, q);
      const Transform<double> X_WS = transform(q, dGeomGetPosition(geom));
      def.position = X_WS.translation;
      def.orientation = X_WS.rotation;
    }
    return this->insert(geom, def);
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
    body.pose = pose_of(from);
    body.center = body.pose.translation;
    const Vec6<double> now = twist_of(from);
    body.twist = {now.head<3>(), now.tail<3>()};
    const Vec6<double> gain = (response(from).twist - now) / dt_;
    body.acceleration = {gain.head<3>(), gain.tail<3>()};
    return body;
  }
  /// [1/kg, 1/(kg m^2)] Mobility that a body's joints leave free. Bodies are queried one at a time.
  [[nodiscard]] Mat6<double> mobility(BodyId i, BodyId j) const {
    return i == j ? response(body_of(i)).mobility : detail::zero<Mat6<double>>();
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
  /// Mobility of a body, and its twist at the end of the step without sensors.
  struct Response {
    Mat6<double> mobility = detail::zero<Mat6<double>>();
    Vec6<double> twist = detail::zero<Vec6<double>>();
    /// Diagonal of the mobility without joints.
    Vec6<double> free = detail::zero<Vec6<double>>();

    /// Sets the twist along a row to that of `base`, by an impulse along that row.
    void hold(const Vec3<double>& linear, const Vec3<double>& angular, const Vec6<double>& base) {
      const Vec6<double> row = detail::stacked<double>(linear, angular);
      const Vec6<double> moved = mobility * row;
      const double give = row.dot(moved);
      // Joints may hold the same motion twice. Then only rounding is left.
      if (give <= 1e-10 * cwise_square(row).dot(free)) return;
      twist -= moved * (row.dot(twist - base) / give);
      mobility -= moved * moved.transpose() / give;
    }
  };
  /// Motion that a joint holds, along an axis and across it: of its point, and turns.
  struct Hold {
    bool along = false, across = false, turn_along = false, turn_across = false;
    Vec3<double> point = detail::zero<Vec3<double>>();
    Vec3<double> axis = detail::unit_z<Vec3<double>>();
  };

  /// Mirrored geoms without body are fixed, never queried.
  [[nodiscard]] dBodyID body_of(BodyId id) const { return static_cast<dBodyID>(*this->key_of(id)); }
  [[nodiscard]] static Vec3<double> vector(const dReal* x) { return {x[0], x[1], x[2]}; }
  [[nodiscard]] static Transform<double> transform(const dReal* q, const dReal* x) {
    return {Quat<double>(q[0], q[1], q[2], q[3]).normalized(), vector(x)};
  }
  [[nodiscard]] static Transform<double> pose_of(dBodyID body) {
    return transform(dBodyGetQuaternion(body), dBodyGetPosition(body));
  }
  [[nodiscard]] static Vec6<double> twist_of(dBodyID body) {
    return detail::stacked<double>(vector(dBodyGetLinearVel(body)),
                                   vector(dBodyGetAngularVel(body)));
  }
  template <typename Getter, typename Of>
  [[nodiscard]] static Vec3<double> vector(Getter get, Of of) {
    dVector3 x;
    get(of, x);
    return vector(x);
  }

  [[nodiscard]] Response response(dBodyID body) const {
    Response result;
    result.twist = twist_of(body);
    if (dBodyIsKinematic(body)) return result;
    dMass mass;
    dBodyGetMass(body, &mass);
    Mat3<double> inertia;
    for (int i = 0; i < 3; ++i) inertia.row(i) = vector(mass.I + 4 * i);
    const Mat3<double> R = pose_of(body).rotation_matrix();
    inertia = (R * inertia * R.transpose()).eval();
    result.mobility = free_mobility<double>(1 / mass.mass, inertia.inverse());
    result.free = result.mobility.diagonal();
    if (dBodyGetGyroscopicMode(body)) {
      // Gyroscopic turning by the momentum at the end of the step, as in ODE.
      const Vec3<double> momentum = inertia * result.twist.template tail<3>();
      result.twist.template tail<3>() = (inertia - dt_ * skew(momentum)).inverse() * momentum;
    }
    Vec3<double> force = vector(dBodyGetForce(body));
    if (dBodyGetGravityMode(body)) force += mass.mass * vector(dWorldGetGravity, ode_);
    result.twist +=
        dt_ * result.mobility * detail::stacked<double>(force, vector(dBodyGetTorque(body)));
    for (int i = 0; i < dBodyGetNumJoints(body); ++i) hold(dBodyGetJoint(body, i), body, result);
    return result;
  }
  /// Holds the motion that a joint to the world or a kinematic body holds.
  static void hold(dJointID joint, dBodyID body, Response& response) {
    const dBodyID first = dJointGetBody(joint, 0);
    const dBodyID other = first == body ? dJointGetBody(joint, 1) : first;
    if (!dJointIsEnabled(joint) || (other != nullptr && !dBodyIsKinematic(other))) return;
    const Vec3<double> center = vector(dBodyGetPosition(body));
    Vec6<double> base = detail::zero<Vec6<double>>();
    if (other != nullptr) {
      base = twist_of(other);
      base.head<3>() += base.tail<3>().cross(center - vector(dBodyGetPosition(other)));
    }
    const Hold held = hold_of(joint, center);
    dVector3 axis = {held.axis.x(), held.axis.y(), held.axis.z()}, p, q;
    dPlaneSpace(axis, p, q);
    for (const dReal* direction : {axis, p, q}) {
      const Vec3<double> d = vector(direction);
      if (direction == axis ? held.along : held.across) {
        response.hold(d, (held.point - center).cross(d), base);
      }
      if (direction == axis ? held.turn_along : held.turn_across) {
        response.hold(detail::zero<Vec3<double>>(), d, base);
      }
    }
  }
  [[nodiscard]] static Hold hold_of(dJointID joint, const Vec3<double>& center) {
    const auto at = [joint](auto get) { return vector(get, joint); };
    switch (dJointGetType(joint)) {
      case dJointTypeBall:
        return {true, true, false, false, at(dJointGetBallAnchor)};
      case dJointTypeHinge:
        return {true, true, false, true, at(dJointGetHingeAnchor), at(dJointGetHingeAxis)};
      case dJointTypeUniversal: {
        const Vec3<double> axis = at(dJointGetUniversalAxis1).cross(at(dJointGetUniversalAxis2));
        return {true, true, true, false, at(dJointGetUniversalAnchor), axis.normalized()};
      }
      case dJointTypeSlider:
        return {false, true, true, true, center, at(dJointGetSliderAxis)};
      case dJointTypePiston:
        return {false, true, false, true, at(dJointGetPistonAnchor), at(dJointGetPistonAxis)};
      case dJointTypePlane2D:
        return {true, false, false, true, center};
      case dJointTypeFixed:
        return {true, true, true, true, center};
      default:
        return {};
    }
  }

  [[nodiscard]] static const char* name_of_class(dGeomID geom) {
    constexpr const char* names[] = {"sphere", "box",    "capsule",   "cylinder", "plane",
                                     "ray",    "convex", "transform", "trimesh",  "heightfield"};
    const int number = dGeomGetClass(geom);
    return number < dFirstSpaceClass ? names[number] : number < dFirstUserClass ? "space" : "user";
  }
  [[nodiscard]] static ShapeDef<double> shape(dGeomID geom, const Transform<double>& X_BS) {
    ShapeDef<double> def;
    def.X_BS = X_BS;
    dVector4 size;
    switch (dGeomGetClass(geom)) {
      case dPlaneClass:
        dGeomPlaneGetParams(geom, size);
        def.shape = HalfSpace<double>{vector(size), size[3]};
        break;
      case dSphereClass:
        def.shape = Sphere<double>{dGeomSphereGetRadius(geom)};
        break;
      case dCapsuleClass:
        dGeomCapsuleGetParams(geom, &size[0], &size[1]);
        def.shape = Capsule<double>{size[0], size[1] / 2};
        break;
      case dCylinderClass:
        dGeomCylinderGetParams(geom, &size[0], &size[1]);
        def.shape = Cylinder<double>{size[0], size[1] / 2};
        break;
      case dBoxClass:
        dGeomBoxGetLengths(geom, size);
        def.shape = Box<double>{vector(size) / 2};
        break;
      default:
        detail::require(false, "geom", name_of_class(geom),
                        "must be a plane, box, sphere, capsule or cylinder");
    }
    return def;
  }

  dWorldID ode_;
  /// [s] Length of the sensed step.
  double dt_ = 1e-3;
};

}  // namespace bristle::inline BRISTLE_ABI
