/// @file
/// Heaps in motion: a wall that is knocked down, mixed bodies in a bin and in a bowl.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scenes/rigid/watched.hpp"
#include "support/random.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

namespace bristle::scenes {

using namespace bristle::detail;

/// A wall of 20 bricks, 0.4 x 0.2 x 0.2 m and 2 kg, five rows in bond, mu = 0.5; a ball of 100 kg
/// hits its middle at 8 m/s. Nothing bounces.
[[nodiscard]] inline Scene knocked_down_wall() {
  constexpr double friction = 0.5;
  Scene scene;
  scene.duration = 3;
  scene.is_large = true;
  scene.add(floor_body(friction));
  for (int row = 0; row < 5; ++row) {
    for (int i = 0; i < 4; ++i) {
      const double y = 0.401 * (i - 1.5) + (row % 2 == 0 ? 0.1 : -0.1);
      scene.add(box_body({0.1, 0.2, 0.1}, 2, {0, y, 0.1 + 0.2 * row}, friction));
    }
  }
  SceneBody ball = ball_body(0.3, 100, {-1, 0, 0.5}, friction);
  ball.velocity = {8, 0, 0};
  scene.add(ball);
  return scene;
}

namespace parts {

/// A convex stone of about a radius about its centroid: an octahedron whose corners are pulled
/// about by so little that its faces stay as they are.
[[nodiscard]] inline TriangleMesh<double> random_stone(test::Random& random, double radius) {
  TriangleMesh<double> mesh;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      Vector corner = random.in_cube(0.15 * radius);
      corner[axis] += side * radius;
      mesh.vertices.push_back(corner);
    }
  }
  // Corners 0 to 5: -x, x, -y, y, -z, z.
  mesh.triangles = {{1, 3, 5}, {3, 0, 5}, {0, 2, 5}, {2, 1, 5},
                    {3, 1, 4}, {0, 3, 4}, {2, 0, 4}, {1, 2, 4}};
  const MassProperties<double> solid = unit_mass_properties(Shape<double>(mesh));
  for (Vector& v : mesh.vertices) v -= solid.center;
  return mesh;
}

/// A ring: closed, not convex, with its axis along z.
[[nodiscard]] inline Surface torus(double radius, double thickness, int around, int across) {
  Surface ring;
  const auto number = [&](int i, int j) {
    return static_cast<std::uint32_t>((i % around) * across + j % across);
  };
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      const double a = 2 * std::numbers::pi * i / around;
      const double b = 2 * std::numbers::pi * j / across;
      const double out = radius + thickness * std::cos(b);
      ring.mesh.vertices.push_back({out * std::cos(a), out * std::sin(a), thickness * std::sin(b)});
      ring.mesh.triangles.push_back({number(i, j), number(i + 1, j), number(i + 1, j + 1)});
      ring.mesh.triangles.push_back({number(i, j), number(i + 1, j + 1), number(i, j + 1)});
    }
  }
  return ring;
}

/// A bowl, open above: half a sphere inside, another one outside of it. Its faces lie inside the
/// sphere of the radius by up to one part in two hundred.
[[nodiscard]] inline Surface bowl(double radius, double thickness, int around, int rings) {
  Surface surface;
  TriangleMesh<double>& mesh = surface.mesh;
  const auto add_skin = [&](double r) {
    for (int k = 0; k < rings; ++k) {
      // From the rim down; the lowest point follows.
      const double down = std::numbers::pi / 2 * k / rings;
      for (int i = 0; i < around; ++i) {
        const double a = 2 * std::numbers::pi * i / around;
        mesh.vertices.push_back({r * std::cos(down) * std::cos(a), r * std::cos(down) * std::sin(a),
                                 -r * std::sin(down)});
      }
    }
    mesh.vertices.push_back({0, 0, -r});
  };
  add_skin(radius);
  add_skin(radius + thickness);
  const int skin = around * rings + 1;
  const auto number = [&](int side, int k, int i) {
    const int in_skin = k == rings ? skin - 1 : k * around + i % around;
    return static_cast<std::uint32_t>(side * skin + in_skin);
  };
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    mesh.triangles.push_back({a, b, c});
  };
  for (int i = 0; i < around; ++i) {
    for (int k = 0; k < rings; ++k) {
      // Seen from inside, then from outside.
      add(number(0, k, i), number(0, k, i + 1), number(0, k + 1, i));
      if (k + 1 < rings) add(number(0, k, i + 1), number(0, k + 1, i + 1), number(0, k + 1, i));
      add(number(1, k, i), number(1, k + 1, i), number(1, k, i + 1));
      if (k + 1 < rings) add(number(1, k, i + 1), number(1, k + 1, i), number(1, k + 1, i + 1));
    }
    add(number(0, 0, i), number(1, 0, i), number(0, 0, i + 1));
    add(number(0, 0, i + 1), number(1, 0, i), number(1, 0, i + 1));
  }
  return surface;
}

/// The walls of a bin: a floor at 0 and four plates around a square of a half width.
inline void add_bin(Scene& scene, double half, double friction) {
  scene.add(floor_body(friction));
  for (const double side : {-1.0, 1.0}) {
    scene.add(box_body({0.1, half + 0.2, 2}, 0, {side * (half + 0.1), 0, 2}, friction));
    scene.add(box_body({half + 0.2, 0.1, 2}, 0, {0, side * (half + 0.1), 2}, friction));
  }
}

}  // namespace parts

/// 64 boxes, balls, capsules, cylinders and stones of 0.1 to 0.2 m, 0.2 to 5 kg, fall into a bin of
/// 1 m, mu = 0.5.
[[nodiscard]] inline Scene mixed_bin() {
  constexpr double friction = 0.5;
  test::Random random(7);
  Scene scene;
  scene.duration = 4;
  scene.is_large = true;
  parts::add_bin(scene, 0.5, friction);
  for (int i = 0; i < 64; ++i) {
    const Vector at = {0.22 * (i % 4 - 1.5), 0.22 * (i / 4 % 4 - 1.5), 0.2 + 0.25 * (i / 16)};
    const double size = random.uniform(0.05, 0.1);
    SceneBody body;
    switch (i % 5) {
      case 0:
        body.shape = Box<double>{{size, 0.7 * size, 0.5 * size}};
        break;
      case 1:
        body.shape = Sphere<double>{0.8 * size};
        break;
      case 2:
        body.shape = Capsule<double>{0.5 * size, 0.5 * size};
        break;
      case 3:
        body.shape = Cylinder<double>{0.7 * size, 0.6 * size};
        break;
      default:
        body.shape = parts::random_stone(random, size);
    }
    body.mass = std::pow(10, random.uniform(-0.7, 0.7));
    body.friction = std::sqrt(friction);
    body.position = at;
    body.orientation = random.rotation<double>();
    // Stones are not symmetric; all engines take the moments of a ball for them.
    if (i % 5 == 4) body.principal_inertia = Vector::Constant(0.2 * body.mass * size * size);
    scene.add(body);
  }
  return scene;
}

/// 300 balls, boxes and capsules of 0.1 m and 0.5 kg fall into a bowl of triangles of 1.2 m radius,
/// mu = 0.5; one in eight is a ring of triangles if asked for. The error is the larger of the
/// deepest overlap between bodies that are not rings, and of how far a body's centre is outside the
/// inner sphere of the bowl [m]; sampled every 10 ms.
class Bowl : public Trial {
 public:
  explicit Bowl(bool has_rings) : Trial(make(has_rings)) {}

  void observe(const Engine& engine, const Instant& now) override {
    if (!now.is_sampled() && !now.is(scene().duration)) return;
    depth_ = std::max(depth_, overlaps(scene(), engine).largest);
    escaped_ = 0;
    fastest_ = 0;
    for (std::size_t i = 1; i < scene().bodies.size(); ++i) {
      const BodyState state = engine.state(i);
      is_finite_ = is_finite_ && state.position.allFinite();
      fastest_ = std::max(fastest_, state.velocity.norm());
      if (state.position.z() > 0) continue;
      const double beyond = state.position.norm() - radius;
      outside_ = std::max(outside_, beyond);
      if (beyond > 0) ++escaped_;
    }
  }
  [[nodiscard]] Outcome outcome() const override {
    const double error =
        is_finite_ ? std::max(depth_, outside_) : std::numeric_limits<double>::infinity();
    return {error,
            error < 0.01,
            {{"depth", depth_},
             {"outside", outside_},
             {"escaped", static_cast<double>(escaped_)},
             {"v_end", fastest_}}};
  }

 private:
  static constexpr double radius = 1.2;

  static Scene make(bool has_rings) {
    constexpr double friction = 0.5;
    test::Random random(3);
    Scene scene;
    scene.duration = 3;
    scene.is_large = true;
    SceneBody bowl;
    bowl.shape = parts::bowl(radius, 0.1, 48, 16);
    bowl.friction = std::sqrt(friction);
    scene.add(bowl);
    for (int i = 0; i < 300; ++i) {
      const Vector at = {0.17 * (i % 6 - 2.5), 0.17 * (i / 6 % 6 - 2.5), -0.4 + 0.17 * (i / 36)};
      SceneBody body = i % 3 == 0   ? ball_body(0.05, 0.5, at, friction)
                       : i % 3 == 1 ? box_body({0.05, 0.04, 0.035}, 0.5, at, friction)
                                    : capsule_body({0.03, 0.03}, 0.5, at, friction);
      if (has_rings && i % 8 == 7) body.shape = parts::torus(0.05, 0.02, 16, 8);
      body.orientation = random.rotation<double>();
      scene.add(body);
    }
    return scene;
  }

  double depth_ = 0;
  double outside_ = 0;
  double fastest_ = 0;
  int escaped_ = 0;
  bool is_finite_ = true;
};

}  // namespace bristle::scenes
