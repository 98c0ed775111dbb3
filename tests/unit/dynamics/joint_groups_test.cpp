// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/dynamics/joints/mechanism_integrator.hpp>
#include <bristle/math/rotation.hpp>

#include <doctest/doctest.h>

#include <numbers>
#include <random>
#include <vector>

using namespace bristle;

using namespace bristle::detail;

namespace {

MechanismJoint<double> joined(std::uint32_t a, std::uint32_t b, JointKind kind) {
  MechanismJoint<double> joint;
  joint.kind = kind;
  joint.body_a = a;
  joint.body_b = b;
  return joint;
}

/// A body of 2 kg that swings on a fixed one about y, on `count` hinges along the same axis, every
/// other one with the two bodies exchanged.
struct Pendulum {
  std::vector<MechanismBody<double>> bodies{2};
  std::vector<MechanismJoint<double>> joints;
  Wrench<double> total;  // On the body, about its hinge.
  double energy = 0.0;

  explicit Pendulum(int count, double disagreement = 0.0) {
    MechanismBody<double>& body = bodies[1];
    body.moves_by_forces = true;
    body.mass = 2.0;
    body.inertia_B = Vec3<double>(0.01, 0.02, 0.03).asDiagonal();
    body.inverse_inertia_B = body.inertia_B.inverse();
    body.center_pose.translation = {0.3, 0, 0};
    body.load.force = {0, 0, -2.0 * 9.81};
    const Quat<double> to_y = exp_rotation<double>(std::numbers::pi / 2 * Vec3<double>::UnitZ());
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (int i = 0; i < count; ++i) {
      MechanismJoint<double> joint = joined(0, 1, JointKind::revolute);
      const Vec3<double> along(0, count > 1 ? 0.1 * uniform(random) : 0.0, 0);
      const Vec3<double> off(uniform(random), uniform(random), uniform(random));
      joint.X_CmA_J = {to_y, along};
      joint.X_CmB_J = {to_y, Vec3<double>(along + Vec3<double>(-0.3, 0, 0) + disagreement * off)};
      if (i % 2 == 1) {
        std::swap(joint.body_a, joint.body_b);
        std::swap(joint.X_CmA_J, joint.X_CmB_J);
      }
      joints.push_back(joint);
    }
  }

  bool step(MechanismIntegrator<double>& integrator, double dt) {
    std::vector<Transform<double>> poses(2);
    std::vector<Twist<double>> twists(2);
    std::vector<Wrench<double>> impulses(joints.size());
    if (!integrator.advance(bodies, joints, dt, poses, twists, impulses)) return false;
    total = {};
    for (std::size_t i = 0; i < joints.size(); ++i) {
      const bool is_reversed = joints[i].body_b == 0;
      const double along = (is_reversed ? joints[i].X_CmB_J : joints[i].X_CmA_J).translation.y();
      const Wrench<double> one = is_reversed ? -impulses[i] : impulses[i];
      total += {one.force, one.torque + Vec3<double>(0, along, 0).cross(one.force)};
    }
    for (std::size_t k = 0; k < 2; ++k) {
      bodies[k].center_pose = poses[k];
      bodies[k].twist = twists[k];
    }
    const Vec3<double>& w = bodies[1].twist.angular;
    energy = bodies[1].twist.linear.squaredNorm() + 0.5 * 0.02 * w.y() * w.y() +
             2.0 * 9.81 * bodies[1].center_pose.translation.z();
    return true;
  }
};

}  // namespace

TEST_CASE("JointGroups: joints between two bodies are one, and so are those to what is fixed") {
  const std::vector<MechanismJoint<double>> joints = {
      joined(1, 2, JointKind::fixed), joined(2, 3, JointKind::ball), joined(2, 1, JointKind::ball),
      joined(0, 3, JointKind::revolute), joined(3, 4, JointKind::prismatic)};
  JointGroups<double> groups;
  groups.build(joints, {false, true, true, true, false});
  REQUIRE(groups.size() == 3);
  CHECK(groups.is_merged(0));
  CHECK_FALSE(groups.is_merged(1));
  CHECK(groups.is_merged(2));
  CHECK(groups.joints()[1].kind == JointKind::ball);
}

TEST_CASE("MechanismIntegrator: a pendulum swings on 300 hinges as on one") {
  MechanismIntegrator<double> integrator_of_one, integrator_of_many;
  Pendulum one(1), many(300);
  for (int i = 0; i < 240; ++i) {
    REQUIRE(one.step(integrator_of_one, 1.0 / 240));
    REQUIRE(many.step(integrator_of_many, 1.0 / 240));
    // Both follow the same equation, each within 5e-5 of its velocity in a substep, of which about
    // a fortieth is the error of the fifth order that is kept; and no error grows but linearly.
    CHECK((one.bodies[1].center_pose.translation - many.bodies[1].center_pose.translation).norm() <
          1e-5);
    CHECK((one.total.force - many.total.force).norm() < 1e-5 * one.total.force.norm());
    // Nothing is given about the axis.
    CHECK(std::abs(many.total.torque.y()) < 1e-6 * one.total.force.norm());
    CHECK(std::abs(many.energy) < 1e-4 * 2.0 * 9.81 * 0.3);
  }
}

TEST_CASE(
    "MechanismIntegrator: hinges that contradict each other by rounding change a swing by that "
    "much") {
  MechanismIntegrator<double> integrator_of_one, integrator_of_many;
  Pendulum one(1), many(300, 1e-12);
  for (int i = 0; i < 240; ++i) {
    REQUIRE(one.step(integrator_of_one, 1.0 / 240));
    REQUIRE(many.step(integrator_of_many, 1.0 / 240));
    CHECK((one.bodies[1].center_pose.translation - many.bodies[1].center_pose.translation).norm() <
          1e-5);
    CHECK(std::abs(many.energy) < 1e-4 * 2.0 * 9.81 * 0.3);
  }
}
