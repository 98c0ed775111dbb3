// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"
#include "support/relative.hpp"

#include <bristle/geometry/backends/analytic_backend.hpp>
#include <bristle/geometry/meshes/mesh_shapes.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <limits>

using namespace bristle;
using namespace bristle::detail;

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

// In float every eighth had a third contact, halfway between an end and a corner of the box.
TEST_CASE_TEMPLATE("analytic backend: a capsule that lies on a box has contacts at its ends alone",
                   S, float, double) {
  const auto box = AnalyticBackend::make<S>(Box<S>{.half_extents = {1, 1, S(0.05)}});
  const auto capsule =
      AnalyticBackend::make<S>(Capsule<S>{.radius = S(0.1), .half_length = S(0.4)});
  test::Random random(5);
  for (int i = 0; i < 500; ++i) {
    CAPTURE(i);
    const Quat<S> lie = exp_rotation<S>({S(0), S(1.5707963267948966), S(0)});
    const Transform<S> X{
        .rotation = exp_rotation<S>({S(0), S(0), random.uniform(S(-3), S(3))}) * lie,
        .translation = {random.uniform(S(-0.5), S(0.5)), random.uniform(S(-0.5), S(0.5)),
                        S(0.15) - S(0.001)}};
    ContactManifolds<S> found;
    REQUIRE(AnalyticBackend::collide(box, capsule, X, S(0.005), found) == ContactStatus::ok);
    REQUIRE(found.size() == 1);
    REQUIRE(found[0].size == 2);
    for (const S end : {S(-0.4), S(0.4)}) {
      const Vec3<S> middle = X * Vec3<S>(0, 0, end);
      const S nearest = std::min((found[0].points[0].position - middle).norm(),
                                 (found[0].points[1].position - middle).norm());
      CHECK(nearest == test::relative(0.1 - 0.0005).epsilon(1e-3));
    }
  }
}
