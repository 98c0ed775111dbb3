// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/collision/contact_cache.hpp>

#include <doctest/doctest.h>

using namespace bristle;

namespace {

template <typename S>
ContactManifolds<S> manifold(std::uint32_t key, std::initializer_list<std::uint32_t> features) {
  ContactManifold<S> m;
  m.key = key;
  m.normal = {0, 0, 1};
  for (const std::uint32_t f : features) {
    ContactPoint<S> point;
    point.position = {S(f), 0, 0};
    point.gap = S(-0.25);
    point.feature = f;
    m.add(point);
  }
  return {m};
}

template <typename S>
void add(ContactCache<S>& cache, ShapePair pair, const ContactManifolds<S>& found) {
  cache.add(pair, found, Mat3<S>::Identity(), Vec3<S>::Zero(), Vec3<S>(0, 0, 2));
}

}  // namespace

TEST_CASE_TEMPLATE("ContactCache: points inherit impulses of the same pair, key and feature", S,
                   float, double) {
  ContactCache<S> cache;
  cache.begin_step();
  add<S>(cache, {0, 1}, manifold<S>(0, {1, 2}));
  add<S>(cache, {0, 2}, manifold<S>(5, {1}));
  CHECK(cache.points()[0].impulse[0] == S(0));
  cache.points()[0].impulse = {S(1), 0, 0};
  cache.points()[1].impulse = {S(2), 0, 0};
  cache.points()[2].impulse = {S(3), 0, 0};
  cache.begin_step();
  // The first pair lost feature 1 and found 7; the second came under another key.
  add<S>(cache, {0, 1}, manifold<S>(0, {2, 7}));
  add<S>(cache, {0, 2}, manifold<S>(6, {1}));
  CHECK(cache.points()[0].impulse[0] == S(2));
  CHECK(cache.points()[1].impulse[0] == S(0));
  CHECK(cache.points()[2].impulse[0] == S(0));
}

TEST_CASE_TEMPLATE("ContactCache: arms reach from each centre of mass to the point", S, float,
                   double) {
  ContactCache<S> cache;
  cache.begin_step();
  // Shape a turned by a quarter about z and shifted.
  Mat3<S> R;
  R << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  cache.add({0, 1}, manifold<S>(0, {3}), R, Vec3<S>(S(0.5), 0, 0), Vec3<S>(0, 0, 2));
  CHECK(cache.points()[0].arm_a == Vec3<S>(S(0.5), 3, 0));
  CHECK(cache.points()[0].arm_b == Vec3<S>(S(0.5), 3, -2));
  CHECK(cache.points()[0].gap == S(-0.25));
  CHECK(cache.manifolds()[0].normal == Vec3<S>(0, 0, 1));
}

TEST_CASE("ContactCache: a forgotten shape leaves nothing to its successor") {
  ContactCache<double> cache;
  cache.begin_step();
  add<double>(cache, {0, 1}, manifold<double>(0, {1}));
  cache.points()[0].impulse = {1, 0, 0};
  cache.forget(1);
  cache.begin_step();
  add<double>(cache, {0, 1}, manifold<double>(0, {1}));
  CHECK(cache.points()[0].impulse[0] == 0);
}
