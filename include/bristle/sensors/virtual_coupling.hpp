/// @file
/// A spring and a damper between a haptic device and its tool, with a bound on what the hand gets.
///
/// A tool that is moved as the device says shows the hand the stiffness of the sensors, whatever
/// the device can render. A coupling is softer than the device's limit, and the tool gives way in
/// its place. The source is Colgate, Stanley and Brown, *Issues in the haptic display of tool use*
/// (1995).
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/math/rotation.hpp>
#include <bristle/math/spatial.hpp>
#include <bristle/math/transform.hpp>
#include <bristle/math/types.hpp>

namespace bristle::inline BRISTLE_ABI {

/// Settings of a `VirtualCoupling`.
template <Scalar S>
struct CouplingDef {
  /// [N/m] Spring between device and tool. Finite, > 0.
  S stiffness = S(1000);
  /// [N s/m] Damper beside it. Finite, >= 0.
  S damping = S(5);
  /// [N m/rad] Spring against turns. Finite, > 0.
  S angular_stiffness = S(1);
  /// [N m s/rad] Damper beside it. Finite, >= 0.
  S angular_damping = S(0.005);
  /// [kg] Mass of the tool, which has no weight: the hand feels it when it accelerates the tool.
  /// More than `least_coupled_mass`. Finite, > 0.
  S mass = S(0.01);
  /// [kg m^2] Inertia of the tool, whose centre of mass is the origin of its frame, about all axes
  /// alike. Finite, > 0.
  S inertia = S(1e-5);
  /// [N] Largest force between device and tool, > 0. It may be infinite. Where it is reached the
  /// spring no longer steadies the tool, whose mass has to be enough without it. A damper of
  /// `PassivityObserver::control` comes on top of it.
  S max_force = infinity<S>;
  /// [N m] Largest torque, > 0. It may be infinite.
  S max_torque = infinity<S>;
};

/// [kg] Mass from which on a coupled tool is steady on sensors; not above 0 where the coupling
/// alone is enough.
///
/// Sensors answer a tool as if it kept its velocity over the substep, with f = -K x - (h K + B) v;
/// the coupling answers at the end of it. So x and v of a tool in a wall shrink if and only if
/// 3 h^2 K + 2 h B < 4 m + h^2 K_c + 2 h B_c (Jury's criterion). Turns are alike, with torques per
/// angle and the inertia. Sensors at an arm r move and turn a tool at once: it is steady if
/// q / m + q r^2 / I < 1, where q is the least mass without spring and damper of the coupling.
///
/// @param stiffness  [N/m] K: the largest in any direction. Sensors in contact times K_N over their
///                   length along the rays, mu_S times the normal force across.
/// @param damping    [N s/m] B: sensors in contact times K_D over their length, or times mu_V.
/// @param h          [s] Length of a substep.
/// @throws InvalidArgument naming the argument.
template <Scalar S>
[[nodiscard]] S least_coupled_mass(const CouplingDef<S>& coupling, S stiffness, S damping, S h) {
  detail::require_not_negative("stiffness", stiffness);
  detail::require_not_negative("damping", damping);
  detail::require_positive("h", h);
  return h *
         (S(3) * h * stiffness + S(2) * damping - h * coupling.stiffness -
          S(2) * coupling.damping) /
         S(4);
}

/// A tool on a spring and a damper behind a device. After `loop.move(tool, coupling.pose())`, once
/// a substep of a `HapticLoop`:
///
///     loop.substep();
///     const Wrench<S> on_hand = coupling.step(X_WD, moved, loop.wrench(tool), h);
///     device.send(observer.control(on_hand, moved, h));
///     loop.move(tool, coupling.pose(), coupling.twist());
///
/// Spring and damper are those at the end of the substep (backward Euler): they are stable at any
/// stiffness. Below the largest force and torque, and where the device keeps its velocity, they
/// give no energy in translation and in turns about one axis. Turns about changing axes may give
/// some, and a hand does not keep its velocity, hence the observer. At rest the hand feels sensors
/// and spring in series. While device and tool are apart, the moment of the damper about both is
/// left out.
template <Scalar S>
class VirtualCoupling {
 public:
  /// Starts with the tool at the device, at rest.
  /// @param X_WD  [m] Pose of the device in the world.
  /// @throws InvalidArgument naming the field, or a pose that is not finite or no rotation.
  VirtualCoupling(const CouplingDef<S>& def, const Transform<S>& X_WD);

  /// Moves the tool over one substep.
  /// @param X_WD     [m] Pose of the device at the start of the substep.
  /// @param device   [m/s, rad/s] Its velocity, which it is taken to keep. World axes.
  /// @param on_tool  [N, N m] Wrench on the tool about the origin of its frame, world axes.
  /// @param h        [s] Length of the substep. > 0.
  /// @return Wrench [N, N m] on the device, about the origin of its frame: what the tool pulls.
  /// @throws InvalidArgument when any of them is not finite; nothing has changed then.
  const Wrench<S>& step(const Transform<S>& X_WD, const Twist<S>& device, const Wrench<S>& on_tool,
                        S h);

  /// [m] Pose of the tool in the world.
  [[nodiscard]] const Transform<S>& pose() const { return pose_; }
  /// [m/s, rad/s] Velocity of the tool, world axes.
  [[nodiscard]] const Twist<S>& twist() const { return twist_; }
  /// [N, N m] Wrench on the device in the last step.
  [[nodiscard]] const Wrench<S>& wrench() const { return wrench_; }

 private:
  /// One of the two springs, with the inertia behind it.
  struct Spring {
    S stiffness, damping, inertia, largest;
  };
  /// Gives a velocity its value at the end of the substep.
  /// @param stretch  [m] or [rad] From the tool to the device.
  /// @param other    Force or torque on the tool besides that of the spring.
  /// @return Force or torque of the spring on the tool.
  static Vec3<S> pull(const Spring& spring, const Vec3<S>& stretch, const Vec3<S>& device,
                      const Vec3<S>& other, S h, Vec3<S>& velocity);

  CouplingDef<S> def_;
  Transform<S> pose_;
  Twist<S> twist_{};
  Wrench<S> wrench_{};
};

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
VirtualCoupling<S>::VirtualCoupling(const CouplingDef<S>& def, const Transform<S>& X_WD)
    : def_(def), pose_(X_WD) {
  detail::require_positive("CouplingDef::stiffness", def.stiffness);
  detail::require_not_negative("CouplingDef::damping", def.damping);
  detail::require_positive("CouplingDef::angular_stiffness", def.angular_stiffness);
  detail::require_not_negative("CouplingDef::angular_damping", def.angular_damping);
  detail::require_positive("CouplingDef::mass", def.mass);
  detail::require_positive("CouplingDef::inertia", def.inertia);
  detail::require(def.max_force > S(0), "CouplingDef::max_force", def.max_force, "must be > 0");
  detail::require(def.max_torque > S(0), "CouplingDef::max_torque", def.max_torque, "must be > 0");
  detail::require_pose("X_WD", X_WD);
  pose_.rotation = X_WD.rotation.normalized();
}

template <Scalar S>
Vec3<S> VirtualCoupling<S>::pull(const Spring& spring, const Vec3<S>& stretch,
                                 const Vec3<S>& device, const Vec3<S>& other, S h,
                                 Vec3<S>& velocity) {
  // Inertia, damper and spring resist a change of velocity over the substep.
  const S resistance = h * spring.stiffness + spring.damping;
  const S whole = spring.inertia + h * resistance;
  const Vec3<S> free = spring.stiffness * stretch + resistance * device;
  Vec3<S> next = (spring.inertia * velocity + h * (free + other)) / whole;
  Vec3<S> force = free - resistance * next;
  const S size = force.stableNorm();
  if (size > spring.largest) {
    // At its limit a spring pulls with that force, whatever the tool does.
    force *= spring.largest / size;
    next = velocity + h / spring.inertia * (force + other);
  }
  velocity = next;
  return force;
}

template <Scalar S>
const Wrench<S>& VirtualCoupling<S>::step(const Transform<S>& X_WD, const Twist<S>& device,
                                          const Wrench<S>& on_tool, S h) {
  detail::require_pose("X_WD", X_WD);
  detail::require_all_finite("device.linear", device.linear);
  detail::require_all_finite("device.angular", device.angular);
  detail::require_all_finite("on_tool.force", on_tool.force);
  detail::require_all_finite("on_tool.torque", on_tool.torque);
  detail::require_positive("h", h);
  const Vec3<S> turned = log_rotation<S>(X_WD.rotation * pose_.rotation.conjugate());
  const Vec3<S> force =
      pull({def_.stiffness, def_.damping, def_.mass, def_.max_force},
           X_WD.translation - pose_.translation, device.linear, on_tool.force, h, twist_.linear);
  const Vec3<S> torque =
      pull({def_.angular_stiffness, def_.angular_damping, def_.inertia, def_.max_torque}, turned,
           device.angular, on_tool.torque, h, twist_.angular);
  pose_.translation += h * twist_.linear;
  pose_.rotation = step_rotation<S>(pose_.rotation, twist_.angular, h);
  wrench_ = {-force, -torque};
  return wrench_;
}

}  // namespace bristle::inline BRISTLE_ABI
