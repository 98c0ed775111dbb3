/// @file
/// Sensors in a DART world. Opt-in: needs DART, and the target bristle::dart.
///
///     DartHost<> host(world);
///     host.mirror(*part);
///     host.add_patch(*finger, pad);
///     for (;;) host.step();  // in the place of world->step()
///
/// docs/hosts.md explains the resulting order of DART's step.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/hosts/engine_host.hpp>

#include <cstddef>
#include <cstdint>
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/BoxShape.hpp>
#include <dart/dynamics/CapsuleShape.hpp>
#include <dart/dynamics/CylinderShape.hpp>
#include <dart/dynamics/EllipsoidShape.hpp>
#include <dart/dynamics/PlaneShape.hpp>
#include <dart/dynamics/ShapeNode.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <dart/dynamics/SphereShape.hpp>
#include <dart/simulation/World.hpp>
#include <optional>
#include <utility>

namespace bristle::inline BRISTLE_ABI {

/// The skeletons of a DART world as `HostSensors` sees them. Bodies are mirrored in their own
/// frames.
template <typename Backend = AnalyticBackend>
class DartHost : public EngineHost<dart::dynamics::BodyNode*, Backend> {
  using Base = EngineHost<dart::dynamics::BodyNode*, Backend>;

 public:
  using Base::world;

  /// Shares the world, which must not be null.
  explicit DartHost(dart::simulation::WorldPtr engine) : dart_(std::move(engine)) {}

  /// Mirrors a body with its shapes for the sensors. DART's collision filters do not matter.
  /// @return The same id again for a body that is mirrored already.
  /// @throws InvalidArgument when no shape of bristle matches one of the body's.
  BodyId mirror(dart::dynamics::BodyNode& node) {
    if (const auto known = this->find(&node)) return *known;
    BodyDef<double> def;
    const bool moves = node.getSkeleton()->isMobile() && node.getNumDependentGenCoords() > 0;
    def.motion = moves ? Motion::kinematic : Motion::fixed;
    def.center_of_mass = Vec3<double>(node.getLocalCOM());
    const Transform<double> X_WB = transform(node.getWorldTransform());
    def.position = X_WB.translation;
    def.orientation = X_WB.rotation;
    for (std::size_t i = 0; i < node.getNumShapeNodes(); ++i) {
      def.shapes.push_back(shape(*node.getShapeNode(i)));
    }
    return this->insert(&node, def);
  }
  /// Adds sensors to a body, in its frame. Mirrors it if needed.
  PatchId add_patch(dart::dynamics::BodyNode& node, const PatchDef<double>& def) {
    return this->add_patch_to(&node, def, [&] { return mirror(node); });
  }

  /// A step of DART with sensors, in the place of `World::step`. Their forces join the caller's
  /// external forces.
  void step() {
    for (std::size_t i = 0; i < dart_->getNumSkeletons(); ++i) {
      if (dart_->getSkeleton(i)->isMobile()) dart_->getSkeleton(i)->computeForwardDynamics();
    }
    this->sensors().step(*this, dart_->getTimeStep());
    dart_->step();
  }

  // Interface that `HostSensors` queries.

  /// State of a body; nothing if it is not mirrored or its skeleton has left the world.
  [[nodiscard]] std::optional<HostBody<double>> body(BodyId id) const {
    if (!this->key_of(id)) return {};
    const dart::dynamics::BodyNode& node = **this->key_of(id);
    HostBody<double> state;
    // All bodies of a skeleton move each other. A skeleton that left DART's world has no index.
    state.mechanism = 0;
    while (state.mechanism < dart_->getNumSkeletons() &&
           dart_->getSkeleton(state.mechanism) != node.getSkeleton()) {
      ++state.mechanism;
    }
    if (state.mechanism == dart_->getNumSkeletons()) return {};
    state.pose = transform(node.getWorldTransform());
    state.center = node.getCOM();
    state.twist = {node.getCOMLinearVelocity(), node.getAngularVelocity()};
    // Acceleration by forces, springs, dampers and gravity, without constraints.
    state.acceleration = {node.getCOMLinearAcceleration(), node.getAngularAcceleration()};
    return state;
  }
  /// [1/kg, 1/(kg m^2)] Mobility between two bodies of one skeleton.
  [[nodiscard]] Mat6<double> mobility(BodyId i, BodyId j) const {
    const auto jacobian = [this](BodyId id) {
      const dart::dynamics::BodyNode& node = **this->key_of(id);
      const dart::math::Jacobian turned_first =
          node.getSkeleton()->getWorldJacobian(&node, node.getLocalCOM());
      dart::math::Jacobian J(6, turned_first.cols());
      J << turned_first.bottomRows<3>(), turned_first.topRows<3>();
      return J;
    };
    // DART treats springs and dampers of joints implicitly: they are part of the resistance.
    const Eigen::MatrixXd& inverse = (*this->key_of(i))->getSkeleton()->getInvAugMassMatrix();
    return jacobian(i) * inverse * jacobian(j).transpose();
  }
  /// Adds a wrench [N, N m] about the centre of mass, as an external force of the next step.
  void apply_wrench(BodyId id, const Wrench<double>& wrench) {
    dart::dynamics::BodyNode& node = **this->key_of(id);
    node.addExtForce(Eigen::Vector3d(wrench.force), node.getLocalCOM(), false, true);
    node.addExtTorque(Eigen::Vector3d(wrench.torque), false);
  }

 private:
  [[nodiscard]] static Transform<double> transform(const Eigen::Isometry3d& X) {
    const Eigen::Quaterniond q(X.linear());
    return {Quat<double>(q.w(), q.x(), q.y(), q.z()).normalized(), Vec3<double>(X.translation())};
  }
  [[nodiscard]] static ShapeDef<double> shape(const dart::dynamics::ShapeNode& node) {
    namespace shapes = dart::dynamics;
    const shapes::Shape* shape = node.getShape().get();
    ShapeDef<double> def;
    def.X_BS = transform(node.getRelativeTransform());
    if (const auto* box = dynamic_cast<const shapes::BoxShape*>(shape)) {
      def.shape = Box<double>{Vec3<double>(0.5 * box->getSize())};
    } else if (const auto* ball = dynamic_cast<const shapes::SphereShape*>(shape)) {
      def.shape = Sphere<double>{ball->getRadius()};
    } else if (const auto* capsule = dynamic_cast<const shapes::CapsuleShape*>(shape)) {
      def.shape = Capsule<double>{capsule->getRadius(), 0.5 * capsule->getHeight()};
    } else if (const auto* cylinder = dynamic_cast<const shapes::CylinderShape*>(shape)) {
      def.shape = Cylinder<double>{cylinder->getRadius(), 0.5 * cylinder->getHeight()};
    } else if (const auto* ellipsoid = dynamic_cast<const shapes::EllipsoidShape*>(shape)) {
      def.shape = Ellipsoid<double>{Vec3<double>(ellipsoid->getRadii())};
    } else if (const auto* plane = dynamic_cast<const shapes::PlaneShape*>(shape)) {
      def.shape = HalfSpace<double>{Vec3<double>(plane->getNormal()), plane->getOffset()};
    } else {
      detail::require(false, "BodyNode: shape", shape->getType().c_str(),
                      "must be a box, sphere, capsule, cylinder, ellipsoid or plane");
    }
    return def;
  }

  dart::simulation::WorldPtr dart_;
};

}  // namespace bristle::inline BRISTLE_ABI
