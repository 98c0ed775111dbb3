// A part is pinched and lifted in Bullet: by Bullet's own contacts, and by bristle's sensors.
//
// The host takes the callback before each tick of a btDiscreteDynamicsWorld, so that the program
// steps its world as before.
// The table says how fast a light part and a heavy one creep out of the pads at steps from 1 to 17
// ms; the plot shows where they are between the pads.
//
// Usage: host_bullet [PLOT.svg]
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/pinch.hpp"
#include "support/lifted_pinch.hpp"

#include <bristle/bristle.hpp>
#include <bristle/hosts/bullet_host.hpp>

#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <optional>

using namespace bristle;
using namespace figure;

namespace {

// Debian's Bullet counts in float.
btScalar scalar(double x) { return static_cast<btScalar>(x); }

class BulletPinch {
 public:
  BulletPinch(const LiftedPinch& pinch, bool has_sensors) : pinch_(pinch) {
    world_.setGravity(btVector3(0, 0, scalar(-pinch.gravity)));
    for (btRigidBody* body : {&part_, &pads_[0], &pads_[1]}) {
      // Bullet multiplies the coefficients of two bodies.
      body->setFriction(scalar(std::sqrt(pinch.friction)));
      body->setActivationState(DISABLE_DEACTIVATION);
      // Sensors do what contacts did: with them, bodies collide with nothing.
      world_.addRigidBody(body, 1, has_sensors ? 0 : 1);
    }
    for (btRigidBody& pad : pads_) {
      pad.setLinearFactor(btVector3(1, 0, 0));
      pad.setAngularFactor(btVector3(0, 0, 0));
    }
    if (!has_sensors) return;
    host_.emplace(world_);
    host_->mirror(part_);
    host_->add_patch(pads_[0], scenes::pinch_pad(1, pinch.spec()));
    host_->add_patch(pads_[1], scenes::pinch_pad(-1, pinch.spec()));
  }
  ~BulletPinch() {
    host_.reset();
    for (btRigidBody* body : {&part_, &pads_[0], &pads_[1]}) world_.removeRigidBody(body);
  }
  BulletPinch(const BulletPinch&) = delete;
  BulletPinch& operator=(const BulletPinch&) = delete;

  void step(double t) {
    for (btRigidBody& pad : pads_) {
      pad.setLinearVelocity(btVector3(pad.getLinearVelocity().x(), 0, scalar(pinch_.speed(t))));
    }
    pads_[0].applyCentralForce(btVector3(scalar(pinch_.squeeze), 0, 0));
    pads_[1].applyCentralForce(btVector3(scalar(-pinch_.squeeze), 0, 0));
    world_.stepSimulation(scalar(pinch_.dt), 0);
  }
  [[nodiscard]] double place() const {
    return height(part_) - 0.5 * (height(pads_[0]) + height(pads_[1]));
  }

 private:
  static double height(const btRigidBody& body) {
    return static_cast<double>(body.getWorldTransform().getOrigin().z());
  }
  btRigidBody body(double mass, double x) {
    btVector3 inertia;
    box_.calculateLocalInertia(scalar(mass), inertia);
    btRigidBody::btRigidBodyConstructionInfo info(scalar(mass), nullptr, &box_, inertia);
    info.m_startWorldTransform.setOrigin(btVector3(scalar(x), 0, 0));
    return btRigidBody(info);
  }

  LiftedPinch pinch_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  btBoxShape box_{btVector3(scalar(0.005), scalar(0.01), scalar(0.01))};
  btRigidBody part_ = body(pinch_.mass, 0);
  std::array<btRigidBody, 2> pads_{body(0.1, -0.0101), body(0.1, 0.0101)};
  std::optional<BulletHost<>> host_;
};

}  // namespace

int main(int count, char** arguments) {
  try {
    const char* plot = count > 1 ? arguments[1] : "host_bullet.svg";
    return compare_pinches<BulletPinch>("Bullet", plot, 1e-7);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "host_bullet: %s\n", error.what());
    return 2;
  }
}
