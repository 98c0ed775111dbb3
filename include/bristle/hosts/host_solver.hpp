/// @file
/// What a patch in somebody else's engine does in a step, once the host has said what its rays met.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/proximal_solver.hpp>
#include <bristle/hosts/sensor_host.hpp>
#include <bristle/math/finite.hpp>
#include <bristle/sensors/passes.hpp>
#include <bristle/sensors/patch_contacts.hpp>
#include <bristle/sensors/patch_explicit.hpp>
#include <bristle/sensors/patch_readings.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace bristle::inline BRISTLE_ABI {
namespace detail {

/// Finds the impulses of a `HostPatch` and its readings. It holds scratch memory only.
template <Scalar S>
class HostSolver {
 public:
  /// Fills `host.impulses_`, which are finite, and the readings. The hits are this step's, and all
  /// bodies they name are known.
  void solve(HostPatch<S>& host, S dt);

 private:
  /// Index of a body of the host.
  [[nodiscard]] static std::uint32_t slot_of(const HostPatch<S>& host, std::uint32_t number) {
    std::uint32_t i = 0;
    while (host.bodies_[i].number != number) ++i;
    return i;
  }

  void choose_integration(HostPatch<S>& host, S dt) const;
  void find_impulses(HostPatch<S>& host, S dt);
  [[nodiscard]] bool solve_once(const SensorPatch<S>& patch, const Island& island,
                                const SolveContext<S>& context);
  [[nodiscard]] bool answer(HostPatch<S>& host, S dt, const SolvePass& pass);
  static void discard_what_is_not_finite(HostPatch<S>& host);

  /// Takes back what pair k gave.
  static void take_back(HostPatch<S>& host, std::size_t k) {
    host.impulses_[k] = {};
    clear_impulses(host.patch_, host.patch_.pairs[k]);
  }

  std::vector<SolverBody<S>> bodies_;
  std::vector<std::uint32_t> moving_;
  std::vector<std::uint32_t> soft_numbers_;
  Constraints<S> constraints_;
  ProximalSolver<S> solver_;
};

}  // namespace detail

/// The table of this file's instruction set.
template <Scalar S>
[[nodiscard]] const HostKernels<S>& own_host_kernels() {
  using Own = detail::HostSolver<S>;
  static constexpr HostKernels<S> own{
      .make_scratch = []() -> void* { return new Own; },
      .delete_scratch = [](void* solver) { delete static_cast<Own*>(solver); },
      .solve = [](void* solver, HostPatch<S>& patch,
                  S dt) { static_cast<Own*>(solver)->solve(patch, dt); }};
  return own;
}

template <Scalar S>
const HostKernels<S>& host_kernels() {
  return own_host_kernels<S>();
}

// Implementation -----------------------------------------------------------------------------------

namespace detail {

template <Scalar S>
void HostSolver<S>::solve(HostPatch<S>& host, S dt) {
  SensorPatch<S>& patch = host.patch_;
  collect_contacts(
      patch, host.bodies_.front().body,
      [&](std::uint32_t number) {
        return TouchedBody<S>{&host.bodies_[slot_of(host, number)].body, BodyId{number, 0}};
      },
      {.dt = dt, .measures_lambda = patch.def.integration == Integration::automatic});
  host.impulses_.clear();
  if (patch.contacts.empty()) {
    clear_patch(patch);
    return;
  }
  bodies_.clear();
  for (const HostEntry<S>& entry : host.bodies_) bodies_.push_back(entry.solver);
  choose_integration(host, dt);
  find_impulses(host, dt);
  discard_what_is_not_finite(host);
  fill_readings<S>(patch, host.bodies_.front().body.center_pose.translation, dt,
                   [](std::uint32_t number) {
                     return BodyId{number, 0};
                   });
}

template <Scalar S>
void HostSolver<S>::choose_integration(HostPatch<S>& host, S dt) const {
  SensorPatch<S>& patch = host.patch_;
  S lambda = S(0);
  for (PatchPair<S>& pair : patch.pairs) {
    if (pair.count == 0) continue;
    measure_pair(patch, pair, bodies_.front(), bodies_[slot_of(host, pair.body_b)], dt);
    lambda += pair.lambda;
  }
  const PatchDef<S>& def = patch.def;
  for (PatchPair<S>& pair : patch.pairs) {
    const bool can_be_implicit =
        def.options.law == Law::paper && def.integration != Integration::explicit_ &&
        (bodies_.front().is_moving() || bodies_[slot_of(host, pair.body_b)].is_moving());
    pair.is_implicit = can_be_implicit &&
                       (def.integration == Integration::implicit || lambda > def.explicit_below);
  }
}

template <Scalar S>
void HostSolver<S>::find_impulses(HostPatch<S>& host, S dt) {
  SensorPatch<S>& patch = host.patch_;
  constraints_.clear();
  host.impulses_.assign(patch.pairs.size(), Wrench<S>{});
  soft_numbers_.clear();
  for (std::size_t k = 0; k < patch.pairs.size(); ++k) {
    PatchPair<S>& pair = patch.pairs[k];
    if (pair.count == 0) continue;
    if (!pair.is_implicit) {
      host.impulses_[k] = explicit_impulses(patch, pair, BodyId{pair.body_b, 0}, dt);
      continue;
    }
    start_linearisation(patch, pair, dt);
    pair.soft = static_cast<std::uint32_t>(constraints_.soft.size());
    SoftBlock<S> block;
    block.body_b = slot_of(host, pair.body_b);
    block.arm_a = pair.arm_a;
    block.arm_b = pair.arm_b;
    constraints_.soft.push_back(block);
    soft_numbers_.push_back(pair.soft);
  }
  if (soft_numbers_.empty()) return;
  moving_.clear();
  for (std::uint32_t i = 0; i < bodies_.size(); ++i) {
    if (bodies_[i].is_moving()) moving_.push_back(i);
  }
  SolveContext<S> context;
  context.dt = dt;
  const Island island{moving_, {}, {}, soft_numbers_};
  bool is_solved = false;
  solve_in_passes(
      context.settings.max_passes, [&] { is_solved = solve_once(patch, island, context); },
      [&](const SolvePass& pass) { return is_solved && answer(host, dt, pass); });
  for (std::size_t k = 0; k < patch.pairs.size() && !is_solved; ++k) {
    if (patch.pairs[k].is_implicit) take_back(host, k);
  }
}

/// @return Whether there is a solution.
template <Scalar S>
bool HostSolver<S>::solve_once(const SensorPatch<S>& patch, const Island& island,
                               const SolveContext<S>& context) {
  for (const PatchPair<S>& pair : patch.pairs) {
    if (pair.is_implicit && pair.count > 0) fill_block(pair, constraints_.soft[pair.soft]);
  }
  SolveReport<S> report;
  return S(solver_.solve(island, constraints_, bodies_, context, report)) < infinity<S>;
}

template <Scalar S>
bool HostSolver<S>::answer(HostPatch<S>& host, S dt, const SolvePass& pass) {
  bool has_changed = false;
  for (std::size_t k = 0; k < host.patch_.pairs.size(); ++k) {
    PatchPair<S>& pair = host.patch_.pairs[k];
    if (!pair.is_implicit || pair.count == 0) continue;
    const PairAnswer<S> found =
        answer_motion(host.patch_, pair, constraints_.soft[pair.soft].motion, dt, pass);
    host.impulses_[k] = found.impulse;
    has_changed = found.has_changed || has_changed;
  }
  return has_changed;
}

template <Scalar S>
void HostSolver<S>::discard_what_is_not_finite(HostPatch<S>& host) {
  for (std::size_t k = 0; k < host.patch_.pairs.size(); ++k) {
    const Wrench<S>& impulse = host.impulses_[k];
    if (!all_finite(impulse.force) || !all_finite(impulse.torque)) take_back(host, k);
  }
}

}  // namespace detail
}  // namespace bristle::inline BRISTLE_ABI
