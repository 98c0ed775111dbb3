// SPDX-License-Identifier: BSD-3-Clause
#include "support/mechanism.hpp"
#include "support/relative.hpp"

#include <bristle/dynamics/joints/joint_projection.hpp>

#include <doctest/doctest.h>

#include <cstddef>

using namespace bristle;

using namespace bristle::detail;
using test::Mechanism;
using V = Vec3<double>;

// A kilogram, and a link of a gram whose joint is at the end of its lever: whatever the link is
// turned by and thrown to, it comes back, and the centre of mass, which no joint moves, stays.
TEST_CASE("JointProjection: a light link comes back to its joint from afar") {
  for (const double angle : {1.0, 2.0, 3.1}) {
    CAPTURE(angle);
    Mechanism<double> m;
    m.add(1, 1e-3 * Mat3<double>::Identity(), V::Zero());
    m.add(1e-3, 1e-7 * Mat3<double>::Identity(), {0.1, 0, 0});
    m.join(JointKind::ball, 0, 1, V(0.02, 0, 0));
    m.bodies[1].center_pose = {exp_rotation<double>(V(0, angle, 0)), V(0.05, 0.3, 0.1)};
    const V before = m.bodies[0].center_pose.translation + 1e-3 * V(0.05, 0.3, 0.1);

    JointSystem<double> system;
    system.set(m.bodies, m.joints);
    system.place();
    JointProjection<double> projection;
    CHECK(projection.find_gaps(system) > 0.2);
    REQUIRE(projection.close_wide_gaps(system, 1e-6));
    CHECK(projection.find_gaps(system) <= 1e-6);
    const auto nodes = system.nodes();
    CHECK((nodes[0].now.x + 1e-3 * nodes[1].now.x - before).norm() < 1e-15);
  }
}

// Two fixed frames, farther from each other than the rod between them is long.
TEST_CASE("JointProjection: gaps that cannot be closed are told") {
  Mechanism<double> m;
  m.add_fixed();
  m.add_fixed({1, 0, 0});
  m.add(1, Mat3<double>::Identity(), {0.5, 0, 0});
  m.join(JointKind::ball, 0, 2, V::Zero());
  m.join(JointKind::ball, 1, 2, V(1, 0, 0));
  m.bodies[1].center_pose.translation.x() = 1.2;
  JointSystem<double> system;
  system.set(m.bodies, m.joints);
  system.place();
  JointProjection<double> projection;
  CHECK(projection.find_gaps(system) == test::relative(0.2));
  CHECK_FALSE(projection.close_wide_gaps(system, 1e-6));
}
