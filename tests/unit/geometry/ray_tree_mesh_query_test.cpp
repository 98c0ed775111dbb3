// SPDX-License-Identifier: BSD-3-Clause
#include "support/ray_patches.hpp"
#include "support/relative.hpp"
#include "support/rounds.hpp"

#include <bristle/geometry/rays/ray_tree_mesh_query.hpp>
#include <bristle/sensors/ray_fan.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

using namespace bristle;

using namespace bristle::detail;
using bristle::test::ray_mesh;
using test::PatchKind;

TEST_CASE_TEMPLATE("cast_rays_at_mesh: nodes answer as each ray alone does in double", S, float,
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
        // Sensors row by row, and as nodes have them: hits are written in other ways.
        for (const auto& ordered : {patch, test::in_tree_order(patch)}) {
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
        const RayTree<S> ray_tree(shorter.batch(nullptr));
        CAPTURE(shape.triangles.size());
        CAPTURE(int(kind));
        CAPTURE(share);
        CHECK(test::wrong_answers(reference, longer, 1, test::rounds(30), ++seed,
                                  [&](const Transform<S>& X, const RayBatch<S>&, RayHits<S>& hits) {
                                    cast_rays_at_mesh(mesh, X, shorter.batch(&ray_tree, extra), 7,
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
        // As parallel as sensors are, so that they go by nodes.
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
    const RayTree<S> ray_tree(moved.batch(nullptr));
    RayHits<S> hits;
    hits.reset(moved.length.size());
    cast_rays_at_mesh(ball, X.template cast<S>(), moved.batch(&ray_tree), 7, hits);
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
  for (const auto& patch : {rows, test::in_tree_order(rows)}) {
    const RayTree<S> ray_tree(patch.batch(nullptr));
    const Transform<S> X{.translation = {0, 0, S(0.057)}};
    const auto cast = [&](S extra) {
      RayHits<S> hits;
      hits.reset(patch.length.size());
      cast_rays_at_mesh(ball, X, patch.batch(&ray_tree, extra), 7, hits);
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
    cast_rays_at_mesh(ball, X, patch.batch(&ray_tree, S(0.02)), 8, twice);
    CHECK(twice.tag == all.tag);
    CHECK(twice.distance == all.distance);
    const Transform<S> farther{.translation = {0, 0, S(0.058)}};
    cast_rays_at_mesh(ball, farther, patch.batch(&ray_tree, S(0.02)), 9, twice);
    CHECK(twice.tag == all.tag);
    CHECK(twice.distance == all.distance);
  }
}

TEST_CASE_TEMPLATE("cast_rays_at_mesh: any range of whole nodes is asked, and nothing else", S,
                   float, double) {
  // Large triangles, so that nodes are asked together; outside, and around the starts.
  test::Random random(7);
  const RayMesh<S> mesh = ray_mesh(test::scaled_mesh<S>(test::angle_mesh(), 1));
  const auto rows = test::make_rays<S>(PatchKind::pad, 256, 1, random);
  for (const auto& patch : {rows, test::in_tree_order(rows)}) {
    const RayTree<S> ray_tree(patch.batch(nullptr));
    for (const S height : {S(0.001), S(-0.01)}) {
      const Transform<S> X{.translation = {S(-0.01), S(-0.01), height + S(0.02)}};
      const auto cast = [&](RayRange range) {
        RayHits<S> hits;
        hits.reset(patch.length.size());
        RayBatch<S> rays = patch.batch(&ray_tree);
        rays.range = range;
        cast_rays_at_mesh(mesh, X, rays, 7, hits);
        return hits;
      };
      const RayHits<S> whole = cast({});
      CHECK(std::any_of(whole.distance.begin(), whole.distance.end(),
                        [](S d) { return d < infinity<S>; }));
      const auto size = static_cast<std::uint32_t>(RayTree<S>::leaf_size);
      for (std::uint32_t first = 0; first < ray_tree.size(); first += size) {
        const RayHits<S> part = cast({first, first + size});
        for (std::uint32_t place = 0; place < ray_tree.size(); ++place) {
          const std::size_t i = ray_tree.ray_at(place);
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
  const RayTree<S> ray_tree(rays);
  rays.ray_tree = &ray_tree;
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

TEST_CASE("RayTree: every ray is in one node, within its boxes") {
  test::Random random(2);
  for (const std::size_t n : {1u, 15u, 16u, 17u, 64u, 65u, 100u, 1000u}) {
    for (const PatchKind kind : {PatchKind::pad, PatchKind::convex, PatchKind::scattered}) {
      const auto patch = test::make_rays<double>(kind, n, 1, random);
      const RayBatch<double> batch = patch.batch(nullptr);
      const RayTree<double> ray_tree(batch);
      REQUIRE(ray_tree.size() == n);
      std::vector<int> times(n, 0);
      for (std::size_t place = 0; place < n; ++place) ++times[ray_tree.ray_at(place)];
      CHECK(times == std::vector<int>(n, 1));
      std::size_t in_undivided = 0;
      for (const RayTreeNode<double>& node : ray_tree.nodes()) {
        if (!node.is_divided()) {
          in_undivided += node.count;
          CHECK(node.count <= RayTree<double>::leaf_size);
          CHECK(node.first % packet_size == 0);
        }
        const Aabb<double> box = node.box.inflated(1e-15);
        for (std::size_t place = node.first; place < node.first + node.count; ++place) {
          const Ray<double> ray = batch[ray_tree.ray_at(place)];
          const Vec3<double> start = node.axes * (ray.origin - node.center);
          const Vec3<double> end = start + ray.length * (node.axes * ray.direction);
          CHECK(box.contains(start));
          CHECK(box.contains(end));
          CHECK(start.z() <= node.highest_start + 1e-15);
          if (node.is_divided() || !node.is_narrow) continue;
          const Aabb<double> block = ray_tree.packet_box(place).inflated(1e-15);
          CHECK(block.contains(start));
          CHECK(block.contains(end));
          const auto& lines = ray_tree.lines();
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

TEST_CASE("RayTree: rays of a fan are divided by direction, in whatever order they come") {
  RayFanDef<double> def;
  def.width = 2 * std::numbers::pi;
  def.height = 0.5;
  def.columns = 360;
  def.rows = 8;
  def.range = 10;
  const SensorLayout<double> fan = ray_fan(def);
  const RayBatch<double> rays = fan.rays();
  const RayTree<double> tree(rays);
  for (const RayTreeNode<double>& node : tree.nodes()) {
    if (node.is_divided()) continue;
    // 64 of 2880 rays that divide a band of 2 pi x 0.5 rad evenly, in pieces at most four times as
    // long as wide: sqrt(4 pi 64 / 2880) rad. Pieces of single rows would be 1.1 rad long.
    Vec3<double> mean = Vec3<double>::Zero();
    for (std::size_t k = node.first; k < node.first + node.count; ++k) {
      mean += rays[tree.ray_at(k)].direction;
    }
    mean.normalize();
    for (std::size_t k = node.first; k < node.first + node.count; ++k) {
      CHECK(std::acos(mean.dot(rays[tree.ray_at(k)].direction)) < 0.53 / 2);
    }
  }
}

TEST_CASE("RayTree: parts of a node with one frame have its frame") {
  test::Random random(5);
  const std::size_t most = RayTree<double>::frame_size;
  for (const PatchKind kind : {PatchKind::pad, PatchKind::scattered}) {
    const RayTree<double> ray_tree(test::make_rays<double>(kind, 1000, 1, random).batch(nullptr));
    for (std::size_t id = 0; id < ray_tree.nodes().size(); ++id) {
      const RayTreeNode<double>& whole = ray_tree.nodes()[id];
      if (!whole.is_divided()) continue;
      // All of a flat pad that are not too large; none where rays go anywhere.
      CHECK(whole.has_one_frame == (kind == PatchKind::pad && whole.count <= most));
      if (!whole.has_one_frame) continue;
      for (const std::size_t part : {id + 1, std::size_t(whole.second)}) {
        CHECK(ray_tree.nodes()[part].has_one_frame);
        CHECK(ray_tree.nodes()[part].axes == whole.axes);
        CHECK(ray_tree.nodes()[part].center == whole.center);
      }
    }
  }
}

TEST_CASE("RayTree: blocks whose rays follow each other are known") {
  test::Random random(6);
  for (const std::size_t n : {15u, 16u, 40u, 300u}) {
    const auto rows = test::make_rays<double>(PatchKind::pad, n, 1, random);
    for (const bool is_ordered : {false, true}) {
      const auto patch = is_ordered ? test::in_tree_order(rows) : rows;
      const RayTree<double> ray_tree(patch.batch(nullptr));
      for (std::size_t place = 0; place < n; ++place) {
        const std::size_t first = place - place % packet_size;
        const bool is_full = first + packet_size <= n;
        bool follow = is_full;
        for (std::size_t k = 1; follow && k < packet_size; ++k) {
          follow = ray_tree.ray_at(first + k) == ray_tree.ray_at(first) + k;
        }
        CHECK(ray_tree.is_in_order(place) == follow);
        // Nodes leave rays that are in their order as they are.
        if (is_ordered) CHECK(follow == is_full);
      }
    }
  }
}

TEST_CASE("RayTree: rays without a finite length are left to be asked alone") {
  test::Random random(3);
  auto patch = test::make_rays<double>(PatchKind::pad, 40, 1, random);
  patch.length[17] = infinity<double>;
  CHECK(RayTree<double>(patch.batch(nullptr)).is_empty());
}
