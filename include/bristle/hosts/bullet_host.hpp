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

#include <bristle/hosts/bullet_conversions.hpp>
#include <bristle/hosts/bullet_mechanism.hpp>
#include <bristle/hosts/bullet_shapes.hpp>
#include <bristle/hosts/engine_host.hpp>

#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <algorithm>
#include <btBulletDynamicsCommon.h>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// The bodies of a Bullet world as `HostSensors` sees them, in double for any build of Bullet:
/// rigid bodies, the links of multibodies by their colliders, and collision objects that stand
/// still. Frames are those of Bullet, about centres of mass. Axes that linear and angular factors
/// lock are known, and so are the joints of multibodies. Constraints are not: express a finger on a
/// slider by its factors, or as a link.
template <typename Backend = AnalyticBackend>
class BulletHost : public EngineHost<btCollisionObject*, Backend>, private btActionInterface {
  using Base = EngineHost<btCollisionObject*, Backend>;

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
  /// @throws InvalidArgument when no shape of bristle matches the body's, or a mesh is open.
  BodyId mirror(btCollisionObject& body) {
    if (const auto known = this->find(&body)) return *known;
    return mirror(body, detail::shapes_of(*body.getCollisionShape()));
  }
  /// Mirrors a body with other shapes than Bullet's: terrain as an `extruded_mesh`, a mesh in the
  /// place of its hulls.
  /// @return The same id again for a body that is mirrored already, with the shapes that it has.
  /// @throws InvalidArgument when a shape is refused.
  BodyId mirror(btCollisionObject& body, std::vector<ShapeDef<double>> shapes) {
    if (const auto known = this->find(&body)) return *known;
    return this->insert(&body, body.isStaticObject() ? Motion::fixed : Motion::kinematic,
                        detail::from_bullet(body.getWorldTransform()), detail::zero<Vec3<double>>(),
                        std::move(shapes));
  }
  /// Adds sensors to a body, in its frame. Mirrors it if needed.
  PatchId add_patch(btCollisionObject& body, const PatchDef<double>& def) {
    return this->add_patch_to(&body, def, [&] { return mirror(body); });
  }

  // Interface that `HostSensors` queries.

  /// State of a body, with its acceleration by present forces; nothing if not mirrored.
  [[nodiscard]] std::optional<HostBody<double>> body(BodyId id) const {
    if (!this->key_of(id)) return {};
    btCollisionObject* object = *this->key_of(id);
    HostBody<double> state;
    state.pose = detail::from_bullet(object->getWorldTransform());
    state.center = state.pose.translation;
    if (const auto* b = btRigidBody::upcast(object)) {
      state.twist = {detail::from_bullet(b->getLinearVelocity()),
                     detail::from_bullet(b->getAngularVelocity())};
      // Before a tick, forces include gravity.
      state.acceleration = {
          detail::from_bullet(b->getTotalForce() * b->getInvMass()),
          detail::from_bullet(b->getInvInertiaTensorWorld() * b->getTotalTorque())};
    } else if (const auto* link = btMultiBodyLinkCollider::upcast(object)) {
      detail::BulletMechanism& mechanism = mechanism_of(*link->m_multiBody);
      state.twist = mechanism.velocity(link->m_link);
      state.acceleration = (1 / static_cast<double>(dt_)) * mechanism.gain(link->m_link);
      state.mechanism = static_cast<std::uint32_t>(&mechanism - mechanisms_.data());
    }
    return state;
  }
  /// [1/kg, 1/(kg m^2)] Mobility of a body without its locked axes, or between two links of one
  /// multibody.
  [[nodiscard]] Mat6<double> mobility(BodyId i, BodyId j) const {
    btCollisionObject* object = *this->key_of(i);
    if (const auto* link = btMultiBodyLinkCollider::upcast(object)) {
      const auto* other = btMultiBodyLinkCollider::upcast(*this->key_of(j));
      return mechanism_of(*link->m_multiBody).mobility(link->m_link, other->m_link);
    }
    const btRigidBody* b = btRigidBody::upcast(object);
    if (b == nullptr || b->isStaticOrKinematicObject()) return detail::zero<Mat6<double>>();
    const Vec3<double> turns = detail::from_bullet(b->getAngularFactor());
    Mat3<double> inverse_inertia;
    for (int k = 0; k < 3; ++k) {
      inverse_inertia.row(k) =
          turns[k] * detail::from_bullet(b->getInvInertiaTensorWorld()[k]).transpose();
    }
    const Vec3<double> inverse_mass = detail::from_bullet(b->getLinearFactor() * b->getInvMass());
    return free_mobility<double>(inverse_mass, inverse_inertia * turns.asDiagonal());
  }
  /// Applies a wrench [N, N m] about the centre of mass for one tick. Activates the body.
  void apply_wrench(BodyId id, const Wrench<double>& wrench) {
    applied_.push_back(
        {*this->key_of(id), detail::to_bullet(wrench.force), detail::to_bullet(wrench.torque)});
    apply(applied_.back(), 1);
    applied_.back().object->activate();
    if (const auto* link = btMultiBodyLinkCollider::upcast(applied_.back().object)) {
      detail::wake(*link);
    }
  }

 private:
  /// Wrench applied to a body for the present tick [N, N m].
  struct AppliedWrench {
    btCollisionObject* object = nullptr;
    btVector3 force, torque;
  };

  void sense(btScalar dt) {
    dt_ = dt;
    // A caller may have asked for a body between two ticks.
    for (detail::BulletMechanism& mechanism : mechanisms_) (void)mechanism.end();
    this->sensors().step(*this, static_cast<double>(dt));
  }
  /// A multibody in this tick.
  [[nodiscard]] detail::BulletMechanism& mechanism_of(btMultiBody& body) const {
    auto found = std::find_if(mechanisms_.begin(), mechanisms_.end(),
                              [&](const detail::BulletMechanism& m) { return m.key() == &body; });
    if (found == mechanisms_.end()) found = mechanisms_.emplace(found, body);
    found->begin(dt_);
    return *found;
  }
  static void apply(const AppliedWrench& applied, btScalar times) {
    if (auto* body = btRigidBody::upcast(applied.object)) {
      body->applyCentralForce(times * applied.force);
      body->applyTorque(times * applied.torque);
    } else if (auto* link = btMultiBodyLinkCollider::upcast(applied.object)) {
      detail::add_wrench(*link, times * applied.force, times * applied.torque);
    }
  }
  /// Removes the wrenches after their tick: Bullet applies forces in all ticks of a step.
  void updateAction(btCollisionWorld*, btScalar) override {
    for (const AppliedWrench& applied : applied_) apply(applied, -1);
    applied_.clear();
    // Those that nobody asked for in this tick have no mirrored link any more.
    std::erase_if(mechanisms_, [](detail::BulletMechanism& m) { return !m.end(); });
  }
  void debugDraw(btIDebugDraw*) override {}

  btDiscreteDynamicsWorld* engine_;
  /// [s] Length of the tick.
  btScalar dt_ = btScalar(1) / 60;
  std::vector<AppliedWrench> applied_;
  /// The multibodies of mirrored links, as Bullet has them in this tick.
  mutable std::vector<detail::BulletMechanism> mechanisms_;
};

}  // namespace bristle::inline BRISTLE_ABI
