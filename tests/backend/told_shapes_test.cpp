/// @file
/// Tests of the shapes that backends tell: those that they were given.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/backends.hpp"

#include <bristle/geometry/meshes/drawn_mesh.hpp>
#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/geometry/shapes/quickhull.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

using namespace bristle;
using namespace bristle::detail;

namespace {

template <typename S>
std::vector<Shape<S>> shapes_of_all_kinds() {
  const std::vector<Vec3<S>> corners{
      {S(0), S(0), S(0)}, {S(1), S(0), S(0)}, {S(0), S(2), S(0)}, {S(0), S(0), S(3)}};
  return {Sphere<S>{S(0.3)},
          Box<S>{{S(1), S(2), S(3)}},
          Capsule<S>{S(0.2), S(0.7)},
          Cylinder<S>{S(0.2), S(0.7)},
          Cone<S>{S(0.2), S(0.7)},
          Ellipsoid<S>{{S(1), S(2), S(3)}},
          HalfSpace<S>{Vec3<S>::UnitY(), S(0.25)},
          convex_hull<S>(std::span<const Vec3<S>>(corners)),
          box_mesh<S>({S(1), S(2), S(3)})};
}

/// Largest distance [m] of a vertex of one mesh from the same of the other.
template <typename S>
S largest_difference(const TriangleMesh<S>& a, const TriangleMesh<S>& b) {
  REQUIRE(a.vertices.size() == b.vertices.size());
  S largest = S(0);
  for (std::size_t i = 0; i < a.vertices.size(); ++i) {
    largest = std::max(largest, (a.vertices[i] - b.vertices[i]).norm());
  }
  return largest;
}

}  // namespace

TEST_CASE_TEMPLATE("shape of a backend: is the one it was made from", Setup, BRISTLE_TEST_SETUPS) {
  using S = typename Setup::Scalar;
  using Backend = typename Setup::Backend;
  for (const Shape<S>& shape : shapes_of_all_kinds<S>()) {
    const Shape<S> told = Backend::shape(Backend::make(shape));
    CHECK(kind_of(told) == kind_of(shape));
    CHECK(largest_difference(drawn_mesh(told), drawn_mesh(shape)) <
          S(16) * Tolerance<S>::round_off());
  }
}
