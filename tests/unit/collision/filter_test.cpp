// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/collision/filter.hpp>

#include <doctest/doctest.h>

using namespace bristle;

TEST_CASE("may_meet: needs both masks, and no common negative group") {
  const CollisionFilter all;
  CHECK(may_meet(all, all));
  const CollisionFilter finger{4, 2, 0};
  const CollisionFilter part{2, 4, 0};
  CHECK(may_meet(finger, part));
  CHECK(may_meet(part, finger));
  CHECK_FALSE(may_meet(finger, finger));
  // One side is not enough.
  CHECK_FALSE(may_meet(finger, CollisionFilter{2, 1, 0}));
  CHECK_FALSE(may_meet(CollisionFilter{2, 1, 0}, finger));
  CHECK_FALSE(may_meet(CollisionFilter{1, 1, -3}, CollisionFilter{1, 1, -3}));
  CHECK(may_meet(CollisionFilter{1, 1, -3}, CollisionFilter{1, 1, -4}));
  CHECK(may_meet(CollisionFilter{1, 1, 3}, CollisionFilter{1, 1, 3}));
}
