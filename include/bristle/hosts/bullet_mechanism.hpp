/// @file
/// A `btMultiBody` as sensors see it: motion and mobility of its links.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/hosts/bullet_conversions.hpp>
#include <bristle/math/spatial.hpp>

#include <Eigen/Core>

#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <utility>

namespace bristle::inline BRISTLE_ABI::detail {

/// Velocities, accelerations and mobility of the links of one `btMultiBody`. Link -1 is its base.
/// Twists are those of the links' centres of mass in world axes.
class BulletMechanism {
 public:
  explicit BulletMechanism(btMultiBody& mechanism) : mechanism_(&mechanism) {}

  /// The mechanism in Bullet.
  [[nodiscard]] const btMultiBody* key() const { return mechanism_; }

  /// Finds the velocities at the end of a tick of dt [s], by forces and torques that were added,
  /// gravity, damping and gyroscopic terms, without constraints. Bullet keeps what the mobility
  /// needs. The functions below need it once in each tick; more calls do nothing.
  void begin(btScalar dt) {
    if (has_begun_) return;
    has_begun_ = true;
    velocities_ = velocities();
    mechanism_->computeAccelerationsArticulatedBodyAlgorithmMultiDof(
        dt, numbers_, vectors_, matrices_, false, false, false);
    gains_ = velocities() - velocities_;
    restore();
  }
  /// Ends the tick.
  /// @return True if it was begun.
  bool end() { return std::exchange(has_begun_, false); }

  /// [m/s, rad/s] Velocity of a link.
  [[nodiscard]] Twist<double> velocity(int link) { return twist(jacobian(link) * velocities_); }
  /// [m/s, rad/s] Change of a link's velocity by the tick without constraints. The part of joints
  /// whose directions change is left out.
  [[nodiscard]] Twist<double> gain(int link) { return twist(jacobian(link) * gains_); }
  /// [1/kg, 1/(kg m^2)] Twist of link i by a unit impulse on link j: J_i M^-1 J_j^T.
  [[nodiscard]] Mat6<double> mobility(int i, int j) {
    const Jacobian pushed = jacobian(j);
    Jacobian moved(6, size());
    for (int row = 0; row < 6; ++row) {
      mechanism_->calcAccelerationDeltasMultiDof(pushed.row(row).data(), moved.row(row).data(),
                                                 numbers_, vectors_);
    }
    const Mat6<double> matrix = jacobian(i).cast<double>() * moved.transpose().cast<double>();
    if (i != j) return matrix;
    // Rounding of Bullet's numbers must not turn it into one that no mechanism has.
    return 0.5 * (matrix + matrix.transpose());
  }

 private:
  using Numbers = Eigen::Matrix<btScalar, Eigen::Dynamic, 1>;
  using Jacobian = Eigen::Matrix<btScalar, 6, Eigen::Dynamic, Eigen::RowMajor>;

  /// [-] Six numbers of the base, then those of the joints.
  [[nodiscard]] int size() const { return 6 + mechanism_->getNumDofs(); }
  [[nodiscard]] Numbers velocities() const {
    return Eigen::Map<const Numbers>(mechanism_->getVelocityVector(), size());
  }
  /// Gives Bullet back the velocities at the start of the tick.
  void restore() {
    const btScalar* v = velocities_.data();
    mechanism_->setBaseOmega(btVector3(v[0], v[1], v[2]));
    mechanism_->setBaseVel(btVector3(v[3], v[4], v[5]));
    for (int link = 0; link < mechanism_->getNumLinks(); ++link) {
      mechanism_->setJointVelMultiDof(link, v + 6 + mechanism_->getLink(link).m_dofOffset);
    }
  }
  /// From these numbers' velocities to the twist of a link's centre of mass.
  [[nodiscard]] Jacobian jacobian(int link) {
    Jacobian J(6, size());
    const btVector3 center =
        link < 0 ? mechanism_->getBasePos() : mechanism_->localPosToWorld(link, btVector3(0, 0, 0));
    for (int k = 0; k < 3; ++k) {
      btVector3 axis(0, 0, 0);
      axis[k] = 1;
      const btVector3 none(0, 0, 0);
      mechanism_->fillConstraintJacobianMultiDof(link, center, none, axis, J.row(k).data(),
                                                 numbers_, vectors_, matrices_);
      mechanism_->fillConstraintJacobianMultiDof(link, center, axis, none, J.row(3 + k).data(),
                                                 numbers_, vectors_, matrices_);
    }
    return J;
  }
  [[nodiscard]] static Twist<double> twist(const Eigen::Matrix<btScalar, 6, 1>& v) {
    return twist_of<double>(Vec6<double>(v.cast<double>()));
  }

  btMultiBody* mechanism_;
  bool has_begun_ = false;
  Numbers velocities_, gains_;
  /// Scratch memory of Bullet's functions.
  btAlignedObjectArray<btScalar> numbers_;
  btAlignedObjectArray<btVector3> vectors_;
  btAlignedObjectArray<btMatrix3x3> matrices_;
};

/// Wakes the multibody of a link. Bullet skips one of which any collider sleeps.
inline void wake(const btMultiBodyLinkCollider& link) {
  btMultiBody& body = *link.m_multiBody;
  body.wakeUp();
  if (body.getBaseCollider() != nullptr) body.getBaseCollider()->activate();
  for (int i = 0; i < body.getNumLinks(); ++i) {
    if (body.getLink(i).m_collider != nullptr) body.getLink(i).m_collider->activate();
  }
}

/// Adds a wrench [N, N m] about the centre of mass of a link, until Bullet clears its forces.
inline void add_wrench(btMultiBodyLinkCollider& link, const btVector3& force,
                       const btVector3& torque) {
  if (link.m_link < 0) {
    link.m_multiBody->addBaseForce(force);
    link.m_multiBody->addBaseTorque(torque);
  } else {
    link.m_multiBody->addLinkForce(link.m_link, force);
    link.m_multiBody->addLinkTorque(link.m_link, torque);
  }
}

}  // namespace bristle::inline BRISTLE_ABI::detail
