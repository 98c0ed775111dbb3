/// @file
/// Contacts of meshes that are not convex, cost of contacts of two meshes, and contacts of meshes
/// that passed through each other.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/rigid/tumbling.hpp"
#include "support/frame_mesh.hpp"
#include "support/random.hpp"
#include "support/relative.hpp"

#include <bristle/geometry/contacts/mesh_contacts.hpp>
#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/geometry/meshes/mesh_tree.hpp>
#include <bristle/geometry/meshes/mesh_validation.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>

using namespace bristle;

using namespace bristle::detail;

namespace {

/// The library's distance of convex cores, counted.
struct CountedDistance {
  static inline std::uint64_t count = 0;

  template <Scalar S>
  [[nodiscard]] GjkResult<S> operator()(const PlacedConvex<S>& a, const PlacedConvex<S>& b,
                                        const Vec3<S>& towards, S far) const {
    ++count;
    return GjkDistance{}(a, b, towards, far);
  }
};

/// [m] Distance of the point of all manifolds that is nearest, or deepest.
double least_gap(const ContactManifolds<double>& contacts) {
  double least = infinity<double>;
  for (const ContactManifold<double>& manifold : contacts) {
    for (std::size_t k = 0; k < manifold.size; ++k) {
      least = std::min(least, manifold.points[k].gap);
    }
  }
  return least;
}

/// Distance and direction of the two plates of meshes that are nearest, B at X in the frame of
/// A. Infinite beyond `far` [m].
ContactNormal<double> nearest_plates(const MeshSurface<double, MeshTree<double>>& a,
                                     const MeshSurface<double, MeshTree<double>>& b,
                                     const Transform<double>& X, double far) {
  ContactNormal<double> nearest{.gap = infinity<double>};
  for (std::uint32_t i = 0; i < a.size(); ++i) {
    const Plate<double> in_a = a.plate(i);
    for (std::uint32_t k = 0; k < b.size(); ++k) {
      const Plate<double> in_b = b.plate(k);
      const auto found = contact_normal<GjkDistance>(convex_view(in_a), convex_view(in_b), X,
                                                     std::min(nearest.gap, far));
      if (found.nearness == Nearness::near && found.gap < nearest.gap) nearest = found;
    }
  }
  return nearest;
}

/// Contacts of two meshes, the second turned by an odd angle and moved, and what was asked for
/// them.
struct MeshPair {
  ContactManifolds<double> contacts;
  std::uint64_t distances = 0;
};

MeshPair collide(const TriangleMesh<double>& a, const TriangleMesh<double>& b,
                 const Transform<double>& X_AB, double margin) {
  const MeshTree<double> tree_a(a);
  const MeshTree<double> tree_b(b);
  const MeshSurface<double, MeshTree<double>> surface_a(tree_a);
  const MeshSurface<double, MeshTree<double>> surface_b(tree_b);
  MeshPair pair;
  ContactSink<double> sink(pair.contacts);
  sink.set_frame({}, false);
  CountedDistance::count = 0;
  collide_meshes<CountedDistance, double>(surface_a, surface_b, X_AB, margin, sink);
  pair.distances = CountedDistance::count;
  return pair;
}

}  // namespace

TEST_CASE("mesh_contacts: two meshes cost what is within the margin, however fine they are") {
  const double radius = 0.2;
  const Quat<double> odd = Quat<double>(1, 0.1, 0.2, 0.3).normalized();
  for (const std::uint32_t fineness : {5u, 10u, 20u}) {
    CAPTURE(fineness);
    const TriangleMesh<double> ball = sphere_mesh<double>(radius, fineness);
    // Chords lie up to 1.2 (edge)^2 / 8 radius within the sphere; edges are 1.2 radius / fineness.
    const double edge = 1.2 * radius / fineness;
    const double within = edge * edge / (4 * radius);
    const double margin = 0.001 + 2 * within;
    const MeshPair apart = collide(ball, ball, {odd, {2 * radius + 2 * margin, 0, 0}}, margin);
    CHECK(apart.distances == 0);
    CHECK(apart.contacts.empty());
    // A few triangles on each side are as near as that, whatever their size.
    const MeshPair near = collide(ball, ball, {odd, {2 * radius + 0.0005, 0, 0}}, margin);
    CHECK(near.distances > 0);
    CHECK(near.distances < 2000);
    CHECK_FALSE(near.contacts.empty());
  }
}

TEST_CASE(
    "mesh_contacts: surfaces that have passed through each other are found beyond the margin") {
  const TriangleMesh<double> box = box_mesh<double>({0.1, 0.1, 0.1});
  const double margin = 1e-4;
  for (const double depth : {0.001, 0.03, 0.09}) {
    CAPTURE(depth);
    // Turned about the normal and set aside, so that no edges coincide.
    const Quat<double> turned(Eigen::AngleAxisd(0.3, Vec3<double>::UnitZ()));
    const MeshPair pair = collide(box, box, {turned, {0.03, 0.01, 0.2 - depth}}, margin);
    double deepest = 0;
    for (const ContactManifold<double>& manifold : pair.contacts) {
      if (manifold.normal.z() < 1 - 1e-9) continue;
      for (std::size_t k = 0; k < manifold.size; ++k) {
        deepest = std::min(deepest, manifold.points[k].gap);
      }
    }
    CHECK(deepest == test::relative(-depth));
  }
}

TEST_CASE("mesh_contacts: boxes of a stack cut each other where their edges coincide") {
  const TriangleMesh<double> box = box_mesh<double>({0.1, 0.1, 0.1});
  const MeshPair pair = collide(box, box, {Quat<double>::Identity(), {0, 0, 0.19}}, 1e-4);
  REQUIRE(pair.contacts.size() == 1);
  CHECK(pair.contacts[0].size == 4);
  CHECK(pair.contacts[0].normal.z() == test::relative(1));
  CHECK(pair.contacts[0].points[0].gap == test::relative(-0.01));
}

TEST_CASE("mesh_contacts: a plate that is all inside a block leaves it, whichever is asked") {
  // A plate of 5 mm, askew in its own frame, 1 mm below the block's upper face and parallel to it.
  const double half_thickness = 0.0025;
  const Quat<double> askew(Eigen::AngleAxisd(0.7, Vec3<double>(1, 2, 0).normalized()));
  TriangleMesh<double> plate = box_mesh<double>({0.05, 0.05, half_thickness});
  for (Vec3<double>& vertex : plate.vertices) vertex = askew * vertex;
  const TriangleMesh<double> block = box_mesh<double>({0.2, 0.2, 0.2});
  const double top = 0.2 - 0.001;
  const Transform<double> X_block_plate{askew.conjugate(), {0.01, 0.02, top - half_thickness}};
  const auto check = [&](const MeshPair& pair, double sign) {
    REQUIRE(pair.contacts.size() == 1);
    CHECK(pair.contacts[0].normal.norm() == test::relative(1));
    for (std::size_t k = 0; k < pair.contacts[0].size; ++k) {
      CHECK(pair.contacts[0].points[k].gap == test::relative(-0.001 - 2 * half_thickness));
    }
    return sign * pair.contacts[0].normal;
  };
  const MeshPair first = collide(block, plate, X_block_plate, 1e-4);
  CHECK(check(first, 1).z() == test::relative(1));
  const MeshPair second = collide(plate, block, X_block_plate.inverse(), 1e-4);
  CHECK((X_block_plate.rotation * check(second, -1)).z() == test::relative(1));
}

namespace {

/// A ring and a box beside it, or in it.
struct RingAndBox {
  explicit RingAndBox(const Vec3<double>& half_extents) : box{half_extents} {}

  [[nodiscard]] ConvexView<double> solid() const { return convex_view(box); }
  /// The nearest plate's distance and direction to the box at X.
  [[nodiscard]] ContactNormal<double> nearest(const Transform<double>& X) const {
    ContactNormal<double> nearest{.gap = infinity<double>};
    for (std::uint32_t i = 0; i < surface.size(); ++i) {
      const Plate<double> plate = surface.plate(i);
      const auto found =
          contact_normal<GjkDistance>(convex_view(plate), solid(), X, infinity<double>);
      if (found.gap < nearest.gap) nearest = found;
    }
    return nearest;
  }
  [[nodiscard]] double least_gap(const Transform<double>& X, double margin) const {
    ContactManifolds<double> contacts;
    ContactSink<double> sink(contacts);
    sink.set_frame({}, false);
    collide_mesh<GjkDistance, double>(surface, solid(), X, margin, sink);
    return ::least_gap(contacts);
  }

  Box<double> box;
  TriangleMesh<double> ring = scenes::parts::torus(0.05, 0.02, 16, 8).mesh;
  MeshTree<double> tree{ring};
  MeshSurface<double, MeshTree<double>> surface{tree};
};

}  // namespace

// The inner side of a ring has hollow edges. Triangles there look away from what lies outside, and
// have no contact with it, however near it is for their size.
TEST_CASE("mesh_contacts: nothing that is beside a ring is deep in its far side") {
  const RingAndBox scene({0.05, 0.04, 0.035});
  const double margin = 0.08;  // Beyond the far side.
  test::Random random(5);
  int apart = 0;
  for (int n = 0; n < 300; ++n) {
    CAPTURE(n);
    const Transform<double> X{random.rotation<double>(), random.in_cube(0.1)};
    const double distance = scene.nearest(X).gap;
    if (distance <= 0 || distance > margin) continue;
    ++apart;
    CHECK(scene.least_gap(X, margin) == test::relative(distance));
  }
  CHECK(apart > 50);
}

// The box is free again where it came from. So it is no deeper than that; contacts beside hollow
// edges exceed it.
TEST_CASE("mesh_contacts: a box that a ring cuts is touched, and hardly deeper than it is") {
  const RingAndBox scene({0.010, 0.012, 0.015});
  const double depth = 0.001;
  test::Random random(5);
  int apart = 0;
  for (int n = 0; n < 1500; ++n) {
    CAPTURE(n);
    Transform<double> X{random.rotation<double>(), random.in_cube(0.08)};
    const ContactNormal<double> nearest = scene.nearest(X);
    if (nearest.gap <= 0 || nearest.gap > 0.05) continue;
    ++apart;
    X.translation -= (nearest.gap + depth) * nearest.normal;
    const double least = scene.least_gap(X, 0.001);
    CHECK(least < 0);
    CHECK(least > -1.5 * depth);
  }
  CHECK(apart > 500);
}

TEST_CASE("mesh_contacts: the nearest contact of two rings is as far as the rings are apart") {
  const TriangleMesh<double> ring = scenes::parts::torus(0.05, 0.02, 16, 8).mesh;
  const MeshTree<double> tree(ring);
  const MeshSurface<double, MeshTree<double>> surface(tree);
  const double margin = 0.03;
  test::Random random(6);
  int apart = 0;
  for (int n = 0; n < 60; ++n) {
    CAPTURE(n);
    const Transform<double> X{random.rotation<double>(), random.in_cube(0.12)};
    const double distance = nearest_plates(surface, surface, X, 0.1).gap;
    if (distance <= 0 || distance > margin) continue;
    ++apart;
    CHECK(least_gap(collide(ring, ring, X, margin).contacts) == test::relative(distance));
  }
  CHECK(apart > 15);
}

// Moved back to where they are free, no two triangles overlap. So a pair is no deeper than the way
// back, and triangles that meet corner to corner pass no others face to face.
TEST_CASE("mesh_contacts: meshes that cut each other touch, and hardly deeper than they are") {
  const TriangleMesh<double> ring = scenes::parts::torus(0.05, 0.02, 16, 8).mesh;
  const TriangleMesh<double> box = box_mesh<double>({0.05, 0.04, 0.035});
  struct Pair {
    const TriangleMesh<double>& a;
    const TriangleMesh<double>& b;
    int poses;
  };
  for (const Pair& pair : {Pair{box, box, 400}, Pair{ring, box, 150}, Pair{ring, ring, 25}}) {
    const MeshTree<double> tree_a(pair.a);
    const MeshTree<double> tree_b(pair.b);
    const MeshSurface<double, MeshTree<double>> a(tree_a);
    const MeshSurface<double, MeshTree<double>> b(tree_b);
    CAPTURE(a.size() + b.size());
    test::Random random(5);
    int apart = 0;
    for (int n = 0; n < pair.poses; ++n) {
      CAPTURE(n);
      Transform<double> X{random.rotation<double>(), random.in_cube(0.12)};
      const ContactNormal<double> nearest = nearest_plates(a, b, X, 0.05);
      if (nearest.gap <= 0 || nearest.gap > 0.05) continue;
      ++apart;
      for (const double depth : {0.0001, 0.001}) {
        CAPTURE(depth);
        Transform<double> X_cut = X;
        X_cut.translation -= (nearest.gap + depth) * nearest.normal;
        const double least = least_gap(collide(pair.a, pair.b, X_cut, 0.001).contacts);
        CHECK(least < 0);
        CHECK(least > -1.5 * depth);
      }
    }
    CHECK(apart > pair.poses / 4);
  }
}

namespace {

/// A wedge along y whose upper edge is in `pieces` parts, 0.2 m long and 0.2 m high.
TriangleMesh<double> rail(std::uint32_t pieces) {
  TriangleMesh<double> mesh;
  for (std::uint32_t i = 0; i <= pieces; ++i) {
    mesh.vertices.push_back({0, 0.2 * i / pieces - 0.1, 0});
  }
  const std::uint32_t left = pieces + 1;
  const std::uint32_t right = pieces + 3;
  for (const double x : {-0.02, 0.02}) {
    for (const double y : {-0.1, 0.1}) mesh.vertices.push_back({x, y, -0.2});
  }
  for (std::uint32_t i = 0; i < pieces; ++i) {
    mesh.triangles.push_back({i, i + 1, left});
    mesh.triangles.push_back({i, right, i + 1});
  }
  mesh.triangles.push_back({pieces, left + 1, left});
  mesh.triangles.push_back({pieces, right, right + 1});
  mesh.triangles.push_back({left, left + 1, right});
  mesh.triangles.push_back({left + 1, right + 1, right});
  mesh.triangles.push_back({0, left, right});
  mesh.triangles.push_back({pieces, right + 1, left + 1});
  return mesh;
}

}  // namespace

// An edge of several pieces is touched along all of them, by one plate of each side or by several.
TEST_CASE("mesh_contacts: a box lies on the whole of an edge, in however many pieces that is") {
  const Box<double> box{{0.3, 0.3, 0.05}};
  for (const std::uint32_t pieces : {1u, 2u, 4u, 6u}) {
    for (const double turn : {0.0, 1e-4, -1e-4}) {
      CAPTURE(pieces);
      CAPTURE(turn);
      const TriangleMesh<double> mesh = rail(pieces);
      validate_solid(mesh);
      const MeshTree<double> tree(mesh);
      const MeshSurface<double, MeshTree<double>> surface(tree);
      ContactManifolds<double> contacts;
      ContactSink<double> sink(contacts);
      sink.set_frame({}, false);
      const Quat<double> R(Eigen::AngleAxis<double>(turn, Vec3<double>::UnitX()));
      collide_mesh<GjkDistance, double>(surface, convex_view(box), {R, {0, 0, 0.05 - 1e-4}}, 1e-3,
                                        sink);
      double low = 0;
      double high = 0;
      for (const ContactManifold<double>& manifold : contacts) {
        for (std::size_t k = 0; k < manifold.size; ++k) {
          low = std::min(low, manifold.points[k].position.y());
          high = std::max(high, manifold.points[k].position.y());
        }
      }
      CHECK(low == test::relative(-0.1).epsilon(1e-3));
      CHECK(high == test::relative(0.1).epsilon(1e-3));
    }
  }
}

// A frame of 3 by 3 squares around a hole. Its top is cut into squares along the lines of the hole,
// since an edge of a plate is inside of a face or not. The sides below are one plate each. So what
// is one edge of a side is three of the top.
TEST_CASE("mesh contacts: a ball has one contact with an edge that is cut on one side only") {
  const TriangleMesh<double> frame = bristle::test::frame_mesh();
  const MeshTree<double> tree(frame);
  const MeshSurface<double, MeshTree<double>> surface(tree);
  // Eight for the top and for the bottom, and one for each of eight sides.
  CHECK(surface.size() == 24);
  const Sphere<double> ball{0.02};
  for (double along = 0.005; along < 0.3; along += 0.01) {
    CAPTURE(along);
    // Beside each outer edge of the top, 1 mm away.
    const double off = (ball.radius + 0.001) * std::sqrt(0.5);
    for (const Vec3<double>& place :
         {Vec3<double>(along, -off, off), Vec3<double>(along, 0.3 + off, off),
          Vec3<double>(-off, along, off), Vec3<double>(0.3 + off, along, off)}) {
      const Transform<double> X{Quat<double>::Identity(), place};
      ContactManifolds<double> contacts;
      ContactSink<double> sink(contacts);
      sink.set_frame({}, false);
      collide_mesh<GjkDistance, double>(surface, convex_view(ball), X, 0.005, sink);
      REQUIRE(contacts.size() == 1);
      CHECK(contacts[0].size == 1);
      CHECK(contacts[0].points[0].gap == test::relative(0.001).epsilon(1e-9));
    }
  }
}
