// SPDX-License-Identifier: BSD-3-Clause
#include "support/ray_patches.hpp"

#include <bristle/geometry/backends/analytic_backend.hpp>

#include <doctest/doctest.h>

#if defined(BRISTLE_WITH_FCL)
#include <bristle/geometry/backends/fcl_backend.hpp>
#endif

using namespace bristle;

using namespace bristle::detail;
using test::PatchKind;

namespace {

/// How many answers of a backend's nodes about a mesh are wrong.
template <Scalar S, typename Backend>
std::size_t wrong_by(const TriangleMesh<double>& shape, double scale, std::uint64_t seed) {
  const TriangleMesh<S> mesh = test::scaled_mesh<S>(shape, scale);
  const auto collidable = Backend::template make<S>(Shape<S>(mesh));
  test::Random random(seed);
  std::size_t wrong = 0;
  for (const PatchKind kind : {PatchKind::pad, PatchKind::convex, PatchKind::scattered}) {
    const auto patch = test::make_rays<S>(kind, 150, scale, random);
    wrong +=
        test::wrong_answers(test::ReferenceMesh<S>(mesh), patch, scale, 20, ++seed,
                            [&](const Transform<S>& X, const RayBatch<S>& rays, RayHits<S>& hits) {
                              Backend::cast_rays(collidable, X, rays, 3, hits);
                            });
  }
  return wrong;
}

template <Scalar S, typename Backend>
void check_meshes() {
  for (const double scale : {0.01, 1.0, 100.0}) {
    CAPTURE(scale);
    CHECK(wrong_by<S, Backend>(test::angle_mesh(), scale, 1) == 0);
    CHECK(wrong_by<S, Backend>(test::torus_mesh(30, 16), scale, 2) == 0);
    CHECK(wrong_by<S, Backend>(test::bumpy_mesh(16), scale, 3) == 0);
  }
}

/// The largest difference between rays of a patch in nodes and one after the other, over all
/// primitives: there is none, since these do not go by nodes.
template <Scalar S, typename Backend>
bool are_primitives_alike() {
  const Shape<S> shapes[] = {Sphere<S>{S(0.03)},
                             Box<S>{{S(0.02), S(0.03), S(0.04)}},
                             Capsule<S>{S(0.02), S(0.02)},
                             Cylinder<S>{S(0.02), S(0.03)},
                             Cone<S>{S(0.03), S(0.02)},
                             Ellipsoid<S>{{S(0.02), S(0.03), S(0.04)}},
                             HalfSpace<S>{Vec3<S>(0, 0, 1), S(0.001)}};
  test::Random random(9);
  const auto patch = test::make_rays<S>(PatchKind::convex, 100, 1, random);
  const RayTree<S> ray_tree(patch.batch(nullptr));
  bool are_alike = true;
  for (const Shape<S>& shape : shapes) {
    const auto collidable = Backend::template make<S>(shape);
    // About as large as all of them.
    test::Wanderer wanderer(1, 5, {Vec3<double>(0.02, 0, 0), Vec3<double>(0, 0, -0.03)});
    for (int step = 0; step < 40; ++step, wanderer.step()) {
      const Transform<S> X = wanderer.pose().template cast<S>();
      RayHits<S> together;
      RayHits<S> alone;
      together.reset(100);
      alone.reset(100);
      Backend::cast_rays(collidable, X, patch.batch(&ray_tree), 3, together);
      Backend::cast_rays(collidable, X, patch.batch(nullptr), 3, alone);
      are_alike = are_alike && together.distance == alone.distance &&
                  together.normal.x == alone.normal.x && together.tag == alone.tag;
    }
  }
  return are_alike;
}

/// Returns whether the ranges of a patch, cast one by one in order or from the last to the first,
/// give the same bits as all its rays together; for some poses of a shape.
template <Scalar S, typename Backend>
bool are_ranges_alike(const Shape<S>& shape, PatchKind kind) {
  test::Random random(3);
  constexpr std::size_t n = 5000;
  const auto patch = test::make_rays<S>(kind, n, 1, random);
  const RayTree<S> ray_tree(patch.batch(nullptr));
  const auto collidable = Backend::template make<S>(shape);
  test::Wanderer wanderer(1, 11,
                          {Vec3<double>(0.03, 0, 0), Vec3<double>(0, 0.05, 0),
                           Vec3<double>(0.04, 0, 0.015), Vec3<double>(0, 0, -0.05)});
  bool are_alike = true;
  std::size_t hits = 0;
  for (int step = 0; step < 30; ++step, wanderer.step()) {
    const Transform<S> X = wanderer.pose().template cast<S>();
    RayBatch<S> rays = patch.batch(&ray_tree, S(1e-4));
    RayHits<S> whole;
    whole.reset(n);
    Backend::cast_rays(collidable, X, rays, 3, whole);
    DynamicArray<RayRange> ranges = ray_tree.ranges();
    for (int order = 0; order < 2; ++order) {
      RayHits<S> in_ranges;
      in_ranges.reset(n);
      for (const RayRange& range : ranges) {
        rays.range = range;
        Backend::cast_rays(collidable, X, rays, 3, in_ranges);
      }
      are_alike = are_alike && whole.distance == in_ranges.distance && whole.tag == in_ranges.tag &&
                  whole.normal.x == in_ranges.normal.x && whole.normal.y == in_ranges.normal.y &&
                  whole.normal.z == in_ranges.normal.z;
      std::reverse(ranges.begin(), ranges.end());
    }
    for (std::size_t i = 0; i < n; ++i) hits += whole.is_hit(i) ? 1u : 0u;
  }
  CHECK(hits > 0);
  return are_alike;
}

/// Returns whether ranges of a patch in neighbour order leave the hits of all other rays alone,
/// which other threads own; for some poses of a shape.
template <Scalar S, typename Backend>
bool do_ranges_keep_apart(const Shape<S>& shape, PatchKind kind) {
  test::Random random(4);
  constexpr std::size_t n = 2000;
  const auto patch = test::in_tree_order(test::make_rays<S>(kind, n, 1, random));
  const RayTree<S> ray_tree(patch.batch(nullptr));
  REQUIRE(ray_tree.has_packets_in_ranges());
  REQUIRE(ray_tree.ranges().size() > 1);
  const auto collidable = Backend::template make<S>(shape);
  test::Wanderer wanderer(1, 11, {Vec3<double>(0.03, 0, 0), Vec3<double>(0, 0, -0.05)});
  RayBatch<S> rays = patch.batch(&ray_tree, S(1e-4));
  bool are_apart = true;
  std::size_t hits = 0;
  for (int step = 0; step < 20; ++step, wanderer.step()) {
    for (const RayRange& range : ray_tree.ranges()) {
      RayHits<S> found;
      found.reset(n);
      // Anything that is offered to the others is nearer than this.
      for (std::size_t i = 0; i < n; ++i) {
        if (i < range.first || i >= range.end) found.distance[i] = S(1e6);
      }
      rays.range = range;
      Backend::cast_rays(collidable, wanderer.pose().template cast<S>(), rays, 3, found);
      for (std::size_t i = 0; i < n; ++i) {
        const bool is_own = i >= range.first && i < range.end;
        are_apart = are_apart && (is_own || found.distance[i] == S(1e6));
        hits += is_own && found.is_hit(i) ? 1u : 0u;
      }
    }
  }
  CHECK(hits > 0);
  return are_apart;
}

template <Scalar S, typename Backend>
void check_ranges() {
  static_assert(asks_ranges<Backend>);
  const Shape<S> shapes[] = {Sphere<S>{S(0.03)}, Box<S>{{S(0.02), S(0.03), S(0.04)}},
                             test::scaled_mesh<S>(test::bumpy_mesh(16), 1),
                             test::scaled_mesh<S>(test::torus_mesh(30, 16), 1),
                             test::scaled_mesh<S>(test::bumpy_mesh(60), 1)};
  for (const Shape<S>& shape : shapes) {
    CAPTURE(shape.index());
    for (const PatchKind kind : {PatchKind::pad, PatchKind::convex, PatchKind::scattered}) {
      CHECK(are_ranges_alike<S, Backend>(shape, kind));
      CHECK(do_ranges_keep_apart<S, Backend>(shape, kind));
    }
  }
}

/// How often `is_clear` of a backend said of patches near a mesh and within it that they meet
/// nothing, how often it was right, and how often there was nothing to be met.
struct Clearances {
  int said = 0;
  int right = 0;
  int all = 0;
};

template <Scalar S, typename Backend>
Clearances clearances(const TriangleMesh<double>& mesh, PatchKind kind, double scale) {
  test::Random random(5);
  constexpr std::size_t n = 700;
  const auto patch = test::make_rays<S>(kind, n, scale, random);
  const RayTree<S> ray_tree(patch.batch(nullptr));
  const auto collidable = Backend::template make<S>(Shape<S>(test::scaled_mesh<S>(mesh, scale)));
  Clearances result;
  for (int k = 0; k < 100; ++k) {
    // Up to 6 cm from middle to middle: deep in the solid, across its surface, and beside it.
    Transform<double> X;
    X.translation = random.in_cube(0.06 * scale);
    X.rotation = random.rotation<double>();
    const RayBatch<S> rays = patch.batch(&ray_tree, S(1e-4 * scale));
    RayHits<S> hits;
    hits.reset(n);
    const Transform<S> X_RC = X.template cast<S>();
    Backend::cast_rays(collidable, X_RC, rays, 3, hits);
    bool is_any_hit = false;
    for (std::size_t i = 0; i < n; ++i) is_any_hit = is_any_hit || hits.is_hit(i);
    const bool is_clear = Backend::is_clear(collidable, X_RC, rays);
    result.said += is_clear ? 1 : 0;
    result.right += is_clear && !is_any_hit ? 1 : 0;
    result.all += is_any_hit ? 0 : 1;
    CHECK_FALSE(Backend::is_clear(collidable, X_RC, patch.batch(nullptr)));
  }
  return result;
}

/// A patch is said to be clear only where it is, and mostly where it is.
template <Scalar S, typename Backend>
void check_clearances() {
  for (const TriangleMesh<double>& mesh :
       {test::angle_mesh(), test::torus_mesh(30, 16), test::bumpy_mesh(16)}) {
    for (const PatchKind kind : {PatchKind::pad, PatchKind::convex, PatchKind::scattered}) {
      for (const double scale : {0.01, 1.0, 100.0}) {
        const Clearances found = clearances<S, Backend>(mesh, kind, scale);
        CAPTURE(scale);
        CHECK(found.said == found.right);
        CHECK(found.all > 5);
        // Rays that stand in all directions have boxes as large as the mesh.
        if (kind != PatchKind::scattered) CHECK(found.said > found.all * 8 / 10);
      }
    }
  }
}

}  // namespace

TEST_CASE_TEMPLATE("nodes: a look at boxes tells what is clear of a mesh", S, float, double) {
  check_clearances<S, AnalyticBackend>();
#if defined(BRISTLE_WITH_FCL)
  check_clearances<S, FclBackend>();
#endif
}

TEST_CASE_TEMPLATE("nodes: answer as each ray alone does, over meshes of three sizes", S, float,
                   double) {
  check_meshes<S, AnalyticBackend>();
#if defined(BRISTLE_WITH_FCL)
  check_meshes<S, FclBackend>();
#endif
}

TEST_CASE_TEMPLATE("nodes: change nothing about primitives", S, float, double) {
  CHECK(are_primitives_alike<S, AnalyticBackend>());
#if defined(BRISTLE_WITH_FCL)
  CHECK(are_primitives_alike<S, FclBackend>());
#endif
}

TEST_CASE_TEMPLATE("nodes: ranges give the bits of the whole", S, float, double) {
  test::Random random(3);
  for (const std::size_t n : {1u, 64u, 1024u, 1025u, 5000u, 10000u}) {
    const RayTree<S> ray_tree(test::make_rays<S>(PatchKind::pad, n, 1, random).batch(nullptr));
    std::uint32_t end = 0;
    for (const RayRange& range : ray_tree.ranges()) {
      CHECK(range.first == end);
      CHECK(range.first % RayTree<S>::leaf_size == 0);
      end = range.end;
      CHECK((range.first < end && end <= range.first + RayTree<S>::range_size));
    }
    CHECK(end == n);
    CHECK(ray_tree.ranges().size() >= n / RayTree<S>::range_size);
  }
  check_ranges<S, AnalyticBackend>();
#if defined(BRISTLE_WITH_FCL)
  check_ranges<S, FclBackend>();
#endif
}
