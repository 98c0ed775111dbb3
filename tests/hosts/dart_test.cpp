/// @file
/// The pinch in DART: held by patches at any step, and let go below Coulomb's limit.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/hosts/dart_host.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <dart/dynamics/ConeShape.hpp>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/dynamics/PrismaticJoint.hpp>
#include <dart/dynamics/RevoluteJoint.hpp>
#include <memory>
#include <string>

using namespace bristle;

namespace {

struct DartPinchDef {
  double mass = 0.045;
  double squeeze = 12;
  double offset = 0;
  double dt = 1e-3;
  /// Whether both pads hang on an arm of seven joints.
  bool has_arm = false;
};

struct DartPinch {
  DartPinchDef def;
  dart::simulation::WorldPtr world = std::make_shared<dart::simulation::World>();
  dart::dynamics::BodyNode* pads[2];
  dart::dynamics::BodyNode* part;
  std::unique_ptr<DartHost<>> host;
  PatchId patches[2];

  explicit DartPinch(const DartPinchDef& d) : def(d) {
    using namespace dart::dynamics;
    world->setTimeStep(def.dt);
    world->setGravity(Eigen::Vector3d::Zero());
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
    for (int k = 0; k < 2; ++k) {
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
        world->addSkeleton(own);
      }
      add_box(*pads[k], Eigen::Vector3d::Zero());
    }
    if (def.has_arm) world->addSkeleton(gripper);
    const SkeletonPtr free = Skeleton::create("part");
    part = free->createJointAndBodyNodePair<FreeJoint>().second;
    Inertia inertia;
    inertia.setMass(def.mass);
    inertia.setLocalCOM(Eigen::Vector3d(0, def.offset, 0));
    inertia.setMoment(def.mass / 3 * 2e-4, def.mass / 3 * 1.25e-4, def.mass / 3 * 1.25e-4, 0, 0, 0);
    part->setInertia(inertia);
    add_box(*part, Eigen::Vector3d::Zero());
    world->addSkeleton(free);

    host = std::make_unique<DartHost<>>(world);
    (void)host->mirror(*part);
    GripWants<double> wants;
    wants.friction = 0.7;
    wants.load = def.squeeze;
    wants.mass = def.mass;
    wants.press = 0.45;
    for (int k = 0; k < 2; ++k) {
      const double side = k == 0 ? 1 : -1;
      PatchDef<double> patch;
      for (int i = 0; i < 36; ++i) {
        const double y = 0.003 * (i % 6 - 2.5);
        const double z = 0.003 * (i / 6 - 2.5);
        patch.sensors.add({side * 0.002, y, z}, {side * 0.010, y, z});
      }
      patch.parameters = tuned_for<double>(wants).parameters(patch.sensors);
      patches[k] = host->add_patch(*pads[k], patch);
    }
  }
  /// A box that DART collides with nothing.
  static void add_box(dart::dynamics::BodyNode& node, const Eigen::Vector3d& place) {
    const auto box = std::make_shared<dart::dynamics::BoxShape>(Eigen::Vector3d(0.01, 0.02, 0.02));
    dart::dynamics::ShapeNode* shape = node.createShapeNodeWith<dart::dynamics::VisualAspect>(box);
    shape->setRelativeTranslation(place);
  }
  void run(double seconds) {
    const long steps = std::lround(seconds / def.dt);
    for (long i = 0; i < steps; ++i) {
      pads[0]->getParentJoint()->setForce(0, def.squeeze);
      pads[1]->getParentJoint()->setForce(0, -def.squeeze);
      host->step();
    }
  }
  /// [m] Where the part is between the pads.
  [[nodiscard]] double height() const {
    return part->getWorldTransform().translation().z() -
           pads[0]->getWorldTransform().translation().z();
  }
  [[nodiscard]] PatchReading<double> felt(int k) const { return host->world().reading(patches[k]); }
  [[nodiscard]] double weight() const {
    return -felt(0).wrench.force.z() - felt(1).wrench.force.z();
  }
  [[nodiscard]] double expected_sag() const {
    const double mu_S = host->world().patch(patches[0]).def.parameters.static_friction;
    return def.mass * 9.81 / (mu_S * (felt(0).total_normal() + felt(1).total_normal()));
  }
};

const Eigen::Vector3d dart_gravity(0, 0, -9.81);

}  // namespace

TEST_CASE("DART: the pinch holds at any step, and sags by m g / (mu_S sum F_N)") {
  for (const DartPinchDef& base :
       {DartPinchDef{.mass = 0.045, .squeeze = 12}, DartPinchDef{.mass = 2, .squeeze = 60}}) {
    for (const double dt : {5e-4, 1e-3, 2e-3, 1.0 / 240, 1.0 / 120, 1.0 / 60}) {
      CAPTURE(base.mass);
      CAPTURE(dt);
      DartPinchDef def = base;
      def.dt = dt;
      DartPinch pinch(def);
      pinch.run(0.5);
      const double start = pinch.height();
      pinch.world->setGravity(dart_gravity);
      pinch.run(1.5);
      const double there = pinch.height();
      pinch.run(2);
      CHECK(std::abs(pinch.height() - there) < 2e-9);
      CHECK(start - there == doctest::Approx(pinch.expected_sag()).epsilon(1e-3));
      CHECK(pinch.weight() == doctest::Approx(def.mass * 9.81).epsilon(1e-9));
    }
  }
}

TEST_CASE("DART: a part whose centre of mass lies beside the pads does not turn on") {
  for (const double dt : {1e-3, 1.0 / 60}) {
    DartPinch pinch({.squeeze = 30, .offset = 0.04, .dt = dt});
    pinch.run(0.5);
    pinch.world->setGravity(dart_gravity);
    pinch.run(1.5);
    const Eigen::Vector3d there = pinch.part->getCOM();
    pinch.run(2);
    CHECK((pinch.part->getCOM() - there).norm() < 2e-9);
    CHECK(pinch.weight() == doctest::Approx(pinch.def.mass * 9.81).epsilon(1e-9));
  }
}

TEST_CASE("DART: pads on an arm of seven joints hold a part as on slides") {
  for (const double dt : {1e-3, 1.0 / 240, 1.0 / 120}) {
    CAPTURE(dt);
    DartPinch pinch({.dt = dt, .has_arm = true});
    pinch.run(1);
    const double start = pinch.height();
    pinch.world->setGravity(dart_gravity);
    pinch.run(5);
    const double there = pinch.height();
    pinch.run(2);
    CHECK(std::abs(pinch.height() - there) < 2e-8);
    CHECK(start - there == doctest::Approx(pinch.expected_sag()).epsilon(0.02));
    CHECK(pinch.weight() == doctest::Approx(pinch.def.mass * 9.81).epsilon(1e-6));
  }
}

TEST_CASE("DART: a squeeze below Coulomb's limit lets go, and one above it holds") {
  const double limit = 0.045 * 9.81 / (2 * 0.7);
  for (const double factor : {1.01, 0.99}) {
    CAPTURE(factor);
    DartPinch pinch({});
    pinch.run(0.5);
    pinch.world->setGravity(dart_gravity);
    pinch.run(0.5);
    while (pinch.def.squeeze > factor * limit) {
      pinch.def.squeeze *= 0.99;
      pinch.run(0.01);
    }
    pinch.def.squeeze = factor * limit;
    const double start = pinch.height();
    pinch.run(2);
    CHECK((std::abs(pinch.height() - start) < 1e-4) == (factor > 1));
  }
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
  pinch.world->step();
  // From rest; but for the positions that the velocities are at, which differ by dt of them.
  const double tolerance = 10 * pinch.def.dt * own.norm();
  CHECK((twist(*pinch.pads[0]) - own).norm() < tolerance);
  CHECK((twist(*pinch.pads[1]) - other).norm() < tolerance);
  CHECK(own.norm() > 0);
}

TEST_CASE("DART: forces of the caller stay, and what has no shape like it is refused by name") {
  DartPinch pinch({});
  pinch.run(0.3);
  for (int i = 0; i < 2000; ++i) {
    pinch.part->addExtForce(Eigen::Vector3d(0, 0.25, 0));
    pinch.run(pinch.def.dt);
  }
  CHECK(pinch.felt(0).wrench.force.y() + pinch.felt(1).wrench.force.y() ==
        doctest::Approx(0.25).epsilon(1e-6));
  const auto cone = std::make_shared<dart::dynamics::ConeShape>(0.1, 0.2);
  const auto other = dart::dynamics::Skeleton::create("other");
  dart::dynamics::BodyNode& node =
      *other->createJointAndBodyNodePair<dart::dynamics::FreeJoint>().second;
  node.createShapeNodeWith<dart::dynamics::VisualAspect>(cone);
  pinch.world->addSkeleton(other);
  const std::uint64_t before = pinch.host->world().state_hash();
  CHECK_THROWS_WITH_AS(pinch.host->mirror(node), doctest::Contains("ConeShape"), InvalidArgument);
  CHECK(pinch.host->world().state_hash() == before);
}
