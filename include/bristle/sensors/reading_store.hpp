/// @file
/// Memory of the readings of a patch, with room for whole packets of sensors.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/dynamics/bodies/body.hpp>
#include <bristle/geometry/rays/ray.hpp>
#include <bristle/math/spatial.hpp>
#include <bristle/sensors/reading.hpp>
#include <bristle/sensors/sensor_packets.hpp>

#include <cstddef>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// Readings of a patch, one entry a sensor.
template <Scalar S>
struct ReadingStore {
  /// [-] Number of sensors.
  std::size_t count = 0;
  LineArray<S> depth, normal_force, shear_1, shear_2;
  Vec3Array<S> point;
  DynamicArray<BodyId> body;
  DynamicArray<SensorState> state;
  Wrench<S> wrench{};
  Vec3<S> shear_W = zero<Vec3<S>>();

  void resize(std::size_t sensors) {
    count = sensors;
    const std::size_t n = (sensors + packet_size - 1) / packet_size * packet_size;
    depth.resize(n);
    normal_force.resize(n);
    shear_1.resize(n);
    shear_2.resize(n);
    point.resize(n);
    body.resize(n);
    state.resize(n, SensorState::free);
  }
  /// Clears the readings of one packet.
  void clear_packet(std::size_t packet) {
    const std::size_t first = packet * packet_size;
    for (std::size_t i = first; i < first + packet_size; ++i) clear_sensor(i);
  }
  /// Clears the reading of one sensor.
  void clear_sensor(std::size_t i) {
    depth[i] = normal_force[i] = shear_1[i] = shear_2[i] = S(0);
    body[i] = BodyId{};
    state[i] = SensorState::free;
  }
  [[nodiscard]] PatchReading<S> view() const {
    const auto of = [this](const auto& items) { return std::span(items.data(), count); };
    return {of(depth),   of(normal_force), of(shear_1), of(shear_2), of(point.x), of(point.y),
            of(point.z), of(body),         of(state),   wrench,      shear_W};
  }
};

}  // namespace bristle::inline BRISTLE_ABI::detail
