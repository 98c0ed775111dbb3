// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/geometry/backends/fcl_backend.hpp>
#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/geometry/shapes/quickhull.hpp>

#include <doctest/doctest.h>

#include <backend/reference_shapes.hpp>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <support/counted_new.hpp>
#include <support/random.hpp>
#include <vector>

using namespace bristle;

using namespace bristle::detail;
using bristle::test::Random;

namespace {

template <Scalar S>
struct NamedCollidable {
  std::string name;
  FclBackend::Collidable<S> collidable;
};

template <Scalar S>
std::vector<NamedCollidable<S>> all_collidables() {
  std::vector<NamedCollidable<S>> all;
  for (const auto& reference : test::reference_shapes<S>(S(1))) {
    all.push_back({reference.name, FclBackend::make<S>(reference.shape)});
  }
  return all;
}

/// Rays from all around towards the middle.
template <Scalar S>
struct Rays {
  explicit Rays(std::size_t count) {
    Random random(31);
    origin.resize(count);
    direction.resize(count);
    length.assign(count, S(10));
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3<S> from = S(3) * random.direction<S>();
      origin.set(i, from);
      direction.set(i, (random.in_cube(S(0.3)) - from).normalized());
    }
    hits.reset(count);
  }
  RayBatch<S> batch() const {
    return {origin.x, origin.y, origin.z, direction.x, direction.y, direction.z, length};
  }

  Vec3Array<S> origin;
  Vec3Array<S> direction;
  std::vector<S> length;
  RayHits<S> hits;
};

}  // namespace

TEST_CASE_TEMPLATE("FclBackend: hostile poses end in `failed` or an answer, and never add nonsense",
                   S, float, double) {
  const S nan = std::numeric_limits<S>::quiet_NaN();
  const S huge = std::numeric_limits<S>::max() / S(4);
  const auto all = all_collidables<S>();
  for (const auto& a : all) {
    for (const auto& b : all) {
      CAPTURE(a.name);
      CAPTURE(b.name);
      if (!FclBackend::can_collide(FclBackend::kind(a.collidable),
                                   FclBackend::kind(b.collidable))) {
        continue;
      }
      ContactManifolds<S> out(1);
      const auto ask = [&](const Transform<S>& X, S margin) {
        const ContactStatus status =
            FclBackend::collide(a.collidable, b.collidable, X, margin, out);
        REQUIRE(!out.empty());
        for (std::size_t i = 1; i < out.size(); ++i) {
          CHECK(out[i].normal.allFinite());
          CHECK(out[i].size > 0);
          for (std::size_t k = 0; k < out[i].size; ++k) CHECK(std::isfinite(out[i].points[k].gap));
        }
        if (status == ContactStatus::failed) CHECK(out.size() == 1);
        out.resize(1);
        return status;
      };
      CHECK(ask({.translation = {nan, S(0), S(0)}}, S(0.01)) == ContactStatus::failed);
      CHECK(ask({.rotation = Quat<S>(nan, S(0), S(0), S(0))}, S(0.01)) == ContactStatus::failed);
      CHECK(ask({.translation = {S(0), infinity<S>, S(0)}}, S(0.01)) == ContactStatus::failed);
      CHECK(ask({}, nan) == ContactStatus::failed);
      CHECK(ask({.translation = {S(0), S(0), huge}}, S(0.01)) == ContactStatus::ok);
      CHECK(ask({.translation = {S(1e6), S(-1e6), S(1e6)}}, S(0.01)) == ContactStatus::ok);
      // Not a rotation: caller's mistake, but no reason to hang.
      (void)ask({.rotation = Quat<S>(S(0), S(0), S(0), S(0))}, S(0.01));
      // Concentric, a hair off, and touching within round-off.
      CHECK(ask({}, S(0)) == ContactStatus::ok);
      CHECK(ask({.translation = {std::numeric_limits<S>::min(), S(0), S(0)}}, S(0)) ==
            ContactStatus::ok);
    }
    // Rays: no hit for a pose that is none, none for a ray that starts nowhere.
    Rays<S> rays(8);
    FclBackend::cast_rays<S>(a.collidable, {.translation = {nan, S(0), S(0)}}, rays.batch(), 1,
                             rays.hits);
    for (std::size_t i = 0; i < 8; ++i) CHECK(!rays.hits.is_hit(i));
    rays.origin.x[3] = nan;
    FclBackend::cast_rays<S>(a.collidable, {}, rays.batch(), 1, rays.hits);
    CHECK(!rays.hits.is_hit(3));
  }
}

TEST_CASE_TEMPLATE(
    "FclBackend: fcl#493 and the like: boxes that touch within round-off get their face", S, float,
    double) {
  // Configurations of FCL's issues #493, #529, #578 in spirit: equal attitude, faces or sides that
  // touch, where its expanding polytope throws or loops.
  const auto cube = FclBackend::make<S>(Box<S>{Vec3<S>::Constant(S(0.125))});
  const auto rod = FclBackend::make<S>(Cylinder<S>{S(0.01), S(0.5)});
  Random random(41);
  for (int i = 0; i < 200; ++i) {
    Quat<S> attitude = random.rotation<S>();
    if (i == 0) attitude.setIdentity();
    const S noise = random.uniform(S(-1), S(1)) * std::numeric_limits<S>::epsilon();
    ContactManifolds<S> out;
    const Transform<S> X_WA{attitude, random.in_cube(S(1))};
    const Transform<S> X_WB{attitude, X_WA * Vec3<S>(S(0.25) + noise, S(0.03), S(-0.05))};
    const auto X_AB = relative_pose(X_WA, X_WB);
    REQUIRE(FclBackend::collide(cube, cube, X_AB, S(0.001), out) == ContactStatus::ok);
    REQUIRE(out.size() == 1);
    CHECK((out[0].normal - Vec3<S>::UnitX()).norm() < S(1e-5));
    CHECK(out[0].size == 4);
    out.clear();
    const Transform<S> X_rods{Quat<S>::Identity(), {S(0.02) + noise, S(0), S(0.2)}};
    REQUIRE(FclBackend::collide(rod, rod, X_rods, S(0.001), out) == ContactStatus::ok);
    REQUIRE(out.size() == 1);
    CHECK((out[0].normal - Vec3<S>::UnitX()).norm() < S(1e-3));
    CHECK(out[0].size == 2);
  }
}

TEST_CASE_TEMPLATE("FclBackend: neither contacts nor rays allocate once warm", S, float, double) {
  const auto all = all_collidables<S>();
  ContactManifolds<S> out;
  out.reserve(256);
  Rays<S> rays(64);
  Random random(51);
  for (const auto& a : all) {
    for (const auto& b : all) {
      if (!FclBackend::can_collide(FclBackend::kind(a.collidable),
                                   FclBackend::kind(b.collidable))) {
        continue;
      }
      CAPTURE(a.name);
      CAPTURE(b.name);
      const std::size_t before = test::allocations;
      bool is_ok = true;
      for (int i = 0; i < 20; ++i) {
        out.clear();
        const Transform<S> X = random.pose(S(1));
        is_ok = is_ok && FclBackend::collide(a.collidable, b.collidable, X, S(0.01), out) ==
                             ContactStatus::ok;
      }
      CHECK(test::allocations == before);
      CHECK(is_ok);
    }
    const std::size_t before = test::allocations;
    FclBackend::cast_rays<S>(a.collidable, random.pose(S(0.2)), rays.batch(), 1, rays.hits);
    CHECK(test::allocations == before);
  }
}

TEST_CASE_TEMPLATE("FclBackend: the FCL geometry is what the shape is, and reads back as it", S,
                   float, double) {
  const auto geometry_of = [](const Shape<S>& shape) { return to_fcl(shape); };
  const FclGeometry box = geometry_of(Box<S>{{S(1), S(2), S(3)}});
  CHECK(box->getNodeType() == fcl::GEOM_BOX);
  CHECK(box->aabb_radius == test::relative(std::sqrt(14.0)));
  CHECK(std::get<Box<double>>(from_fcl(*box)).half_extents == Vec3<double>(1.0, 2.0, 3.0));
  CHECK(std::get<Sphere<double>>(from_fcl(*geometry_of(Sphere<S>{S(0.5)}))).radius == 0.5);
  const auto capsule = std::get<Capsule<double>>(from_fcl(*geometry_of(Capsule<S>{S(0.5), S(2)})));
  CHECK(capsule.radius == 0.5);
  CHECK(capsule.half_length == 2.0);
  const auto cone = std::get<Cone<double>>(from_fcl(*geometry_of(Cone<S>{S(0.5), S(2)})));
  CHECK(cone.radius == 0.5);
  CHECK(cone.half_length == 2.0);
  const auto cylinder =
      std::get<Cylinder<double>>(from_fcl(*geometry_of(Cylinder<S>{S(0.5), S(2)})));
  CHECK(cylinder.radius == 0.5);
  CHECK(cylinder.half_length == 2.0);
  const auto ellipsoid =
      std::get<Ellipsoid<double>>(from_fcl(*geometry_of(Ellipsoid<S>{{S(1), S(2), S(4)}})));
  CHECK(ellipsoid.radii == Vec3<double>(1.0, 2.0, 4.0));
  const auto plane =
      std::get<HalfSpace<double>>(from_fcl(*geometry_of(HalfSpace<S>{{S(0), S(1), S(0)}, S(3)})));
  CHECK(plane.normal == Vec3<double>::UnitY());
  CHECK(plane.offset == 3.0);

  std::vector<Vec3<S>> corners;
  for (int i = 0; i < 8; ++i) {
    corners.emplace_back(i & 1 ? S(1) : S(-1), i & 2 ? S(2) : S(-2), i & 4 ? S(3) : S(-3));
  }
  const auto hull = convex_hull<S>(std::span<const Vec3<S>>(corners));
  const FclGeometry convex = geometry_of(hull);
  const auto read = std::get<ConvexHull<double>>(from_fcl(*convex));
  CHECK_NOTHROW(read.validate());
  REQUIRE(read.face_count() == hull.face_count());
  for (std::size_t f = 0; f < read.face_count(); ++f) {
    CHECK((read.face_normals[f] - hull.face_normals[f].template cast<double>()).norm() < 1e-6);
    CHECK(read.face_offsets[f] == test::relative(double(hull.face_offsets[f])));
  }

  const TriangleMesh<S> mesh = sphere_mesh<S>(S(1), 2);
  const FclGeometry bvh = geometry_of(mesh);
  const auto tree = std::get<FclMeshTree<double>>(from_fcl(*bvh));
  REQUIRE(tree.size() == mesh.triangles.size());
  for (std::uint32_t i = 0; i < tree.size(); ++i) {
    CHECK(tree.vertex_numbers(i) == mesh.triangles[i]);
    CHECK(tree.corners(i)[1] == mesh.vertices[mesh.triangles[i][1]].template cast<double>());
  }
}

TEST_CASE("from_fcl: a geometry without a shape of its own is refused by name") {
  const fcl::BVHModel<fcl::AABB<double>> empty;
  CHECK_THROWS_AS((void)from_fcl<double>(empty), InvalidArgument);
  const fcl::BVHModel<fcl::OBB<double>> other_boxes;
  CHECK_THROWS_AS((void)from_fcl<double>(other_boxes), InvalidArgument);
}

TEST_CASE("FclMeshTree: walks a ray through its triangles, the nearer first") {
  const FclGeometry geometry = to_fcl<double>(box_mesh<double>({1.0, 1.0, 1.0}));
  const auto tree = std::get<FclMeshTree<double>>(from_fcl(*geometry));
  CHECK(tree.root_box().upper == Vec3<double>(1.0, 1.0, 1.0));
  // A ray through two walls and no more: nearer boxes first.
  std::vector<std::uint32_t> met;
  tree.walk_ray({{-3.0, 0.5, 0.25}, Vec3<double>::UnitX()}, [&](std::uint32_t i, double reach) {
    met.push_back(i);
    return reach;
  });
  REQUIRE(met.size() == 4);
  CHECK(tree.corners(met.front())[0].x() == -1.0);
  CHECK(tree.corners(met.back())[0].x() == 1.0);
}

// Types that are made by our code and read by Debian's binary, which was built without -march.
// Their members are Vector3<double>, which Eigen never aligns, so the sizes hold under any flags.
TEST_CASE("FclBackend: FCL types have the layout that libfcl was built with") {
  CHECK(alignof(fcl::Vector3<double>) == 8);
  CHECK(sizeof(fcl::Vector3<double>) == 24);
  CHECK(sizeof(fcl::AABB<double>) == 48);
  CHECK(alignof(fcl::CollisionGeometry<double>) == 8);
  CHECK(sizeof(fcl::CollisionGeometry<double>) == 120);
  CHECK(sizeof(fcl::Box<double>) == 144);
  CHECK(sizeof(fcl::BVNode<fcl::AABB<double>>) == 64);
}
