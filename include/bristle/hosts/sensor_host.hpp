/// @file
/// Patches of sensors in somebody else's engine.
///
/// The engine keeps its bodies, its contacts and its solver; it answers rays and takes wrenches. A
/// `HostPatch` senses, solves the patch implicitly against the free motion of the bodies it
/// touches, and hands out forces that are stable at any stiffness with a plain "add force"
/// interface.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/kernel_scratch.hpp>
#include <bristle/dynamics/solver_types.hpp>
#include <bristle/sensors/patch.hpp>

#include <concepts>
#include <cstdint>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// A body of the host, about its centre of mass, world axes.
template <Scalar S>
struct HostBody {
  /// [m] Axes and centre of mass; [m/s, rad/s] velocities.
  BodyMotion<S> motion{};
  /// [1/kg], [1/(kg m^2)] Zero for bodies that forces do not move.
  S inverse_mass = S(0);
  Mat3<S> inverse_inertia_W = Mat3<S>::Zero();
  /// [m/s^2] What the host will add by itself in the next step: gravity and applied forces, over
  /// the mass. The patch solves for the velocity at the end of the step, so what is left out here
  /// is taken for motion: a force f left out presses a stiff patch deeper by about f dt times its
  /// damping.
  Vec3<S> acceleration = Vec3<S>::Zero();
  /// [rad/s^2] The same for what turns it.
  Vec3<S> angular_acceleration = Vec3<S>::Zero();
};

/// What a patch asks of an engine. Bodies are numbers the engine chooses, below 2^32 - 1.
///
/// - `host.body(i)` is the present state of a body.
/// - `host.cast_rays(i, rays, hits)` offers to `hits` the nearest hit of each ray, with the number
///   of the body that was hit as tag. The rays start from the centre of mass of body i, along its
///   axes; body i itself is not to be hit. A ray that starts inside a body hits it at distance 0.
/// - `host.apply_wrench(i, wrench)` adds a wrench [N, N m] about the centre of mass of body i that
///   acts during the host's next step.
template <typename H, typename S>
concept SensorHost = Scalar<S> &&
    requires(H& host, const H& view, std::uint32_t body, const RayBatch<S>& rays, RayHits<S>& hits,
             const Wrench<S>& wrench) {
  { view.body(body) } -> std::same_as<HostBody<S>>;
  view.cast_rays(body, rays, hits);
  host.apply_wrench(body, wrench);
};

template <Scalar S>
class HostPatch;

/// The functions of a host's patch that are compiled for each instruction set, as `WorldKernels`.
template <Scalar S>
struct HostKernels {
  /// A new `HostSolver`, and its end.
  void* (*make_scratch)();
  void (*delete_scratch)(void* solver);
  /// `HostSolver::solve`.
  void (*solve)(void* solver, HostPatch<S>& patch, S dt);
};

/// The table that is used from here on.
template <Scalar S>
[[nodiscard]] const HostKernels<S>& host_kernels();

namespace detail {

template <Scalar S>
class HostSolver;

/// A body of the host as a patch works with it. The first one of a patch is its own.
template <Scalar S>
struct HostEntry {
  /// [-] The host's number.
  std::uint32_t number = 0;
  Body<S> body{};
  SolverBody<S> solver{};
};

}  // namespace detail

/// A patch on a body of a host.
///
/// Several patches on one body do not see each other's implicit part: with stiff grips from two
/// sides step the world of this library instead, or shorten the step.
template <Scalar S>
class HostPatch {
 public:
  /// @param body  The host's number of the patch's body.
  /// @param def   `excluded`, `sees` and `cast_every` are not used: the host's rays decide what is
  ///              met, in every step.
  /// @throws InvalidArgument naming the field.
  HostPatch(std::uint32_t body, PatchDef<S> def);

  /// Senses, and applies to the host's bodies the mean force of the next `dt` [s], which must be
  /// the host's next step. Applies nothing that is not finite; allocates only until warm. Sensors
  /// act from the step after the one in which their rays first reach a body.
  /// @throws InvalidArgument when dt is not finite and > 0, and whatever the host throws.
  template <typename Host>
  requires SensorHost<Host, S>
  void step(Host& host, S dt) {
    detail::require_positive("dt", dt);
    sense(host, dt);
    solver_.kernels().solve(solver_.get(), *this, dt);
    for (std::size_t k = 0; k < impulses_.size(); ++k) {
      const PatchPair<S>& pair = patch_.pairs[k];
      if (pair.count == 0) continue;
      const Wrench<S> on_b = (S(1) / dt) * impulses_[k];
      host.apply_wrench(body_, -on_b.shifted(-pair.arm_a));
      host.apply_wrench(pair.body_b, on_b.shifted(-pair.arm_b));
    }
  }

  /// What the sensors felt in the last step; `body` holds the host's numbers as indices.
  [[nodiscard]] PatchReading<S> reading() const { return patch_.readings.view(); }

 private:
  friend class detail::HostSolver<S>;

  template <typename Host>
  void sense(const Host& host, S dt) {
    bodies_.clear();
    note_body(host, body_, dt);
    patch_.hits.reset(patch_.size());
    host.cast_rays(body_, patch_.rays(S(0)), patch_.hits);
    for (std::size_t i = 0; i < patch_.size(); ++i) {
      if (patch_.hits.is_hit(i)) note_body(host, patch_.hits.tag[i], dt);
    }
  }

  /// Asks for the state of a body of the host, unless it is known.
  template <typename Host>
  void note_body(const Host& host, std::uint32_t number, S dt) {
    for (const detail::HostEntry<S>& entry : bodies_) {
      if (entry.number == number) return;
    }
    add_body(number, host.body(number), dt);
  }
  void add_body(std::uint32_t number, const HostBody<S>& state, S dt);

  SensorPatch<S> patch_;
  std::uint32_t body_;
  std::vector<detail::HostEntry<S>> bodies_;
  /// [N s, N m s] On B of each pair; empty where nothing was met.
  std::vector<Wrench<S>> impulses_;
  detail::KernelScratch<HostKernels<S>> solver_{host_kernels<S>()};
};

}  // namespace bristle::inline BRISTLE_ABI

// Implementation -----------------------------------------------------------------------------------

#if BRISTLE_HAS_DEFINITIONS
#include <bristle/hosts/host_solver.hpp>

namespace bristle::inline BRISTLE_ABI {

template <Scalar S>
HostPatch<S>::HostPatch(std::uint32_t body, PatchDef<S> def)
    : patch_(make_patch(std::move(def), BodyId{body, 0}, Vec3<S>(Vec3<S>::Zero()))), body_(body) {}

template <Scalar S>
void HostPatch<S>::add_body(std::uint32_t number, const HostBody<S>& state, S dt) {
  detail::HostEntry<S>& entry = bodies_.emplace_back();
  entry.number = number;
  entry.body.center_pose = state.motion.pose;
  entry.body.twist = state.motion.twist;
  SolverBody<S>& solver = entry.solver;
  solver.start = solver.free = state.motion.twist;
  if (state.inverse_mass > S(0)) {
    solver.inverse_mass.setConstant(state.inverse_mass);
    solver.moves = true;
    solver.mass = S(1) / state.inverse_mass;
    solver.inverse_inertia = state.inverse_inertia_W;
    solver.inertia = inverse_inertia<S>(state.inverse_inertia_W);
    solver.free.linear += dt * state.acceleration;
    solver.free.angular += dt * state.angular_acceleration;
  }
  solver.twist = solver.free;
}

}  // namespace bristle::inline BRISTLE_ABI
#endif

#if defined(BRISTLE_COMPILED) && BRISTLE_HAS_DEFINITIONS
namespace bristle::inline BRISTLE_ABI {

template <>
const HostKernels<float>& host_kernels<float>();
template <>
const HostKernels<double>& host_kernels<double>();
extern template class HostPatch<float>;
extern template class HostPatch<double>;

}  // namespace bristle::inline BRISTLE_ABI
#endif
