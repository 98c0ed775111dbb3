// DART: generalised coordinates, a direct solver, its own collision detector.
// SPDX-License-Identifier: BSD-3-Clause
#include "benchmarks/work_precision/drivers/features.hpp"
#include "benchmarks/work_precision/drivers/slab.hpp"
#include "benchmarks/work_precision/engines.hpp"

#include <cmath>
#include <dart/collision/dart/DARTCollisionDetector.hpp>
#include <dart/constraint/ConstraintSolver.hpp>
#include <dart/dynamics/BallJoint.hpp>
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/BoxShape.hpp>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/dynamics/Inertia.hpp>
#include <dart/dynamics/PrismaticJoint.hpp>
#include <dart/dynamics/ShapeNode.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <dart/dynamics/SphereShape.hpp>
#include <dart/dynamics/WeldJoint.hpp>
#include <dart/simulation/World.hpp>

namespace bristle::work_precision {

using namespace bristle::detail;

namespace {

namespace dynamics = dart::dynamics;

using scenes::Scene;
using scenes::SceneBody;
using scenes::Vector;

Eigen::Isometry3d placed(const scenes::Rotation& turn, const Vector& position) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = turn.toRotationMatrix();
  pose.translation() = position;
  return pose;
}

/// Setting: `def`.
class DartEngine : public scenes::Engine {
 public:
  DartEngine(const Scene& scene, double dt) : world_(dart::simulation::World::create()) {
    world_->setTimeStep(dt);
    world_->setGravity(scene.gravity);
    world_->getConstraintSolver()->setCollisionDetector(
        dart::collision::DARTCollisionDetector::create());
    if (!scene.joints.empty()) chain_ = dynamics::Skeleton::create("chain");
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) add(scene, i);
    if (!chain_) return;
    chain_->disableSelfCollisionCheck();
    world_->addSkeleton(chain_);
  }

  void step() override { world_->step(); }
  [[nodiscard]] scenes::BodyState state(std::size_t i) const override {
    const dynamics::BodyNode& body = *bodies_[i];
    return {body.getCOM(), scenes::Rotation(body.getWorldTransform().linear()),
            body.getCOMLinearVelocity(), body.getAngularVelocity()};
  }
  void push(std::size_t i, const Vector& force) override {
    bodies_[i]->addExtForce(force, Vector::Zero(), false, true);
  }

 private:
  void add(const Scene& scene, std::size_t i) {
    const SceneBody& body = scene.bodies[i];
    Eigen::Isometry3d pose = placed(body.orientation, body.position);
    dynamics::ShapePtr shape;
    if (const auto* ball = std::get_if<Sphere<double>>(&body.shape)) {
      shape = std::make_shared<dynamics::SphereShape>(ball->radius);
    } else if (const auto* box = std::get_if<Box<double>>(&body.shape)) {
      shape = std::make_shared<dynamics::BoxShape>(2 * box->half_extents);
    } else if (const auto* ground = std::get_if<HalfSpace<double>>(&body.shape)) {
      const Slab slab = slab_of(*ground);
      shape = std::make_shared<dynamics::BoxShape>(2 * slab.half);
      pose = placed(slab.orientation, slab.position);
    } else {
      throw scenes::Unsupported("a shape that its collision detector does not know");
    }

    dynamics::BodyNode* node = nullptr;
    if (!body.moves()) {
      node = add_by<dynamics::WeldJoint>(i, pose).second;
      node->getSkeleton()->setMobile(false);
    } else if (chain_) {
      node = add_link(scene, i);
    } else if (body.slides_along_x) {
      const auto [joint, slider] = add_by<dynamics::PrismaticJoint>(i, pose);
      joint->setAxis(Vector::UnitX());
      node = slider;
    } else {
      const auto [joint, free] = add_by<dynamics::FreeJoint>(i, Eigen::Isometry3d::Identity());
      joint->setTransform(pose);
      joint->setLinearVelocity(body.velocity);
      joint->setAngularVelocity(body.angular_velocity);
      node = free;
    }
    if (body.moves()) {
      const Eigen::Matrix3d inertia = scenes::principal_inertia(body).asDiagonal();
      node->setInertia(dynamics::Inertia(body.mass, Vector::Zero(), inertia));
    }
    add_shape(scene, body, *node, shape);
    bodies_.push_back(node);
    // Only now: the shapes that a skeleton gets later are not touched in the first step.
    if (node->getSkeleton() != chain_) world_->addSkeleton(node->getSkeleton());
  }

  /// A skeleton of one body on a joint that stands at `pose`.
  template <typename Joint>
  std::pair<Joint*, dynamics::BodyNode*> add_by(std::size_t i, const Eigen::Isometry3d& pose) {
    const dynamics::SkeletonPtr skeleton = dynamics::Skeleton::create("body" + std::to_string(i));
    const auto added = skeleton->createJointAndBodyNodePair<Joint>(nullptr);
    added.first->setTransformFromParentBodyNode(pose);
    skeletons_.push_back(skeleton);
    return added;
  }

  /// The next link of the chain, which are in its order.
  dynamics::BodyNode* add_link(const Scene& scene, std::size_t i) {
    const scenes::SceneJoint& joint = scene.joints[i];
    const SceneBody& body = scene.bodies[i];
    dynamics::BallJoint::Properties properties;
    properties.mName = "joint" + std::to_string(i);
    dynamics::BodyNode* parent = nullptr;
    Eigen::Isometry3d parent_pose = Eigen::Isometry3d::Identity();
    if (joint.a >= 0) {
      const SceneBody& other = scene.bodies[static_cast<std::size_t>(joint.a)];
      parent = bodies_[static_cast<std::size_t>(joint.a)];
      parent_pose = placed(other.orientation, other.position);
    }
    // The axes of the joint are those of the body, so that its angles start at zero.
    const Eigen::Isometry3d at = placed(body.orientation, joint.anchor);
    properties.mT_ParentBodyToJoint = parent_pose.inverse() * at;
    properties.mT_ChildBodyToJoint = placed(body.orientation, body.position).inverse() * at;
    return chain_
        ->createJointAndBodyNodePair<dynamics::BallJoint>(
            parent, properties, dynamics::BodyNode::AspectProperties("body" + std::to_string(i)))
        .second;
  }

  static void add_shape(const Scene& scene, const SceneBody& body, dynamics::BodyNode& node,
                        const dynamics::ShapePtr& shape) {
    if (body.meets == scenes::Meets::nothing) {
      node.createShapeNodeWith<dynamics::VisualAspect>(shape);
      return;
    }
    dynamics::DynamicsAspect& surface =
        *node.createShapeNodeWith<dynamics::VisualAspect, dynamics::CollisionAspect,
                                  dynamics::DynamicsAspect>(shape)
             ->getDynamicsAspect();
    // Of a pair: the smaller friction and the product of restitutions.
    surface.setFrictionCoeff(body.friction_if_minimum.value_or(body.friction * body.friction));
    surface.setRestitutionCoeff(std::sqrt(scene.restitution));
  }

  dart::simulation::WorldPtr world_;
  dynamics::SkeletonPtr chain_;
  std::vector<dynamics::SkeletonPtr> skeletons_;
  std::vector<dynamics::BodyNode*> bodies_;
};

}  // namespace

std::vector<EngineFamily> engine_families() {
  return {
      {"dart",
       {"def"},
       [](const Scene& scene, double dt, const std::string&) -> std::unique_ptr<scenes::Engine> {
         // The cost of a step grows with the cube of the contacts: minutes a step.
         if (scene.bodies.size() > 100) throw scenes::Unsupported("too many bodies");
         require_known(scene, {});
         return std::make_unique<DartEngine>(scene, dt);
       }}};
}

}  // namespace bristle::work_precision
