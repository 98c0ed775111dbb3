/// @file
/// Readings of a patch: the depth, forces and state of each sensor in the last step.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/bodies/body.hpp>
#include <bristle/math/spatial.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

namespace bristle::inline BRISTLE_ABI {

/// State of one sensor.
enum class SensorState : std::uint8_t {
  /// No contact.
  free,
  /// In contact, bristle anchored.
  stuck,
  /// In contact, bristle let go in this step.
  slipping
};

/// View of a patch's readings, in sensor order. Valid until the next step or until the patch is
/// removed.
///
/// Forces are the applied impulses divided by the step, on the sensor's own body. Shear is given in
/// each sensor's tangent frame (t1, t2), fixed in its body: `tangent_basis` of the ray's direction
/// in the body frame.
template <Scalar S>
struct PatchReading {
  /// [1] Depth e_N at the start of the step, in [0, 1]; 0 without contact.
  std::span<const S> depth;
  /// [N] Force along the ray, >= 0, that pushes the sensor back.
  std::span<const S> normal_force;
  /// [N] Force across the ray, along t1: friction, and the sideways push of an oblique surface
  /// (`NormalDirection::gradient`).
  std::span<const S> shear_1;
  /// [N] The same along t2.
  std::span<const S> shear_2;
  /// [m] x of the contact point in the world, valid only in contact.
  std::span<const S> point_x;
  /// [m] y of the contact point in the world, valid only in contact.
  std::span<const S> point_y;
  /// [m] z of the contact point in the world, valid only in contact.
  std::span<const S> point_z;
  /// [-] Body in contact; names nothing without one.
  std::span<const BodyId> body;
  /// [-] Free, stuck or slipping.
  std::span<const SensorState> state;
  /// [N, N m] Total wrench on the patch's body about its centre of mass, world axes. In a
  /// `HapticLoop` it is about the origin of the tool's frame.
  Wrench<S> wrench{};
  /// [N] Vector sum of the shear forces, world axes.
  Vec3<S> shear_W = detail::zero<Vec3<S>>();

  /// [-] Number of sensors.
  [[nodiscard]] std::size_t size() const { return depth.size(); }
  /// [N] Sum of all normal forces.
  [[nodiscard]] S total_normal() const {
    S sum = S(0);
    for (const S f : normal_force) sum += f;
    return sum;
  }
  /// [N] Size of the vector sum of shear forces.
  [[nodiscard]] S total_shear() const { return shear_W.norm(); }
  /// [-] Number of sensors in contact.
  [[nodiscard]] std::size_t touching() const {
    return size() -
           static_cast<std::size_t>(std::count(state.begin(), state.end(), SensorState::free));
  }
  /// [-] Number of sensors that are pressed in over their whole length, with depth 1. They give no
  /// more, however deep a body goes: the constants are for less load (`GripSpec::load`), or for one
  /// that more sensors share (`GripSpec::radius`).
  [[nodiscard]] std::size_t bottomed_out() const {
    return static_cast<std::size_t>(
        std::count_if(depth.begin(), depth.end(), [](S e) { return e >= S(1); }));
  }
  /// [-] Number of sensors that slipped.
  [[nodiscard]] std::size_t slipping() const {
    return static_cast<std::size_t>(std::count(state.begin(), state.end(), SensorState::slipping));
  }
};

}  // namespace bristle::inline BRISTLE_ABI
