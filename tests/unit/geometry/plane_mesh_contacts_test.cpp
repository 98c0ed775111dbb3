// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/contacts/plane_mesh_contacts.hpp>
#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/geometry/meshes/mesh_tree.hpp>
#include <bristle/geometry/meshes/terrain.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <support/random.hpp>
#include <support/relative.hpp>

using namespace bristle;
using namespace bristle::detail;
using bristle::test::Random;

namespace {

template <Scalar S>
constexpr S plane_tolerance = S(4) * Tolerance<S>::equal();

/// Contacts of a half-space with a mesh at X_PM.
template <Scalar S>
ContactManifolds<S> plane_contacts(const HalfSpace<S>& plane, const MeshTree<S>& tree,
                                   const Transform<S>& X_PM, S margin) {
  using P = Precise<S>;
  const MeshSurface<P, MeshTree<S>> surface(tree);
  ContactManifolds<S> out;
  ContactSink<S> sink(out);
  const Transform<P> X = X_PM.template cast<P>();
  sink.set_frame(X, false);
  collide_plane_mesh<S>(HalfSpace<P>{plane.normal.template cast<P>(), P(plane.offset)}, surface, X,
                        P(margin), sink);
  return out;
}

}  // namespace

TEST_CASE_TEMPLATE("plane and mesh: a mesh on a floor stands on corners that are far apart", S,
                   float, double) {
  const HalfSpace<S> floor{Vec3<S>::UnitZ(), S(0)};
  // A finely divided disk stands on its rim.
  const MeshTree<S> disk(cylinder_mesh<S>(Cylinder<S>{S(1), S(0.2)}, 64));
  const auto out =
      plane_contacts(floor, disk, {Quat<S>::Identity(), {S(3), S(0), S(0.19)}}, S(0.001));
  REQUIRE(out.size() == 1);
  REQUIRE(out[0].size == 8);
  int on_rim = 0;
  for (std::size_t i = 0; i < 8; ++i) {
    const Vec3<S> r = out[0].points[i].position - Vec3<S>(S(3), S(0), S(0));
    CHECK(std::abs(out[0].points[i].gap + S(0.01)) <= plane_tolerance<S>);
    on_rim += r.template head<2>().norm() > S(0.99) ? 1 : 0;
    for (std::size_t k = 0; k < i; ++k) {
      CHECK((out[0].points[i].position - out[0].points[k].position).norm() > S(0.3));
      CHECK(out[0].points[i].feature != out[0].points[k].feature);
    }
  }
  CHECK(on_rim >= 7);
  CHECK(
      plane_contacts(floor, disk, {Quat<S>::Identity(), {S(3), S(0), S(0.21)}}, S(0.001)).empty());
  // Tipped, the lowest corner is among them.
  const MeshTree<S> ball(sphere_mesh<S>(S(1), 8));
  Random random(83);
  for (int i = 0; i < 50; ++i) {
    const Transform<S> X_AB{random.rotation<S>(), {S(0), S(0), S(0.95)}};
    S lowest = infinity<S>;
    for (const Vec3<S>& v : ball.mesh().vertices) lowest = std::min(lowest, (X_AB * v).z());
    const auto rolled = plane_contacts(floor, ball, X_AB, S(0.02));
    REQUIRE(rolled.size() == 1);
    S gap = infinity<S>;
    for (std::size_t k = 0; k < rolled[0].size; ++k) {
      gap = std::min(gap, rolled[0].points[k].gap);
    }
    CHECK(std::abs(gap - lowest) <= plane_tolerance<S>);
  }
}

// Where a box of triangles is divided finely, it stands on its own corners.
TEST_CASE("plane and mesh: corners within a flat face or an edge are no contacts") {
  const MeshTree<double> slab(
      extruded_mesh<double>(grid_mesh<double>({2, 2}, {5, 5}), {0, 0, -0.1}));
  const HalfSpace<double> floor{Vec3<double>::UnitZ(), 0};
  const Quat<double> R(Eigen::AngleAxis<double>(0.3, Vec3<double>::UnitZ()));
  const auto found = plane_contacts(floor, slab, {R, {0, 0, 0.1 - 1e-3}}, 1e-3);
  REQUIRE(found.size() == 1);
  REQUIRE(found[0].size == 4);
  for (std::size_t k = 0; k < 4; ++k) {
    const Vec3<double> corner = found[0].points[k].position;
    CHECK(corner.head<2>().norm() == test::relative(std::sqrt(2.0)));
    CHECK(found[0].points[k].gap == test::relative(-1e-3).epsilon(1e-12));
  }
}
