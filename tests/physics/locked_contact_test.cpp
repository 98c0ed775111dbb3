/// @file
/// Contacts along directions in which joints leave no mobility: a finger on its slide that meets
/// the table. Eliminating the joints leaves nothing of the contact's response but round-off.
// SPDX-License-Identifier: BSD-3-Clause
#include <doctest/doctest.h>

using namespace bristle;
using namespace bristle::detail;

TEST_CASE_TEMPLATE("locked_contact: a still finger that overlaps the floor is not thrown", S, float,
                   double) {
  for (const JointKind kind : {JointKind::fixed, JointKind::prismatic}) {
    for (const double yaw : {0.0, 0.3, 0.7, 1.1}) {
      CAPTURE(yaw);
      WorldDef<S> world_def;
      world_def.time_step = S(1e-3);
      World<S> world(world_def);
      BodyDef<S> floor;
      floor.motion = Motion::fixed;
      floor.shape = HalfSpace<S>{};
      world.add_body(floor);

      BodyDef<S> palm;
      palm.motion = Motion::kinematic;
      palm.position = Vec3<S>(S(0.013), S(0.07), S(0.3));
      palm.orientation = exp_rotation<S>(Vec3<S>(S(0), S(0), S(yaw)));
      const BodyId hand = world.add_body(palm);
      BodyDef<S> def = palm;
      def.motion = Motion::dynamic;
      def.mass = S(0.37);
      def.shape = Box<S>{Vec3<S>(S(0.02), S(0.011), S(0.03))};
      def.position.z() = S(0.03 - 1e-4);
      const BodyId finger = world.add_body(def);

      JointDef<S> joint;
      joint.kind = kind;
      joint.body_a = hand;
      joint.body_b = finger;
      joint.X_BJ.translation.z() = palm.position.z() - def.position.z();
      if (kind == JointKind::prismatic) joint.motor = {MotorMode::velocity, S(0), S(50)};
      world.add_joint(joint);

      for (int i = 0; i < 200; ++i) world.step();
      // The joint carries the weight; the overlap cannot be closed, and nothing moves by more than
      // the round-off of positions of 0.3 m.
      const double tolerance = static_cast<double>(Tolerance<S>::round_off());
      CHECK(static_cast<double>((world.pose(finger).translation - def.position).norm()) <
            tolerance);
      CHECK(static_cast<double>(world.body(finger).twist.linear.norm()) < 1e3 * tolerance);
      CHECK(world.report().discarded_islands == 0);
    }
  }
}
