// The scene of the paper's Fig. 2: a sphere of 50 kg and 0.5 m radius, as a primitive or as a mesh,
// falls 2 m onto a plane.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/math/transform.hpp>
#include <bristle/world/world.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

namespace fig2 {

inline constexpr double radius = 0.5;
inline constexpr double mass = 50;
inline constexpr double height = 2;

/// Heights [m] added to the drop, so that the touch falls in other phases of the step: the eight
/// that the other engines were measured with.
inline constexpr std::array<double, 8> phases{0,      0.0047, 0.0113, 0.0231,
                                              0.0377, 0.0291, 0.0179, 0.0419};

/// Rates [Hz] of the paper's figure.
inline constexpr std::array<double, 8> rates{60, 120, 240, 500, 1000, 2000, 5000, 10000};

/// How deep one drop went [m].
struct Depth {
  /// Lowest point of the shape below the plane, at worst.
  double deepest = 0;
  /// D_p, as the paper has it: lowest place of the centre against the one at the end.
  double below_rest = 0;
  /// Between the shape and the plane at the end.
  double rest_gap = 0;

  void worse(const Depth& other) {
    deepest = std::max(deepest, other.deepest);
    below_rest = std::max(below_rest, other.below_rest);
    rest_gap = std::max(rest_gap, other.rest_gap);
  }
};

/// @param frequency  Of the mesh, 20 f^2 triangles; 0: a primitive.
/// @param watch      Sees the world after every step.
inline Depth drop(std::uint32_t frequency, double rate, double extra_height,
                  const std::function<void(const bristle::World<double>&)>& watch = {}) {
  using namespace bristle;
  World<double> world({.time_step = 1 / rate});
  world.add_body(
      {.motion = Motion::fixed, .shape = HalfSpace<double>{}, .material = {.friction = 0.5}});
  BodyDef<double> def;
  def.mass = mass;
  def.material.friction = 0.5;
  def.position = {0, 0, radius + height + extra_height};
  TriangleMesh<double> mesh;
  if (frequency > 0) {
    mesh = sphere_mesh(radius, frequency);
    def.shape = mesh;
  } else {
    def.shape = Sphere<double>{radius};
  }
  const BodyId ball = world.add_body(def);

  const auto lowest_point = [&](const Transform<double>& X) {
    if (frequency == 0) return X.translation.z() - radius;
    const Mat3<double> R = X.rotation_matrix();
    double lowest = infinity<double>;
    for (const Vec3<double>& v : mesh.vertices) lowest = std::min(lowest, R.row(2).dot(v));
    return X.translation.z() + lowest;
  };
  Depth depth;
  double lowest_center = infinity<double>;
  // It falls for 0.64 s; what a mesh does after that is roll onto one of its faces.
  const long steps = std::lround(1.5 * rate);
  for (long i = 0; i < steps; ++i) {
    world.step();
    if (watch) watch(world);
    const Transform<double> X = world.pose(ball);
    lowest_center = std::min(lowest_center, X.translation.z());
    if (X.translation.z() < 1.1 * radius) depth.deepest = std::max(depth.deepest, -lowest_point(X));
  }
  depth.rest_gap = std::abs(lowest_point(world.pose(ball)));
  depth.below_rest = world.pose(ball).translation.z() - lowest_center;
  return depth;
}

/// The worst over the first `count` phases.
inline Depth worst_drop(std::uint32_t frequency, double rate, std::size_t count = phases.size()) {
  Depth worst;
  for (std::size_t i = 0; i < count; ++i) worst.worse(drop(frequency, rate, phases[i]));
  return worst;
}

}  // namespace fig2
