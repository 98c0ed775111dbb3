/// @file
/// Sensors in an ODE world. Opt-in: needs ODE in double, and the target bristle::ode.
///
///     OdeHost<> host(world);
///     host.mirror(part);
///     host.add_patch(finger, pad);
///     for (;;) {
///       host.sense(dt);  // before dWorldStep or dWorldQuickStep
///       dWorldStep(world, dt);
///     }
///
/// docs/hosts.md says what this does to the order of ODE's step.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/hosts/host_sensors.hpp>
#include <bristle/math/elimination.hpp>

#include <algorithm>
#include <cstddef>
#include <ode/ode.h>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// The bodies of an ODE world as `HostSensors` sees them. Frames are those of ODE, about centres of
/// mass.
///
/// ODE has no matrix of masses. A body on a slider, hinge, ball or fixed joint whose other side is
/// the world or a kinematic body moves as that joint lets it, of several joints the first; every
/// other joint is left out, which is of first order in motion.
template <typename Backend = AnalyticBackend>
class OdeHost {
 public:
  explicit OdeHost(dWorldID world) : ode_(world) {
    static_assert(sizeof(dReal) == sizeof(double), "ODE must be built in double: dIDEDOUBLE");
  }

  [[nodiscard]] HostSensors<double, Backend>& sensors() { return sensors_; }
  [[nodiscard]] World<double, Backend>& world() { return sensors_.world(); }

  /// Mirrors a body with its geoms, whatever ODE lets them collide with, so that sensors see it.
  /// @return The same again for a body that is mirrored already.
  /// @throws InvalidArgument when there is no shape like one of its geoms.
  BodyId mirror(dBodyID body) {
    for (const Known& known : bodies_) {
      if (known.body == body && world().contains(known.id)) return known.id;
    }
    BodyDef<double> def;
    def.motion = Motion::kinematic;
    def.center_of_mass = Vec3<double>::Zero();
    def.position = vector(dBodyGetPosition(body));
    def.orientation = rotation(dBodyGetQuaternion(body));
    for (dGeomID geom = dBodyGetFirstGeom(body); geom != nullptr; geom = dBodyGetNextGeom(geom)) {
      dQuaternion q;
      dGeomGetOffsetQuaternion(geom, q);
      def.shapes.push_back(shape(geom, {rotation(q), vector(dGeomGetOffsetPosition(geom))}));
    }
    const BodyId id = world().add_body(def);
    bodies_.resize(std::max(bodies_.size(), id.index + std::size_t(1)));
    bodies_[id.index] = {id, body};
    return id;
  }
  /// Mirrors a geom that has no body, where it is now.
  /// @throws InvalidArgument when there is no shape like it.
  BodyId mirror_ground(dGeomID geom) {
    BodyDef<double> def;
    def.motion = Motion::fixed;
    Transform<double> X{Quat<double>::Identity(), Vec3<double>::Zero()};
    if (dGeomGetClass(geom) != dPlaneClass) {
      dQuaternion q;
      dGeomGetQuaternion(geom, q);
      X = {rotation(q), vector(dGeomGetPosition(geom))};
    }
    def.shapes.push_back(shape(geom, X));
    return world().add_body(def);
  }
  /// Adds sensors to a body, in its frame.
  PatchId add_patch(dBodyID body, const PatchDef<double>& def) {
    return world().add_patch(mirror(body), def);
  }

  /// Senses, and adds forces for ODE's next step, which is to be one of dt [s].
  void sense(double dt) { sensors_.step(*this, dt); }

  // What `HostSensors` asks.

  [[nodiscard]] HostBody<double> body(BodyId id) const {
    const dBodyID b = bodies_[id.index].body;
    HostBody<double> state;
    state.pose = {rotation(dBodyGetQuaternion(b)), vector(dBodyGetPosition(b))};
    state.center = state.pose.translation;
    state.twist = {vector(dBodyGetLinearVel(b)), vector(dBodyGetAngularVel(b))};
    if (dBodyIsKinematic(b) != 0) return state;
    const Mat6<double> W = mobility(id, id);
    const Mass mass = mass_of(b);
    Vec6<double> force;
    Vec3<double> torque = vector(dBodyGetTorque(b));
    if (dBodyGetGyroscopicMode(b) != 0) {
      torque -= state.twist.angular.cross(mass.inertia_W * state.twist.angular);
    }
    force << vector(dBodyGetForce(b)), torque;
    if (dBodyGetGravityMode(b) != 0) {
      dVector3 gravity;
      dWorldGetGravity(ode_, gravity);
      force.head<3>() += mass.mass * vector(gravity);
    }
    const Vec6<double> acceleration = W * force;
    state.acceleration = {acceleration.head<3>(), acceleration.tail<3>()};
    return state;
  }
  [[nodiscard]] Mat6<double> mobility(BodyId id, BodyId) const {
    const dBodyID b = bodies_[id.index].body;
    if (dBodyIsKinematic(b) != 0) return Mat6<double>::Zero();
    const Mass mass = mass_of(b);
    for (int i = 0; i < dBodyGetNumJoints(b); ++i) {
      const dJointID joint = dBodyGetJoint(b, i);
      const dBodyID other = dJointGetBody(joint, dJointGetBody(joint, 0) == b ? 1 : 0);
      if (other != nullptr && dBodyIsKinematic(other) == 0) continue;
      dVector3 axis, anchor;
      switch (dJointGetType(joint)) {
        case dJointTypeSlider:
          dJointGetSliderAxis(joint, axis);
          return along(vector(axis), Vec3<double>::Zero(), mass);
        case dJointTypeHinge:
          dJointGetHingeAxis(joint, axis);
          dJointGetHingeAnchor(joint, anchor);
          return along(vector(axis).cross(vector(dBodyGetPosition(b)) - vector(anchor)),
                       vector(axis), mass);
        case dJointTypeBall:
          dJointGetBallAnchor(joint, anchor);
          return about(vector(dBodyGetPosition(b)) - vector(anchor), mass);
        case dJointTypeFixed:
          return Mat6<double>::Zero();
        default:
          break;
      }
    }
    return free_mobility<double>(1 / mass.mass, inverse(mass.inertia_W));
  }
  void apply_wrench(BodyId id, const Wrench<double>& wrench) {
    const dBodyID b = bodies_[id.index].body;
    const Vec3<double>& f = wrench.force;
    const Vec3<double>& t = wrench.torque;
    dBodyEnable(b);
    dBodyAddForce(b, f.x(), f.y(), f.z());
    dBodyAddTorque(b, t.x(), t.y(), t.z());
  }

 private:
  struct Known {
    BodyId id{};
    dBodyID body = nullptr;
  };
  /// [kg], [kg m^2]
  struct Mass {
    double mass = 0;
    Mat3<double> inertia_W = Mat3<double>::Zero();
  };

  [[nodiscard]] static Vec3<double> vector(const dReal* v) { return {v[0], v[1], v[2]}; }
  [[nodiscard]] static Quat<double> rotation(const dReal* q) {
    return Quat<double>(q[0], q[1], q[2], q[3]).normalized();
  }
  [[nodiscard]] static Mat3<double> inverse(const Mat3<double>& A) {
    return solved<double>(A, Mat3<double>(Mat3<double>::Identity()));
  }
  [[nodiscard]] static Mass mass_of(dBodyID b) {
    dMass mass;
    dBodyGetMass(b, &mass);
    Mat3<double> inertia;
    for (int i = 0; i < 3; ++i) inertia.row(i) = vector(mass.I + 4 * i).transpose();
    const Mat3<double> R = rotation(dBodyGetQuaternion(b)).toRotationMatrix();
    return {mass.mass, R * inertia * R.transpose()};
  }
  /// Mobility of a body that moves along one direction: S S^T / (S^T M S), S = [v; w].
  [[nodiscard]] static Mat6<double> along(const Vec3<double>& v, const Vec3<double>& w,
                                          const Mass& mass) {
    Vec6<double> S;
    S << v, w;
    return S * S.transpose() / (mass.mass * v.squaredNorm() + w.dot(mass.inertia_W * w));
  }
  /// Mobility of one that turns about a point, from which its centre of mass is at `arm`.
  [[nodiscard]] static Mat6<double> about(const Vec3<double>& arm, const Mass& mass) {
    Eigen::Matrix<double, 6, 3> S;
    S << -skew(arm), Mat3<double>::Identity();
    const Mat3<double> M = mass.mass * skew(arm).transpose() * skew(arm) + mass.inertia_W;
    return S * inverse(M) * S.transpose();
  }

  [[nodiscard]] static ShapeDef<double> shape(dGeomID geom, const Transform<double>& X_BS) {
    ShapeDef<double> def;
    def.X_BS = X_BS;
    dVector4 sizes{};
    switch (dGeomGetClass(geom)) {
      case dSphereClass:
        def.shape = Sphere<double>{dGeomSphereGetRadius(geom)};
        break;
      case dBoxClass:
        dGeomBoxGetLengths(geom, sizes);
        def.shape = Box<double>{0.5 * vector(sizes)};
        break;
      case dCapsuleClass:
        dGeomCapsuleGetParams(geom, sizes, sizes + 1);
        def.shape = Capsule<double>{sizes[0], 0.5 * sizes[1]};
        break;
      case dCylinderClass:
        dGeomCylinderGetParams(geom, sizes, sizes + 1);
        def.shape = Cylinder<double>{sizes[0], 0.5 * sizes[1]};
        break;
      case dPlaneClass:
        dGeomPlaneGetParams(geom, sizes);
        def.shape = HalfSpace<double>{vector(sizes), sizes[3]};
        break;
      default:
        detail::require(false, "dGeomGetClass", dGeomGetClass(geom),
                        "must be that of a sphere, box, capsule, cylinder or plane");
    }
    return def;
  }

  dWorldID ode_;
  HostSensors<double, Backend> sensors_;
  std::vector<Known> bodies_;  // By slots of mirrored bodies.
};

}  // namespace bristle::inline BRISTLE_ABI
