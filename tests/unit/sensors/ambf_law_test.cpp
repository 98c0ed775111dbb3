// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/sensors/ambf_law.hpp>

#include <doctest/doctest.h>

using namespace bristle;

using namespace bristle::detail;

TEST_CASE_TEMPLATE("ambf_projected: itself above 1e-4, its cube within", S, float, double) {
  const Vec3<S> above(S(2e-4), 0, 0);
  CHECK(ambf_projected<S>(above) == above);
  const Vec3<S> within(0, S(5e-5), 0);
  CHECK(ambf_projected<S>(within).isApprox(Vec3<S>(0, S(1.25e-13), 0)));
  CHECK(ambf_projected<S>(Vec3<S>::Zero()) == Vec3<S>::Zero());
}

TEST_CASE_TEMPLATE("ambf_sensor_force: roots, holds, lets go, without friction while it does", S,
                   float, double) {
  const SensorParameters<S> p{S(2), S(50), S(1000), S(0), S(1e-3)};
  SensorContact<S> c;
  c.depth = S(0.5);
  c.n = {0, 0, -1};
  c.g = c.n;
  c.v = {0, 0, S(-3)};  // Fast into the surface: the damper does nothing.
  const Vec3<S> m(0, 0, 1);
  const Vec3<S> r_A(0, 0, S(-0.01));
  PairPose<S> pair;
  Anchor<S> anchor;
  bool is_anchored = false;
  bool did_slip = false;
  const auto force = [&] {
    return ambf_sensor_force(p, FrictionScaling::normal_force, c, m, pair, r_A, anchor, is_anchored,
                             did_slip);
  };
  CHECK(force().total() == Vec3<S>(0, 0, S(-1)));
  CHECK(is_anchored);
  pair.p_AB.x() = S(-5e-4);
  CHECK(force().shear.isApprox(Vec3<S>(S(0.5), 0, 0), S(1e-3)));
  CHECK_FALSE(did_slip);
  pair.p_AB.x() = S(-2e-3);
  CHECK(force().shear == Vec3<S>::Zero());
  CHECK(did_slip);
  CHECK_FALSE(is_anchored);
  CHECK(force().shear == Vec3<S>::Zero());
  CHECK_FALSE(did_slip);
  CHECK(is_anchored);
}

TEST_CASE_TEMPLATE("ambf_sensor_force: slides in the plane of the touched surface", S, float,
                   double) {
  const SensorParameters<S> p{S(2), S(0), S(0), S(3), S(1e-3)};
  SensorContact<S> c;
  c.depth = S(0.5);
  c.n = Vec3<S>(S(0.6), 0, S(-0.8));
  c.v = {S(1), 0, S(1)};
  Anchor<S> anchor;
  bool is_anchored = false;
  bool did_slip = false;
  const SensorForce<S> f =
      ambf_sensor_force<S>(p, FrictionScaling::none, c, Vec3<S>(0, 0, 1), PairPose<S>{},
                           Vec3<S>::Zero(), anchor, is_anchored, did_slip);
  CHECK(f.shear.isApprox(Vec3<S>(S(3), 0, 0)));
}
