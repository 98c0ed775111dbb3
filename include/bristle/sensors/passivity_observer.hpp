/// @file
/// Observes the energy at a port and damps exactly the energy that comes out without having gone
/// in.
///
/// A hand on a haptic device feels any energy that a simulation makes up. The source is Hannaford
/// and Ryu, *Time-domain passivity control of haptic interfaces* (2002). They count the energy at
/// the port, where force and velocity meet. A damper acts only then, on the surplus.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/math/finite.hpp>
#include <bristle/math/spatial.hpp>

#include <algorithm>
#include <cmath>

namespace bristle::inline BRISTLE_ABI {

/// Energy that a tool has brought into whatever resists it, less the energy it got back.
///
/// The sum is that of forces held over a substep: E += -dt (f . v + tau . w). It is exact if v is
/// the mean velocity of the substep in which f acts, (x1 - x0) / dt.
///
/// `observe` counts the substeps that are over and leaves the forces alone. `control` stands
/// between simulation and device, once a substep:
///
///     loop.move(tool, X_WT);
///     loop.substep();
///     device.send(observer.control(loop.wrench(tool), moved, dt));
///
/// `moved` is the mean velocity since the last substep. The wrench sent last acted along `moved`,
/// so its energy is counted now. The wrench sent now acts along a velocity not yet known: the
/// damper assumes that the tool keeps its velocity. The substeps that follow make up for the error.
template <Scalar S>
class PassivityObserver {
 public:
  /// @param allowance  [J] Energy that may come out beyond the energy put in: the energy stored in
  ///                   the simulation at the start. Finite, >= 0.
  /// @param most       [N s/m] Strongest damper of `control` the device can render. > 0, finite.
  /// @param radius     [m] Turns rad/s into m/s where torques are damped. Finite, > 0.
  /// @throws InvalidArgument naming the argument.
  explicit PassivityObserver(S allowance = S(0), S most = S(10), S radius = S(0.05))
      : allowance_(allowance), most_(most), radius_(radius) {
    detail::require_not_negative("PassivityObserver: allowance", allowance);
    detail::require_positive("PassivityObserver: most", most);
    detail::require_positive("PassivityObserver: radius", radius);
  }

  /// Counts one substep of `dt` [s]. Skips wrenches and motions that are not finite.
  void observe(const Wrench<S>& on_tool, const Twist<S>& tool, S dt) {
    add(-dt * power(on_tool, tool));
  }

  /// Counts the substep that is over, in which the wrench sent last acted. Damps the next one if it
  /// would bring the balance below minus the allowance.
  /// @param on_tool  [N, N m] Wrench that the simulation wants to send.
  /// @param tool     [m/s, rad/s] Mean motion of the tool in the substep that is over.
  /// @return The wrench to send: `on_tool` - alpha times the velocity. alpha is the least that
  ///         keeps the balance at this velocity, and `most` at most. The part that a slow tool
  ///         cannot pay at once stays in the balance. Zero replaces a wrench that is not finite. A
  ///         motion that is not finite damps nothing.
  [[nodiscard]] Wrench<S> control(const Wrench<S>& on_tool, const Twist<S>& tool, S dt) {
    using std::isfinite;
    observe(sent_, tool, dt);
    const S taken = -dt * power(damper_, tool);
    if (isfinite(taken)) damped_ += taken;
    sent_ = damper_ = {};
    if (!detail::all_finite(on_tool.force) || !detail::all_finite(on_tool.torque)) return {};
    // A debt within round-off does not count.
    const S missing = -(energy_ - dt * power(on_tool, tool) + allowance_);
    const S speed2 = tool.linear.squaredNorm() + radius_ * radius_ * tool.angular.squaredNorm();
    if (missing > detail::Tolerance<S>::equal() * turnover_ && speed2 > S(0) && isfinite(speed2)) {
      const S alpha = std::min(missing / (dt * speed2), most_);
      damper_ = {-alpha * tool.linear, (-alpha * radius_ * radius_) * tool.angular};
    }
    sent_ = {on_tool.force + damper_.force, on_tool.torque + damper_.torque};
    return sent_;
  }

  /// [J] Energy in less energy out, by the end of the last substep that was counted.
  [[nodiscard]] S energy() const { return energy_; }
  /// [J] Lowest value of `energy` so far.
  [[nodiscard]] S lowest_energy() const { return lowest_; }
  /// [J] Energy taken out by the dampers of `control`.
  [[nodiscard]] S damped_energy() const { return damped_; }
  /// Returns whether at most the energy put in and `allowance` came out, up to the sum's round-off.
  [[nodiscard]] bool is_passive() const {
    return lowest_ >= -allowance_ - detail::Tolerance<S>::equal() * turnover_;
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
  /// Wrench that `control` sent last; its damper part.
  Wrench<S> sent_{};
  Wrench<S> damper_{};
  /// [J] Sum of the sizes of all terms, for the round-off of their sum.
  S turnover_ = S(0);
};

}  // namespace bristle::inline BRISTLE_ABI
