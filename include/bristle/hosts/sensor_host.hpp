/// @file
/// Patches of sensors in somebody else's engine.
///
/// The engine keeps its bodies, its contacts and its solver; it answers rays and takes wrenches. A
/// `HostPatch` senses, solves the patch implicitly against the free motion of the bodies it
/// touches, and hands out forces that are stable at any stiffness with a plain "add force"
/// interface.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/proximal_solver.hpp>
#include <bristle/sensors/passes.hpp>
#include <bristle/sensors/patch_contacts.hpp>
#include <bristle/sensors/patch_explicit.hpp>
#include <bristle/sensors/patch_readings.hpp>

#include <concepts>
#include <cstdint>
#include <utility>
#include <vector>

namespace bristle {

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
  HostPatch(std::uint32_t body, PatchDef<S> def)
      : patch_(make_patch(std::move(def), BodyId{body, 0}, Vec3<S>(Vec3<S>::Zero()))),
        body_(body) {}

  /// Senses, and applies to the host's bodies the mean force of the next `dt` [s], which must be
  /// the host's next step. Applies nothing that is not finite; allocates only until warm. Sensors
  /// act from the step after the one in which their rays first reach a body.
  /// @throws InvalidArgument when dt is not finite and > 0, and whatever the host throws.
  template <typename Host>
  requires SensorHost<Host, S>
  void step(Host& host, S dt) {
    detail::require_positive("dt", dt);
    sense(host, dt);
    if (patch_.contacts.empty()) {
      clear_patch(patch_);
      return;
    }
    choose_integration(dt);
    solve(dt);
    discard_what_is_not_finite();
    fill_readings<S>(patch_, bodies_.front().body.center_pose.translation, dt,
                     [](std::uint32_t number) {
                       return BodyId{number, 0};
                     });
    apply(host, dt);
  }

  /// What the sensors felt in the last step; `body` holds the host's numbers as indices.
  [[nodiscard]] PatchReading<S> reading() const { return patch_.readings.view(); }

 private:
  struct Entry {
    std::uint32_t number = 0;
    Body<S> body{};
  };

  /// Local slot of a body of the host; 0 is the patch's own.
  template <typename Host>
  std::uint32_t slot_of(const Host& host, std::uint32_t number, S dt) {
    for (std::uint32_t i = 0; i < bodies_.size(); ++i) {
      if (bodies_[i].number == number) return i;
    }
    const HostBody<S> state = host.body(number);
    Entry entry;
    entry.number = number;
    entry.body.center_pose = state.motion.pose;
    entry.body.twist = state.motion.twist;
    bodies_.push_back(entry);
    SolverBody<S> solver;
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
    solver_bodies_.push_back(solver);
    return static_cast<std::uint32_t>(bodies_.size() - 1);
  }

  template <typename Host>
  void sense(const Host& host, S dt) {
    bodies_.clear();
    solver_bodies_.clear();
    slot_of(host, body_, dt);
    patch_.hits.reset(patch_.size());
    host.cast_rays(body_, patch_.rays(S(0)), patch_.hits);
    for (std::size_t i = 0; i < patch_.size(); ++i) {
      if (patch_.hits.is_hit(i)) slot_of(host, patch_.hits.tag[i], dt);
    }
    collect_contacts(
        patch_, bodies_.front().body,
        [&](std::uint32_t number) {
          return TouchedBody<S>{&bodies_[slot_of(host, number, dt)].body, BodyId{number, 0}};
        },
        {.dt = dt, .measures_lambda = patch_.def.integration == Integration::automatic});
  }

  [[nodiscard]] std::uint32_t known_slot(std::uint32_t number) const {
    std::uint32_t i = 0;
    while (bodies_[i].number != number) ++i;
    return i;
  }

  void choose_integration(S dt) {
    S lambda = S(0);
    for (PatchPair<S>& pair : patch_.pairs) {
      if (pair.count == 0) continue;
      measure_pair(patch_, pair, solver_bodies_.front(), solver_bodies_[known_slot(pair.body_b)],
                   dt);
      lambda += pair.lambda;
    }
    const PatchDef<S>& def = patch_.def;
    for (PatchPair<S>& pair : patch_.pairs) {
      const bool can_be_implicit = def.options.law == Law::paper &&
                                   def.integration != Integration::explicit_ &&
                                   (solver_bodies_.front().is_moving() ||
                                    solver_bodies_[known_slot(pair.body_b)].is_moving());
      pair.is_implicit = can_be_implicit &&
                         (def.integration == Integration::implicit || lambda > def.explicit_below);
    }
  }

  void solve(S dt) {
    constraints_.clear();
    impulses_.assign(patch_.pairs.size(), Wrench<S>{});
    soft_numbers_.clear();
    for (std::size_t k = 0; k < patch_.pairs.size(); ++k) {
      PatchPair<S>& pair = patch_.pairs[k];
      if (pair.count == 0) continue;
      if (!pair.is_implicit) {
        impulses_[k] = explicit_impulses(patch_, pair, BodyId{pair.body_b, 0}, dt);
        continue;
      }
      start_linearisation(patch_, pair, dt);
      pair.soft = static_cast<std::uint32_t>(constraints_.soft.size());
      SoftBlock<S> block;
      block.body_b = known_slot(pair.body_b);
      block.arm_a = pair.arm_a;
      block.arm_b = pair.arm_b;
      constraints_.soft.push_back(block);
      soft_numbers_.push_back(pair.soft);
    }
    if (soft_numbers_.empty()) return;
    moving_.clear();
    for (std::uint32_t i = 0; i < solver_bodies_.size(); ++i) {
      if (solver_bodies_[i].is_moving()) moving_.push_back(i);
    }
    SolveContext<S> context;
    context.dt = dt;
    const Island island{moving_, {}, {}, soft_numbers_};
    bool is_solved = false;
    solve_in_passes(
        context.settings.max_passes, [&] { is_solved = solve_once(island, context); },
        [&](const SolvePass& pass) { return is_solved && answer(dt, pass); });
    for (std::size_t k = 0; k < patch_.pairs.size() && !is_solved; ++k) {
      if (patch_.pairs[k].is_implicit) take_back(k);
    }
  }

  /// @return Whether there is a solution.
  bool solve_once(const Island& island, const SolveContext<S>& context) {
    for (const PatchPair<S>& pair : patch_.pairs) {
      if (pair.is_implicit && pair.count > 0) {
        fill_block(pair, constraints_.soft[pair.soft]);
      }
    }
    SolveReport<S> report;
    return S(solver_.solve(island, constraints_, solver_bodies_, context, report)) < infinity<S>;
  }

  bool answer(S dt, const SolvePass& pass) {
    bool has_changed = false;
    for (std::size_t k = 0; k < patch_.pairs.size(); ++k) {
      PatchPair<S>& pair = patch_.pairs[k];
      if (!pair.is_implicit || pair.count == 0) continue;
      const PairAnswer<S> found =
          answer_motion(patch_, pair, constraints_.soft[pair.soft].motion, dt, pass);
      impulses_[k] = found.impulse;
      has_changed = found.has_changed || has_changed;
    }
    return has_changed;
  }

  void discard_what_is_not_finite() {
    for (std::size_t k = 0; k < patch_.pairs.size(); ++k) {
      if (!impulses_[k].force.allFinite() || !impulses_[k].torque.allFinite()) take_back(k);
    }
  }

  /// Takes back what pair k gave.
  void take_back(std::size_t k) {
    impulses_[k] = {};
    clear_impulses(patch_, patch_.pairs[k]);
  }

  template <typename Host>
  void apply(Host& host, S dt) const {
    for (std::size_t k = 0; k < patch_.pairs.size(); ++k) {
      const PatchPair<S>& pair = patch_.pairs[k];
      if (pair.count == 0) continue;
      const Wrench<S> on_b = (S(1) / dt) * impulses_[k];
      host.apply_wrench(body_, -on_b.shifted(-pair.arm_a));
      host.apply_wrench(pair.body_b, on_b.shifted(-pair.arm_b));
    }
  }

  SensorPatch<S> patch_;
  std::uint32_t body_;
  std::vector<Entry> bodies_;
  std::vector<SolverBody<S>> solver_bodies_;
  std::vector<std::uint32_t> moving_;
  std::vector<std::uint32_t> soft_numbers_;
  std::vector<Wrench<S>> impulses_;
  Constraints<S> constraints_;
  ProximalSolver<S> solver_;
};

}  // namespace bristle
