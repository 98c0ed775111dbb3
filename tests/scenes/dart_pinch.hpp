/// @file
/// The pinch in DART.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/hosts/dart_host.hpp>

#include <array>
#include <cstddef>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/dynamics/PrismaticJoint.hpp>
#include <dart/dynamics/RevoluteJoint.hpp>
#include <memory>
#include <scenes/pinch.hpp>
#include <string>

namespace bristle::scenes {

class DartPinch : public Pinch {
 public:
  explicit DartPinch(const PinchDef& d) : Pinch(d) {
    using namespace dart::dynamics;
    dart->setTimeStep(def.dt);
    dart->setGravity(Eigen::Vector3d::Zero());
    const SkeletonPtr gripper = Skeleton::create("gripper");
    BodyNode* wrist = nullptr;
    Eigen::Vector3d wrist_place = Eigen::Vector3d::Zero();
    for (int i = 0; def.has_arm && i < 7; ++i) {
      const Eigen::Vector3d axes[] = {Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitY(),
                                      Eigen::Vector3d::UnitX()};
      RevoluteJoint::Properties joint;
      joint.mName = "arm" + std::to_string(i);
      joint.mAxis = axes[i % 3];
      const Eigen::Vector3d place =
          i == 0 ? Eigen::Vector3d(-0.5, 0, -0.3) : Eigen::Vector3d(0.5 / 6, 0, 0.05);
      joint.mT_ParentBodyToJoint.translation() = place;
      wrist_place += place;
      wrist = gripper
                  ->createJointAndBodyNodePair<RevoluteJoint>(
                      wrist, joint, BodyNode::AspectProperties(joint.mName))
                  .second;
      wrist->getParentJoint()->setSpringStiffness(0, 2000);
      wrist->getParentJoint()->setDampingCoefficient(0, 20);
      Inertia ball;  // of 40 mm radius
      ball.setMass(1);
      ball.setMoment(6.4e-4, 6.4e-4, 6.4e-4, 0, 0, 0);
      wrist->setInertia(ball);
    }
    for (std::size_t k = 0; k < 2; ++k) {
      PrismaticJoint::Properties joint;
      joint.mName = k == 0 ? "left" : "right";
      joint.mAxis = Eigen::Vector3d::UnitX();
      joint.mT_ParentBodyToJoint.translation() =
          Eigen::Vector3d(k == 0 ? -0.0101 : 0.0101, 0, 0) - wrist_place;
      const SkeletonPtr own = def.has_arm ? gripper : Skeleton::create(joint.mName);
      pads[k] = own->createJointAndBodyNodePair<PrismaticJoint>(
                       wrist, joint, BodyNode::AspectProperties(joint.mName))
                    .second;
      Inertia small;
      small.setMass(0.1);
      small.setMoment(1e-5, 1e-5, 1e-5, 0, 0, 0);
      pads[k]->setInertia(small);
      if (def.has_arm) {
        // On a tilted arm nothing else keeps them between the ends of the slides.
        pads[k]->getParentJoint()->setSpringStiffness(0, 1000);
        pads[k]->getParentJoint()->setDampingCoefficient(0, 20);
      } else {
        dart->addSkeleton(own);
      }
      add_box(*pads[k], Eigen::Vector3d::Zero());
    }
    if (def.has_arm) dart->addSkeleton(gripper);
    const SkeletonPtr free = Skeleton::create("part");
    part_node = free->createJointAndBodyNodePair<FreeJoint>().second;
    Inertia inertia;
    inertia.setMass(def.mass);
    inertia.setLocalCOM(Eigen::Vector3d(0, def.offset, 0));
    inertia.setMoment(def.mass / 3 * 2e-4, def.mass / 3 * 1.25e-4, def.mass / 3 * 1.25e-4, 0, 0, 0);
    part_node->setInertia(inertia);
    add_box(*part_node, Eigen::Vector3d::Zero());
    dart->addSkeleton(free);

    host = std::make_unique<DartHost<>>(dart);
    (void)host->mirror(*part_node);
    for (std::size_t k = 0; k < 2; ++k) {
      patches[k] = host->add_patch(*pads[k], pinch_pad(k == 0 ? 1 : -1, def.spec(), def.across));
    }
  }

  [[nodiscard]] World<double>& world() override { return host->world(); }
  [[nodiscard]] std::size_t missing() override { return host->sensors().report().missing_bodies; }
  [[nodiscard]] Vec3<double> part() const override { return part_node->getCOM(); }
  [[nodiscard]] Vec3<double> pad(std::size_t k) const override {
    return pads[k]->getWorldTransform().translation();
  }
  void open(double gap, double speed) override {
    for (std::size_t k = 0; k < 2; ++k) {
      const double side = k == 0 ? 1 : -1;
      dart::dynamics::Joint* joint = pads[k]->getParentJoint();
      joint->setPosition(0, joint->getPosition(0) - side * gap);
      joint->setVelocity(0, side * speed);
    }
  }
  void step() override {
    pads[0]->getParentJoint()->setForce(0, def.squeeze);
    pads[1]->getParentJoint()->setForce(0, -def.squeeze);
    dart->setGravity(gravity);
    host->step();
  }

  dart::simulation::WorldPtr dart = std::make_shared<dart::simulation::World>();
  std::array<dart::dynamics::BodyNode*, 2> pads{};
  dart::dynamics::BodyNode* part_node = nullptr;
  std::unique_ptr<DartHost<>> host;

 private:
  void add_box(dart::dynamics::BodyNode& node, const Eigen::Vector3d& place) const {
    const auto box = std::make_shared<dart::dynamics::BoxShape>(Eigen::Vector3d(0.01, 0.02, 0.02));
    dart::dynamics::ShapeNode* shape = node.createShapeNodeWith<dart::dynamics::VisualAspect>(box);
    shape->setRelativeTranslation(place);
    if (!def.has_contacts) return;
    (void)shape->createCollisionAspect();
    shape->createDynamicsAspect()->setFrictionCoeff(def.friction);
  }
};

}  // namespace bristle::scenes
