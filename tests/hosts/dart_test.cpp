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
    // DART's own box around a cone is too long by two radii.
    Vec3<double> low = shape->getBoundingBox().getMin();
    Vec3<double> high = shape->getBoundingBox().getMax();
    if (shape->is<ConeShape>()) {
      low.z() = -0.15;
      high.z() = 0.15;
    }
    // Rays from all sides end at the box, but for those that pass beside what is round or pointed.
    for (int axis = 0; axis < 3; ++axis) {
      double nearest_low = 1, nearest_high = 1;
      for (int i = 0; i < 41 * 41; ++i) {
        Vec3<double> from = low;
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        from[u] = low[u] + 0.025 * (i % 41) * (high[u] - low[u]);
        from[v] = low[v] + 0.025 * (i / 41) * (high[v] - low[v]);
        Vec3<double> along = Vec3<double>::Zero();
        along[axis] = 1;
        from[axis] = low[axis] - 0.5;
        nearest_low = std::min(nearest_low, host.world().cast_ray({from, along, 2}).distance);
        from[axis] = high[axis] + 0.5;
        nearest_high = std::min(nearest_high, host.world().cast_ray({from, -along, 2}).distance);
      }
      CHECK(std::abs(nearest_low - 0.5) < 1e-6);
      CHECK(std::abs(nearest_high - 0.5) < 1e-6);
    }
  }
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
