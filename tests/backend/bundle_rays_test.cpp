// SPDX-License-Identifier: BSD-3-Clause
#include "support/ray_patches.hpp"

#include <bristle/geometry/analytic_backend.hpp>

#include <doctest/doctest.h>

#if defined(BRISTLE_WITH_FCL)
#include <bristle/geometry/fcl_backend.hpp>
#endif

using namespace bristle;
using test::PatchKind;

namespace {

/// How many answers of a backend's bundles about a mesh are wrong.
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

/// The largest difference between rays of a patch in bundles and one after the other, over all
/// primitives: there is none, since these do not go by bundles.
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
  const RayBundles<S> bundles(patch.batch(nullptr));
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
      Backend::cast_rays(collidable, X, patch.batch(&bundles), 3, together);
      Backend::cast_rays(collidable, X, patch.batch(nullptr), 3, alone);
      are_alike = are_alike && together.distance == alone.distance &&
                  together.normal.x == alone.normal.x && together.tag == alone.tag;
    }
  }
  return are_alike;
}

}  // namespace

TEST_CASE_TEMPLATE("bundles: answer as each ray alone does, over meshes of three sizes", S, float,
                   double) {
  check_meshes<S, AnalyticBackend>();
#if defined(BRISTLE_WITH_FCL)
  check_meshes<S, FclBackend>();
#endif
}

TEST_CASE_TEMPLATE("bundles: change nothing about primitives", S, float, double) {
  CHECK(are_primitives_alike<S, AnalyticBackend>());
#if defined(BRISTLE_WITH_FCL)
  CHECK(are_primitives_alike<S, FclBackend>());
#endif
}
