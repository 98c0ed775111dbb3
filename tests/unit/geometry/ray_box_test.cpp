// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/rays/ray_box.hpp>

#include <doctest/doctest.h>

using namespace bristle;

using namespace bristle::detail;

TEST_CASE_TEMPLATE("SlabTest: says where the ray enters", S, float, double) {
  const Aabb<S> box{{S(1), S(-1), S(-1)}, {S(2), S(1), S(1)}};
  const SlabTest<S> test(Ray<S>{{S(0), S(0), S(0)}, {S(1), S(0), S(0)}, infinity<S>});
  CHECK(test.enter(box, S(5)) == S(1));
  CHECK(test.enter(box, S(1)) == S(1));
  CHECK(test.enter(box, S(0.9)) == infinity<S>);
  // From inside at once; behind never.
  CHECK(SlabTest<S>(Ray<S>{{S(1.5), S(0), S(0)}, {S(1), S(0), S(0)}, S(1)}).enter(box, S(5)) ==
        S(0));
  CHECK(SlabTest<S>(Ray<S>{{S(3), S(0), S(0)}, {S(1), S(0), S(0)}, S(1)}).enter(box, S(5)) ==
        infinity<S>);
}

TEST_CASE_TEMPLATE("SlabTest: a ray within a face touches the box, one beside it does not", S,
                   float, double) {
  const Aabb<S> box{{S(1), S(-1), S(0)}, {S(2), S(1), S(0)}};
  for (const S zero : {S(0), -S(0)}) {
    const Vec3<S> direction(S(1), zero, zero);
    CHECK(SlabTest<S>(Ray<S>{{S(0), S(1), S(0)}, direction, S(9)}).enter(box, S(9)) == S(1));
    const S beside = std::numeric_limits<S>::min();
    CHECK(SlabTest<S>(Ray<S>{{S(0), S(1), beside}, direction, S(9)}).enter(box, S(9)) ==
          infinity<S>);
  }
}
