// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/sensors/sensor_packets.hpp>

#include <doctest/doctest.h>

using namespace bristle;

using namespace bristle::detail;

TEST_CASE(
    "packets_per_range: ranges of a sweep are alike, and as many for two threads as for four") {
  for (std::size_t packets = 1; packets < 5000; ++packets) {
    CAPTURE(packets);
    const std::size_t size = packets_per_range(packets);
    REQUIRE(size > 0);
    REQUIRE(size <= chosen::range_packets);
    const std::size_t ranges = (packets + size - 1) / size;
    REQUIRE(ranges <= range_count(packets));
    // None where threads have no part in it is smaller than it must be.
    if (packets <= (chosen::fewest_shared_ranges - 1) * chosen::range_packets) {
      REQUIRE(size == chosen::range_packets);
      continue;
    }
    REQUIRE(ranges >= chosen::fewest_shared_ranges);
    if (packets <= 28 * chosen::range_packets) REQUIRE(ranges % 4 == 0);
    // The work of a thread exceeds its share by no more than rounding up, a packet a range.
    for (const std::size_t threads : {2u, 4u}) {
      const std::size_t each = (ranges + threads - 1) / threads * size;
      REQUIRE(each * threads < packets + range_count(packets));
    }
  }
}

TEST_CASE("equal_lanes: bodies of another slot, and of another life of a slot, are others") {
  Row<BodyId> row;
  row.fill({3, 7});
  CHECK(equal_lanes(row.data(), BodyId{3, 7}) == 0xffffu);
  CHECK(equal_lanes(row.data(), BodyId{3, 8}) == 0);
  row[2] = {3, 8};
  row[9] = {4, 7};
  row[15] = {};
  CHECK(equal_lanes(row.data(), BodyId{3, 7}) == (0xffffu & ~((1u << 2) | (1u << 9) | (1u << 15))));
  CHECK(equal_lanes(row.data(), BodyId{3, 8}) == 1u << 2);
  CHECK(equal_lanes(row.data(), BodyId{4, 7}) == 1u << 9);
}

TEST_CASE("equal_lanes: where a value stands") {
  Row<std::uint32_t> row{};
  CHECK(equal_lanes(row.data(), 0u) == 0xffffu);
  row[0] = row[7] = row[15] = 5;
  CHECK(equal_lanes(row.data(), 5u) == ((1u << 0) | (1u << 7) | (1u << 15)));
  CHECK(equal_lanes(row.data(), 4u) == 0u);
}
