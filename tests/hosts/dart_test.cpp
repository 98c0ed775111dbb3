/// @file
/// The pinch in DART.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/pinch.hpp"
#include "support/pinch_checks.hpp"
#include "support/relative.hpp"

#include <bristle/hosts/dart_host.hpp>

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dart/dynamics/ConeShape.hpp>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/dynamics/PrismaticJoint.hpp>
#include <dart/dynamics/RevoluteJoint.hpp>
#include <memory>
#include <string>

using namespace bristle;

using namespace bristle::detail;
using namespace bristle::scenes;

namespace {

class DartPinch : public Pinch {
 public:
  explicit DartPinch(const PinchDef& d) : Pinch(d) {
    using namespace dart::dynamics;
    dart->setTimeStep(def.dt);
    dart->setGravity(Eigen::Vector3d::Zero());
    const SkeletonPtr gripper = Skeleton::create("gripper");
    BodyNode* wrist = nullptr;
    Eigen::Vector3d wrist_place = Eigen::Vector3d::Zero();
    for (int i = 0; def.has_arm && i < 7; ++i) {
      const Eigen::Vector3d axes[] = {Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitY(),
                                      Eigen::Vector3d::UnitX()};
      RevoluteJoint::Properties joint;
      joint.mName = "arm" + std::to_string(i);
      joint.mAxis = axes[i % 3];
      const Eigen::Vector3d place =
          i == 0 ? Eigen::Vector3d(-0.5, 0, -0.3) : Eigen::Vector3d(0.5 / 6, 0, 0.05);
      joint.mT_ParentBodyToJoint.translation() = place;
      wrist_place += place;
      wrist = gripper
                  ->createJointAndBodyNodePair<RevoluteJoint>(
                      wrist, joint, BodyNode::AspectProperties(joint.mName))
                  .second;
      wrist->getParentJoint()->setSpringStiffness(0, 2000);
      wrist->getParentJoint()->setDampingCoefficient(0, 20);
      Inertia ball;  // of 40 mm radius
      ball.setMass(1);
      ball.setMoment(6.4e-4, 6.4e-4, 6.4e-4, 0, 0, 0);
      wrist->setInertia(ball);
    }
    for (std::size_t k = 0; k < 2; ++k) {
      PrismaticJoint::Properties joint;
      joint.mName = k == 0 ? "left" : "right";
      joint.mAxis = Eigen::Vector3d::UnitX();
      joint.mT_ParentBodyToJoint.translation() =
          Eigen::Vector3d(k == 0 ? -0.0101 : 0.0101, 0, 0) - wrist_place;
      const SkeletonPtr own = def.has_arm ? gripper : Skeleton::create(joint.mName);
      pads[k] = own->createJointAndBodyNodePair<PrismaticJoint>(
                       wrist, joint, BodyNode::AspectProperties(joint.mName))
                    .second;
      Inertia small;
      small.setMass(0.1);
      small.setMoment(1e-5, 1e-5, 1e-5, 0, 0, 0);
      pads[k]->setInertia(small);
      if (def.has_arm) {
        // On a tilted arm nothing else keeps them between the ends of the slides.
        pads[k]->getParentJoint()->setSpringStiffness(0, 1000);
        pads[k]->getParentJoint()->setDampingCoefficient(0, 20);
      } else {
        dart->addSkeleton(own);
      }
      add_box(*pads[k], Eigen::Vector3d::Zero());
    }
    if (def.has_arm) dart->addSkeleton(gripper);
    const SkeletonPtr free = Skeleton::create("part");
    part_node = free->createJointAndBodyNodePair<FreeJoint>().second;
    Inertia inertia;
    inertia.setMass(def.mass);
    inertia.setLocalCOM(Eigen::Vector3d(0, def.offset, 0));
    inertia.setMoment(def.mass / 3 * 2e-4, def.mass / 3 * 1.25e-4, def.mass / 3 * 1.25e-4, 0, 0, 0);
    part_node->setInertia(inertia);
    add_box(*part_node, Eigen::Vector3d::Zero());
    dart->addSkeleton(free);

    host = std::make_unique<DartHost<>>(dart);
    (void)host->mirror(*part_node);
    for (std::size_t k = 0; k < 2; ++k) {
      patches[k] = host->add_patch(*pads[k], pinch_pad(k == 0 ? 1 : -1, def.spec()));
    }
  }

  [[nodiscard]] World<double>& world() override { return host->world(); }
  [[nodiscard]] std::size_t missing() override { return host->sensors().report().missing_bodies; }
  [[nodiscard]] Vec3<double> part() const override { return part_node->getCOM(); }
  [[nodiscard]] Vec3<double> pad(std::size_t k) const override {
    return pads[k]->getWorldTransform().translation();
  }
  void open(double gap, double speed) override {
    for (std::size_t k = 0; k < 2; ++k) {
      const double side = k == 0 ? 1 : -1;
      dart::dynamics::Joint* joint = pads[k]->getParentJoint();
      joint->setPosition(0, joint->getPosition(0) - side * gap);
      joint->setVelocity(0, side * speed);
    }
  }
  void step() override {
    pads[0]->getParentJoint()->setForce(0, def.squeeze);
    pads[1]->getParentJoint()->setForce(0, -def.squeeze);
    dart->setGravity(gravity);
    host->step();
  }

  dart::simulation::WorldPtr dart = std::make_shared<dart::simulation::World>();
  std::array<dart::dynamics::BodyNode*, 2> pads{};
  dart::dynamics::BodyNode* part_node = nullptr;
  std::unique_ptr<DartHost<>> host;

 private:
  /// A box that DART collides with nothing.
  static void add_box(dart::dynamics::BodyNode& node, const Eigen::Vector3d& place) {
    const auto box = std::make_shared<dart::dynamics::BoxShape>(Eigen::Vector3d(0.01, 0.02, 0.02));
    dart::dynamics::ShapeNode* shape = node.createShapeNodeWith<dart::dynamics::VisualAspect>(box);
    shape->setRelativeTranslation(place);
  }
};

}  // namespace

TEST_CASE("DART: two pads hold a part at any step, and it sags by m g / (mu_S sum F_N)") {
  check_holds<DartPinch>({.mass = 0.045, .squeeze = 12}, {});
  check_holds<DartPinch>({.mass = 2, .squeeze = 60}, {});
}

TEST_CASE("DART: a part whose centre of mass lies beside the pads is held against turning") {
  check_holds<DartPinch>({.squeeze = 30, .offset = 0.04}, {});
}

TEST_CASE("DART: the squeeze decides whether a part is held or let go") {
  check_lets_go<DartPinch>();
}

TEST_CASE("DART: a shaken part swings as a spring and damper does, and comes back") {
  check_shaken<DartPinch>();
}

TEST_CASE("DART: pads that come from out of reach catch a part in a long step") {
  check_caught<DartPinch>({});
}

TEST_CASE("DART: pads on an arm of seven joints hold a part as on slides") {
  check_on_arm<DartPinch>();
}

TEST_CASE("DART: a body that a caller adds to the mirror himself is missing, and harms nobody") {
  check_stranger<DartPinch>();
}

TEST_CASE("DART: mobility is what a step does with a wrench, springs and dampers included") {
  DartPinch pinch({.has_arm = true});
  const BodyId left = pinch.host->mirror(*pinch.pads[0]);
  const BodyId right = pinch.host->mirror(*pinch.pads[1]);
  const auto twist = [](const dart::dynamics::BodyNode& node) {
    Vec6<double> v;
    v << node.getCOMLinearVelocity(), node.getAngularVelocity();
    return v;
  };
  const Wrench<double> wrench{{0.3, -0.2, 0.5}, {0.01, 0.02, -0.03}};
  Vec6<double> impulse;
  impulse << pinch.def.dt * wrench.force, pinch.def.dt * wrench.torque;
  const Vec6<double> own = pinch.host->mobility(left, left) * impulse;
  const Vec6<double> other = pinch.host->mobility(right, left) * impulse;
  pinch.host->apply_wrench(left, wrench);
  pinch.dart->step();
  // From rest; but for the positions that the velocities are at, which differ by dt of them.
  const double tolerance = 10 * pinch.def.dt * own.norm();
  CHECK((twist(*pinch.pads[0]) - own).norm() < tolerance);
  CHECK((twist(*pinch.pads[1]) - other).norm() < tolerance);
  CHECK(own.norm() > 0);
}

TEST_CASE("DART: forces of the caller stay, and what has no shape like it is refused by name") {
  DartPinch pinch{{}};
  pinch.run(0.3);
  for (int i = 0; i < 2000; ++i) {
    pinch.part_node->addExtForce(Eigen::Vector3d(0, 0.25, 0));
    pinch.run(pinch.def.dt);
  }
  CHECK(pinch.reading(0).wrench.force.y() + pinch.reading(1).wrench.force.y() ==
        test::relative(0.25).epsilon(1e-6));
  const auto cone = std::make_shared<dart::dynamics::ConeShape>(0.1, 0.2);
  const auto other = dart::dynamics::Skeleton::create("other");
  dart::dynamics::BodyNode& node =
      *other->createJointAndBodyNodePair<dart::dynamics::FreeJoint>().second;
  node.createShapeNodeWith<dart::dynamics::VisualAspect>(cone);
  pinch.dart->addSkeleton(other);
  const std::uint64_t before = pinch.host->world().state_hash();
  CHECK_THROWS_WITH_AS(pinch.host->mirror(node), doctest::Contains("ConeShape"), InvalidArgument);
  CHECK(pinch.host->world().state_hash() == before);
}

TEST_CASE("DART: a part whose skeleton has left the world is let go") {
  DartPinch pinch{{}};
  pinch.run(0.1);
  CHECK(pinch.reading(0).touching() == 36);
  const dart::dynamics::SkeletonPtr part = pinch.part_node->getSkeleton();
  pinch.dart->removeSkeleton(part);
  pinch.step();
  CHECK(pinch.reading(0).touching() == 0);
  CHECK(pinch.missing() == 1);
}
