// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/sensors/sensor_tiles.hpp>

#include <doctest/doctest.h>

#include <random>

using namespace bristle;

TEST_CASE("tiles_per_slice: slices of a sweep are alike, and as many for two threads as for four") {
  for (std::size_t tiles = 1; tiles < 5000; ++tiles) {
    CAPTURE(tiles);
    const std::size_t size = tiles_per_slice(tiles);
    REQUIRE(size > 0);
    REQUIRE(size <= slice_tiles);
    const std::size_t slices = (tiles + size - 1) / size;
    REQUIRE(slices <= slice_count(tiles));
    // None where threads have no part in it is smaller than it must be.
    if (tiles <= (fewest_shared_slices - 1) * slice_tiles) {
      REQUIRE(size == slice_tiles);
      continue;
    }
    REQUIRE(slices >= fewest_shared_slices);
    if (tiles <= 28 * slice_tiles) REQUIRE(slices % 4 == 0);
    // What a thread does is more than its part by no more than rounding up, a tile a slice.
    for (const std::size_t threads : {2u, 4u}) {
      const std::size_t each = (slices + threads - 1) / threads * size;
      REQUIRE(each * threads < tiles + slice_count(tiles));
    }
  }
}

TEST_CASE("RootBodies: remembers the body of every rooted lane, as sixteen keys would") {
  std::mt19937 random(3);
  for (int round = 0; round < 200; ++round) {
    RootBodies bodies;
    Row<std::uint64_t> expected{};
    std::uint32_t rooted = 0;
    for (int step = 0; step < 20; ++step) {
      // Some let go; some of the lanes that are not rooted in a body, or in another, are now.
      rooted &= static_cast<std::uint32_t>(random()) | static_cast<std::uint32_t>(random());
      const std::uint64_t key = root_key(
          {static_cast<std::uint32_t>(random() % 3), static_cast<std::uint32_t>(random() % 2)});
      const auto anchored = static_cast<LaneBits>(rooted & bodies.lanes_in(key));
      const auto fresh = static_cast<LaneBits>(random() & ~std::uint32_t(anchored));
      if (fresh != 0) bodies.set(fresh, key, rooted != anchored);
      rooted |= fresh;
      for (std::size_t i = 0; i < tile_size; ++i) {
        if ((fresh >> i & 1u) != 0) expected[i] = key;
        if ((rooted >> i & 1u) == 0) continue;
        CHECK(bodies[i] == expected[i]);
        for (std::uint32_t index = 0; index < 3; ++index) {
          const std::uint64_t other = root_key({index, 1});
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
