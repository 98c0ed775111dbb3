// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/core/parallel.hpp>

#include <doctest/doctest.h>

#include <vector>

TEST_CASE("serial_for: runs every task once, in order") {
  std::vector<std::size_t> seen;
  bristle::serial_for(4, [&](std::size_t i) { seen.push_back(i); });
  CHECK(seen == std::vector<std::size_t>{0, 1, 2, 3});
  bristle::serial_for(0, [&](std::size_t) { FAIL("no task"); });
}
