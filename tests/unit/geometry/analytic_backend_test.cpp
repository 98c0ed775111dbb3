// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/analytic_backend.hpp>
#include <bristle/geometry/mesh_shapes.hpp>

#include <doctest/doctest.h>

using namespace bristle;

// What a backend has to do is tested by tests/backend/conformance.hpp; here is what only this one
// says.

TEST_CASE("AnalyticBackend: knows the pairs that have a formula, in either order") {
  using enum ShapeKind;
  const auto can = [](ShapeKind a, ShapeKind b) {
    CHECK(AnalyticBackend::can_collide(a, b) == AnalyticBackend::can_collide(b, a));
    return AnalyticBackend::can_collide(a, b);
  };
  for (const ShapeKind kind :
       {sphere, box, capsule, cylinder, cone, ellipsoid, convex_hull, triangle_mesh}) {
    CHECK(can(kind, half_space));
  }
  CHECK(can(sphere, sphere));
  CHECK(can(sphere, box));
  CHECK(can(sphere, capsule));
  CHECK(can(capsule, capsule));
  CHECK(can(box, box));
  CHECK(!can(half_space, half_space));
  CHECK(!can(box, capsule));
  CHECK(!can(triangle_mesh, triangle_mesh));
  CHECK(!can(cylinder, box));
  static_assert(AnalyticBackend::can_collide(sphere, sphere));
}

TEST_CASE_TEMPLATE("AnalyticBackend: a pair without a formula fails and adds nothing", S, float,
                   double) {
  const auto box = AnalyticBackend::make<S>(Box<S>{Vec3<S>::Ones()});
  const auto capsule = AnalyticBackend::make<S>(Capsule<S>{S(1), S(1)});
  ContactManifolds<S> out;
  CHECK(AnalyticBackend::collide(box, capsule, Transform<S>{}, S(0), out) == ContactStatus::failed);
  CHECK(out.empty());
}

TEST_CASE_TEMPLATE("AnalyticBackend: a prepared mesh is shared by its copies", S, float, double) {
  const auto mesh = AnalyticBackend::make<S>(box_mesh<S>(Vec3<S>::Ones()));
  const auto copy = mesh;
  CHECK(copy.get() == mesh.get());
  CHECK(AnalyticBackend::kind(copy) == ShapeKind::triangle_mesh);
}
