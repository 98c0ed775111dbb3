// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"

#include <bristle/geometry/trees/aabb.hpp>
#include <bristle/sensors/packet_boxes.hpp>
#include <bristle/sensors/sensor_layout.hpp>

#include <doctest/doctest.h>

#include <algorithm>

using namespace bristle;

using namespace bristle::detail;

// Every ray with a point in the query must be in one of the packets that are found.
TEST_CASE_TEMPLATE("packet boxes: no ray that enters a box is left out", S, float, double) {
  test::Random random(11);
  for (const std::size_t n : {1u, 16u, 17u, 400u, 5000u}) {
    SensorLayout<S> rays;
    for (std::size_t i = 0; i < n; ++i) {
      rays.add(Vec3<S>(S(i % 70), S(i / 70), 0) + random.in_cube(S(0.2)), random.direction<S>(),
               S(1));
    }
    const PacketBoxes<S> boxes(rays.rays());
    DynamicArray<std::uint32_t> packets;
    const Pack3<S> zero = Pack3<S>::all(Vec3<S>(Vec3<S>::Zero()));
    const auto all_are_finite = [&](const Pack3<S>& lower, const Pack3<S>& upper) {
      const Pack3<S> extent = upper - lower;
      CHECK(all(extent.x + extent.y + extent.z < Pack<S>(infinity<S>)));
      CHECK(all(extent.x + extent.y + extent.z > Pack<S>(-infinity<S>)));
      return zero.x <= zero.x;
    };
    boxes.find(all_are_finite, packets);
    CHECK(packets.size() == (n + packet_size - 1) / packet_size);
    boxes.find([&](const auto&, const auto&) { return zero.x < zero.x; }, packets);
    CHECK(packets.empty());
    for (int round = 0; round < 20; ++round) {
      Aabb<S> query;
      query.include(random.in_cube(S(40)) + Vec3<S>(35, 35, 0));
      query = query.inflated(S(3));
      const Pack3<S> least = Pack3<S>::all(query.lower), most = Pack3<S>::all(query.upper);
      const auto overlaps = [&](const Pack3<S>& lower, const Pack3<S>& upper) {
        return (lower.x <= most.x) & (lower.y <= most.y) & (lower.z <= most.z) &
               (least.x <= upper.x) & (least.y <= upper.y) & (least.z <= upper.z);
      };
      boxes.find(overlaps, packets);
      CHECK(std::is_sorted(packets.begin(), packets.end()));
      for (std::size_t i = 0; i < n; ++i) {
        bool enters = false;
        for (int k = 0; k <= 10; ++k) {
          enters =
              enters || query.contains(Vec3<S>(rays.start[i] + S(k) / S(10) * rays.direction[i]));
        }
        if (!enters) continue;
        CHECK(std::binary_search(packets.begin(), packets.end(),
                                 static_cast<std::uint32_t>(i / packet_size)));
      }
    }
  }
}
