// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"

#include <bristle/collision/contact_cache.hpp>
#include <bristle/geometry/contacts/box_box.hpp>

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <limits>
#include <utility>

using namespace bristle;

using namespace bristle::detail;

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
  cache.add(pair, found, {Mat3<S>::Identity(), Vec3<S>::Zero(), Vec3<S>(0, 0, 2), Vec3<S>::Zero()});
}

}  // namespace

TEST_CASE_TEMPLATE("ContactCache: points inherit impulses of the same pair, key and feature", S,
                   float, double) {
  ContactCache<S> cache;
  cache.begin_step(1);
  add<S>(cache, {0, 1}, manifold<S>(0, {1, 2}));
  add<S>(cache, {0, 2}, manifold<S>(5, {1}));
  CHECK(cache.points()[0].impulse[0] == S(0));
  cache.points()[0].impulse = {S(1), 0, 0};
  cache.points()[1].impulse = {S(2), 0, 0};
  cache.points()[2].impulse = {S(3), 0, 0};
  for (std::size_t i = 0; i < 3; ++i) cache.points()[i].position_excess = S(4 + i);
  cache.begin_step(1);
  // The first pair lost feature 1 and found 7; the second came under another key.
  add<S>(cache, {0, 1}, manifold<S>(0, {2, 7}));
  add<S>(cache, {0, 2}, manifold<S>(6, {1}));
  CHECK(cache.points()[0].impulse[0] == S(2));
  CHECK(cache.points()[1].impulse[0] == S(0));
  CHECK(cache.points()[2].impulse[0] == S(0));
  CHECK(cache.points()[0].position_excess == S(5));
  CHECK(cache.points()[1].position_excess == S(0));
  CHECK(cache.points()[2].position_excess == S(0));
}

TEST_CASE("ContactCache: what passes of an impulse is not inherited") {
  ContactCache<double> cache;
  cache.begin_step(1);
  add<double>(cache, {0, 1}, manifold<double>(0, {1}));
  cache.points()[0].impulse = {4, 2, -1};
  cache.points()[0].transient_impulse = {1, 0.5, -2};
  cache.begin_step(1);
  add<double>(cache, {0, 1}, manifold<double>(0, {1}));
  CHECK(cache.points()[0].impulse == std::array<double, 3>{3, 1.5, 1});
  CHECK(cache.points()[0].transient_impulse == std::array<double, 3>{});
}

TEST_CASE_TEMPLATE("ContactCache: arms reach from each centre of mass to the point", S, float,
                   double) {
  ContactCache<S> cache;
  cache.begin_step(1);
  // Shape a turned by a quarter about z and shifted.
  Mat3<S> R;
  R << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  cache.add({0, 1}, manifold<S>(0, {3}),
            {R, Vec3<S>(S(0.5), 0, 0), Vec3<S>(0, 0, 2), Vec3<S>(7, 8, 9)});
  CHECK(cache.points()[0].arm_a == Vec3<S>(S(0.5), 3, 0));
  CHECK(cache.points()[0].arm_b == Vec3<S>(S(0.5), 3, -2));
  CHECK(cache.points()[0].gap == S(-0.25));
  CHECK(cache.manifolds()[0].normal == Vec3<S>(0, 0, 1));
  CHECK(cache.manifolds()[0].center_a == Vec3<S>(7, 8, 9));
}

TEST_CASE("ContactCache: a forgotten shape leaves nothing to its successor, and the rest alone") {
  ContactCache<double> cache;
  for (int generation = 0; generation < 2; ++generation) {
    cache.begin_step(1);
    add<double>(cache, {0, 1}, manifold<double>(0, {1}));
    add<double>(cache, {0, 2}, manifold<double>(0, {4, 5}));
    add<double>(cache, {1, 2}, manifold<double>(0, {6}));
    for (auto& point : cache.points()) point.impulse = {1.0 * point.feature, 0, 0};
  }
  cache.forget(1);
  for (const auto* points : {&std::as_const(cache).points(), &cache.last_points()}) {
    REQUIRE(points->size() == 2);
    CHECK((*points)[0].feature == 4);
    CHECK((*points)[1].feature == 5);
  }
  REQUIRE(cache.manifolds().size() == 1);
  CHECK(cache.manifolds()[0].shapes == ShapePair{0, 2});
  CHECK(cache.manifolds()[0].first == 0);
  CHECK(cache.manifolds()[0].count == 2);
  cache.begin_step(1);
  add<double>(cache, {0, 1}, manifold<double>(0, {1}));
  add<double>(cache, {0, 2}, manifold<double>(0, {4}));
  CHECK(cache.points()[0].impulse[0] == 0);
  CHECK(cache.points()[1].impulse[0] == 4);
}

TEST_CASE("ContactCache: carried pairs come in their place, with their impulses") {
  ContactCache<double> cache;
  cache.begin_step(1);
  for (const ShapePair pair : {ShapePair{0, 1}, {0, 3}, {1, 2}, {2, 3}}) {
    add<double>(cache, pair, manifold<double>(0, {pair.a, pair.b}));
  }
  for (std::size_t i = 0; i < 8; ++i) cache.points()[i].impulse = {1.0 + double(i), 0, 0};
  cache.begin_step(1);
  // Shape 3 moves on its own; the pair (0, 2) is new.
  const auto keeps = [](ShapePair pair) { return pair.b != 3; };
  for (const ShapePair pair : {ShapePair{0, 2}, {0, 3}}) {
    cache.persist_before(pair, keeps);
    add<double>(cache, pair, manifold<double>(0, {pair.a, pair.b}));
  }
  cache.persist_before({~0u, ~0u}, keeps);
  const ShapePair expected[] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}};
  const double impulses[] = {1, 2, 0, 0, 3, 4, 5, 6};
  REQUIRE(cache.manifolds().size() == 4);
  for (std::size_t i = 0; i < 4; ++i) {
    INFO(i);
    const auto& m = cache.manifolds()[i];
    CHECK(m.shapes == expected[i]);
    CHECK(m.first == 2 * i);
    CHECK(m.is_persisted == (i == 0 || i == 3));
    CHECK(cache.points()[m.first].feature == m.shapes.a);
    CHECK(cache.points()[m.first].impulse[0] == impulses[2 * i]);
    CHECK(cache.points()[m.first + 1].impulse[0] == impulses[2 * i + 1]);
  }
}

TEST_CASE("ContactCache: a repeated step is its own predecessor") {
  ContactCache<double> cache;
  cache.begin_step(1);
  cache.begin_step(1);
  add<double>(cache, {0, 1}, manifold<double>(0, {1}));
  CHECK(cache.last_manifolds().empty());
  cache.repeat();
  CHECK(cache.last_manifolds().size() == 1);
  CHECK(cache.last_points().size() == 1);
  cache.begin_step(1);
  CHECK(cache.manifolds().empty());
  CHECK(cache.last_manifolds().size() == 1);
}

TEST_CASE_TEMPLATE("ContactCache: equal boxes that jitter on each other keep all their impulses", S,
                   float, double) {
  test::Random random(21);
  const Box<S> box{{S(0.5), S(0.3), S(0.2)}};
  const S smallest = std::log2(std::numeric_limits<S>::epsilon());
  const S largest = std::log2(Tolerance<S>::equal() / S(10));
  ContactCache<S> cache;
  for (int i = 0; i < 500; ++i) {
    const S jitter = std::exp2(random.uniform(smallest, largest));
    const Transform<S> X_AB{
        exp_rotation<S>(jitter * random.direction<S>()),
        Vec3<S>(Vec3<S>(0, 0, S(0.4)) + S(0.5) * jitter * random.direction<S>())};
    ContactManifolds<S> found;
    collide_shapes(box, box, X_AB, S(0.01), found);
    cache.begin_step(1);
    cache.add({0, 1}, found,
              {Mat3<S>::Identity(), Vec3<S>::Zero(), X_AB.translation, Vec3<S>::Zero()});
    REQUIRE(cache.points().size() == 4);
    for (CachedPoint<S>& point : cache.points()) {
      // Each corner carries a number of its own, and gets its own back.
      const S mine =
          S(1) + (point.arm_a.x() > S(0) ? S(1) : S(0)) + (point.arm_a.y() > S(0) ? S(2) : S(0));
      CHECK(point.is_fresh == (i == 0));
      if (i > 0) CHECK(point.impulse[0] == mine);
      point.impulse[0] = mine;
    }
  }
}

TEST_CASE_TEMPLATE(
    "ContactCache: points are matched by feature in any order, and left over by place", S, float,
    double) {
  ContactCache<S> cache;
  cache.begin_step(1);
  add<S>(cache, {0, 1}, manifold<S>(0, {1, 2, 3, 4}));
  for (std::size_t i = 0; i < 4; ++i) cache.points()[i].impulse = {S(i + 1), S(i) / 4, -S(i)};
  cache.points()[2].took_impact = true;
  cache.begin_step(1);
  ContactManifolds<S> found = manifold<S>(0, {4, 3, 9, 1});
  // Another name where feature 2 was; the patch is 3 long.
  found[0].points[2].position = {S(2.02), 0, 0};
  add<S>(cache, {0, 1}, found);
  const auto& points = cache.points();
  CHECK(points[0].impulse == std::array<S, 3>{S(4), S(0.75), S(-3)});
  CHECK(points[1].is_fresh);
  CHECK(points[2].impulse == std::array<S, 3>{S(2), S(0.25), S(-1)});
  CHECK(points[3].impulse == std::array<S, 3>{S(1), S(0), S(0)});
  // A normal on the other side of the jump of tangent_basis keeps friction as a vector.
  ContactManifolds<S> below = manifold<S>(0, {1});
  below[0].normal = {1, 0, S(1e-6)};
  ContactManifolds<S> above = below;
  above[0].normal = {1, 0, S(-1e-6)};
  const auto friction = [&]() -> Vec3<S> {
    Vec3<S> t1, t2;
    tangent_basis<S>(cache.manifolds()[0].normal, t1, t2);
    return cache.points()[0].impulse[1] * t1 + cache.points()[0].impulse[2] * t2;
  };
  cache.begin_step(1);
  add<S>(cache, {5, 6}, below);
  cache.points()[0].impulse = {S(1), S(0.5), S(0.25)};
  const Vec3<S> before = friction();
  cache.begin_step(1);
  add<S>(cache, {5, 6}, above);
  CHECK((friction() - before).norm() < S(1e-5));
}

TEST_CASE_TEMPLATE("ContactCache: an arm goes on changing as in the last step, however long", S,
                   float, double) {
  const auto offset_after = [](S first, S second, S way) {
    ContactCache<S> cache;
    cache.begin_step(first);
    ContactManifolds<S> found = manifold<S>(0, {1});
    found[0].points[0].position = {S(3), 0, 0};
    add<S>(cache, {0, 1}, found);
    cache.begin_step(second);
    found[0].points[0].position = {S(3), way, 0};
    add<S>(cache, {0, 1}, found);
    cache.find_mid_offsets(cache.points()[0]);
    return Vec3<S>(cache.points()[0].mid_offset_a);
  };
  CHECK(offset_after(S(0.5), S(0.5), S(0.25)) == Vec3<S>(0, S(0.125), 0));
  CHECK(offset_after(S(0.25), S(0.5), S(0.25)) == Vec3<S>(0, S(0.25), 0));
  // More than its length no turn can tell, be the ratio of the steps infinite.
  constexpr S largest = largest_number<S>;
  CHECK(offset_after(S(0.001), S(1), S(0.25)) == Vec3<S>::Zero());
  CHECK(offset_after(S(1) / largest, largest, S(0.25)) == Vec3<S>::Zero());
  CHECK(offset_after(S(1) / largest, largest, S(0)) == Vec3<S>::Zero());
}
