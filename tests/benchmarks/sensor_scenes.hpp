/// @file
/// Worlds with large patches whose steps the benchmark of sensors measures.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "benchmarks/pad_workload.hpp"

#include <bristle/sensors/placement.hpp>
#include <bristle/sensors/tuning.hpp>
#include <bristle/world/world.hpp>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

namespace bristle::benchmarks {

using namespace bristle::detail;

/// Two fingers on slides press with 10 N each on a bumpy ball of 9680 triangles and 0.5 kg. Their
/// pads of 30 x 30 mm follow its curvature, so that all of their sensors touch.
template <Scalar S>
struct HeldBall {
  static constexpr double grip = 10;
  static constexpr double mass = 0.5;
  static constexpr double gravity = 9.81;

  HeldBall(std::size_t sensors, bool in_rows, const ParallelFor& parallel_for)
      : world(
            {.gravity = {0, 0, S(-gravity)}, .time_step = S(1e-3), .parallel_for = parallel_for}) {
    ball = world.add_body({.mass = S(mass),
                           .shape = shape_as<S>(bumpy_ball(22)),
                           .filter = {.category = 1, .mask = 2}});
    const BodyId frame = world.add_body({.motion = Motion::fixed});
    for (int k = 0; k < 2; ++k) {
      const double side = k == 0 ? -1 : 1;
      const BodyId finger = world.add_body({.mass = S(0.2),
                                            .shape = Box<S>{{S(0.005), S(0.02), S(0.02)}},
                                            .filter = {.category = 4, .mask = 0},
                                            .position = {S(side * 0.07), 0, 0}});
      PatchDef<S> def;
      def.sensors = pad(sensors / 2, side);
      if (!in_rows) def.sensors = in_order(def.sensors, neighbour_order(def.sensors));
      def.parameters = tuned_for<S>({.load = S(grip), .mass = S(mass)}).parameters(def.sensors);
      def.integration = Integration::implicit;
      def.sense_mask = 1;
      pads[k] = world.add_patch(finger, def);
      JointDef<S> slide;
      slide.kind = JointKind::prismatic;
      slide.body_a = frame;
      slide.body_b = finger;
      // Its x axis points inwards.
      slide.X_AJ.rotation = slide.X_BJ.rotation =
          exp_rotation<S>(Vec3<S>(0, 0, k == 0 ? S(0) : std::numbers::pi_v<S>));
      slide.X_AJ.translation = {S(side * 0.07), 0, 0};
      slide.motor = {MotorMode::velocity, S(0.1), S(grip), infinity<S>};
      world.add_joint(slide);
    }
    for (int i = 0; i < 2000; ++i) world.step();
  }

  /// [1] How far what the pads carry is from the ball's weight.
  [[nodiscard]] double error() const {
    const double carried = double(world.reading(pads[0]).wrench.force.z()) +
                           double(world.reading(pads[1]).wrench.force.z());
    return std::abs(carried + mass * gravity) / (mass * gravity);
  }

  World<S> world;
  BodyId ball{};
  PatchId pads[2]{};

 private:
  /// Rays towards the ball's centre that reach 1 mm under its mean surface, in a finger's frame.
  static SensorLayout<S> pad(std::size_t n, double side) {
    const auto count = static_cast<std::size_t>(std::lround(std::sqrt(double(n))));
    const double step = 0.03 / ball_radius / double(count);
    SensorLayout<S> rays;
    for (std::size_t i = 0; i < count * count; ++i) {
      const double yaw = (double(i % count) + 0.5 - double(count) / 2) * step;
      const double pitch = (double(i / count) + 0.5 - double(count) / 2) * step;
      const Vec3<double> out(side * std::cos(yaw) * std::cos(pitch),
                             std::sin(yaw) * std::cos(pitch), std::sin(pitch));
      rays.add((0.054 * out - Vec3<double>(side * 0.07, 0, 0)).template cast<S>(),
               (-out).template cast<S>().normalized(), S(0.005));
    }
    return rays;
  }
};

/// The pad fixed under a bumpy ball that turns over it, at the given gap.
template <Scalar S>
struct TurningBall {
  TurningBall(const Object& object, std::size_t sensors, bool in_rows, double gap,
              Integration integration, const ParallelFor& parallel_for)
      : world({.gravity = Vec3<S>::Zero(), .time_step = S(1e-3), .parallel_for = parallel_for}) {
    const BodyId floor = world.add_body({.motion = Motion::fixed});
    PatchDef<S> def;
    def.sensors = layout_as<S>(pad_rays(sensors, in_rows));
    def.parameters = tuned_for<S>({.load = S(20), .mass = S(2)}).parameters(def.sensors);
    def.integration = integration;
    patch = world.add_patch(floor, def);
    // A tenth of a degree a step.
    world.add_body(
        {.motion = integration == Integration::implicit ? Motion::dynamic : Motion::kinematic,
         .mass = S(1e6),
         .shape = shape_as<S>(object.shape),
         .position = {0, 0, S(object.half_height + gap)},
         .angular_velocity = {0, 0, S(100 * degree)}});
    for (int i = 0; i < 50; ++i) world.step();
  }

  World<S> world;
  PatchId patch{};
};

/// A fixed pad beside the ball: their boxes meet, and the ball's surface is `gap` out of reach. Or
/// no pad, for what the rest of the step costs.
template <Scalar S>
[[nodiscard]] World<S> make_near_miss(const Object& object, std::size_t sensors, bool in_rows,
                                      double gap) {
  World<S> world({.time_step = S(1e-3)});
  // The ball's lowest point is 2 mm above the face's plane, below the ends of the rays. Where the
  // pad's nearest row ends, at 2.25 mm, the lowest that bumps reach is to be `gap` higher.
  const double height = 2.25e-3 + gap + 1.2e-3 - 2e-3;
  const double aside = 0.015 + std::sqrt(ball_radius * ball_radius -
                                         (ball_radius - height) * (ball_radius - height));
  world.add_body({.motion = Motion::fixed,
                  .shape = shape_as<S>(object.shape),
                  .position = {S(aside), 0, S(ball_radius + 2e-3)}});
  const BodyId floor = world.add_body({.motion = Motion::fixed});
  if (sensors > 0) {
    PatchDef<S> def;
    def.sensors = layout_as<S>(pad_rays(sensors, in_rows));
    def.parameters = tuned_for<S>({.load = S(20), .mass = S(2)}).parameters(def.sensors);
    world.add_patch(floor, def);
  }
  return world;
}

/// A thousand fixed pads of 100 sensors a metre apart, with nothing in reach; or without patches.
template <Scalar S>
[[nodiscard]] World<S> make_far(bool has_patches) {
  World<S> world({.time_step = S(1e-3)});
  world.add_body({.motion = Motion::fixed, .shape = Sphere<S>{S(0.1)}, .position = {0, 0, 100}});
  PatchDef<S> def;
  def.sensors = layout_as<S>(pad_rays(100));
  def.parameters = tuned_for<S>({.load = S(20), .mass = S(2)}).parameters(def.sensors);
  for (int i = 0; i < 1000; ++i) {
    const BodyId pad = world.add_body({.motion = Motion::fixed, .position = {S(i), 0, 0}});
    if (has_patches) world.add_patch(pad, def);
  }
  return world;
}

/// A plate of 2 kg that has fallen asleep on 10,000 sensors; beside it, if wanted, a ball that
/// falls for ever, so that the world goes on.
template <Scalar S>
[[nodiscard]] World<S> make_sleeping(bool has_patch, bool has_falling_ball) {
  WorldDef<S> world_def;
  world_def.time_step = S(1e-3);
  world_def.sleep.time = S(0.1);
  World<S> world(world_def);
  const BodyId floor = world.add_body({.motion = Motion::fixed});
  if (has_patch) {
    PatchDef<S> def;
    def.sensors = sensor_grid<S>(
        {.side_u = {S(0.04), 0, 0}, .side_v = {0, S(0.04), 0}, .count_u = 100, .count_v = 100});
    def.parameters = tuned_for<S>({.load = S(2 * 9.81), .mass = S(2)}).parameters(def.sensors);
    def.integration = Integration::implicit;
    world.add_patch(floor, def);
  }
  world.add_body({.motion = has_patch ? Motion::dynamic : Motion::fixed,
                  .mass = S(2),
                  .center_of_mass = Vec3<S>(0, 0, S(-0.02)),
                  .shape = Box<S>{{S(0.05), S(0.05), S(0.02)}},
                  .position = {0, 0, S(0.022)}});
  if (has_falling_ball) {
    world.add_body({.mass = S(1), .shape = Sphere<S>{S(0.1)}, .position = {1, 0, 0}});
  }
  for (int i = 0; i < 1500; ++i) world.step();
  return world;
}

}  // namespace bristle::benchmarks
