/// @file
/// Projection of positions and velocities onto joints. It is in the metric of the masses.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/dynamics/dynamics_constants.hpp>
#include <bristle/dynamics/joints/joint_system.hpp>

namespace bristle::inline BRISTLE_ABI::detail {

/// Closes velocities and gaps across joints. Holds the algorithm and its scratch memory. The
/// system's matrix must have been factored at nearby positions.
template <Scalar S>
class JointProjection {
 public:
  /// Returns whether velocities across joints are larger than an integration leaves. A group may
  /// arrive like that. The caller may set them, or an impact in the last step may leave them.
  [[nodiscard]] static bool has_open_velocities(const JointSystem<S>& system);

  /// Removes velocities across joints, as in an impact without rebound.
  /// @param impulses  [N s, N m s] Its impulses are added here. They are on each joint's B about
  ///                  B's joint origin.
  void close_velocities(JointSystem<S>& system, std::span<Wrench<S>> impulses);

  /// Closes gaps by displacements that leave velocities alone, by Newton's method. One pass is
  /// enough after a step. The remaining error is of the order of the square of the gap.
  /// @return False if gaps stay open.
  [[nodiscard]] bool close_gaps(JointSystem<S>& system);

  /// [m] The largest gap. Angles count times the system's size.
  [[nodiscard]] S find_gaps(const JointSystem<S>& system);

  /// Closes wide gaps, up to the size of the mechanism. Bodies turn by half a radian per pass at
  /// most. Each pass factors at the new positions. Newton's method then converges.
  /// @param enough  [m] Gaps that count as closed, as `find_gaps` measures them.
  /// @return False if gaps stay open.
  [[nodiscard]] bool close_wide_gaps(JointSystem<S>& system, S enough);

 private:
  static void displace(JointSystem<S>& system, S share);

  DynamicArray<Twist<S>> wanted_;  // Relative motion of each joint for `solve`.
};

/// [N s, N m s] Momentum, and angular momentum about a point. All bodies move by forces.
template <Scalar S>
[[nodiscard]] Wrench<S> momentum_about(const Vec3<S>& point, const JointSystem<S>& system);

/// Restores the momenta of a group. Joints do not change those of a free group. Runge-Kutta keeps
/// linear momentum, but angular momentum only to its error. The missing part is added as a motion
/// of the group as one rigid body. No joint resists that.
template <Scalar S>
void set_momentum(const Vec3<S>& point, const Wrench<S>& wanted, JointSystem<S>& system);

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
bool JointProjection<S>::has_open_velocities(const JointSystem<S>& system) {
  using std::max;
  S turning2 = S(0), speed2 = S(0), gap_v2 = S(0), gap_w2 = S(0);
  for (const auto& node : system.nodes()) {
    speed2 = max(speed2, node.now.twist.linear.squaredNorm());
    turning2 = max(turning2, node.now.twist.angular.squaredNorm());
  }
  for (std::size_t i = 0; i < system.joints().size(); ++i) {
    const Twist<S> gap =
        system.held(i, [](const auto& node) -> const Twist<S>& { return node.now.twist; });
    gap_v2 = max(gap_v2, gap.linear.squaredNorm());
    gap_w2 = max(gap_w2, gap.angular.squaredNorm());
  }
  const S size = system.size();
  const S size2 = size * size;
  const S small2 = Tolerance<S>::equal() * Tolerance<S>::equal();
  return gap_v2 + size2 * gap_w2 > small2 * (speed2 + size2 * turning2);
}

template <Scalar S>
void JointProjection<S>::close_velocities(JointSystem<S>& system, std::span<Wrench<S>> impulses) {
  wanted_.resize(impulses.size());
  for (std::size_t i = 0; i < wanted_.size(); ++i) {
    wanted_[i] = Twist<S>{} -
                 system.held(i, [](const auto& node) -> const Twist<S>& { return node.now.twist; });
  }
  system.solve(wanted_);
  for (auto& node : system.nodes()) node.now.twist = node.now.twist + node.change;
  for (std::size_t i = 0; i < impulses.size(); ++i) impulses[i] += system.wrenches()[i];
}

template <Scalar S>
S JointProjection<S>::find_gaps(const JointSystem<S>& system) {
  using std::max;
  using std::sqrt;
  const S size = system.size();
  wanted_.resize(system.joints().size());
  S gap2 = S(0);
  for (std::size_t i = 0; i < wanted_.size(); ++i) {
    const Twist<S> left = system.gap(i);
    gap2 = max(gap2, left.linear.squaredNorm() + size * size * left.angular.squaredNorm());
    wanted_[i] = Twist<S>{} - left;
  }
  return sqrt(gap2);
}

/// Moves the bodies by a share of the solved change.
template <Scalar S>
void JointProjection<S>::displace(JointSystem<S>& system, S share) {
  for (auto& node : system.nodes()) {
    if (!node.def->moves_by_forces) continue;
    node.now.x += share * node.change.linear;
    // A rotation to first order, like the rest of Newton's step. The length is corrected at the
    // end.
    const Vec3<S> half = share * node.change.angular / S(2);
    const Quat<S>& q = node.now.q;
    const Quat<S> change = Quat<S>(S(0), half.x(), half.y(), half.z()) * q;
    node.now.set_axes(Quat<S>(Eigen::Matrix<S, 4, 1>(q.coeffs() + change.coeffs())));
  }
  system.place();
}

template <Scalar S>
bool JointProjection<S>::close_gaps(JointSystem<S>& system) {
  using std::max;
  using std::sqrt;
  const S size = system.size();
  S far2 = S(0);
  for (const auto& node : system.nodes()) far2 = max(far2, node.now.x.squaredNorm());
  const S resolved = Tolerance<S>::round_off() * sqrt(far2);
  const S closed = S(chosen::closed_gap_roundings) * Tolerance<S>::round_off() * size + resolved;
  S gap = S(0);
  for (int pass = 0; pass < chosen::most_gap_passes; ++pass) {
    gap = find_gaps(system);
    // One pass closes gaps, and another one their derivatives.
    if (gap <= closed && (pass > 0 || derivatives_of<S> == 0)) return true;
    // The matrix is from nearby positions, good for small gaps.
    if (pass > 0 && gap > S(chosen::stale_matrix_gap) * size && !system.factor()) return false;
    system.solve(wanted_);
    displace(system, S(1));
    if (gap * gap <= closed * size) return true;
  }
  return gap <= Tolerance<S>::equal() * size + resolved;
}

template <Scalar S>
bool JointProjection<S>::close_wide_gaps(JointSystem<S>& system, S enough) {
  using std::max;
  using std::min;
  const S most_turn = S(chosen::most_wide_gap_turn);
  for (int pass = 0; pass < chosen::most_wide_gap_passes; ++pass) {
    if (find_gaps(system) <= enough) return true;
    if (!system.factor()) return false;
    system.solve(wanted_);
    S turn = S(0);
    for (const auto& node : system.nodes()) turn = max(turn, node.change.angular.norm());
    displace(system, turn > most_turn ? S(most_turn / turn) : S(1));
  }
  return false;
}

template <Scalar S>
Wrench<S> momentum_about(const Vec3<S>& point, const JointSystem<S>& system) {
  Wrench<S> sum;
  for (const auto& node : system.nodes()) {
    const Mat3<S>& R = node.now.R;
    const Vec3<S> p = node.def->mass * node.now.twist.linear;
    const Vec3<S> L_B = node.def->inertia_B * Vec3<S>(R.transpose() * node.now.twist.angular);
    sum += Wrench<S>{p, (node.now.x - point).cross(p) + R * L_B};
  }
  return sum;
}

template <Scalar S>
void set_momentum(const Vec3<S>& point, const Wrench<S>& wanted, JointSystem<S>& system) {
  S mass = S(0);
  Vec3<S> center = zero<Vec3<S>>();
  for (const auto& node : system.nodes()) {
    mass += node.def->mass;
    center += node.def->mass * (node.now.x - point);
  }
  center /= mass;
  Mat3<S> inertia = zero<Mat3<S>>();
  for (const auto& node : system.nodes()) {
    const Mat3<S>& R = node.now.R;
    inertia += R * node.def->inertia_B * R.transpose();
    inertia += point_inertia<S>(node.def->mass, node.now.x - point - center);
  }
  const Wrench<S> missing = (wanted + -momentum_about(point, system)).shifted(center);
  const Twist<S> motion{missing.force / mass, inverse_inertia<S>(inertia) * missing.torque};
  for (auto& node : system.nodes()) {
    node.now.twist = node.now.twist + motion.shifted(node.now.x - point - center);
  }
}

}  // namespace bristle::inline BRISTLE_ABI::detail
