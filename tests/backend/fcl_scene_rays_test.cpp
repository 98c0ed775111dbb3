// SPDX-License-Identifier: BSD-3-Clause

#include "support/relative.hpp"

#include <bristle/geometry/backends/fcl_scene_rays.hpp>
#include <bristle/geometry/meshes/mesh_shapes.hpp>

#include <doctest/doctest.h>

#include <cstddef>
#include <memory>
#include <support/random.hpp>
#include <vector>

using namespace bristle;

using namespace bristle::detail;
using bristle::test::Random;

// Debian's libfcl aligns to 16 bytes. Where this build aligns to more, the header refuses to
// compile what shares objects with it, and all that can be tested is that it knows.
#if EIGEN_MAX_ALIGN_BYTES > 16

TEST_CASE("cast_ray: objects laid out unlike libfcl's are known as such") {
  CHECK_FALSE(detail::is_fcl_layout_common<double>);
}

#else

namespace {

using Objects = std::vector<std::unique_ptr<fcl::CollisionObject<double>>>;

/// Objects of all finite kinds in random poses.
Objects random_objects(Random& random, int count) {
  Objects objects;
  for (int i = 0; i < count; ++i) {
    const auto size = [&] { return random.uniform(0.05, 0.2); };
    Shape<double> shape;
    switch (i % 8) {
      case 0:
        shape = Sphere<double>{size()};
        break;
      case 1:
        shape = Box<double>{{size(), size(), size()}};
        break;
      case 2:
        shape = Capsule<double>{size(), size()};
        break;
      case 3:
        shape = Cylinder<double>{size(), size()};
        break;
      case 4:
        shape = Cone<double>{size(), size()};
        break;
      case 5:
        shape = Ellipsoid<double>{{size(), size(), size()}};
        break;
      case 6: {
        // A tetrahedron.
        ConvexHull<double> hull;
        const double a = size();
        hull.vertices = {{0, 0, 0}, {a, 0, 0}, {0, a, 0}, {0, 0, a}};
        hull.face_vertices = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
        hull.face_starts = {0, 3, 6, 9, 12};
        hull.face_normals.assign(4, Vec3<double>::Zero());
        hull.face_offsets.assign(4, 0.0);
        shape = hull;
        break;
      }
      default:
        shape = sphere_mesh<double>(size(), 3);
    }
    auto geometry = std::const_pointer_cast<fcl::CollisionGeometry<double>>(to_fcl(shape));
    auto object = std::make_unique<fcl::CollisionObject<double>>(geometry);
    const Transform<double> X = random.pose(1.0);
    object->setTransform(X.rotation_matrix(), X.translation);
    object->computeAABB();
    objects.push_back(std::move(object));
  }
  return objects;
}

}  // namespace

TEST_CASE("cast_ray: finds in FCL's tree what asking every object finds") {
  Random random(21);
  const Objects objects = random_objects(random, 120);
  fcl::DynamicAABBTreeCollisionManager<double> scene;
  for (const auto& object : objects) scene.registerObject(object.get());
  scene.setup();
  int hits = 0;
  for (int i = 0; i < 3000; ++i) {
    CAPTURE(i);
    const Ray<double> ray{random.in_cube(1.5), random.direction<double>(),
                          i % 3 == 0 ? infinity<double> : random.uniform(0.0, 2.0)};
    FclSceneHit<double> expected;
    for (const auto& object : objects) {
      const RayHit<double> hit = ray_cast(*object, ray);
      if (hit.distance < expected.hit.distance) expected = {hit, object.get()};
    }
    const FclSceneHit<double> found = cast_ray(scene, ray);
    // The very same arithmetic, so the very same numbers. Which of two solids that both hold the
    // ray's start is named is up to the tree.
    CHECK(found.hit.distance == expected.hit.distance);
    if (expected.hit.distance > 0.0) {
      CHECK(found.object == expected.object);
      CHECK(found.hit.normal == expected.hit.normal);
    }
    hits += found.object != nullptr ? 1 : 0;
  }
  CHECK(hits > 500);
  CHECK(hits < 2900);
}

TEST_CASE("cast_ray: an empty scene is missed, an unknown geometry not seen") {
  fcl::DynamicAABBTreeCollisionManager<double> scene;
  const Ray<double> ray{{0.0, 0.0, 2.0}, {0.0, 0.0, -1.0}};
  CHECK(cast_ray(scene, ray).object == nullptr);
  auto plane = std::make_shared<fcl::Plane<double>>(Vec3<double>::UnitZ(), 0.0);
  auto ball = std::make_shared<fcl::Sphere<double>>(0.5);
  fcl::CollisionObject<double> plane_object(plane);
  fcl::CollisionObject<double> ball_object(ball);
  ball_object.setTranslation({0.0, 0.0, -2.0});
  ball_object.computeAABB();
  scene.registerObject(&plane_object);
  scene.registerObject(&ball_object);
  scene.setup();
  const FclSceneHit<double> found = cast_ray(scene, ray);
  CHECK(found.object == &ball_object);
  CHECK(found.hit.distance == test::relative(3.5));
}

TEST_CASE("cast_ray: objects have the layout that libfcl was built with") {
  // 224 bytes in Debian's binary (16-byte alignment); 256 with AVX-512's.
  CHECK(sizeof(fcl::CollisionObject<double>) == 224);
  CHECK(alignof(fcl::CollisionObject<double>) == 16);
}

#endif
