/// @file
/// The pinch in DART.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/dart_pinch.hpp"
#include "support/pinch_checks.hpp"
#include "support/relative.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <assimp/scene.h>
#include <cmath>
#include <cstdint>
#include <dart/dynamics/ConeShape.hpp>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/dynamics/MeshShape.hpp>
#include <dart/dynamics/MultiSphereConvexHullShape.hpp>
#include <dart/dynamics/PyramidShape.hpp>
#include <dart/dynamics/SphereShape.hpp>
#include <memory>

using namespace bristle;

using namespace bristle::detail;
using namespace bristle::scenes;

TEST_CASE("DART: two pads hold a part at any step, and it sags by m g / (mu_S sum F_N)") {
  check_holds<DartPinch>({.mass = 0.045, .squeeze = 12}, {});
  check_holds<DartPinch>({.mass = 2, .squeeze = 60}, {});
}

TEST_CASE("DART: a part whose centre of mass lies beside the pads is held against turning") {
  check_holds<DartPinch>({.squeeze = 30, .offset = 0.04}, {});
}

TEST_CASE("DART: the squeeze decides whether a part is held or let go") {
  check_lets_go<DartPinch>();
}

TEST_CASE("DART: a shaken part swings as a spring and damper does, and comes back") {
  check_shaken<DartPinch>();
}

TEST_CASE("DART: pads that come from out of reach catch a part in a long step") {
  check_caught<DartPinch>({});
}

TEST_CASE("DART: pads on an arm of seven joints hold a part as on slides") {
  check_on_arm<DartPinch>();
}

TEST_CASE("DART: the part gains the momentum that readings tell") { check_momentum<DartPinch>({}); }

TEST_CASE("DART: a body that a caller adds to the mirror himself is missing, and harms nobody") {
  check_stranger<DartPinch>();
}

TEST_CASE("DART: mobility is what a step does with a wrench, springs and dampers included") {
  DartPinch pinch({.has_arm = true});
  const BodyId left = pinch.host->mirror(*pinch.pads[0]);
  const BodyId right = pinch.host->mirror(*pinch.pads[1]);
  const auto twist = [](const dart::dynamics::BodyNode& node) {
    Vec6<double> v;
    v << node.getCOMLinearVelocity(), node.getAngularVelocity();
    return v;
  };
  const Wrench<double> wrench{{0.3, -0.2, 0.5}, {0.01, 0.02, -0.03}};
  Vec6<double> impulse;
  impulse << pinch.def.dt * wrench.force, pinch.def.dt * wrench.torque;
  const Vec6<double> own = pinch.host->mobility(left, left) * impulse;
  const Vec6<double> other = pinch.host->mobility(right, left) * impulse;
  pinch.host->apply_wrench(left, wrench);
  pinch.dart->step();
  // From rest; but for the positions that the velocities are at, which differ by dt of them.
  const double tolerance = 10 * pinch.def.dt * own.norm();
  CHECK((twist(*pinch.pads[0]) - own).norm() < tolerance);
  CHECK((twist(*pinch.pads[1]) - other).norm() < tolerance);
  CHECK(own.norm() > 0);
}

TEST_CASE("DART: forces of the caller stay, and what has no shape like it is refused by name") {
  DartPinch pinch{{}};
  pinch.run(0.3);
  for (int i = 0; i < 2000; ++i) {
    pinch.part_node->addExtForce(Eigen::Vector3d(0, 0.25, 0));
    pinch.run(pinch.def.dt);
  }
  CHECK(pinch.reading(0).wrench.force.y() + pinch.reading(1).wrench.force.y() ==
        test::relative(0.25).epsilon(1e-6));
  using Balls = dart::dynamics::MultiSphereConvexHullShape;
  const auto balls = std::make_shared<Balls>(Balls::Spheres{{0.1, Eigen::Vector3d::Zero()}});
  const auto other = dart::dynamics::Skeleton::create("other");
  dart::dynamics::BodyNode& node =
      *other->createJointAndBodyNodePair<dart::dynamics::FreeJoint>().second;
  node.createShapeNodeWith<dart::dynamics::VisualAspect>(balls);
  pinch.dart->addSkeleton(other);
  const std::uint64_t before = pinch.host->world().state_hash();
  CHECK_THROWS_WITH_AS(pinch.host->mirror(node), doctest::Contains("MultiSphere"), InvalidArgument);
  CHECK(pinch.host->world().state_hash() == before);
}

TEST_CASE("DART: cones, pyramids and meshes are seen where DART has them") {
  using namespace dart::dynamics;
  const Eigen::Vector3d scale(0.5, 1, 2);
  // A tetrahedron with a corner at the origin. DART owns the scene.
  auto* scene = new aiScene;
  scene->mNumMeshes = 1;
  scene->mMeshes = new aiMesh* [1] { new aiMesh };
  aiMesh& mesh = *scene->mMeshes[0];
  const unsigned faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  mesh.mNumVertices = 4;
  mesh.mVertices = new aiVector3D[4]{{0, 0, 0}, {0.25f, 0, 0}, {0, 0.25f, 0}, {0, 0, 0.25f}};
  mesh.mNumFaces = 4;
  mesh.mFaces = new aiFace[4];
  for (unsigned f = 0; f < 4; ++f) {
    mesh.mFaces[f].mNumIndices = 3;
    mesh.mFaces[f].mIndices = new unsigned[3]{faces[f][0], faces[f][1], faces[f][2]};
  }
  const ShapePtr shapes[] = {std::make_shared<ConeShape>(0.1, 0.3),
                             std::make_shared<PyramidShape>(0.2, 0.3, 0.4),
                             std::make_shared<MeshShape>(scale, scene)};
  for (const ShapePtr& shape : shapes) {
    CAPTURE(shape->getType());
    const auto world = std::make_shared<dart::simulation::World>();
    const SkeletonPtr skeleton = Skeleton::create("body");
    BodyNode& node = *skeleton->createJointAndBodyNodePair<FreeJoint>().second;
    node.createShapeNodeWith<VisualAspect>(shape);
    world->addSkeleton(skeleton);
    DartHost<> host(world);
    (void)host.mirror(node);
    // From above and below, beside the middle: the surface as DART's documentation has it.
    for (const double x : {-0.03, 0.02, 0.05}) {
      for (const double y : {-0.04, 0.01, 0.06}) {
        double high = 0, low = 0;
        if (shape->is<ConeShape>()) {
          high = 0.15 - 0.3 * std::hypot(x, y) / 0.1;
          low = -0.15;
        } else if (shape->is<PyramidShape>()) {
          high = 0.2 - 0.4 * std::max(std::abs(x) / 0.1, std::abs(y) / 0.15);
          low = -0.2;
        } else {
          // The slanted face meets the axes at 0.25 times the scale.
          high = 0.5 * (1 - x / 0.125 - y / 0.25);
          if (x < 0 || y < 0) high = -1;
        }
        const WorldHit<double> down = host.world().cast_ray({{x, y, 1}, {0, 0, -1}, 2});
        const WorldHit<double> up = host.world().cast_ray({{x, y, -1}, {0, 0, 1}, 2});
        CHECK(down.is_hit() == (high > low));
        if (!down.is_hit()) continue;
        CHECK(down.distance == test::relative(1 - high).epsilon(1e-6));
        CHECK(up.distance == test::relative(low + 1).epsilon(1e-6));
      }
    }
  }
}

TEST_CASE("DART: what a body is only drawn by is not sensed where it collides by something") {
  using namespace dart::dynamics;
  const auto world = std::make_shared<dart::simulation::World>();
  const SkeletonPtr skeleton = Skeleton::create("body");
  BodyNode& node = *skeleton->createJointAndBodyNodePair<FreeJoint>().second;
  node.createShapeNodeWith<VisualAspect>(std::make_shared<SphereShape>(0.3));
  node.createShapeNodeWith<CollisionAspect>(std::make_shared<SphereShape>(0.1));
  world->addSkeleton(skeleton);
  DartHost<> host(world);
  (void)host.mirror(node);
  CHECK(host.world().cast_ray({{0, 0, 1}, {0, 0, -1}, 2}).distance == test::relative(0.9));
}

TEST_CASE("DART: a part whose skeleton has left the world is let go") {
  DartPinch pinch{{}};
  pinch.run(0.1);
  CHECK(pinch.reading(0).touching() == 36);
  const dart::dynamics::SkeletonPtr part = pinch.part_node->getSkeleton();
  pinch.dart->removeSkeleton(part);
  pinch.step();
  CHECK(pinch.reading(0).touching() == 0);
  CHECK(pinch.missing() == 1);
}
