// SPDX-License-Identifier: BSD-3-Clause
#include "support/texts.hpp"

#include <bristle/geometry/shapes/convex_hull.hpp>

#include <doctest/doctest.h>

#include <limits>
#include <string>

using namespace bristle;
using bristle::test::contains;
using bristle::test::error_of;

namespace {

/// Corners at the origin and at 1 on each axis.
template <typename S>
ConvexHull<S> tetrahedron() {
  const S third = S(1) / std::sqrt(S(3));
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
          {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3},
          {0, 3, 6, 9, 12},
          {{0, 0, -1}, {0, -1, 0}, {-1, 0, 0}, {third, third, third}},
          {0, 0, 0, third}};
}

template <typename S>
std::string validity_error(const ConvexHull<S>& hull) {
  return error_of([&] { hull.validate(); });
}
template <typename S, typename Change>
std::string error_after(Change&& change) {
  ConvexHull<S> hull = tetrahedron<S>();
  change(hull);
  return validity_error(hull);
}

}  // namespace

TEST_CASE_TEMPLATE("ConvexHull: a tetrahedron is valid and lists its faces", S, float, double) {
  const ConvexHull<S> hull = tetrahedron<S>();
  CHECK(validity_error(hull) == "");
  REQUIRE(hull.face_count() == 4);
  REQUIRE(hull.face(2).size() == 3);
  CHECK(hull.face(2)[1] == 3);
  for (const S scale : {S(1e-6), S(1e6)}) {
    ConvexHull<S> copy = hull;
    for (auto& v : copy.vertices) v *= scale;
    for (auto& offset : copy.face_offsets) offset *= scale;
    CHECK(validity_error(copy) == "");
  }
}

TEST_CASE_TEMPLATE("ConvexHull::validate: refuses what is no closed convex solid", S, float,
                   double) {
  using Hull = ConvexHull<S>;
  const S nan = std::numeric_limits<S>::quiet_NaN();
  CHECK(contains(validity_error(Hull{}), "vertices.size() = 0"));
  CHECK(contains(error_after<S>([](Hull& h) { h.face_normals.pop_back(); }), "face_normals"));
  CHECK(contains(error_after<S>([](Hull& h) { h.face_offsets.pop_back(); }), "face_offsets"));
  CHECK(contains(error_after<S>([](Hull& h) { h.face_starts.pop_back(); }), "face_starts"));
  CHECK(contains(error_after<S>([](Hull& h) { h.face_starts[0] = 1; }), "face_starts[0]"));
  CHECK(contains(error_after<S>([](Hull& h) { h.face_starts[1] = 100; }), "face 0"));
  CHECK(contains(error_after<S>([](Hull& h) { h.face_starts[1] = 2; }), "at least 3 corners"));
  CHECK(contains(error_after<S>([](Hull& h) { h.face_vertices.pop_back(); }), "face_vertices"));
  CHECK(contains(error_after<S>([](Hull& h) { h.face_vertices[4] = 4; }), "existing vertex"));
  CHECK(contains(error_after<S>([](Hull& h) {
                   h.vertices.push_back({0, 0, 0});
                 }),
                 "corner of a face"));
  CHECK(contains(error_after<S>([nan](Hull& h) { h.vertices[2].x() = nan; }), "finite"));
  CHECK(contains(error_after<S>([nan](Hull& h) { h.face_normals[2].x() = nan; }), "finite"));
  CHECK(contains(error_after<S>([nan](Hull& h) { h.face_offsets[2] = nan; }), "finite"));
  CHECK(contains(error_after<S>([](Hull& h) { std::swap(h.face_vertices[0], h.face_vertices[1]); }),
                 "opposite directions"));
  CHECK(contains(error_after<S>([](Hull& h) { h.face_normals[0] *= S(2); }), "length 1"));
  CHECK(contains(error_after<S>([](Hull& h) { h.face_offsets[0] = S(0.1); }), "in its plane"));
  CHECK(contains(error_after<S>([](Hull& h) { h.face_normals[0] *= S(-1); }), "not convex"));
  // A corner pushed through the opposite face.
  CHECK(error_after<S>([](Hull& h) { h.vertices[0] = {1, 1, 1}; }) != "");
}
