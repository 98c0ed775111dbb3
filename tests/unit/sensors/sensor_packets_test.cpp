// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/sensors/sensor_packets.hpp>

#include <doctest/doctest.h>

#include <random>

using namespace bristle;

using namespace bristle::detail;

TEST_CASE(
    "packets_per_range: ranges of a sweep are alike, and as many for two threads as for four") {
  for (std::size_t packets = 1; packets < 5000; ++packets) {
    CAPTURE(packets);
    const std::size_t size = packets_per_range(packets);
    REQUIRE(size > 0);
    REQUIRE(size <= range_packets);
    const std::size_t ranges = (packets + size - 1) / size;
    REQUIRE(ranges <= range_count(packets));
    // None where threads have no part in it is smaller than it must be.
    if (packets <= (fewest_shared_ranges - 1) * range_packets) {
      REQUIRE(size == range_packets);
      continue;
    }
    REQUIRE(ranges >= fewest_shared_ranges);
    if (packets <= 28 * range_packets) REQUIRE(ranges % 4 == 0);
    // The work of a thread exceeds its share by no more than rounding up, a packet a range.
    for (const std::size_t threads : {2u, 4u}) {
      const std::size_t each = (ranges + threads - 1) / threads * size;
      REQUIRE(each * threads < packets + range_count(packets));
    }
  }
}

TEST_CASE("AnchorBodies: remembers the body of every was_anchored lane, as sixteen keys would") {
  std::mt19937 random(3);
  for (int round = 0; round < 200; ++round) {
    AnchorBodies bodies;
    Row<std::uint64_t> expected{};
    std::uint32_t was_anchored = 0;
    for (int step = 0; step < 20; ++step) {
      // Some let go; some of the lanes that are not was_anchored in a body, or in another, are now.
      was_anchored &= static_cast<std::uint32_t>(random()) | static_cast<std::uint32_t>(random());
      const std::uint64_t key = anchor_key(
          {static_cast<std::uint32_t>(random() % 3), static_cast<std::uint32_t>(random() % 2)});
      const auto anchored = static_cast<LaneBits>(was_anchored & bodies.lanes_in(key));
      const auto fresh = static_cast<LaneBits>(random() & ~std::uint32_t(anchored));
      if (fresh != 0) bodies.set(fresh, key, was_anchored != anchored);
      was_anchored |= fresh;
      for (std::size_t i = 0; i < packet_size; ++i) {
        if ((fresh >> i & 1u) != 0) expected[i] = key;
        if ((was_anchored >> i & 1u) == 0) continue;
        CHECK(bodies[i] == expected[i]);
        for (std::uint32_t index = 0; index < 3; ++index) {
          const std::uint64_t other = anchor_key({index, 1});
          CHECK(((bodies.lanes_in(other) >> i & 1u) != 0) == (expected[i] == other));
        }
      }
    }
  }
}

TEST_CASE("equal_lanes: where a value stands") {
  Row<std::uint32_t> row{};
  CHECK(equal_lanes(row.data(), 0u) == 0xffffu);
  row[0] = row[7] = row[15] = 5;
  CHECK(equal_lanes(row.data(), 5u) == ((1u << 0) | (1u << 7) | (1u << 15)));
  CHECK(equal_lanes(row.data(), 4u) == 0u);
}
