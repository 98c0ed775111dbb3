// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/math/finite.hpp>

#include <doctest/doctest.h>

#include <limits>

using namespace bristle;

using namespace bristle::detail;

TEST_CASE_TEMPLATE("all_finite: finds an infinite or undefined entry in any place", S, float,
                   double) {
  const S most = std::numeric_limits<S>::max();
  CHECK(all_finite(Vec3<S>(most, -most, most)));
  CHECK(all_finite(Mat6<S>(Mat6<S>::Constant(most))));
  for (const S bad : {infinity<S>, -infinity<S>, std::numeric_limits<S>::quiet_NaN()}) {
    for (Eigen::Index i = 0; i < 3; ++i) {
      Vec3<S> v(1, 2, 3);
      v[i] = bad;
      CHECK_FALSE(all_finite(v));
    }
    Vec6<S> last = Vec6<S>::Zero();
    last[5] = bad;
    CHECK_FALSE(all_finite(last));
  }
}

TEST_CASE_TEMPLATE("is_unit: a direction that overflowed, or lost its length, is none", S, float,
                   double) {
  CHECK(is_unit(Vec3<S>(Vec3<S>::UnitY())));
  CHECK_FALSE(is_unit(Vec3<S>(Vec3<S>::Zero())));
  CHECK_FALSE(is_unit(Vec3<S>(0, 0, S(1.01))));
  CHECK_FALSE(is_unit(Vec3<S>(0, 0, std::numeric_limits<S>::max())));
  CHECK_FALSE(is_unit(Vec3<S>(0, 0, std::numeric_limits<S>::quiet_NaN())));
}
