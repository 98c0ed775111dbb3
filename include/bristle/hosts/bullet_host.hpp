/// @file
/// Sensors in a Bullet world. Opt-in: needs Bullet, and the target bristle::bullet.
///
///     BulletHost<> host(world);
///     host.mirror(part);
///     host.add_patch(finger, pad);
///     for (;;) world.stepSimulation(dt);  // each substep senses first
///
/// docs/hosts.md explains the resulting order of Bullet's step.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/shapes/quickhull.hpp>
#include <bristle/hosts/engine_host.hpp>

#include <btBulletDynamicsCommon.h>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// The rigid bodies of a Bullet world as `HostSensors` sees them, in double for any build of
/// Bullet. Frames are those of Bullet, about centres of mass. Axes that linear and angular factors
/// lock are known. Constraints and multibodies are not: express a finger on a slider by its
/// factors.
template <typename Backend = AnalyticBackend>
class BulletHost : public EngineHost<btRigidBody*, Backend>, private btActionInterface {
  using Base = EngineHost<btRigidBody*, Backend>;

 public:
  using Base::world;

  /// Takes the pre-tick callback of the world, with its user info, and adds an action. The world
  /// must outlive the host.
  explicit BulletHost(btDiscreteDynamicsWorld& engine) : engine_(&engine) {
    engine.setInternalTickCallback(
        [](btDynamicsWorld* ticking, btScalar dt) {
          static_cast<BulletHost*>(ticking->getWorldUserInfo())->sense(dt);
        },
        this, true);
    engine.addAction(this);
  }
  /// Removes the action and clears the pre-tick callback.
  ~BulletHost() override {
    engine_->removeAction(this);
    engine_->setInternalTickCallback(nullptr, nullptr, true);
  }
  BulletHost(const BulletHost&) = delete;
  BulletHost& operator=(const BulletHost&) = delete;

  /// Mirrors a body with its shape for the sensors. Bullet's collision filters do not matter. Hulls
  /// and cones are seen without Bullet's margin.
  /// @return The same id again for a body that is mirrored already.
  /// @throws InvalidArgument when no shape of bristle matches the body's.
  BodyId mirror(btRigidBody& body) {
    if (const auto known = this->find(&body)) return *known;
    BodyDef<double> def;
    def.motion = body.isStaticObject() ? Motion::fixed : Motion::kinematic;
    def.center_of_mass = detail::zero<Vec3<double>>();
    const Transform<double> X_WB = transform(body.getWorldTransform());
    def.position = X_WB.translation;
    def.orientation = X_WB.rotation;
    add_shapes(*body.getCollisionShape(), btTransform::getIdentity(), def);
    return this->insert(&body, def);
  }
  /// Adds sensors to a body, in its frame. Mirrors it if needed.
  PatchId add_patch(btRigidBody& body, const PatchDef<double>& def) {
    return this->add_patch_to(&body, def, [&] { return mirror(body); });
  }

  // Interface that `HostSensors` queries.

  /// State of a body, with its acceleration by present forces; nothing if not mirrored.
  [[nodiscard]] std::optional<HostBody<double>> body(BodyId id) const {
    if (!this->key_of(id)) return {};
    const btRigidBody& b = **this->key_of(id);
    HostBody<double> state;
    state.pose = transform(b.getWorldTransform());
    state.center = state.pose.translation;
    state.twist = {vector(b.getLinearVelocity()), vector(b.getAngularVelocity())};
    // Before a tick, forces include gravity.
    state.acceleration = {vector(b.getTotalForce() * b.getInvMass()),
                          vector(b.getInvInertiaTensorWorld() * b.getTotalTorque())};
    return state;
  }
  /// [1/kg, 1/(kg m^2)] Free mobility of a body, without its locked axes.
  [[nodiscard]] Mat6<double> mobility(BodyId id, BodyId) const {
    const btRigidBody& b = **this->key_of(id);
    if (b.isStaticOrKinematicObject()) return detail::zero<Mat6<double>>();
    const Vec3<double> turns = vector(b.getAngularFactor());
    Mat3<double> inverse_inertia;
    for (int i = 0; i < 3; ++i) {
      inverse_inertia.row(i) = turns[i] * vector(b.getInvInertiaTensorWorld()[i]).transpose();
    }
    const Vec3<double> inverse_mass = vector(b.getLinearFactor() * b.getInvMass());
    return free_mobility<double>(inverse_mass, inverse_inertia * turns.asDiagonal());
  }
  /// Applies a wrench [N, N m] about the centre of mass for one tick. Activates the body.
  void apply_wrench(BodyId id, const Wrench<double>& wrench) {
    applied_.push_back({*this->key_of(id), vector(wrench.force), vector(wrench.torque)});
    give(applied_.back(), 1);
    applied_.back().body->activate();
  }

 private:
  /// Wrench applied to a body for the present tick [N, N m].
  struct Given {
    btRigidBody* body = nullptr;
    btVector3 force, torque;
  };

  void sense(btScalar dt) { this->sensors().step(*this, static_cast<double>(dt)); }
  static void give(const Given& given, btScalar times) {
    given.body->applyCentralForce(times * given.force);
    given.body->applyTorque(times * given.torque);
  }
  /// Removes the wrenches after their tick: Bullet applies forces in all ticks of a step.
  void updateAction(btCollisionWorld*, btScalar) override {
    for (const Given& given : applied_) give(given, -1);
    applied_.clear();
  }
  void debugDraw(btIDebugDraw*) override {}

  [[nodiscard]] static Vec3<double> vector(const btVector3& v) {
    return {static_cast<double>(v.x()), static_cast<double>(v.y()), static_cast<double>(v.z())};
  }
  [[nodiscard]] static btVector3 vector(const Vec3<double>& v) {
    return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()),
            static_cast<btScalar>(v.z())};
  }
  [[nodiscard]] static Transform<double> transform(const btTransform& X) {
    const btQuaternion q = X.getRotation();
    const Quat<double> rotation(static_cast<double>(q.w()), static_cast<double>(q.x()),
                                static_cast<double>(q.y()), static_cast<double>(q.z()));
    return {rotation.normalized(), vector(X.getOrigin())};
  }
  /// [1] Rotation from z to another axis.
  [[nodiscard]] static Quat<double> axis_rotation(int axis) {
    const double half = std::sqrt(0.5);
    if (axis == 0) return {half, 0, half, 0};
    if (axis == 1) return {half, -half, 0, 0};
    return {1, 0, 0, 0};
  }

  /// Appends the match of a Bullet shape, in the frame X of the body.
  static void add_shapes(const btCollisionShape& shape, const btTransform& X,
                         BodyDef<double>& out) {
    ShapeDef<double> def;
    def.X_BS = transform(X);
    const auto turn_to = [&](int axis) {
      def.X_BS.rotation = def.X_BS.rotation * axis_rotation(axis);
    };
    const auto number = [](btScalar x) { return static_cast<double>(x); };
    if (const auto* all = dynamic_cast<const btCompoundShape*>(&shape)) {
      for (int i = 0; i < all->getNumChildShapes(); ++i) {
        add_shapes(*all->getChildShape(i), X * all->getChildTransform(i), out);
      }
      return;
    }
    if (const auto* box = dynamic_cast<const btBoxShape*>(&shape)) {
      def.shape = Box<double>{vector(box->getHalfExtentsWithMargin())};
    } else if (const auto* ball = dynamic_cast<const btSphereShape*>(&shape)) {
      def.shape = Sphere<double>{number(ball->getRadius())};
    } else if (const auto* capsule = dynamic_cast<const btCapsuleShape*>(&shape)) {
      turn_to(capsule->getUpAxis());
      def.shape = Capsule<double>{number(capsule->getRadius()), number(capsule->getHalfHeight())};
    } else if (const auto* cylinder = dynamic_cast<const btCylinderShape*>(&shape)) {
      turn_to(cylinder->getUpAxis());
      const btVector3 half = cylinder->getHalfExtentsWithMargin();
      def.shape =
          Cylinder<double>{number(cylinder->getRadius()), number(half[cylinder->getUpAxis()])};
    } else if (const auto* cone = dynamic_cast<const btConeShape*>(&shape)) {
      turn_to(cone->getConeUpIndex());
      def.shape = Cone<double>{number(cone->getRadius()), 0.5 * number(cone->getHeight())};
    } else if (const auto* plane = dynamic_cast<const btStaticPlaneShape*>(&shape)) {
      const Vec3<double> n = vector(plane->getPlaneNormal());
      def.shape = HalfSpace<double>{n.normalized(), number(plane->getPlaneConstant()) / n.norm()};
    } else if (const auto* hull = dynamic_cast<const btConvexHullShape*>(&shape)) {
      std::vector<Vec3<double>> points;
      for (int i = 0; i < hull->getNumPoints(); ++i)
        points.push_back(vector(hull->getScaledPoint(i)));
      def.shape = convex_hull<double>(points);
    } else {
      detail::require(false, "btRigidBody: shape", shape.getName(),
                      "must be a box, sphere, capsule, cylinder, cone, plane, hull or compound");
    }
    out.shapes.push_back(std::move(def));
  }

  btDiscreteDynamicsWorld* engine_;
  std::vector<Given> applied_;
};

}  // namespace bristle::inline BRISTLE_ABI
