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

#include <bristle/hosts/dart_shapes.hpp>
#include <bristle/hosts/engine_host.hpp>

#include <cstddef>
#include <cstdint>
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <dart/simulation/World.hpp>
#include <optional>
#include <utility>
#include <vector>

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

  /// Mirrors a body for the sensors with the shapes that it collides by, or with all that it is
  /// drawn by where it collides by none. DART's collision filters do not matter.
  /// @return The same id again for a body that is mirrored already.
  /// @throws InvalidArgument when no shape of bristle matches one of the body's, or a mesh is open.
  BodyId mirror(dart::dynamics::BodyNode& node) {
    if (const auto known = this->find(&node)) return *known;
    return mirror(node, detail::dart_shapes(node));
  }
  /// Mirrors a body with other shapes than DART's: a height map as an `extruded_mesh`.
  /// @return The same id again for a body that is mirrored already, with the shapes that it has.
  /// @throws InvalidArgument when a shape is refused.
  BodyId mirror(dart::dynamics::BodyNode& node, std::vector<ShapeDef<double>> shapes) {
    if (const auto known = this->find(&node)) return *known;
    const bool moves = node.getSkeleton()->isMobile() && node.getNumDependentGenCoords() > 0;
    return this->insert(&node, moves ? Motion::kinematic : Motion::fixed,
                        detail::dart_pose(node.getWorldTransform()),
                        Vec3<double>(node.getLocalCOM()), std::move(shapes));
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
    state.pose = detail::dart_pose(node.getWorldTransform());
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
  dart::simulation::WorldPtr dart_;
};

}  // namespace bristle::inline BRISTLE_ABI
