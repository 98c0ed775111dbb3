// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/backends/analytic_backend.hpp>
#include <bristle/geometry/meshes/mesh_shapes.hpp>

#include <doctest/doctest.h>

#include <cstddef>
#include <limits>

using namespace bristle;

// Requirements on every backend are tested by tests/backend/conformance.hpp; these tests are for
// this backend only.

TEST_CASE("AnalyticBackend: knows all pairs but two half-spaces") {
  for (std::size_t a = 0; a < shape_kind_count; ++a) {
    for (std::size_t b = 0; b < shape_kind_count; ++b) {
      const auto kind_a = static_cast<ShapeKind>(a);
      const auto kind_b = static_cast<ShapeKind>(b);
      const bool is_known = kind_a != ShapeKind::half_space || kind_b != ShapeKind::half_space;
      CHECK(AnalyticBackend::can_collide(kind_a, kind_b) == is_known);
    }
  }
  static_assert(AnalyticBackend::can_collide(ShapeKind::cone, ShapeKind::triangle_mesh));
}

TEST_CASE_TEMPLATE("AnalyticBackend: what it does not know fails and adds nothing", S, float,
                   double) {
  const auto plane = AnalyticBackend::make<S>(HalfSpace<S>{});
  const auto cone = AnalyticBackend::make<S>(Cone<S>{S(1), S(1)});
  ContactManifolds<S> out;
  CHECK(AnalyticBackend::collide(plane, plane, Transform<S>{}, S(0), out) == ContactStatus::failed);
  Transform<S> nowhere;
  nowhere.translation.x() = std::numeric_limits<S>::quiet_NaN();
  CHECK(AnalyticBackend::collide(cone, cone, nowhere, S(0), out) == ContactStatus::failed);
  CHECK(out.empty());
}

TEST_CASE_TEMPLATE("AnalyticBackend: a prepared mesh is shared by its copies", S, float, double) {
  const auto mesh = AnalyticBackend::make<S>(box_mesh<S>(Vec3<S>::Ones()));
  const auto copy = mesh;
  CHECK(copy.get() == mesh.get());
  CHECK(AnalyticBackend::kind(copy) == ShapeKind::triangle_mesh);
}
