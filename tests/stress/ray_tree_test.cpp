// SPDX-License-Identifier: BSD-3-Clause
#include "support/ray_patches.hpp"

#include <bristle/geometry/backends/analytic_backend.hpp>

#include <doctest/doctest.h>

using namespace bristle;

TEST_CASE_TEMPLATE("nodes: a million rays a shape, and none wrong", S, float, double) {
  const TriangleMesh<double> shapes[] = {test::angle_mesh(), test::torus_mesh(48, 24),
                                         test::bumpy_mesh(22)};
  std::uint64_t seed = 100;
  for (const TriangleMesh<double>& shape : shapes) {
    std::size_t bad = 0;
    for (const double scale : {0.01, 1.0, 100.0}) {
      const TriangleMesh<S> mesh = test::scaled_mesh<S>(shape, scale);
      const test::ReferenceMesh<S> reference(mesh);
      const auto collidable = AnalyticBackend::make<S>(Shape<S>(mesh));
      test::Random random(++seed);
      for (const test::PatchKind kind :
           {test::PatchKind::pad, test::PatchKind::convex, test::PatchKind::scattered}) {
        for (const std::size_t n : {100u, 1000u}) {
          const auto patch = test::make_rays<S>(kind, n, scale, random);
          bad += test::wrong_answers(
              reference, patch, scale, static_cast<int>(60000 / n), ++seed,
              [&](const Transform<S>& X, const RayBatch<S>& rays, RayHits<S>& hits) {
                AnalyticBackend::cast_rays(collidable, X, rays, 0, hits);
              });
        }
      }
    }
    CAPTURE(shape.triangles.size());
    CHECK(bad == 0);
  }
}
