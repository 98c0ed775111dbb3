// SPDX-License-Identifier: BSD-3-Clause
#include "support/ray_patches.hpp"
#include "support/relative.hpp"
#include "support/rounds.hpp"

#include <bristle/geometry/rays/bundle_mesh_rays.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

using namespace bristle;
using bristle::test::ray_mesh;
using test::PatchKind;

TEST_CASE_TEMPLATE("cast_rays_at_mesh: bundles answer as each ray alone does in double", S, float,
                   double) {
  const std::array<TriangleMesh<double>, 4> meshes{test::angle_mesh(), test::torus_mesh(24, 12),
                                                   test::bumpy_mesh(7), test::bumpy_mesh(30)};
  std::uint64_t seed = 1;
  test::Random random(1);
  for (const TriangleMesh<double>& shape : meshes) {
    for (const double scale : {0.01, 1.0, 100.0}) {
      const TriangleMesh<S> scaled = test::scaled_mesh<S>(shape, scale);
      const test::ReferenceMesh<S> reference(scaled);
      const RayMesh<S> mesh = ray_mesh(scaled);
      for (const PatchKind kind :
           {PatchKind::pad, PatchKind::convex, PatchKind::scattered, PatchKind::column}) {
        const std::size_t n = 20 + 130 * random.index(3);
        const auto patch = test::make_rays<S>(kind, n, scale, random);
        CAPTURE(shape.triangles.size());
        CAPTURE(scale);
        CAPTURE(int(kind));
        ++seed;
        // Sensors row by row, and as bundles have them: hits are written in other ways.
        for (const auto& ordered : {patch, test::in_bundle_order(patch)}) {
          CHECK(test::wrong_answers(
                    reference, ordered, scale, test::rounds(30), seed,
                    [&](const Transform<S>& X, const RayBatch<S>& rays, RayHits<S>& hits) {
                      cast_rays_at_mesh(mesh, X, rays, 7, hits);
                    }) == 0);
        }
      }
    }
  }
}

TEST_CASE_TEMPLATE("cast_rays_at_mesh: lengthened rays meet what rays of that length do", S, float,
                   double) {
  test::Random random(12);
  std::uint64_t seed = 1;
  for (const TriangleMesh<double>& shape : {test::angle_mesh(), test::bumpy_mesh(30)}) {
    const TriangleMesh<S> scaled = test::scaled_mesh<S>(shape, 1);
    const test::ReferenceMesh<S> reference(scaled);
    const RayMesh<S> mesh = ray_mesh(scaled);
    for (const PatchKind kind :
         {PatchKind::pad, PatchKind::convex, PatchKind::scattered, PatchKind::column}) {
      // Up to many times as long as they were.
      for (const S share : {S(0.3), S(0.99)}) {
        auto longer = test::make_rays<S>(kind, 300, 1, random);
        auto shorter = longer;
        const S extra = share * *std::min_element(longer.length.begin(), longer.length.end());
        for (std::size_t i = 0; i < longer.length.size(); ++i) {
          shorter.length[i] = longer.length[i] - extra;
          longer.length[i] = shorter.length[i] + extra;
        }
        const RayBundles<S> bundles(shorter.batch(nullptr));
        CAPTURE(shape.triangles.size());
        CAPTURE(int(kind));
        CAPTURE(share);
        CHECK(test::wrong_answers(reference, longer, 1, test::rounds(30), ++seed,
                                  [&](const Transform<S>& X, const RayBatch<S>&, RayHits<S>& hits) {
                                    cast_rays_at_mesh(mesh, X, shorter.batch(&bundles, extra), 7,
                                                      hits);
                                  }) == 0);
      }
    }
  }
}

TEST_CASE_TEMPLATE("cast_rays_at_mesh: no ray slips through edges and corners that rays aim at", S,
                   float, double) {
  // From inside a ball every ray has to come out, whatever it aims at; from outside, towards the
  // middle, every ray has to hit.
  const TriangleMesh<S> mesh = test::scaled_mesh<S>(test::bumpy_mesh(12), 1);
  const RayMesh<S> ball = ray_mesh(mesh);
  test::RayPatch<S> rays;
  const Vec3<double> toward(0, 0, 1);
  for (const auto& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3<double> corner = mesh.vertices[t[k]].template cast<double>();
      const Vec3<double> next = mesh.vertices[t[(k + 1) % 3]].template cast<double>();
      for (const Vec3<double>& target : {corner, Vec3<double>((corner + next) / 2)}) {
        // As parallel as sensors are, so that they go by bundles.
        if (target.normalized().dot(toward) < 0.9) continue;
        rays.add(target + 0.01 * toward, -toward, 0.03);
      }
    }
  }
  REQUIRE(rays.length.size() > 200);
  // As the mesh stands, and turned, so that corners are rounded on their way to the rays.
  const Transform<double> turned{.rotation = Quat<double>(0.6, 0.2, -0.5, 0.3).normalized(),
                                 .translation = {0.3, -0.2, 0.1}};
  for (const Transform<double>& X : {Transform<double>{}, turned}) {
    test::RayPatch<S> moved;
    for (std::size_t i = 0; i < rays.length.size(); ++i) {
      moved.add(X * rays.start[i].template cast<double>(),
                X.rotate(rays.direction[i].template cast<double>()), 0.03);
    }
    const RayBundles<S> bundles(moved.batch(nullptr));
    RayHits<S> hits;
    hits.reset(moved.length.size());
    cast_rays_at_mesh(ball, X.template cast<S>(), moved.batch(&bundles), 7, hits);
    std::size_t missed = 0;
    for (std::size_t i = 0; i < moved.length.size(); ++i) {
      missed += std::abs(hits.distance[i] - S(0.01)) < S(1e-5) ? 0u : 1u;
    }
    CHECK(missed == 0);
  }
}

TEST_CASE_TEMPLATE("cast_rays_at_mesh: longer by `extra_length`, and no nearer than what is known",
                   S, float, double) {
  test::Random random(4);
  const TriangleMesh<S> mesh = test::scaled_mesh<S>(test::bumpy_mesh(10), 1);
  const RayMesh<S> ball = ray_mesh(mesh);
  const auto rows = test::make_rays<S>(PatchKind::pad, 200, 1, random);
  for (const auto& patch : {rows, test::in_bundle_order(rows)}) {
    const RayBundles<S> bundles(patch.batch(nullptr));
    const Transform<S> X{.translation = {0, 0, S(0.057)}};
    const auto cast = [&](S extra) {
      RayHits<S> hits;
      hits.reset(patch.length.size());
      cast_rays_at_mesh(ball, X, patch.batch(&bundles, extra), 7, hits);
      return hits;
    };
    const RayHits<S> none = cast(S(0));
    const RayHits<S> all = cast(S(0.02));
    for (std::size_t i = 0; i < patch.length.size(); ++i) {
      CHECK(!none.is_hit(i));
      CHECK(all.distance[i] < S(0.025));
      CHECK(all.tag[i] == 7);
    }
    // The same shape once more is no nearer: the first tag stays. Farther away it is nowhere
    // nearer.
    RayHits<S> twice = all;
    cast_rays_at_mesh(ball, X, patch.batch(&bundles, S(0.02)), 8, twice);
    CHECK(twice.tag == all.tag);
    CHECK(twice.distance == all.distance);
    const Transform<S> farther{.translation = {0, 0, S(0.058)}};
    cast_rays_at_mesh(ball, farther, patch.batch(&bundles, S(0.02)), 9, twice);
    CHECK(twice.tag == all.tag);
    CHECK(twice.distance == all.distance);
  }
}

TEST_CASE_TEMPLATE("cast_rays_at_mesh: any slice of whole bundles is asked, and nothing else", S,
                   float, double) {
  // Large triangles, so that bundles are asked together; outside, and around the starts.
  test::Random random(7);
  const RayMesh<S> mesh = ray_mesh(test::scaled_mesh<S>(test::angle_mesh(), 1));
  const auto rows = test::make_rays<S>(PatchKind::pad, 256, 1, random);
  for (const auto& patch : {rows, test::in_bundle_order(rows)}) {
    const RayBundles<S> bundles(patch.batch(nullptr));
    for (const S height : {S(0.001), S(-0.01)}) {
      const Transform<S> X{.translation = {S(-0.01), S(-0.01), height + S(0.02)}};
      const auto cast = [&](RaySlice slice) {
        RayHits<S> hits;
        hits.reset(patch.length.size());
        RayBatch<S> rays = patch.batch(&bundles);
        rays.slice = slice;
        cast_rays_at_mesh(mesh, X, rays, 7, hits);
        return hits;
      };
      const RayHits<S> whole = cast({});
      CHECK(std::any_of(whole.distance.begin(), whole.distance.end(),
                        [](S d) { return d < infinity<S>; }));
      const auto size = static_cast<std::uint32_t>(RayBundles<S>::bundle_size);
      for (std::uint32_t first = 0; first < bundles.size(); first += size) {
        const RayHits<S> part = cast({first, first + size});
        for (std::uint32_t place = 0; place < bundles.size(); ++place) {
          const std::size_t i = bundles.ray_at(place);
          const bool is_asked = place >= first && place < first + size;
          CHECK(part.distance[i] == (is_asked ? whole.distance[i] : infinity<S>));
        }
      }
    }
  }
}

TEST_CASE_TEMPLATE("cast_rays_at_mesh: of two triangles met at one point the lower number counts",
                   S, float, double) {
  // Roofs upside down, each of two triangles that cross below a ray, one larger than the other. All
  // numbers are small multiples of a power of two, so that both are met at the same distance to the
  // last bit.
  constexpr std::uint32_t roofs = 64;
  const S unit = S(0x1p-10);
  test::Random random(4);
  std::vector<std::uint32_t> number(2 * roofs);
  for (std::uint32_t i = 0; i < number.size(); ++i) number[i] = i;
  for (std::size_t i = number.size(); i > 1; --i) std::swap(number[i - 1], number[random.index(i)]);
  TriangleMesh<S> mesh;
  mesh.triangles.resize(2 * roofs);
  Vec3Array<S> start, direction;
  start.resize(roofs);
  direction.resize(roofs);
  for (std::uint32_t k = 0; k < roofs; ++k) {
    const S y = S(16 * k);
    start.set(k, Vec3<S>(0, unit * y, 0));
    direction.set(k, Vec3<S>::UnitZ());
    for (const std::uint32_t side : {0u, 1u}) {
      // Seen from below, its front; it rises towards +x or -x.
      const S size = side == 0 ? S(2) : S(4);
      const S slope = side == 0 ? S(1) : S(-1);
      const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
      mesh.triangles[number[2 * k + side]] = {first, first + 1, first + 2};
      for (const auto& [dx, dy] : {std::pair{-2, -1}, {0, 2}, {2, -1}}) {
        const S x = size * S(dx);
        mesh.vertices.push_back(unit * Vec3<S>(x, y + size * S(dy), S(32) + slope * x));
      }
    }
  }
  const RayMesh<S> tree = ray_mesh(mesh);
  const std::vector<S> length(roofs, S(64) * unit);
  RayBatch<S> rays{start.x, start.y, start.z, direction.x, direction.y, direction.z, length, S(0)};
  const RayBundles<S> bundles(rays);
  rays.bundles = &bundles;
  RayHits<S> hits;
  hits.reset(roofs);
  cast_rays_at_mesh(tree, Transform<S>{}, rays, 7, hits);
  for (std::uint32_t k = 0; k < roofs; ++k) {
    CAPTURE(k);
    CHECK(hits.distance[k] == S(32) * unit);
    const bool is_first = number[2 * k] < number[2 * k + 1];
    CHECK(hits.normal.x[k] * (is_first ? S(1) : S(-1)) > S(0.7));
  }
}

TEST_CASE("RayBundles: every ray is in one bundle, within its boxes") {
  test::Random random(2);
  for (const std::size_t n : {1u, 15u, 16u, 17u, 64u, 65u, 100u, 1000u}) {
    for (const PatchKind kind : {PatchKind::pad, PatchKind::convex, PatchKind::scattered}) {
      const auto patch = test::make_rays<double>(kind, n, 1, random);
      const RayBatch<double> batch = patch.batch(nullptr);
      const RayBundles<double> bundles(batch);
      REQUIRE(bundles.size() == n);
      std::vector<int> times(n, 0);
      for (std::size_t place = 0; place < n; ++place) ++times[bundles.ray_at(place)];
      CHECK(times == std::vector<int>(n, 1));
      std::size_t in_undivided = 0;
      for (const RayBundle<double>& bundle : bundles.bundles()) {
        if (!bundle.is_divided()) {
          in_undivided += bundle.count;
          CHECK(bundle.count <= RayBundles<double>::bundle_size);
          CHECK(bundle.first % RayBundles<double>::block_size == 0);
        }
        const Aabb<double> box = bundle.box.inflated(1e-15);
        for (std::size_t place = bundle.first; place < bundle.first + bundle.count; ++place) {
          const Ray<double> ray = batch[bundles.ray_at(place)];
          const Vec3<double> start = bundle.axes * (ray.origin - bundle.center);
          const Vec3<double> end = start + ray.length * (bundle.axes * ray.direction);
          CHECK(box.contains(start));
          CHECK(box.contains(end));
          CHECK(start.z() <= bundle.highest_start + 1e-15);
          if (bundle.is_divided() || !bundle.is_narrow) continue;
          const Aabb<double> block = bundles.block_box(place).inflated(1e-15);
          CHECK(block.contains(start));
          CHECK(block.contains(end));
          const auto& lines = bundles.lines();
          CHECK(lines.start[place] == test::relative(start.z()));
          CHECK(std::abs(lines.x[place] + lines.slope_x[place] * end.z() - end.x()) < 1e-15);
          CHECK(std::abs(lines.y[place] + lines.slope_y[place] * end.z() - end.y()) < 1e-15);
          CHECK((end.z() - start.z()) * lines.stretch[place] == test::relative(ray.length));
        }
      }
      CHECK(in_undivided == n);
    }
  }
}

TEST_CASE("RayBundles: parts of a bundle with one frame have its frame") {
  test::Random random(5);
  const std::size_t most = RayBundles<double>::frame_size;
  for (const PatchKind kind : {PatchKind::pad, PatchKind::scattered}) {
    const RayBundles<double> bundles(test::make_rays<double>(kind, 1000, 1, random).batch(nullptr));
    for (std::size_t id = 0; id < bundles.bundles().size(); ++id) {
      const RayBundle<double>& whole = bundles.bundles()[id];
      if (!whole.is_divided()) continue;
      // All of a flat pad that are not too large; none where rays go anywhere.
      CHECK(whole.has_one_frame == (kind == PatchKind::pad && whole.count <= most));
      if (!whole.has_one_frame) continue;
      for (const std::size_t part : {id + 1, std::size_t(whole.second)}) {
        CHECK(bundles.bundles()[part].has_one_frame);
        CHECK(bundles.bundles()[part].axes == whole.axes);
        CHECK(bundles.bundles()[part].center == whole.center);
      }
    }
  }
}

TEST_CASE("RayBundles: blocks whose rays follow each other are known") {
  test::Random random(6);
  for (const std::size_t n : {15u, 16u, 40u, 300u}) {
    const auto rows = test::make_rays<double>(PatchKind::pad, n, 1, random);
    for (const bool is_ordered : {false, true}) {
      const auto patch = is_ordered ? test::in_bundle_order(rows) : rows;
      const RayBundles<double> bundles(patch.batch(nullptr));
      for (std::size_t place = 0; place < n; ++place) {
        const std::size_t first = place - place % RayBundles<double>::block_size;
        const bool is_full = first + RayBundles<double>::block_size <= n;
        bool follow = is_full;
        for (std::size_t k = 1; follow && k < RayBundles<double>::block_size; ++k) {
          follow = bundles.ray_at(first + k) == bundles.ray_at(first) + k;
        }
        CHECK(bundles.is_in_order(place) == follow);
        // Bundles leave rays that are in their order as they are.
        if (is_ordered) CHECK(follow == is_full);
      }
    }
  }
}

TEST_CASE("RayBundles: rays without a finite length are left to be asked alone") {
  test::Random random(3);
  auto patch = test::make_rays<double>(PatchKind::pad, 40, 1, random);
  patch.length[17] = infinity<double>;
  CHECK(RayBundles<double>(patch.batch(nullptr)).is_empty());
}
