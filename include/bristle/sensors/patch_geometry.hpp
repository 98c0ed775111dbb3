/// @file
/// The rays of a patch on its body: all that no step changes, so that copies of a world share it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/error.hpp>
#include <bristle/geometry/rays/ray.hpp>
#include <bristle/geometry/rays/ray_tree.hpp>
#include <bristle/geometry/trees/aabb.hpp>
#include <bristle/math/rotation.hpp>
#include <bristle/sensors/packet_boxes.hpp>
#include <bristle/sensors/sensor_layout.hpp>
#include <bristle/sensors/sensor_packets.hpp>

#include <algorithm>
#include <cstddef>

namespace bristle::inline BRISTLE_ABI::detail {

/// Rays of a patch, as queries and kernels read them. Arrays have one entry a sensor.
template <Scalar S>
struct PatchGeometry {
  /// [m] Starts from A's centre of mass in A's axes; [1] unit directions; [m] lengths.
  Vec3Array<S> start, direction;
  LineArray<S> length;
  /// Tree over the rays.
  RayTree<S> ray_tree{};
  /// [m] Box around all rays, from A's centre of mass in A's axes.
  Aabb<S> box{};
  /// The same rays for the kernels: [0, size()) in order, then unused lanes.
  DynamicArray<RayPacket<S>> packets;
  PacketBoxes<S> packet_boxes{};
  /// [m] Farthest point of the rays from A's centre of mass, and the length of the shortest.
  S reach = S(0);
  S shortest = S(0);

  /// @param layout    At least one sensor, in the frame of the body.
  /// @param center_B  [m] Centre of mass of the body, in its frame.
  /// @throws InvalidArgument when a ray ends too far away to be measured.
  PatchGeometry(const SensorLayout<S>& layout, const Vec3<S>& center_B);

  [[nodiscard]] std::size_t size() const { return length.size(); }
  /// All rays, each longer by `extra_length` [m].
  [[nodiscard]] RayBatch<S> rays(S extra_length) const {
    return {start.x,     start.y, start.z,      direction.x, direction.y,
            direction.z, length,  extra_length, &ray_tree};
  }
};

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
PatchGeometry<S>::PatchGeometry(const SensorLayout<S>& layout, const Vec3<S>& center_B)
    : start(layout.start), direction(layout.direction), length(layout.length) {
  const std::size_t n = size();
  for (std::size_t i = 0; i < n; ++i) {
    start.set(i, start[i] - center_B);
    box.include(start[i]);
    const Vec3<S> end = start[i] + length[i] * direction[i];
    box.include(end);
    reach = std::max({reach, start[i].norm(), end.norm()});
  }
  require_finite("PatchDef::sensors: farthest point of a ray", reach);
  shortest = *std::min_element(length.begin(), length.end());
  packet_boxes = PacketBoxes<S>(rays(S(0)));
  ray_tree = RayTree<S>(rays(S(0)));
  packets.resize((n + packet_size - 1) / packet_size);
  for (std::size_t i = 0; i < packets.size() * packet_size; ++i) {
    RayPacket<S>& packet = packets[i / packet_size];
    const std::size_t lane = i % packet_size;
    // Lanes behind the last sensor never hit anything. A unit direction keeps them finite.
    const Vec3<S> along = i < n ? direction[i] : unit_x<Vec3<S>>();
    Vec3<S> t1, t2;
    tangent_basis<S>(along, t1, t2);
    packet.direction.set(lane, along);
    packet.tangent.set(lane, t1);
    if (i < n) packet.start.set(lane, start[i]);
    packet.inverse_length[lane] = i < n ? S(1) / length[i] : S(1);
  }
}

}  // namespace bristle::inline BRISTLE_ABI::detail
