// A part is pinched and lifted in DART: by DART's own contacts, and by bristle's sensors.
//
// `host.step()` takes the place of World::step.
// The table says how fast a light part and a heavy one creep out of the pads at steps from 1 to 17
// ms; the plot shows where they are between the pads.
//
// Usage: host_dart [PLOT.svg]
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/pinch.hpp"
#include "support/lifted_pinch.hpp"

#include <bristle/bristle.hpp>
#include <bristle/hosts/dart_host.hpp>

#include <array>
#include <cstddef>
#include <cstdio>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/dynamics/PrismaticJoint.hpp>
#include <exception>
#include <memory>
#include <optional>

using namespace bristle;
using namespace figure;
using namespace dart::dynamics;

namespace {

class DartPinch {
 public:
  DartPinch(const LiftedPinch& pinch, bool has_sensors) : pinch_(pinch) {
    world_->setTimeStep(pinch.dt);
    world_->setGravity({0, 0, -pinch.gravity});
    const SkeletonPtr gripper = Skeleton::create("gripper");
    lift_ = add_slide(*gripper, nullptr, "lift", 1, Eigen::Vector3d::UnitZ(), 0);
    // A spring and a damper whose rest position is the command.
    lift_->getParentJoint()->setSpringStiffness(0, 2000);
    lift_->getParentJoint()->setDampingCoefficient(0, 100);
    pads_[0] = add_slide(*gripper, lift_, "left", 0.1, Eigen::Vector3d::UnitX(), -0.0101);
    pads_[1] = add_slide(*gripper, lift_, "right", 0.1, Eigen::Vector3d::UnitX(), 0.0101);
    const SkeletonPtr free = Skeleton::create("part");
    part_ = free->createJointAndBodyNodePair<FreeJoint>().second;
    set_inertia(*part_, pinch.mass);
    for (BodyNode* node : {pads_[0], pads_[1], part_}) add_box(*node, !has_sensors);
    world_->addSkeleton(gripper);
    world_->addSkeleton(free);
    if (!has_sensors) return;
    host_.emplace(world_);
    host_->mirror(*part_);
    host_->add_patch(*pads_[0], scenes::pinch_pad(1, pinch.spec()));
    host_->add_patch(*pads_[1], scenes::pinch_pad(-1, pinch.spec()));
  }

  void step(double t) {
    lift_->getParentJoint()->setRestPosition(0, LiftedPinch::height(t));
    pads_[0]->getParentJoint()->setForce(0, pinch_.squeeze);
    pads_[1]->getParentJoint()->setForce(0, -pinch_.squeeze);
    if (host_) {
      host_->step();
    } else {
      world_->step();
    }
  }
  [[nodiscard]] double place() const {
    return part_->getWorldTransform().translation().z() -
           lift_->getWorldTransform().translation().z();
  }

 private:
  static void set_inertia(BodyNode& node, double mass) {
    Inertia inertia;
    inertia.setMass(mass);
    inertia.setMoment(mass / 3 * 2e-4, mass / 3 * 1.25e-4, mass / 3 * 1.25e-4, 0, 0, 0);
    node.setInertia(inertia);
  }
  /// A body that slides along `axis` [1], from `x` [m] beside its parent.
  static BodyNode* add_slide(Skeleton& skeleton, BodyNode* parent, const char* name, double mass,
                             const Eigen::Vector3d& axis, double x) {
    PrismaticJoint::Properties joint;
    joint.mName = name;
    joint.mAxis = axis;
    joint.mT_ParentBodyToJoint.translation().x() = x;
    BodyNode* node = skeleton
                         .createJointAndBodyNodePair<PrismaticJoint>(
                             parent, joint, BodyNode::AspectProperties(name))
                         .second;
    set_inertia(*node, mass);
    return node;
  }
  /// The box of a pad or of the part. Without collision only sensors meet it.
  void add_box(BodyNode& node, bool collides) const {
    const auto box = std::make_shared<BoxShape>(Eigen::Vector3d(0.01, 0.02, 0.02));
    ShapeNode* shape = node.createShapeNodeWith<VisualAspect>(box);
    if (!collides) return;
    shape->createCollisionAspect();
    shape->createDynamicsAspect();
    shape->getDynamicsAspect()->setFrictionCoeff(pinch_.friction);
  }

  LiftedPinch pinch_;
  dart::simulation::WorldPtr world_ = std::make_shared<dart::simulation::World>();
  BodyNode* lift_ = nullptr;
  BodyNode* part_ = nullptr;
  std::array<BodyNode*, 2> pads_{};
  std::optional<DartHost<>> host_;
};

}  // namespace

int main(int count, char** arguments) {
  try {
    const char* plot = count > 1 ? arguments[1] : "host_dart.svg";
    return compare_pinches<DartPinch>("DART", plot, 1e-9);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "host_dart: %s\n", error.what());
    return 2;
  }
}
