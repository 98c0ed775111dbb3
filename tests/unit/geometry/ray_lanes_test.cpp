/// @file
/// Rays in lanes that are just long enough, and rays beside others. All other hits are compared in
/// tests/backend.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/backends/analytic_backend.hpp>
#include <bristle/geometry/rays/ray_shapes.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <support/random.hpp>
#include <utility>
#include <vector>

using namespace bristle;

using namespace bristle::detail;

namespace {

/// As many rays as there are lanes, all of them with the same ray.
template <typename S>
struct SameRays {
  SameRays(const Vec3<S>& origin, const Vec3<S>& direction)
      : x(lanes<S>, origin[0]),
        y(lanes<S>, origin[1]),
        z(lanes<S>, origin[2]),
        dx(lanes<S>, direction[0]),
        dy(lanes<S>, direction[1]),
        dz(lanes<S>, direction[2]) {}

  /// Where a shape is hit by rays of a length [m].
  [[nodiscard]] RayHit<S> hit(const Shape<S>& shape, S length) const {
    const std::vector<S> lengths(lanes<S>, length);
    RayHits<S> hits;
    hits.reset(lanes<S>);
    const auto made = AnalyticBackend::make<S>(shape);
    AnalyticBackend::cast_rays<S>(made, Transform<S>{}, {x, y, z, dx, dy, dz, lengths}, 0, hits);
    return {hits.distance[lanes<S> - 1], hits.normal[lanes<S> - 1]};
  }
  [[nodiscard]] S distance(const Shape<S>& shape, S length) const {
    return hit(shape, length).distance;
  }

  std::vector<S> x, y, z, dx, dy, dz;
};

}  // namespace

TEST_CASE_TEMPLATE("cast_rays: a hit at the very end of a ray is one, and behind it is none", S,
                   float, double) {
  test::Random random(5);
  const Shape<S> shapes[] = {Sphere<S>{S(0.03)}, Capsule<S>{S(0.02), S(0.05)},
                             Capsule<S>{S(0.01), S(10)}};
  int hits = 0;
  for (const Shape<S>& shape : shapes) {
    for (int i = 0; i < 3000; ++i) {
      // Near and far; head-on at the axis, where a ray has no length to spare, or past it.
      const S away = i % 3 == 0 ? S(0.001) : S(i % 3);
      const bool is_head_on = i % 2 == 0;
      Vec3<S> target = is_head_on ? Vec3<S>(Vec3<S>::Zero()) : random.in_cube(S(0.015));
      if (i % 5 == 0) target.z() += S(5);  // Off a ball; the side of the long capsule.
      Vec3<S> back = random.in_cube(S(1));
      if (is_head_on) back.z() = S(0);
      const Vec3<S> origin = target + (S(0.06) + away) * back.normalized();
      const Vec3<S> direction = (target - origin).normalized();
      const SameRays<S> rays(origin, direction);
      const S found = rays.distance(shape, S(100));
      if (!(found > S(0) && found < infinity<S>)) continue;
      ++hits;
      CHECK(rays.distance(shape, found) == found);
      CHECK(rays.distance(shape, found * (S(1) - S(1e-3))) == infinity<S>);
    }
  }
  CHECK(hits > 3000);
}

TEST_CASE_TEMPLATE(
    "cast_rays: a ray at a capsule meets the same alone, beside its like and any others", S, float,
    double) {
  test::Random random(6);
  const Capsule<S> capsule{S(0.02), S(0.05)};
  const auto made = AnalyticBackend::make<S>(Shape<S>{capsule});
  int hits = 0;
  for (int i = 0; i < 500; ++i) {
    // Beyond either end, along the side, from far away, all mixed; a few of them inside.
    std::vector<S> x, y, z, dx, dy, dz, lengths;
    const std::size_t count = lanes<S> + 1;  // One pack is full, the other is not.
    for (std::size_t k = 0; k < count; ++k) {
      const Vec3<S> middle(S(0), S(0), random.in_cube(S(0.06)).z());
      const S away = random.in_cube(S(1)).x() > S(0.8) ? S(1) : S(0.03);
      const Vec3<S> origin = middle + away * random.direction<S>();
      const Vec3<S> direction = (middle + random.in_cube(S(0.015)) - origin).normalized();
      for (auto [values, v] : {std::pair{&x, origin.x()},
                               {&y, origin.y()},
                               {&z, origin.z()},
                               {&dx, direction.x()},
                               {&dy, direction.y()},
                               {&dz, direction.z()},
                               {&lengths, S(1.5) * away}}) {
        values->push_back(v);
      }
    }
    RayHits<S> mixed;
    mixed.reset(count);
    std::fill(mixed.tag.begin(), mixed.tag.end(), 7u);
    AnalyticBackend::cast_rays<S>(made, Transform<S>{}, {x, y, z, dx, dy, dz, lengths}, 3, mixed);
    for (std::size_t k = 0; k < count; ++k) {
      const SameRays<S> alike({x[k], y[k], z[k]}, {dx[k], dy[k], dz[k]});
      const RayHit<S> same = alike.hit(Shape<S>{capsule}, lengths[k]);
      CHECK(same.distance == mixed.distance[k]);
      const bool is_hit = mixed.distance[k] < infinity<S>;
      CHECK(mixed.tag[k] == (is_hit ? 3u : 7u));
      if (!is_hit) continue;
      CHECK(same.normal == mixed.normal[k]);
      const RayHit<S> hit =
          ray_cast(capsule, Ray<S>{{x[k], y[k], z[k]}, {dx[k], dy[k], dz[k]}, lengths[k]});
      // Some ten roundings of coordinates up to 1 m move a ray across. Where it comes in at an
      // angle, and not along the surface, that is ten times as much along it.
      const S facing = -hit.normal.dot(Vec3<S>(dx[k], dy[k], dz[k]));
      if (!(facing > S(0.1))) continue;
      ++hits;
      const S allowed = S(100) * std::numeric_limits<S>::epsilon();
      CHECK(std::abs(hit.distance - mixed.distance[k]) <= allowed);
      CHECK((hit.normal - mixed.normal[k]).norm() <= allowed / capsule.radius);
    }
  }
  CHECK(hits > 250 * static_cast<int>(lanes<S>));
}

TEST_CASE_TEMPLATE("cast_rays: any range of rays or packets, and no other ray", S, float, double) {
  const auto made = AnalyticBackend::make<S>(Shape<S>{Sphere<S>{S(0.03)}});
  constexpr std::size_t most = 2 * packet_size + 1;
  for (std::size_t count = 0; count <= most; ++count) {
    // Arrays of exactly `count`, so that a sanitizer sees what lies behind them. Each ray goes down
    // to the ball from a height of its own, and the third beside it. The fifth was hit before.
    std::vector<S> x(count, S(0)), none(count, S(0)), z(count), down(count, S(-1));
    std::vector<S> lengths(count, S(99));
    for (std::size_t i = 0; i < count; ++i) z[i] = S(1) + S(i);
    if (count > 2) x[2] = S(1);
    const auto check = [&](RayBatch<S> rays, const auto& is_asked) {
      RayHits<S> hits;
      hits.reset(count);
      if (count > 4) hits.offer(4, {S(0.5), {S(1), S(0), S(0)}}, 3);
      AnalyticBackend::cast_rays<S>(made, Transform<S>{}, rays, 5, hits);
      for (std::size_t i = 0; i < count; ++i) {
        const bool is_hit = is_asked(i) && i != 2 && i != 4;
        CHECK(hits.tag[i] == (is_hit ? 5u : (i == 4 ? 3u : 0xffffffffu)));
        if (!is_hit) {
          CHECK(hits.distance[i] == (i == 4 ? S(0.5) : infinity<S>));
          continue;
        }
        // Three roundings of numbers up to 40; those of a normal are of numbers over 0.03.
        constexpr S rounding = S(120) * std::numeric_limits<S>::epsilon();
        CHECK(std::abs(hits.distance[i] - (z[i] - S(0.03))) <= rounding);
        CHECK((hits.normal[i] - Vec3<S>(0, 0, 1)).norm() <= rounding / S(0.03));
      }
    };
    RayBatch<S> rays{x, none, z, none, none, down, lengths};
    for (std::size_t first = 0; first < count; ++first) {
      for (std::size_t end = first; end <= count; end += packet_size / 2) {
        rays.range = {static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(end)};
        check(rays, [&](std::size_t i) { return i >= first && i < end; });
      }
    }
    rays.range = {};
    // Neighbours, and packets with one between them.
    for (const std::uint32_t skipped : {0u, 1u}) {
      DynamicArray<std::uint32_t> packets;
      for (const std::uint32_t packet : {0u, 1u, 2u}) {
        if (packet != skipped) packets.push_back(packet);
      }
      rays.near_packets = &packets;
      check(rays, [&](std::size_t i) { return i / packet_size != skipped; });
    }
  }
}
