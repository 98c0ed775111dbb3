/// @file
/// A body near a haptic tool, predicted ahead of the world by the substeps of a loop.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/bodies/integrator.hpp>
#include <bristle/dynamics/solver/soft_block.hpp>
#include <bristle/math/elimination.hpp>
#include <bristle/math/finite.hpp>
#include <bristle/math/spatial.hpp>
#include <bristle/world/held_mobility.hpp>

namespace bristle::inline BRISTLE_ABI::detail {

/// A body as the substeps of a `HapticLoop` see it. Between steps of the world it moves by
///
///     v' = v + h W f + W sum of impulses,
///
/// where W is its `HeldMobility` and f the other force on it in the last step. Impulses of all
/// patches in contact with it are solved together and implicitly. So stiff sensors on a light body
/// are stable at any rate of substeps.
template <Scalar S>
class HapticBody {
 public:
  HapticBody() = default;
  /// @param other_force  [N, N m] Other forces on the body, about its centre of mass.
  /// @param step         [s] Step of the world.
  HapticBody(BodyId id, const Body<S>& body, const HeldMobility<S>& held,
             const Vec6<S>& other_force, S step)
      : id_(id),
        body_(body),
        held_(held),
        other_force_(other_force),
        share_((held.integrator == Integrator::trapezoidal ? S(0.5) : S(1)) * step),
        excess_(share_ - S(0.5) * step) {}

  [[nodiscard]] BodyId id() const { return id_; }
  /// Predicted state of the body.
  [[nodiscard]] const Body<S>& body() const { return body_; }
  [[nodiscard]] const HeldMobility<S>& held() const { return held_; }
  /// [N s, N m s] Impulse of all substeps about its centre of mass, world axes.
  [[nodiscard]] const Wrench<S>& impulse() const { return applied_; }

  /// [kg m/s, kg m^2/s] Momentum of a body about its centre of mass.
  [[nodiscard]] static Vec6<S> momentum(const Body<S>& body) {
    return stacked<S>(body.mass * body.twist.linear, body.angular_momentum());
  }

  /// Prepares for one substep.
  void begin_substep() {
    if (held_.is_held || !body_.moves()) return;
    set_quarter<3, 3, S>(held_.matrix, body_.inverse_inertia_W());
  }
  /// [1/kg] Mean mobility of the point at `arm` [m] from the centre of mass.
  [[nodiscard]] S mobility_at(const Vec3<S>& arm) const {
    return mean_mobility<S>(held_.matrix, arm);
  }

  /// Starts the equations of one solve.
  void clear_system() {
    set_zero(matrix_);
    set_zero(offset_);
  }
  /// Adds a patch that acts on this body as B.
  /// @param motion_a  [m/s, rad/s] Twist of A at the point c of the block.
  void add(const SoftBlock<S>& block, const Vec6<S>& motion_a) {
    const Mat6<S> G = shift_matrix<S>(block.arm_b);
    matrix_ += G.transpose() * block.matrix * G;
    offset_ += G.transpose() * (block.offset + block.matrix * motion_a);
  }
  /// Finds the twist at the end of the substep: (1 + W Q) v' = v + W (h f + q).
  void solve(S h) {
    const Vec6<S> start = stacked(body_.twist);
    end_ = start;
    if (!body_.moves()) return;
    const Mat6<S> left = identity<Mat6<S>>() + held_.matrix * matrix_;
    end_ = solved(left, start + held_.matrix * (h * other_force_ + offset_));
    if (!all_finite(end_)) end_ = start + held_.matrix * (h * other_force_);
  }
  /// Solved twist at the point c of a block.
  [[nodiscard]] Vec6<S> motion_at(const Vec3<S>& arm) const { return shift_matrix<S>(arm) * end_; }

  /// Adds an impulse about the centre of mass.
  /// @param left  [s] Time from the start of the substep to the end of the step, for which the
  ///              impulse moves the body.
  void apply_impulse(const Wrench<S>& impulse, S left) {
    const S excess = left - share_;
    applied_ += impulse;
    timed_impulse_ += excess * impulse;
  }
  /// Moves the body by one substep.
  void end_substep(S h) {
    if (body_.moves()) {
      // Forces known from the start accelerate the body evenly. All substeps share the error of the
      // world's integrator.
      const Vec6<S> motion = end_ + (excess_ - S(0.5) * h) * (held_.matrix * other_force_);
      body_.twist = twist_of<S>(end_);
      step_pose(body_, twist_of<S>(motion), h);
    } else {
      step_pose(body_, body_.twist, h);
    }
  }

  /// [m, rad] Displacement by the substeps' impulses beyond that of a constant force, due to their
  /// instants.
  [[nodiscard]] Twist<S> excess_displacement() const {
    return twist_of<S>(held_.matrix * stacked(timed_impulse_));
  }

  /// [kg m/s, kg m^2/s] Momentum of the world's body when the impulses were applied.
  Vec6<S> start_momentum = zero<Vec6<S>>();

 private:
  BodyId id_{};
  Body<S> body_{};
  HeldMobility<S> held_{};
  Vec6<S> other_force_ = zero<Vec6<S>>();
  /// [s] Time over which a force of the whole step displaces the body at its velocity change: half
  /// the step, or all of it. And the excess over half the step.
  S share_ = S(0);
  S excess_ = S(0);
  Wrench<S> applied_{};
  Wrench<S> timed_impulse_{};  // [N s^2, N m s^2]
  Mat6<S> matrix_ = zero<Mat6<S>>();
  Vec6<S> offset_ = zero<Vec6<S>>();
  Vec6<S> end_ = zero<Vec6<S>>();
};

}  // namespace bristle::inline BRISTLE_ABI::detail
