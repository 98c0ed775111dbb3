/// @file
/// What the sensors of a patch felt in the last step.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/bodies/body.hpp>
#include <bristle/geometry/rays/ray.hpp>
#include <bristle/math/lane_vector.hpp>
#include <bristle/math/spatial.hpp>
#include <bristle/sensors/sensor_tiles.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// State of one sensor.
enum class SensorState : std::uint8_t {
  /// Touches nothing.
  free,
  /// Touches, its bristle rooted.
  stuck,
  /// Touches, its bristle let go in this step.
  slipping
};

/// View of a patch's readings, in the order of its sensors. Valid until the next step or until the
/// patch is removed.
///
/// Forces are the impulses that were applied, divided by the step, on the sensor's own body. Shear
/// is given in each sensor's tangent frame (t1, t2), fixed in its body: `tangent_basis` of the
/// ray's direction in the body frame.
template <Scalar S>
struct PatchReading {
  /// [1] Depth e_N at the start of the step, in [0, 1]; 0 where nothing is touched.
  std::span<const S> depth;
  /// [N] Force along the ray, >= 0, that pushes the sensor back.
  std::span<const S> normal_force;
  /// [N] Force across the ray, along t1 and t2: friction, and what an oblique surface pushes aside
  /// (`NormalDirection::gradient`).
  std::span<const S> shear_1;
  std::span<const S> shear_2;
  /// [m] Point of touch in the world, valid where something is touched.
  std::span<const S> point_x;
  std::span<const S> point_y;
  std::span<const S> point_z;
  /// [-] Body that is touched; names nothing where none is.
  std::span<const BodyId> body;
  /// [-] Free, stuck or slipping.
  std::span<const SensorState> state;
  /// [N, N m] Total on the patch's body about its centre of mass, world axes.
  Wrench<S> wrench{};
  /// [N] Total of the shear forces as a vector, world axes.
  Vec3<S> shear_W = Vec3<S>::Zero();

  [[nodiscard]] std::size_t size() const { return depth.size(); }
  /// [N] Sum of all normal forces.
  [[nodiscard]] S total_normal() const {
    S sum = S(0);
    for (const S f : normal_force) sum += f;
    return sum;
  }
  /// [N] Length of the vector sum of all shear forces.
  [[nodiscard]] S total_shear() const { return shear_W.norm(); }
  /// [-] Number of sensors that touch something.
  [[nodiscard]] std::size_t touching() const {
    return size() -
           static_cast<std::size_t>(std::count(state.begin(), state.end(), SensorState::free));
  }
  /// [-] Number of sensors that slipped.
  [[nodiscard]] std::size_t slipping() const {
    return static_cast<std::size_t>(std::count(state.begin(), state.end(), SensorState::slipping));
  }
};

/// Where the readings of a patch are kept, with room for whole tiles of sensors.
template <Scalar S>
struct ReadingStore {
  /// [-] Number of sensors.
  std::size_t count = 0;
  LaneVector<S> depth, normal_force, shear_1, shear_2;
  Vec3Array<S> point;
  std::vector<BodyId> body;
  std::vector<SensorState> state;
  Wrench<S> wrench{};
  Vec3<S> shear_W = Vec3<S>::Zero();

  void resize(std::size_t sensors) {
    count = sensors;
    const std::size_t n = (sensors + tile_size - 1) / tile_size * tile_size;
    depth.resize(n);
    normal_force.resize(n);
    shear_1.resize(n);
    shear_2.resize(n);
    point.resize(n);
    body.resize(n);
    state.resize(n, SensorState::free);
  }
  /// Makes the sensors of one tile read nothing.
  void clear_tile(std::size_t tile) {
    const std::size_t first = tile * tile_size;
    for (std::size_t i = first; i < first + tile_size; ++i) {
      depth[i] = normal_force[i] = shear_1[i] = shear_2[i] = S(0);
      body[i] = BodyId{};
      state[i] = SensorState::free;
    }
  }
  [[nodiscard]] PatchReading<S> view() const {
    const auto of = [this](const auto& items) { return std::span(items.data(), count); };
    return {of(depth),   of(normal_force), of(shear_1), of(shear_2), of(point.x), of(point.y),
            of(point.z), of(body),         of(state),   wrench,      shear_W};
  }
};

}  // namespace bristle::inline BRISTLE_ABI
