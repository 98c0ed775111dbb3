/// @file
/// Watches a port for energy that comes out without having gone in, and damps just that away.
///
/// A hand on a haptic device feels whatever a simulation makes up. Hannaford and Ryu, *Time-domain
/// passivity control of haptic interfaces* (2002), count the energy at the port, where force and
/// velocity meet, and take out what is too much by a damper that is there only then.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/math/finite.hpp>
#include <bristle/math/spatial.hpp>

#include <algorithm>
#include <cmath>

namespace bristle::inline BRISTLE_ABI {

/// Energy that a tool has brought into whatever resists it, less what it got back.
///
/// The sum is that of forces held over a tick: E += -dt (f . v + tau . w). It is exact where v is
/// the mean velocity of the tick in which f acts, (x1 - x0) / dt.
///
/// Either `observe` counts the ticks that are over, and leaves the forces alone; or `control`
/// stands between simulation and device, once a tick:
///
///     loop.move(tool, X_WT);
///     loop.tick();
///     device.send(observer.control(loop.wrench(tool), moved, dt));
///
/// where `moved` is the mean velocity since the last tick. What was sent then acted along it, and
/// is counted now; what is sent now will act along a velocity that nobody knows yet, so the damper
/// is that for a tool that keeps its velocity, and what that misses is paid in the ticks that
/// follow.
template <Scalar S>
class PassivityObserver {
 public:
  /// @param allowance  [J] Energy that may come out beyond what went in: what was stored in the
  ///                   simulation at the start. Finite, >= 0.
  /// @param most       [N s/m] The strongest damper of `control`: what the device can take.
  ///                   Finite, > 0.
  /// @param radius     [m] Turns rad/s into m/s where torques are damped. Finite, > 0.
  /// @throws InvalidArgument naming the argument.
  explicit PassivityObserver(S allowance = S(0), S most = S(10), S radius = S(0.05))
      : allowance_(allowance), most_(most), radius_(radius) {
    detail::require_not_negative("PassivityObserver: allowance", allowance);
    detail::require_positive("PassivityObserver: most", most);
    detail::require_positive("PassivityObserver: radius", radius);
  }

  /// Counts one tick of `dt` [s]. A wrench or motion that is not finite is not counted.
  void observe(const Wrench<S>& on_tool, const Twist<S>& tool, S dt) {
    add(-dt * power(on_tool, tool));
  }

  /// Counts the tick that is over, in which the wrench that was sent last acted, and damps the next
  /// one where it would bring the balance below minus the allowance.
  /// @param on_tool  [N, N m] What the simulation wants to send.
  /// @param tool     [m/s, rad/s] Mean motion of the tool in the tick that is over.
  /// @return The wrench to send: `on_tool` - alpha times the velocity, with the least alpha that
  ///         keeps the balance at this velocity, `most` at most. What a slow tool cannot be made to
  ///         pay at once stays in the balance. A wrench that is not finite is not sent: zero is;
  ///         nothing is damped by a motion that is not.
  [[nodiscard]] Wrench<S> control(const Wrench<S>& on_tool, const Twist<S>& tool, S dt) {
    using std::isfinite;
    observe(sent_, tool, dt);
    const S taken = -dt * power(damper_, tool);
    if (isfinite(taken)) damped_ += taken;
    sent_ = damper_ = {};
    if (!all_finite(on_tool.force) || !all_finite(on_tool.torque)) return {};
    // What the rounding of the balance owes is no debt.
    const S missing = -(energy_ - dt * power(on_tool, tool) + allowance_);
    const S speed2 = tool.linear.squaredNorm() + radius_ * radius_ * tool.angular.squaredNorm();
    if (missing > Tolerance<S>::equal() * turnover_ && speed2 > S(0) && isfinite(speed2)) {
      const S alpha = std::min(missing / (dt * speed2), most_);
      damper_ = {-alpha * tool.linear, (-alpha * radius_ * radius_) * tool.angular};
    }
    sent_ = {on_tool.force + damper_.force, on_tool.torque + damper_.torque};
    return sent_;
  }

  /// [J] What went in less what came out, by the end of the last tick that was counted.
  [[nodiscard]] S energy() const { return energy_; }
  /// [J] The lowest that `energy` has been.
  [[nodiscard]] S lowest_energy() const { return lowest_; }
  /// [J] What the dampers of `control` have taken out.
  [[nodiscard]] S damped_energy() const { return damped_; }
  /// Whether no more has come out than went in and was allowed, up to the sum's round-off.
  [[nodiscard]] bool is_passive() const {
    return lowest_ >= -allowance_ - Tolerance<S>::equal() * turnover_;
  }

 private:
  static S power(const Wrench<S>& on_tool, const Twist<S>& tool) {
    return on_tool.force.dot(tool.linear) + on_tool.torque.dot(tool.angular);
  }
  void add(S work) {
    using std::abs;
    using std::isfinite;
    if (!isfinite(work)) return;
    energy_ += work;
    turnover_ += abs(work);
    lowest_ = std::min(lowest_, energy_);
  }

  S allowance_, most_, radius_;
  S energy_ = S(0);
  S lowest_ = S(0);
  S damped_ = S(0);
  /// What `control` sent last, and the damper's part of it.
  Wrench<S> sent_{};
  Wrench<S> damper_{};
  /// [J] Sum of the sizes of all terms, for the round-off of their sum.
  S turnover_ = S(0);
};

}  // namespace bristle::inline BRISTLE_ABI
