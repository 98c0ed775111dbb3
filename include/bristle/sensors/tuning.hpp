/// @file
/// Sensor constants from a physical spec, and the physical meaning of given constants.
///
/// docs/sensors.md derives the closed forms of both directions. The test suite verifies them on
/// masses from 2 g to 1000 kg.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/sensors/law.hpp>
#include <bristle/sensors/patch_def.hpp>
#include <bristle/sensors/sensor_constants.hpp>
#include <bristle/sensors/sensor_layout.hpp>
#include <bristle/sensors/sensor_parameters.hpp>
#include <bristle/sensors/stability.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

namespace bristle::inline BRISTLE_ABI {

/// Required behaviour of a patch that grips.
template <Scalar S>
struct GripSpec {
  /// [1] Static friction coefficient: shear that each newton of normal force must hold. > 0.
  S friction = S(0.8);
  /// [m] Creep of the held body when it is about to slip: sigma_a. > 0.
  S creep = S(1e-3);
  /// [N] Normal force that the whole patch carries. > 0.
  S load = S(10);
  /// [kg] Mass that moves against the patch. 0: the heaviest that the grip holds at 9.81 m/s^2,
  /// friction * load / 9.81.
  S mass = S(0);
  /// [1] Depth of the sensors under the load, in (0, 1]. Under a ball it is that of the deepest.
  S press = S(0.3);
  /// [m] Radius of the ball that is touched; 0 for a surface that presses all sensors in alike. A
  /// ball presses few of them in, and most of these less deep, so each must give more.
  S radius = S(0);
  /// [1] Damping ratio of the normal direction, >= 0.
  S normal_damping_ratio = S(1);
  /// [1] Damping ratio of the bristles, >= 0. At 0.7 slip starts at the same load for every step,
  /// and load changes pump no energy in. Below 0.2 sudden loads slip at half the limit.
  S bristle_damping_ratio = S(0.7);
  /// [-] Quantity that friction grows with; `none` and `depth` change the unit of the constants.
  FrictionScaling scaling = FrictionScaling::normal_force;
};

/// A spec that becomes constants once the number and length of the sensors are known.
template <Scalar S>
struct Tuning {
  /// Spec to meet, as `tuned_for` checked it.
  GripSpec<S> spec{};

  /// The patch of a layout: sensors, constants, and the scaling of friction that they are made for.
  [[nodiscard]] PatchDef<S> patch(SensorLayout<S> layout) const;
  /// Constants for `count` sensors of `length` [m] that share the load equally, whatever the radius
  /// of the spec. They are right in a patch whose `PatchDef::options` have the `scaling` of the
  /// spec.
  [[nodiscard]] SensorParameters<S> parameters(std::size_t count, S length) const;
  /// Constants for a layout, by its mean ray length. If the spec has a radius, they are for the
  /// place where a ball of it meets the sensors that carry most.
  [[nodiscard]] SensorParameters<S> parameters(const SensorLayout<S>& layout) const;
};

/// Checks a spec. Use: `world.add_patch(body, sensors, tuned_for<double>({.friction = 0.8}))`.
/// @throws InvalidArgument naming the field.
template <Scalar S>
[[nodiscard]] Tuning<S> tuned_for(const GripSpec<S>& spec);

/// A patch in use: the input of `describe`.
template <Scalar S>
struct PatchUse {
  /// [-] Number of sensors in contact.
  std::size_t count = 1;
  /// [m] Length of their rays.
  S length = S(0.01);
  /// [N] Normal force they carry together.
  S load = S(10);
  /// [kg] Mass that moves against them.
  S mass = S(1);
  /// [1] Stiffening of the tangential mode by a lever arm: 1 + m h^2 / I with the height h of the
  /// centre of mass above the patch. 1 for a patch that cannot tilt.
  S lever = S(1);
};

/// Physical meaning of constants in a given use.
template <Scalar S>
struct PatchDescription {
  /// [1] Shear per normal force that is held under slow loading: mu = mu_S sigma_a.
  S holding_coefficient = S(0);
  /// [1] The same for a sudden load. The bristles overshoot by 1 + D with D = exp(-pi z / sqrt(1 -
  /// z^2)), so it is mu / (1 + D); half of mu without damping.
  S sudden_coefficient = S(0);
  /// [1] Mean shear per normal force while sliding with `release`, without the viscous part:
  /// mu / 2.
  S kinetic_release = S(0);
  /// [1] The same with `drag`: mu.
  S kinetic_drag = S(0);
  /// [N/m] Stiffness of the whole patch against shear.
  S bristle_stiffness = S(0);
  /// [N/m] Stiffness of the whole patch along the rays.
  S normal_stiffness = S(0);
  /// [1] Depth at the load. Above 1 the sensors cannot carry it.
  S press = S(0);
  /// [1] Damping ratio against shear.
  S bristle_damping_ratio = S(0);
  /// [1] Damping ratio along the rays.
  S normal_damping_ratio = S(0);
  /// [1/s] Natural frequency of the bristles, as an angular frequency.
  S bristle_frequency = S(0);
  /// [s] Longest stable explicit step.
  S largest_explicit_step = S(0);
  /// [s] Recommended explicit step: 0.35 of the longest one, where Lambda is about 0.5.
  S recommended_explicit_step = S(0);

  /// [m] Creep at rest under a shear force [N].
  [[nodiscard]] S sag(S shear) const { return shear / bristle_stiffness; }
};

/// The inverse of `tuned_for`.
/// @throws InvalidArgument naming the field.
template <Scalar S>
[[nodiscard]] PatchDescription<S> describe(const SensorParameters<S>& p, const PatchUse<S>& use,
                                           FrictionScaling scaling = FrictionScaling::normal_force);

// Implementation ----------------------------------------------------------------------------------

namespace detail {

/// Sensors that carry a load.
template <Scalar S>
struct LoadedSensors {
  /// [-] How many they are.
  S count = S(0);
  /// [1] Sum of their depths.
  S depths = S(0);
  /// [1] Depth of the deepest, and [m] length of its ray.
  S deepest = S(0);
  S length = S(0);
};

/// Sensors that a ball presses in where it meets the sensor `middle` head-on.
/// @param end  [m] Where the ball ends, from the start of that sensor along its ray.
template <Scalar S>
LoadedSensors<S> pressed_by_ball(const SensorLayout<S>& layout, std::size_t middle, S radius,
                                 S end) {
  using std::sqrt;
  const Vec3<S> axis = layout.direction[middle];
  const Vec3<S> lowest = layout.start[middle] + end * axis;
  const S grazing = S(chosen::grazing_cosine) * radius;
  LoadedSensors<S> pressed;
  for (std::size_t i = 0; i < layout.size(); ++i) {
    const Vec3<S> direction = layout.direction[i];
    const Vec3<S> to_lowest = lowest - layout.start[i];
    const Vec3<S> to_center = to_lowest + radius * axis;
    const S along = to_center.dot(direction);
    const S aside2 = i == middle ? S(0) : (to_center - along * direction).squaredNorm();
    const S half2 = radius * radius - aside2;
    if (i != middle && (!(half2 > grazing * grazing) || !(along > S(0)))) continue;
    // The distance to the near side. Radii of hills leave no digits of their differences, and
    // cos - 1 of unit vectors is half the square of what lies between them.
    const S near = to_lowest.dot(direction) - radius * (axis - direction).squaredNorm() / S(2) +
                   aside2 / (radius + sqrt(half2));
    const S depth = S(1) - std::max(near, S(0)) / layout.length[i];
    if (!(depth > S(0))) continue;
    pressed.count += S(1);
    pressed.depths += depth;
    if (depth > pressed.deepest) {
      pressed.deepest = depth;
      pressed.length = layout.length[i];
    }
  }
  return pressed;
}

/// The same with the ball as deep as `press` in the sensor that it presses in most.
template <Scalar S>
LoadedSensors<S> pressed_to_depth(const SensorLayout<S>& layout, std::size_t middle, S radius,
                                  S press) {
  S end = (S(1) - press) * layout.length[middle];
  LoadedSensors<S> pressed = pressed_by_ball(layout, middle, radius, end);
  // Longer rays and those of a hollow skin are met before the one in the middle. Where rays are
  // parallel one shift of the ball is exact; a few do for any others.
  for (int shift = 0; shift < chosen::ball_shifts && pressed.deepest > press; ++shift) {
    end += (pressed.deepest - press) * pressed.length;
    const LoadedSensors<S> next = pressed_by_ball(layout, middle, radius, end);
    if (!(next.depths > S(0))) break;
    pressed = next;
  }
  return pressed;
}

/// The same where the ball meets the sensors that carry most, among at most `tried_ball_places`
/// all over the layout: on its border a ball meets fewer.
template <Scalar S>
LoadedSensors<S> most_pressed_by_ball(const SensorLayout<S>& layout, S radius, S press) {
  const std::size_t places = chosen::tried_ball_places;
  LoadedSensors<S> most;
  const std::size_t count = layout.size();
  for (std::size_t k = 0; k < std::min(count, places); ++k) {
    // Multiples of the golden ratio fall into step with no length of a grid's rows.
    const double share = (std::numbers::phi - 1.0) * static_cast<double>(k);
    const std::size_t i =
        count <= places
            ? k
            : static_cast<std::size_t>((share - std::floor(share)) * static_cast<double>(count));
    const LoadedSensors<S> here = pressed_to_depth(layout, i, radius, press);
    if (here.depths > most.depths) most = here;
  }
  return most;
}

/// Constants of sensors of `length` [m] that carry the load of a spec.
template <Scalar S>
SensorParameters<S> constants_for(const GripSpec<S>& spec, const LoadedSensors<S>& loaded,
                                  S length) {
  using std::sqrt;
  const S mass = spec.mass > S(0) ? spec.mass : spec.friction * spec.load / S(9.81);
  // k_t of the whole patch, for any scaling: mu N at a stretch of sigma_a.
  const S stiffness = spec.friction * spec.load / spec.creep;
  SensorParameters<S> p;
  p.breakaway_distance = spec.creep;
  p.normal_stiffness = spec.load / loaded.depths;
  p.normal_damping =
      S(2) * spec.normal_damping_ratio * sqrt(p.normal_stiffness * mass * length / loaded.count);
  p.sliding_friction = S(2) * spec.bristle_damping_ratio * sqrt(stiffness * mass) / loaded.count;
  switch (spec.scaling) {
    case FrictionScaling::normal_force:
      p.static_friction = spec.friction / spec.creep;
      break;
    case FrictionScaling::depth:
      p.static_friction = stiffness / loaded.depths;
      break;
    case FrictionScaling::none:
      p.static_friction = stiffness / loaded.count;
      break;
  }
  return p;
}

}  // namespace detail

template <Scalar S>
Tuning<S> tuned_for(const GripSpec<S>& spec) {
  detail::require_positive("GripSpec::friction", spec.friction);
  detail::require_positive("GripSpec::creep", spec.creep);
  detail::require_positive("GripSpec::load", spec.load);
  detail::require_not_negative("GripSpec::mass", spec.mass);
  detail::require_positive("GripSpec::press", spec.press);
  detail::require(spec.press <= S(1), "GripSpec::press", spec.press, "must be <= 1");
  detail::require_not_negative("GripSpec::radius", spec.radius);
  detail::require_not_negative("GripSpec::normal_damping_ratio", spec.normal_damping_ratio);
  detail::require_not_negative("GripSpec::bristle_damping_ratio", spec.bristle_damping_ratio);
  detail::require_enumerator("GripSpec::scaling", spec.scaling, FrictionScaling::none);
  return {spec};
}

template <Scalar S>
SensorParameters<S> Tuning<S>::parameters(std::size_t count, S length) const {
  detail::require(count > 0, "count", S(0), "must be > 0");
  detail::require_positive("length", length);
  detail::require(!(spec.radius > S(0)), "GripSpec::radius", spec.radius,
                  "must be 0 where the layout of the sensors is not known");
  const S n = static_cast<S>(count);
  return detail::constants_for(spec, {n, n * spec.press, spec.press, length}, length);
}

template <Scalar S>
PatchDef<S> Tuning<S>::patch(SensorLayout<S> layout) const {
  PatchDef<S> def;
  def.parameters = parameters(layout);
  def.options.scaling = spec.scaling;
  def.load = spec.load;
  def.sensors = std::move(layout);
  return def;
}

template <Scalar S>
SensorParameters<S> Tuning<S>::parameters(const SensorLayout<S>& layout) const {
  layout.validate();
  detail::require(layout.size() > 0, "SensorLayout::size()", S(0),
                  "must be > 0: it has no sensors");
  S sum = S(0);
  for (const S length : layout.length) sum += length;
  const S length = sum / static_cast<S>(layout.size());
  if (!(spec.radius > S(0))) return parameters(layout.size(), length);
  return detail::constants_for(spec, detail::most_pressed_by_ball(layout, spec.radius, spec.press),
                               length);
}

template <Scalar S>
PatchDescription<S> describe(const SensorParameters<S>& p, const PatchUse<S>& use,
                             FrictionScaling scaling) {
  using std::exp;
  using std::sqrt;
  validate(p);
  detail::require(use.count > 0, "PatchUse::count", S(0), "must be > 0");
  detail::require_positive("PatchUse::length", use.length);
  detail::require_positive("PatchUse::load", use.load);
  detail::require_positive("PatchUse::mass", use.mass);
  detail::require_positive("PatchUse::lever", use.lever);
  const S n = static_cast<S>(use.count);
  PatchDescription<S> out;
  out.normal_stiffness = n * p.normal_stiffness / use.length;
  out.press = use.load / (n * p.normal_stiffness);
  out.bristle_stiffness =
      n * detail::bristle_stiffness(p, scaling, use.load / n, std::min(out.press, S(1)));
  out.holding_coefficient = out.bristle_stiffness * p.breakaway_distance / use.load;
  out.kinetic_release = out.holding_coefficient / S(2);
  out.kinetic_drag = out.holding_coefficient;
  out.bristle_frequency = sqrt(out.bristle_stiffness / use.mass);
  const S viscous = n * p.sliding_friction;
  out.bristle_damping_ratio = viscous / (S(2) * sqrt(out.bristle_stiffness * use.mass));
  out.normal_damping_ratio =
      n * p.normal_damping / use.length / (S(2) * sqrt(out.normal_stiffness * use.mass));
  const S z = out.bristle_damping_ratio;
  const S overshoot = z < S(1) ? S(exp(-S(EIGEN_PI) * z / sqrt(S(1) - z * z))) : S(0);
  out.sudden_coefficient = out.holding_coefficient / (S(1) + overshoot);
  const detail::Mode<S> tangential_mode{use.mass, out.bristle_stiffness * use.lever, viscous};
  const detail::Mode<S> normal_mode{use.mass, out.normal_stiffness,
                                    n * p.normal_damping / use.length};
  out.largest_explicit_step =
      std::min(tangential_mode.largest_stable_step(), normal_mode.largest_stable_step());
  out.recommended_explicit_step =
      S(detail::chosen::recommended_step_share) * out.largest_explicit_step;
  return out;
}

}  // namespace bristle::inline BRISTLE_ABI
