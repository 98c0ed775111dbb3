/// @file
/// The pinch in Bullet: with pads that are rigid bodies, and with pads that are links of a
/// multibody.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/hosts/bullet_host.hpp>

#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <scenes/pinch.hpp>
#include <vector>

namespace bristle::scenes {

[[nodiscard]] inline btScalar bullet_number(double x) { return static_cast<btScalar>(x); }

/// A Bullet world with what it needs.
struct BulletWorld {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btMultiBodyConstraintSolver solver;
  btMultiBodyDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
  std::vector<std::unique_ptr<btRigidBody>> bodies;

  BulletWorld() { world.setGravity(btVector3(0, 0, 0)); }
  ~BulletWorld() {
    for (const auto& body : bodies) world.removeRigidBody(body.get());
  }
  BulletWorld(const BulletWorld&) = delete;
  BulletWorld& operator=(const BulletWorld&) = delete;

  /// A body that collides with nothing but, where it has friction, with others that have it.
  btRigidBody& add(double mass, btCollisionShape& shape, const btVector3& inertia,
                   const btVector3& place, double friction = 0) {
    btRigidBody::btRigidBodyConstructionInfo info(bullet_number(mass), nullptr, &shape, inertia);
    info.m_startWorldTransform.setOrigin(place);
    bodies.push_back(std::make_unique<btRigidBody>(info));
    btRigidBody& body = *bodies.back();
    body.setActivationState(DISABLE_DEACTIVATION);
    // Bullet multiplies the coefficients of two bodies.
    body.setFriction(bullet_number(std::sqrt(friction)));
    world.addRigidBody(&body, 1, friction > 0 ? 1 : 0);
    return body;
  }
};

class BulletPinch : public Pinch {
 public:
  explicit BulletPinch(const PinchDef& d) : Pinch(d) {
    btVector3 inertia;
    box_.calculateLocalInertia(bullet_number(def.mass), inertia);
    btTransform beside = btTransform::getIdentity();
    beside.setOrigin(btVector3(0, bullet_number(-def.offset), 0));
    part_shape_.addChildShape(beside, &box_);
    const double friction = def.has_contacts ? def.friction : 0;
    part_body = &bullet.add(def.mass, part_shape_, inertia,
                            btVector3(0, bullet_number(def.offset), 0), friction);
    host = std::make_unique<BulletHost<>>(bullet.world);
    (void)host->mirror(*part_body);
    for (std::size_t k = 0; k < 2; ++k) {
      const double side = k == 0 ? 1 : -1;
      pads_[k] = &bullet.add(pad_mass, box_, btVector3(1, 1, 1),
                             btVector3(bullet_number(-side * 0.0101), 0, 0), friction);
      pads_[k]->setLinearFactor(btVector3(1, 0, 0));
      pads_[k]->setAngularFactor(btVector3(0, 0, 0));
      patches[k] = host->add_patch(*pads_[k], pinch_pad(side, def.spec(), def.across));
    }
  }

  [[nodiscard]] World<double>& world() override { return host->world(); }
  [[nodiscard]] std::size_t missing() override { return host->sensors().report().missing_bodies; }
  [[nodiscard]] Vec3<double> part() const override { return place_of(*part_body); }
  [[nodiscard]] Vec3<double> pad(std::size_t k) const override { return place_of(*pads_[k]); }
  void open(double gap, double speed) override {
    for (std::size_t k = 0; k < 2; ++k) {
      const double side = k == 0 ? 1 : -1;
      pads_[k]->getWorldTransform().getOrigin() -= btVector3(bullet_number(side * gap), 0, 0);
      pads_[k]->setLinearVelocity(btVector3(bullet_number(side * speed), 0, 0));
    }
  }
  void step() override {
    pads_[0]->applyCentralForce(btVector3(bullet_number(def.squeeze), 0, 0));
    pads_[1]->applyCentralForce(btVector3(bullet_number(-def.squeeze), 0, 0));
    part_body->setGravity(btVector3(bullet_number(gravity.x()), bullet_number(gravity.y()),
                                    bullet_number(gravity.z())));
    const double length = def.dt * def.substeps;
    // Of one tick, without Bullet's clock; of more with it, and a little over.
    if (def.substeps == 1) {
      bullet.world.stepSimulation(bullet_number(length), 0);
    } else {
      bullet.world.stepSimulation(bullet_number(length), def.substeps, bullet_number(def.dt));
    }
  }

 private:
  [[nodiscard]] static Vec3<double> place_of(const btRigidBody& body) {
    const btVector3& x = body.getWorldTransform().getOrigin();
    return {static_cast<double>(x.x()), static_cast<double>(x.y()), static_cast<double>(x.z())};
  }

  btBoxShape box_{btVector3(bullet_number(0.005), bullet_number(0.01), bullet_number(0.01))};
  btCompoundShape part_shape_;

 public:
  BulletWorld bullet;
  btRigidBody* part_body = nullptr;
  std::unique_ptr<BulletHost<>> host;

 private:
  std::array<btRigidBody*, 2> pads_{};
};

/// A multibody in a Bullet world, with colliders that collide with nothing.
class BulletChain {
 public:
  /// @param base_mass  [kg] 0 for a base that is fixed.
  /// @param can_sleep  False to keep it awake.
  BulletChain(BulletWorld& bullet, int links, double base_mass, const btVector3& base,
              bool can_sleep = false)
      : bullet_(&bullet),
        body(links, bullet_number(base_mass), inertia, base_mass == 0, can_sleep) {
    body.setBasePos(base);
    // Bullet's defaults take energy.
    body.setLinearDamping(0);
    body.setAngularDamping(0);
  }
  ~BulletChain() {
    for (const auto& collider : colliders) bullet_->world.removeCollisionObject(collider.get());
    bullet_->world.removeMultiBody(&body);
  }
  BulletChain(const BulletChain&) = delete;
  BulletChain& operator=(const BulletChain&) = delete;

  void add_turning(int link, int parent, double mass, const btVector3& axis,
                   const btVector3& from_parent, const btVector3& to_center) {
    body.setupRevolute(link, bullet_number(mass), inertia, parent, btQuaternion::getIdentity(),
                       axis, from_parent, to_center, true);
  }
  void add_sliding(int link, int parent, double mass, const btVector3& from_parent) {
    body.setupPrismatic(link, bullet_number(mass), inertia, parent, btQuaternion::getIdentity(),
                        btVector3(1, 0, 0), from_parent, btVector3(0, 0, 0), true);
  }
  /// Ends the making of joints, and puts the multibody into the world.
  void finish(btCollisionShape& shape) {
    body.finalizeMultiDof();
    bullet_->world.addMultiBody(&body);
    for (int link = -1; link < body.getNumLinks(); ++link) {
      colliders.push_back(std::make_unique<btMultiBodyLinkCollider>(&body, link));
      btMultiBodyLinkCollider* collider = colliders.back().get();
      collider->setCollisionShape(&shape);
      bullet_->world.addCollisionObject(collider, 1, 0);
      if (link < 0) {
        body.setBaseCollider(collider);
      } else {
        body.getLink(link).m_collider = collider;
      }
    }
    update();
  }
  /// Brings places that Bullet keeps in line with the joints.
  void update() {
    btAlignedObjectArray<btQuaternion> rotations;
    btAlignedObjectArray<btVector3> places;
    body.forwardKinematics(rotations, places);
    body.updateCollisionObjectWorldTransforms(rotations, places);
  }
  [[nodiscard]] btMultiBodyLinkCollider& collider(int link) const {
    return *colliders[static_cast<std::size_t>(link + 1)];
  }

 private:
  BulletWorld* bullet_;
  /// [kg m^2] Of links. Drives of the arm are explicit, so that light links would not be stable.
  const btVector3 inertia{bullet_number(0.05), bullet_number(0.06), bullet_number(0.07)};

 public:
  btMultiBody body;
  std::vector<std::unique_ptr<btMultiBodyLinkCollider>> colliders;
};

/// The pinch with pads that are links of a multibody: on slides on its base, or on an arm of seven
/// joints.
class BulletLinkPinch : public Pinch {
 public:
  explicit BulletLinkPinch(const PinchDef& d)
      : Pinch(d), arm_(bullet_, d.has_arm ? 9 : 2, 0, base_place(d)) {
    btVector3 inertia;
    box_.calculateLocalInertia(bullet_number(def.mass), inertia);
    part_ = &bullet_.add(def.mass, box_, inertia, btVector3(0, 0, 0));
    btVector3 wrist = base_place(d);
    const int joints = d.has_arm ? 7 : 0;
    for (int i = 0; i < joints; ++i) {
      const btVector3 axes[] = {{0, 0, 1}, {0, 1, 0}, {1, 0, 0}};
      const btVector3 place(bullet_number(i == 0 ? 0 : 0.5 / 6), 0,
                            bullet_number(i == 0 ? 0 : 0.05));
      arm_.add_turning(i, i - 1, 1, axes[i % 3], place, btVector3(0, 0, 0));
      wrist += place;
    }
    for (int k = 0; k < 2; ++k) {
      arm_.add_sliding(joints + k, joints - 1, pad_mass,
                       btVector3(bullet_number(k == 0 ? -0.0101 : 0.0101), 0, 0) - wrist);
    }
    arm_.finish(box_);
    (void)host_.mirror(*part_);
    for (int k = 0; k < 2; ++k) {
      pads_[static_cast<std::size_t>(k)] = joints + k;
      patches[static_cast<std::size_t>(k)] = host_.add_patch(
          arm_.collider(joints + k), pinch_pad(k == 0 ? 1 : -1, def.spec(), def.across));
    }
  }

  [[nodiscard]] World<double>& world() override { return host_.world(); }
  [[nodiscard]] std::size_t missing() override { return host_.sensors().report().missing_bodies; }
  [[nodiscard]] Vec3<double> part() const override { return place_of(*part_); }
  [[nodiscard]] Vec3<double> pad(std::size_t k) const override {
    return place_of(arm_.collider(pads_[k]));
  }
  void open(double gap, double speed) override {
    for (std::size_t k = 0; k < 2; ++k) {
      const double side = k == 0 ? 1 : -1;
      arm_.body.setJointPos(pads_[k], bullet_number(-side * gap));
      arm_.body.setJointVel(pads_[k], bullet_number(side * speed));
    }
    arm_.update();
  }
  void step() override {
    part_->setGravity(detail::to_bullet(gravity));
    bullet_.world.setGravity(detail::to_bullet(gravity));
    if (def.has_arm) {
      for (int i = 0; i < 7; ++i) drive(i, 500, 5);
      // On a tilted arm nothing else keeps the pads between the ends of the slides.
      for (const int link : pads_) drive(link, 1000, 20);
    }
    arm_.body.addJointTorque(pads_[0], bullet_number(def.squeeze));
    arm_.body.addJointTorque(pads_[1], bullet_number(-def.squeeze));
    // Of one tick, without Bullet's clock; of more with it, and a little over.
    const bool is_one = def.substeps == 1;
    bullet_.world.stepSimulation(bullet_number(def.dt * def.substeps), is_one ? 0 : def.substeps,
                                 bullet_number(def.dt));
  }

 private:
  /// A spring [N/m, N m/rad] and a damper of a joint.
  void drive(int link, double spring, double damper) {
    arm_.body.addJointTorque(link, -bullet_number(spring) * arm_.body.getJointPos(link) -
                                       bullet_number(damper) * arm_.body.getJointVel(link));
  }
  [[nodiscard]] static btVector3 base_place(const PinchDef& d) {
    return d.has_arm ? btVector3(bullet_number(-0.5), 0, bullet_number(-0.3)) : btVector3(0, 0, 0);
  }
  [[nodiscard]] static Vec3<double> place_of(const btCollisionObject& body) {
    return detail::from_bullet(body.getWorldTransform().getOrigin());
  }

  btBoxShape box_{btVector3(bullet_number(0.005), bullet_number(0.01), bullet_number(0.01))};
  BulletWorld bullet_;
  BulletChain arm_;
  BulletHost<> host_{bullet_.world};
  btRigidBody* part_ = nullptr;
  std::array<int, 2> pads_{};
};

}  // namespace bristle::scenes
