// The scenes of the paper's Figs. 4 and 6 (a): an array of sensors below a cube stands on a box,
// and a skin wrapped around a fingertip is pressed on a plane; both by their weight, and by sensors
// alone. With the depths that statics gives them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/math/rotation.hpp>
#include <bristle/sensors/placement.hpp>
#include <bristle/sensors/wrapping.hpp>
#include <bristle/world/world.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numbers>
#include <vector>

namespace fig4 {

using bristle::Vec3;

inline constexpr double gravity = 9.81;
/// Sensors along each side of both maps.
inline constexpr std::size_t side = 16;

/// A scene, and the depths [1] of its sensors by statics.
struct Press {
  bristle::World<double> world;
  bristle::BodyId carrier{};
  bristle::PatchId patch{};
  double weight = 0;  // [N]
  std::vector<double> expected;

  /// [1] Largest difference of a depth from that of statics.
  [[nodiscard]] double depth_error() const {
    const auto depth = world.reading(patch).depth;
    double worst = 0;
    for (std::size_t i = 0; i < depth.size(); ++i) {
      worst = std::max(worst, std::abs(depth[i] - expected[i]));
    }
    return worst;
  }
  /// [1] How far sensors are from carrying the weight, and from carrying it below the centre of
  /// mass: missing force, and torque about a centimetre, as parts of the weight.
  [[nodiscard]] double imbalance() const {
    const bristle::Wrench<double> reading = world.reading(patch).wrench;
    return std::max((reading.force - weight * Vec3<double>::UnitZ()).norm(),
                    reading.torque.norm() / 0.01) /
           weight;
  }
  /// @param watch  Sees the world after every step.
  void run(double seconds, const std::function<void(const bristle::World<double>&)>& watch = {}) {
    const long steps = std::lround(seconds / world.time_step());
    for (long i = 0; i < steps; ++i) {
      world.step();
      if (watch) watch(world);
    }
  }
};

struct Steps {
  double time_step = 1e-3;
  bristle::Integration integration = bristle::Integration::implicit;
};

/// The touched body has no hard contact: it is seen by sensors, and touches nothing.
inline bristle::BodyDef<double> seen_only(const bristle::Shape<double>& shape) {
  return {.motion = bristle::Motion::fixed, .shape = shape, .filter = {1, 0, 0}};
}

/// A block of 60 x 60 x 20 mm and 2 kg, 16 x 16 sensors below it, set down on a box of 40 x 30 mm
/// that is turned by 14 degrees and 2 mm off its centre of mass. The block leans until the forces
/// meet below that.
inline Press press_on_box(const Steps& steps) {
  using namespace bristle;
  constexpr double half = 0.03;
  constexpr double half_height = 0.01;
  constexpr double mass = 2;
  constexpr double stiffness = 1;  // [N] K_N
  constexpr double depth = 0.002;
  constexpr double range = 0.004;
  Press press{World<double>({.time_step = steps.time_step}), {}, {}, mass * gravity, {}};
  const Transform<double> X_WB{exp_rotation<double>({0, 0, 14 * std::numbers::pi / 180}),
                               {0.002, -0.001, -0.02}};
  const Vec3<double> box_half(0.02, 0.015, 0.02);
  BodyDef<double> box = seen_only(Box<double>{box_half});
  box.position = X_WB.translation;
  box.orientation = X_WB.rotation;
  press.world.add_body(box);
  press.carrier = press.world.add_body({.mass = mass,
                                        .shape = Box<double>{{half, half, half_height}},
                                        .position = {0, 0, half_height + 0.0015}});
  PatchDef<double> patch;
  // The rays look down: side_u x side_v = -z.
  patch.sensors = sensor_grid<double>({.center = {0, 0, -half_height},
                                       .side_u = {2 * half, 0, 0},
                                       .side_v = {0, -2 * half, 0},
                                       .count_u = side,
                                       .count_v = side,
                                       .depth = depth,
                                       .range = range});
  patch.parameters = {.normal_stiffness = stiffness,
                      .normal_damping = 0.01,
                      .static_friction = 1000,
                      .sliding_friction = 1,
                      .breakaway_distance = 1e-3};
  patch.integration = steps.integration;
  press.patch = press.world.add_patch(press.carrier, patch);

  // A rigid plate on springs: e = a + b x + c y over the box. The forces add up to the weight and
  // meet below the centre of mass, which moves by its height above the box times the lean, range b
  // and range c.
  Mat3<double> sums = Mat3<double>::Zero();
  std::vector<Vec3<double>> touching(side * side, Vec3<double>::Zero());
  double count = 0;
  for (std::size_t i = 0; i < touching.size(); ++i) {
    const Vec3<double> p = patch.sensors.start[i];
    const Vec3<double> p_B = X_WB.inverse() * p;
    if (std::abs(p_B.x()) > box_half.x() || std::abs(p_B.y()) > box_half.y()) continue;
    touching[i] = {1, p.x(), p.y()};
    sums += stiffness * touching[i] * touching[i].transpose();
    count += 1;
  }
  const double height = half_height - depth + range * (1 - press.weight / (count * stiffness));
  const double toppling = press.weight * height * range;
  sums(1, 1) -= toppling;
  sums(2, 2) -= toppling;
  const Vec3<double> plane = sums.inverse() * Vec3<double>(press.weight, 0, 0);
  for (const Vec3<double>& t : touching) press.expected.push_back(t.dot(plane));
  return press;
}

/// A fingertip, a ball of 20 mm radius and 1 kg, as a mesh; a plane patch of 24 mm is wrapped
/// around its underside, with a sensor at each vertex. It sinks on a slide onto a plane.
inline Press press_skin(const Steps& steps) {
  using namespace bristle;
  constexpr double radius = 0.02;
  constexpr double mass = 1;
  constexpr double stiffness = 2;  // [N] K_N
  constexpr double depth = 0.004;
  constexpr double range = 0.006;
  Press press{World<double>({.time_step = steps.time_step}), {}, {}, mass * gravity, {}};
  press.world.add_body(seen_only(HalfSpace<double>{}));
  BodyDef<double> tip;
  tip.mass = mass;
  tip.shape = sphere_mesh<double>(radius, 32);
  tip.position = {0, 0, radius + (range - depth)};
  tip.locked = {.linear = {true, true, false}, .angular = {true, true, true}};
  press.carrier = press.world.add_body(tip);
  // The patch, which faces +z, is turned about x to face down, below the ball.
  const Transform<double> X_SM{exp_rotation<double>({std::numbers::pi, 0, 0}), {0, 0, -2 * radius}};
  const TriangleMesh<double> skin = wrap_patch<double>(
      plane_patch<double>({0.024, 0.024}, {side - 1, side - 1}), sphere_mesh<double>(radius, 32),
      {.offset_along = WrapOffset::normal, .X_SM = X_SM});
  PatchDef<double> patch;
  patch.sensors = sensors_from_mesh<double>(
      skin, {.depth = depth, .range = range, .faces = false, .vertices = true});
  patch.parameters = {
      .normal_stiffness = stiffness,
      .normal_damping = 0.01,
      // Bristles would carry some of the weight, and statics could not say how much.
      .static_friction = 0};
  // As in the paper, and as the balance below has it.
  patch.options.normal = NormalDirection::ray;
  patch.integration = steps.integration;
  press.patch = press.world.add_patch(press.carrier, patch);

  // Along the radius at an angle t from straight down the plane is at h / cos t; the height h of
  // the centre is where the vertical parts of all forces add up to the weight.
  std::vector<double> cosines;
  for (const Vec3<double>& p : skin.vertices) {
    cosines.push_back(std::sqrt(1 - p.head<2>().squaredNorm() / (radius * radius)));
  }
  const auto depth_at = [&](double height, double cosine) {
    return std::clamp(1 - (height / cosine - (radius - depth)) / range, 0.0, 1.0);
  };
  double low = radius - depth;
  double high = radius + range;
  for (int i = 0; i < 60; ++i) {
    const double height = 0.5 * (low + high);
    double force = 0;
    for (const double c : cosines) force += stiffness * depth_at(height, c) * c;
    (force > press.weight ? low : high) = height;
  }
  for (const double c : cosines) press.expected.push_back(depth_at(low, c));
  return press;
}

}  // namespace fig4
