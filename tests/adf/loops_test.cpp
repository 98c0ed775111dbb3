// Loops of joints whose axes and places are rounded to three digits.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/io/adf.hpp>
#include <bristle/io/adf/adf_loop_fit.hpp>
#include <bristle/io/adf/adf_loops.hpp>
#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>
#include <vector>

using namespace bristle;

using namespace bristle::detail;

namespace {

/// A parallelogram of two cranks of 0.5 m and a coupler of 1 m, that turns about z. With digits of
/// files: the cranks lie on their backs by 3.141 rad, and axes are askew.
std::string parallelogram() {
  const std::string turned = "orientation: {r: 3.141, p: 0, y: 1.571}}}\n";
  const auto hinge = [](const std::string& key, const std::string& bodies, const std::string& from,
                        const std::string& to, const std::string& axes) {
    return key + ": {type: hinge, " + bodies + ", parent pivot: " + from + ", child pivot: " + to +
           ", " + axes + "}\n";
  };
  const std::string shape = "collision shape: SPHERE, collision geometry: {radius: 0.01}";
  return "bodies: [Base, Left, Right, Coupler]\njoints: [A, B, C, D]\nBase: {mass: 0, " + shape +
         "}\nLeft: {mass: 1, " + shape + ", location: {position: {x: 0, y: 0.25, z: 0}, " + turned +
         "Right: {mass: 1, " + shape + ", location: {position: {x: 1, y: 0.25, z: 0.001}, " +
         turned + "Coupler: {mass: 1, " + shape +
         ", location: {position: {x: 0.5, y: 0.5, z: 0}}}\n" +
         hinge("A", "parent: Base, child: Left", "{x: 0, y: 0, z: 0}", "{x: -0.25, y: 0, z: 0}",
               "parent axis: {x: 0.001, y: 0, z: 1}, child axis: {x: 0, y: 0.001, z: -1}") +
         hinge("B", "parent: Base, child: Right", "{x: 1, y: 0, z: 0}", "{x: -0.25, y: 0, z: 0}",
               "parent axis: {x: 0, y: -0.001, z: 1}, child axis: {x: 0, y: 0, z: -1}") +
         hinge("C", "parent: Left, child: Coupler", "{x: 0.25, y: 0, z: 0}",
               "{x: -0.5, y: 0, z: 0.001}",
               "parent axis: {x: 0, y: 0, z: -1}, child axis: {x: -0.001, y: 0, z: 1}") +
         hinge("D", "parent: Right, child: Coupler", "{x: 0.25, y: 0, z: 0}",
               "{x: 0.5, y: 0, z: 0}",
               "parent axis: {x: 0, y: 0, z: -1}, child axis: {x: 0, y: 0, z: 1}");
}

}  // namespace

TEST_CASE("AdfLoops: connections of a loop are a set, those of a tree are in none") {
  // A triangle 0-1-2 and a square 2-3-4-5 that share node 2, with a diagonal 3-5; a chain 5-6-7 of
  // which 6 and 7 are connected twice; and 8 alone.
  const std::vector<AdfConnection> connections{{0, 1}, {1, 2}, {2, 0}, {2, 3}, {3, 4}, {4, 5},
                                               {5, 2}, {5, 6}, {6, 7}, {7, 6}, {5, 3}};
  std::vector<std::vector<std::size_t>> sets = AdfLoops(9, connections).sets();
  std::sort(sets.begin(), sets.end());
  CHECK(sets == std::vector<std::vector<std::size_t>>{{0, 1, 2}, {3, 4, 5, 6, 10}});
  // Two of a loop may connect the same nodes. They are in it, too.
  CHECK(AdfLoops(3, {{0, 1}, {1, 0}, {1, 2}, {2, 0}}).sets() ==
        std::vector<std::vector<std::size_t>>{{0, 1, 2, 3}});
  CHECK(AdfLoops(2, {{0, 1}, {1, 0}, {0, 1}}).sets().empty());
  CHECK(AdfLoops(0, {}).sets().empty());
  // A ring of any length.
  const std::size_t length = 20'000;
  std::vector<AdfConnection> ring{{length - 1, 0}};
  for (std::size_t i = 1; i < length; ++i) ring.emplace_back(i, i - 1);
  const AdfLoops one(length, ring);
  REQUIRE(one.sets().size() == 1);
  CHECK(one.sets()[0].size() == length);
}

TEST_CASE("fit_loop: hinges become parallel, slides perpendicular to them, the plane stays") {
  using V = Vec3<double>;
  const auto frame = [](const V& axis, const V& at) {
    return Transform<double>{axis_turn(V::UnitX(), axis.normalized()), at};
  };
  // The slide's frames are turned against each other by 2 mrad in the plane, and 1 mrad out of it.
  const Transform<double> turn{(Quat<double>(Eigen::AngleAxis<double>(0.002, V::UnitZ())) *
                                Quat<double>(Eigen::AngleAxis<double>(0.001, V::UnitY())))
                                   .normalized(),
                               {0.001, 2, 0.001}};
  const Transform<double> slide = frame({0, 1, 0.001}, {0, 1, 0});
  const std::vector<AdfLoopJoint> before{
      {JointKind::revolute, frame({0.001, 0, 1}, {0, 0, 0}), frame({0, 0.001, 1}, {0, 0, 0.001}),
       0.002},
      {JointKind::revolute, frame({0, 0, -1}, {1, 0, 0}), frame({0, 0, -1}, {1, 0, 0}), 0.002},
      {JointKind::prismatic, slide, turn * Transform<double>{slide.rotation, V::Zero()}, 0.002},
      {JointKind::ball, frame({1, 0, 0}, {0, 0, 0.001}), frame({0, 0, 1}, {0, 0, 0}), 0.002}};
  std::vector<AdfLoopJoint> loop = before;
  const auto was = fit_loop(loop);
  REQUIRE(was.has_value());
  const V normal = loop[0].X_WJa.rotate(V::UnitX());
  CHECK((loop[0].X_WJb.rotate(V::UnitX()) - normal).norm() < 1e-15);
  CHECK((loop[1].X_WJa.rotate(V::UnitX()) + normal).norm() < 1e-15);
  CHECK((*was)[0].tilt == test::relative(0.001 * std::numbers::sqrt2).epsilon(1e-5));
  CHECK((*was)[0].gap == test::relative(0.001).epsilon(1e-2));
  CHECK((*was)[1].tilt == 0.0);
  CHECK((*was)[2].tilt == test::relative(0.001).epsilon(1e-2));
  for (std::size_t i = 0; i < loop.size(); ++i) {
    CAPTURE(i);
    // Nothing is left across the plane, and in the plane nothing has moved.
    const V apart = loop[i].X_WJb.translation - loop[i].X_WJa.translation;
    const V apart_before = before[i].X_WJb.translation - before[i].X_WJa.translation;
    CHECK(std::abs(apart.dot(normal)) < 1e-15);
    CHECK((apart - (apart_before - apart_before.dot(normal) * normal)).norm() < 1e-15);
    // No frame has turned by more than the axes are askew.
    CHECK(loop[i].X_WJa.rotation.angularDistance(before[i].X_WJa.rotation) < adf_axis_rounding);
  }
  // A slide is along the plane, and its frames are turned against each other in it alone.
  CHECK(std::abs(loop[2].X_WJa.rotate(V::UnitX()).dot(normal)) < 1e-15);
  const Quat<double> twist = loop[2].X_WJb.rotation * loop[2].X_WJa.rotation.conjugate();
  CHECK(twist.vec().cross(normal).norm() < 1e-15);
  CHECK(2.0 * twist.vec().norm() == test::relative(0.002).epsilon(1e-2));
  // A ball joint turns as it likes.
  CHECK(loop[3].X_WJb.rotation.coeffs() == before[3].X_WJb.rotation.coeffs());

  // What rounding does not explain stays as it is.
  const auto stays = [&](std::size_t i, const AdfLoopJoint& joint) {
    std::vector<AdfLoopJoint> other = before;
    other[i] = joint;
    CHECK_FALSE(fit_loop(other).has_value());
    CHECK(other[0].X_WJa.rotation.coeffs() == before[0].X_WJa.rotation.coeffs());
  };
  stays(1, {JointKind::revolute, frame({0.01, 0, 1}, {1, 0, 0}), before[1].X_WJb, 0.002});
  stays(1, {JointKind::revolute, before[1].X_WJa, frame({0, 0, -1}, {1, 0, 0.0021}), 0.002});
  stays(2, {JointKind::prismatic, frame({0, 1, 0.01}, {0, 1, 0}), before[2].X_WJb, 0.002});
}

TEST_CASE("add_adf: a loop with rounded axes moves, as far as its joints let it") {
  World<double> world({.gravity = {0, 0, 0}, .time_step = 1e-3});
  const AdfScene<double> scene = add_adf(world, read_adf(parallelogram(), "scene.yaml"));
  std::size_t fitted = 0;
  for (const AdfNote& note : scene.report.notes()) {
    if (note.reason.find("out of the plane of its loop: fitted") != std::string::npos) ++fitted;
  }
  CHECK(fitted >= 3);
  const JointId crank = scene.joints.at("A");
  for (const double end : {1.0, -1.0}) {
    const double start = world.reading(crank).position;
    const double follower = world.reading(scene.joints.at("B")).position;
    const double elbow = world.reading(scene.joints.at("C")).position;
    world.set_motor(
        crank,
        {.mode = MotorMode::position, .target = start + end, .max_force = 10.0, .max_speed = 2.0});
    for (int i = 0; i < 2000; ++i) world.step();
    CHECK(world.reading(crank).position == test::relative(start + end).epsilon(1e-6));
    // The coupler stays parallel, but for the 1 mm by which the sides differ: 2 mrad.
    CHECK(std::abs(world.reading(scene.joints.at("B")).position - follower - end) < 0.003);
    CHECK(std::abs(world.reading(scene.joints.at("C")).position - elbow + end) < 0.003);
    for (const auto& joint : scene.joints) {
      CHECK(world.reading(joint.value).gap < 1e-9);
      CHECK(world.reading(joint.value).tilt < 1e-7);
    }
  }

  // Nothing is fitted that is to stay.
  World<double> as_written;
  (void)add_adf(as_written, read_adf(parallelogram(), "scene.yaml"), {.fit_loops = false});
  CHECK(as_written.state_hash() != world.state_hash());
}
