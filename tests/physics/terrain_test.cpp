/// @file
/// Bodies on terrain: as on a plane where it is flat, held by valleys, stopped from below.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"
#include "support/relative.hpp"

#include <bristle/bristle.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

using namespace bristle;
using bristle::test::Random;

namespace {

/// Ground of 4 m by 4 m and `thickness` [m] with heights z(x, y) [m] at the corners of n by n
/// cells.
template <typename Height>
TriangleMesh<double> ground_of(std::uint32_t n, double thickness, Height&& height) {
  std::vector<double> heights;
  for (std::uint32_t j = 0; j <= n; ++j) {
    for (std::uint32_t i = 0; i <= n; ++i) {
      heights.push_back(height(4.0 * i / n - 2, 4.0 * j / n - 2));
    }
  }
  return extruded_mesh<double>(height_field_mesh<double>({4, 4}, {n, n}, heights),
                               {0, 0, -thickness});
}

/// A world with a body that moves on a slope z = 0.3 x.
struct OnSlope {
  World<double> world{{.time_step = 1.0 / 240}};
  BodyId mover;

  OnSlope(BodyDef<double> ground, BodyDef<double> body, double height, const Quat<double>& lie) {
    const Quat<double> tilt(Eigen::AngleAxisd(-std::atan(0.3), Vec3<double>::UnitY()));
    if (ground.shape && std::holds_alternative<HalfSpace<double>>(*ground.shape)) {
      ground.orientation = tilt;
    }
    ground.motion = Motion::fixed;
    ground.material.friction = 0.3;
    world.add_body(ground);
    body.mass = 1;
    body.material.friction = 0.3;
    body.position = tilt * Vec3<double>(-1.003, -0.507, height);
    body.velocity = tilt * Vec3<double>(1.5, 0.37, 0);
    body.orientation = tilt * lie;
    mover = world.add_body(body);
  }
};

}  // namespace

// On the mesh of a plane nothing may be felt but the plane: its inner edges carry nothing. Both
// runs solve to tolerances of 1e-9 of the weight in 240 steps.
TEST_CASE("terrain: what rolls and slides on a flat slope moves as on a half-space") {
  const Quat<double> flat = Quat<double>::Identity();
  const Quat<double> across(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3<double>::UnitX()));
  struct Case {
    Shape<double> shape;
    double height;
    Quat<double> lie;
  };
  for (const Case& c :
       {Case{Sphere<double>{0.05}, 0.05, flat}, Case{Box<double>{{0.05, 0.04, 0.03}}, 0.03, flat},
        Case{Capsule<double>{0.03, 0.06}, 0.03, across}}) {
    OnSlope plane({.shape = HalfSpace<double>{}}, {.shape = c.shape}, c.height, c.lie);
    for (int i = 0; i < 240; ++i) plane.world.step();
    for (const std::uint32_t n : {7u, 40u}) {
      CAPTURE(n);
      OnSlope mesh({.shape = ground_of(n, 0.5, [](double x, double) { return 0.3 * x; })},
                   {.shape = c.shape}, c.height, c.lie);
      for (int i = 0; i < 240; ++i) mesh.world.step();
      const Body<double>& a = plane.world.body(plane.mover);
      const Body<double>& b = mesh.world.body(mesh.mover);
      CHECK((plane.world.pose(plane.mover).translation - mesh.world.pose(mesh.mover).translation)
                .norm() < 1e-8);
      CHECK((a.twist.linear - b.twist.linear).norm() < 1e-8);
      CHECK((a.twist.angular - b.twist.angular).norm() < 1e-6);
    }
  }
}

// z = 0.5 (x^2 + y^2) in cells of 0.1 m: from the valley's lowest corner four facets rise by 5 %,
// too little for a ball of 0.2 m to stand elsewhere.
TEST_CASE("terrain: a ball comes to rest in the lowest place, damped") {
  World<double> world({.time_step = 1.0 / 240});
  world.add_body({.motion = Motion::fixed, .shape = ground_of(40, 0.2, [](double x, double y) {
                                             return 0.5 * (x * x + y * y);
                                           })});
  const BodyId ball = world.add_body({.mass = 1,
                                      .shape = Sphere<double>{0.2},
                                      .position = {0.7, 0.4, 0.6},
                                      .linear_damping = 1.0,
                                      .angular_damping = 1.0});
  for (int i = 0; i < 15 * 240; ++i) world.step();
  const Vec3<double> at = world.pose(ball).translation;
  CHECK(std::hypot(at.x(), at.y()) < 1e-3);
  // It lies over a pit of slope s = 0.05 beside the corner: higher than on a point by at most
  // r (sqrt(1 + s^2) - 1).
  CHECK(at.z() > 0.2 - 1e-5);
  CHECK(at.z() < 0.2 * (1 + 0.05 * 0.05));
  CHECK(world.body(ball).twist.linear.norm() < 1e-3);
}

TEST_CASE("terrain: what comes from below or falls fast is stopped by its thickness") {
  const auto rough = [](double x, double y) { return 0.1 * std::sin(5 * x) * std::cos(4 * y); };
  Random random(8);
  struct Case {
    double thickness;
    double speed;
    double step;
  };
  for (const Case& c :
       {Case{0.01, -40, 1.0 / 240}, Case{0.3, -40, 1.0 / 240}, Case{0.01, 40, 1.0 / 240},
        Case{0.3, 40, 1.0 / 240}, Case{0.01, -10, 1.0 / 60}, Case{0.3, 10, 1.0 / 60}}) {
    const auto [thickness, speed, step] = c;
    World<double> world({.gravity = {0, 0, 0}, .time_step = step});
    world.add_body({.motion = Motion::fixed, .shape = ground_of(32, thickness, rough)});
    std::vector<BodyId> bodies;
    for (int i = 0; i < 30; ++i) {
      const Shape<double> shape = i % 2 == 0 ? Shape<double>(Sphere<double>{0.03})
                                             : Shape<double>(Box<double>{{0.03, 0.02, 0.04}});
      const double side = speed < 0 ? 1 : -1;
      bodies.push_back(world.add_body(
          {.shape = shape,
           .position = {0.3 * (i % 6) - 0.75, 0.3 * (i / 6) - 0.6, side * (1.2 + thickness)},
           .orientation = random.rotation<double>(),
           .velocity = {0, 0, speed}}));
    }
    // As long again as they need to the ground: before all of them have slid off its sides.
    for (double t = 0; t < 2.4 / std::abs(speed); t += step) world.step();
    int stopped = 0;
    for (const BodyId id : bodies) {
      const Vec3<double> at = world.pose(id).translation;
      // What slid off the side may be anywhere.
      if (std::max(std::abs(at.x()), std::abs(at.y())) > 2) continue;
      ++stopped;
      if (speed < 0) {
        CHECK(at.z() > rough(at.x(), at.y()) - 0.02);
      } else {
        CHECK(at.z() < rough(at.x(), at.y()) - thickness + 0.02);
      }
    }
    CHECK(stopped > 20);
  }
}

// Each facet is part of z = x or z = 0, so that the ray's way is known.
TEST_CASE("terrain: rays meet its surface") {
  World<double> world;
  world.add_body({.motion = Motion::fixed,
                  .shape = ground_of(8, 0.1, [](double x, double) { return std::max(0.0, x); })});
  Random random(2);
  for (int i = 0; i < 200; ++i) {
    const double x = random.uniform(-1.9, 1.9);
    const double y = random.uniform(-1.9, 1.9);
    const auto hit = world.cast_ray({.origin = {x, y, 5}, .direction = {0, 0, -1}, .length = 10});
    REQUIRE(hit.is_hit());
    CHECK(hit.distance == test::relative(5 - std::max(0.0, x)).epsilon(1e-12));
    CHECK(hit.normal.z() == test::relative(x < 0 ? 1 : std::sqrt(0.5)).epsilon(1e-12));
  }
}
