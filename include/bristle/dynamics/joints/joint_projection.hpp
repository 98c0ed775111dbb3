/// @file
/// Shortest ways back to what joints allow, in the metric of the masses.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/joints/joint_system.hpp>

#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// Closes what velocities and positions have left across joints. Scratch memory and the algorithm;
/// the system's matrix must have been factored at a place nearby.
template <Scalar S>
class JointProjection {
 public:
  /// Whether velocities across joints are more than an integration leaves. A group may arrive like
  /// that: set by the caller, or left by a step in which something hit it.
  [[nodiscard]] static bool has_open_velocities(const JointSystem<S>& system);

  /// Takes away what velocities have left across joints, as in an impact without rebound.
  /// @param impulses  [N s, N m s] The impulses that do so are added, of each joint on B about B's
  ///                  joint origin.
  void close_velocities(JointSystem<S>& system, std::span<Wrench<S>> impulses);

  /// Closes gaps by displacements that leave velocities alone, by Newton. One is enough for what a
  /// step leaves: the error after it is of the order of its square.
  /// @return False when gaps stay open.
  [[nodiscard]] bool close_gaps(JointSystem<S>& system);

  /// [m] The largest gap; turns count times the system's size.
  [[nodiscard]] S find_gaps(const JointSystem<S>& system);

  /// Closes gaps from afar: they may be as large as the mechanism. Bodies turn by half a radian in
  /// a pass at most, and each pass factors where they are, so that Newton finds its way.
  /// @param enough  [m] Gaps that count as closed, as `find_gaps` measures them.
  /// @return False when gaps stay open.
  [[nodiscard]] bool close_wide_gaps(JointSystem<S>& system, S enough);

 private:
  static void displace(JointSystem<S>& system, S share);

  std::vector<Twist<S>> wanted_;  // Relative motion of each joint that `solve` shall give.
};

/// [N s, N m s] Momentum, and angular momentum about a point, of bodies that all move by forces.
template <Scalar S>
[[nodiscard]] Wrench<S> momentum_about(const Vec3<S>& point, const JointSystem<S>& system);

/// Gives a group its momenta back. Joints give a free group none. Runge-Kutta keeps the linear one
/// but angular momentum only to its error; what is missing comes back as a motion of the group as
/// one rigid body, which no joint minds.
template <Scalar S>
void set_momentum(const Vec3<S>& point, const Wrench<S>& wanted, JointSystem<S>& system);

// Implementation -----------------------------------------------------------------------------------

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

/// Moves the bodies by a share of the change that was solved for.
template <Scalar S>
void JointProjection<S>::displace(JointSystem<S>& system, S share) {
  for (auto& node : system.nodes()) {
    if (!node.def->moves_by_forces) continue;
    node.now.x += share * node.change.linear;
    // A turn to first order, like the rest of Newton's step; the length is set right at the end.
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
  constexpr int most_passes = 8;
  const S size = system.size();
  S far2 = S(0);
  for (const auto& node : system.nodes()) far2 = max(far2, node.now.x.squaredNorm());
  const S resolved = Tolerance<S>::round_off() * sqrt(far2);
  const S closed = S(256) * Tolerance<S>::round_off() * size + resolved;
  S gap = S(0);
  for (int pass = 0; pass < most_passes; ++pass) {
    gap = find_gaps(system);
    // One pass closes gaps, and another what they have for derivatives.
    if (gap <= closed && (pass > 0 || derivatives_of<S> == 0)) return true;
    // The matrix is of a place nearby, good for gaps that are small.
    if (pass > 0 && gap > S(1e-3) * size && !system.factor()) return false;
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
  constexpr int most_passes = 32;
  const S most_turn = S(0.5);
  for (int pass = 0; pass < most_passes; ++pass) {
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
  Vec3<S> center = Vec3<S>::Zero();
  for (const auto& node : system.nodes()) {
    mass += node.def->mass;
    center += node.def->mass * (node.now.x - point);
  }
  center /= mass;
  Mat3<S> inertia = Mat3<S>::Zero();
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

}  // namespace bristle::inline BRISTLE_ABI
