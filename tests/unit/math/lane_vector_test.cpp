// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/math/lane_vector.hpp>

#include <doctest/doctest.h>

#include <cstdint>

using namespace bristle;

using namespace bristle::detail;

TEST_CASE_TEMPLATE("LaneVector: begins at a cache line, however long, and as it grows", T, float,
                   double, std::uint32_t) {
  for (std::size_t n = 1; n < 5000; n = 2 * n + 1) {
    LaneVector<T> row(n, T(3));
    row.push_back(T(4));
    CHECK(reinterpret_cast<std::uintptr_t>(row.data()) % 64 == 0);
    CHECK(row.front() == T(3));
    CHECK(row.back() == T(4));
  }
}
