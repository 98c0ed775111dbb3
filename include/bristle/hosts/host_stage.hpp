/// @file
/// The step of an engine's sensors: cast rays, make contacts, and solve all of them together.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/dynamics/solver/soft_system.hpp>
#include <bristle/hosts/host_sensors.hpp>
#include <bristle/math/finite.hpp>
#include <bristle/sensors/patch_contacts.hpp>
#include <bristle/sensors/patch_explicit.hpp>
#include <bristle/sensors/patch_readings.hpp>
#include <bristle/sensors/solve_passes.hpp>
#include <bristle/world/near_shapes.hpp>
#include <bristle/world/patch_rays.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// The parts of `HostSensors::step` between queries of the engine. It holds only scratch memory.
template <Scalar S>
class HostStage {
 public:
  using State = WorldState<S>;
  using Step = HostStep<S>;

  /// Finds the hits of all patches' rays on the mirrored shapes.
  /// @param all_rays  True if the engine casts them, too: all then need room for hits.
  void cast(State& state, const Step& step, bool all_rays);
  /// Takes hits of a patch's rays by the engine where they are nearer than those on mirrored
  /// shapes. Tags are indices of bodies.
  void take_hits(std::uint32_t patch, const RayHits<S>& hits) {
    for (std::size_t i = 0; i < hits.distance.size(); ++i) {
      if (!hits.is_hit(i)) continue;
      scratch_[patch].hits.offer(i, {hits.distance[i], hits.normal[i]},
                                 first_host_tag | hits.tag[i]);
    }
  }
  /// Makes contacts from the hits, and lists the bodies that take part.
  void collect(State& state, Step& step);
  /// Solves all patches, fills readings, and lists the wrenches to apply.
  void solve(State& state, Step& step);

 private:
  using Shape = ShapeInReach<S>;

  /// A pair in contact, and its impulse on B about c [N s, N m s].
  struct Touch {
    SensorPatch<S>* patch = nullptr;
    PatchScratch<S>* scratch = nullptr;
    PatchPair<S>* pair = nullptr;
    Wrench<S> on_b{};
  };

  void find_shapes(const State& state, const Step& step, const SensorPatch<S>& patch);
  void add_bodies(const Step& step);
  void add_touches(State& state);
  void fill_blocks();
  [[nodiscard]] bool evaluate_touches(S dt, const SolvePass& pass);
  void deliver(State& state, Step& step);

  /// Calls visit(patch, scratch, pair) for all pairs in contact.
  template <typename Visit>
  void for_each_pair(State& state, Visit&& visit) {
    for (const std::uint32_t i : near_something_) {
      for (PatchPair<S>& pair : scratch_[i].pairs) {
        if (pair.count > 0) visit(state.patches.at(i), scratch_[i], pair);
      }
    }
  }

  /// By index of the patch.
  DynamicArray<PatchScratch<S>> scratch_;
  DynamicArray<Shape> shapes_;
  DynamicArray<std::uint32_t> candidates_;
  /// Indices of the patches whose rays may meet something.
  DynamicArray<std::uint32_t> near_something_;
  SoftSystem<S> system_;
  DynamicArray<Touch> touches_;
  /// Blocks of implicit pairs, by `PatchPair::soft`.
  DynamicArray<SoftBlock<S>> blocks_;
  /// By index of mirrored bodies: their index in the system, and their own mobility about the
  /// mirrored centre of mass.
  DynamicArray<std::uint32_t> number_;
  DynamicArray<Mat6<S>> own_mobility_;
};

/// The table of this file's instruction set.
template <Scalar S>
[[nodiscard]] const HostKernels<S>& own_host_kernels() {
  using Own = HostStage<S>;
  using State = WorldState<S>;
  using Step = HostStep<S>;
  static constexpr HostKernels<S> own{
      .make_scratch = []() -> void* { return new Own; },
      .delete_scratch = [](void* stage) { delete static_cast<Own*>(stage); },
      .cast = [](void* stage, State& state, const Step& step,
                 bool all_rays) { static_cast<Own*>(stage)->cast(state, step, all_rays); },
      .take_hits = [](void* stage, std::uint32_t patch,
                      const RayHits<S>& hits) { static_cast<Own*>(stage)->take_hits(patch, hits); },
      .collect = [](void* stage, State& state,
                    Step& step) { static_cast<Own*>(stage)->collect(state, step); },
      .solve = [](void* stage, State& state,
                  Step& step) { static_cast<Own*>(stage)->solve(state, step); }};
  return own;
}

template <Scalar S>
const HostKernels<S>& host_kernels() {
  return own_host_kernels<S>();
}

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
void HostStage<S>::cast(State& state, const Step& step, bool all_rays) {
  near_something_.clear();
  scratch_.resize(std::max<std::size_t>(scratch_.size(), state.patches.slot_count()));
  for (const std::uint32_t i : state.patches.live_slots()) {
    SensorPatch<S>& patch = state.patches.at(i);
    shapes_.clear();
    const bool is_sensing = step.is_sensing(state, i);
    if (is_sensing) find_shapes(state, step, patch);
    if (shapes_.empty() && !(all_rays && is_sensing)) {
      clear_patch(patch);
      continue;
    }
    near_something_.push_back(i);
    PatchScratch<S>& scratch = scratch_[i];
    scratch.begin(patch);
    if (!all_rays) {
      const bool is_due = (state.steps + i) % patch.def.cast_every == 0;
      (void)find_hits<S>(patch, scratch, shapes_, is_due);
      continue;
    }
    scratch.list_all();
    scratch.reset_near_hits();
    for (const Shape& shape : shapes_) cast_rays_at<S>(patch, scratch, shape, {});
  }
  ++state.steps;
}

/// Finds shapes that a patch may meet this step.
template <Scalar S>
void HostStage<S>::find_shapes(const State& state, const Step& step, const SensorPatch<S>& patch) {
  const Body<S>& A = state.bodies.at(patch.body.index);
  const Twist<S>& free_a = step.bodies[patch.body.index].free;
  const auto approach_of = [&](std::uint32_t slot) {
    return state.def.time_step * closing_speed(patch.geometry->box, A.center_pose, free_a,
                                               state.bodies.at(slot).center_pose.translation,
                                               step.bodies[slot].free);
  };
  const Aabb<S> box = transformed(patch.geometry->box, A.center_pose)
                          .inflated(step.reach(patch, state.def.time_step));
  candidates_.clear();
  state.broad_phase.overlap(box, [&](std::uint32_t tag) {
    candidates_.push_back(tag);
    return true;
  });
  std::sort(candidates_.begin(), candidates_.end());
  for (const std::uint32_t tag : candidates_) {
    const Collider<S>& c = state.colliders.at(tag);
    if (!step.bodies[c.body.index].is_there || !senses(state, patch, c)) continue;
    const Shape shape = shape_in_reach(patch, state.colliders.handle(tag), c,
                                       relative_pose(A.center_pose, state.body_of(c).center_pose),
                                       approach_of(c.body.index));
    if (shape.is_near(patch.geometry->box)) shapes_.push_back(shape);
  }
}

template <Scalar S>
void HostStage<S>::collect(State& state, Step& step) {
  step.touched.clear();
  const auto slot_of = [&](std::uint32_t tag) {
    return tag >= first_host_tag ? tag - first_host_tag : state.colliders.at(tag).body.index;
  };
  for (const std::uint32_t i : near_something_) {
    SensorPatch<S>& patch = state.patches.at(i);
    collect_contacts(patch, scratch_[i], state.bodies.at(patch.body.index),
                     [&](std::uint32_t tag) {
                       const BodyId id = state.bodies.handle(slot_of(tag));
                       return TouchedBody<S>{&state.bodies.at(id.index), id};
                     },
                     {.dt = state.def.time_step, .measures_lambda = false});
    if (!patch.has_hits) clear_patch(patch);
  }
  for_each_pair(state,
                [&](const SensorPatch<S>& patch, const PatchScratch<S>&, const PatchPair<S>& pair) {
                  step.touched.push_back(patch.body.index);
                  step.touched.push_back(pair.body_b);
                  ++step.report.pairs;
                });
  std::sort(step.touched.begin(), step.touched.end());
  step.touched.erase(std::unique(step.touched.begin(), step.touched.end()), step.touched.end());
}

template <Scalar S>
void HostStage<S>::solve(State& state, Step& step) {
  const S dt = state.def.time_step;
  add_bodies(step);
  add_touches(state);
  if (!blocks_.empty()) {
    step.report.passes = solve_in_passes(
        SolverDef<S>{}.max_passes,
        [this] {
          fill_blocks();
          system_.solve(blocks_);
        },
        [&](const SolvePass& pass) { return evaluate_touches(dt, pass); });
  }
  deliver(state, step);
}

/// Adds the bodies in contact to the system.
template <Scalar S>
void HostStage<S>::add_bodies(const Step& step) {
  system_.clear();
  number_.resize(step.bodies.size());
  own_mobility_.resize(step.bodies.size());
  for (const std::uint32_t slot : step.touched) {
    number_[slot] = system_.add_body(step.bodies[slot].free);
    set_zero(own_mobility_[slot]);
  }
  const auto to_mirrored = [&](std::uint32_t slot) {
    return shift_matrix<S>(step.bodies[slot].shift);
  };
  for (const HostMobility<S>& m : step.mobilities) {
    if (m.matrix.isZero(S(0))) continue;
    const Mat6<S> matrix = to_mirrored(m.from) * m.matrix * to_mirrored(m.to).transpose();
    system_.set_mobility(number_[m.from], number_[m.to], matrix);
    if (m.from == m.to) own_mobility_[m.from] = matrix;
  }
}

/// Makes a soft block of each implicit pair, and finds the impulses of the others.
template <Scalar S>
void HostStage<S>::add_touches(State& state) {
  const S dt = state.def.time_step;
  blocks_.clear();
  touches_.clear();
  for_each_pair(state, [&](SensorPatch<S>& patch, PatchScratch<S>& scratch, PatchPair<S>& pair) {
    Touch& touch = touches_.emplace_back();
    touch.patch = &patch;
    touch.scratch = &scratch;
    touch.pair = &pair;
    const std::uint32_t a = patch.body.index;
    const S mobility = mean_mobility<S>(own_mobility_[a], pair.arm_a) +
                       mean_mobility<S>(own_mobility_[pair.body_b], pair.arm_b);
    pair.is_implicit = patch.def.integration != Integration::explicit_ &&
                       patch.def.options.law == Law::paper && mobility > S(0) &&
                       patch.can_apply_force();
    if (!pair.is_implicit) {
      touch.on_b = explicit_impulses(patch, scratch, pair, state.bodies.handle(pair.body_b), dt);
      system_.apply_impulse(number_[a], -touch.on_b.shifted(-pair.arm_a));
      system_.apply_impulse(number_[pair.body_b], touch.on_b.shifted(-pair.arm_b));
      return;
    }
    set_scheme(pair, pair.stiffness.bristle_sum, pair.stiffness.viscous_sum, mobility, dt);
    start_linearisation(patch, scratch, pair, dt);
    pair.soft = static_cast<std::uint32_t>(blocks_.size());
    SoftBlock<S>& block = blocks_.emplace_back();
    block.body_a = number_[a];
    block.body_b = number_[pair.body_b];
    block.arm_a = pair.arm_a;
    block.arm_b = pair.arm_b;
  });
}

template <Scalar S>
void HostStage<S>::fill_blocks() {
  for (const Touch& touch : touches_) {
    if (touch.pair->is_implicit) fill_block(*touch.pair, blocks_[touch.pair->soft]);
  }
}

/// Evaluates all patches at the solved motion.
/// @return True if any left the state it was linearised for.
template <Scalar S>
bool HostStage<S>::evaluate_touches(S dt, const SolvePass& pass) {
  bool has_changed = false;
  for (Touch& touch : touches_) {
    if (!touch.pair->is_implicit) continue;
    const PairResponse<S> found = evaluate(*touch.patch, *touch.scratch, *touch.pair,
                                           blocks_[touch.pair->soft].motion, dt, pass);
    touch.on_b = found.impulse;
    has_changed = found.has_changed || has_changed;
  }
  return has_changed;
}

/// Turns impulses into readings and wrenches on both bodies.
template <Scalar S>
void HostStage<S>::deliver(State& state, Step& step) {
  const S dt = state.def.time_step;
  step.wrenches.clear();
  const auto apply = [&](std::uint32_t slot, const Wrench<S>& wrench) {
    if (!is_moved_by_engine(state, slot)) return;
    // From the mirrored centre of mass to the engine's.
    step.wrenches.push_back({slot, wrench.shifted(-step.bodies[slot].shift)});
  };
  for (const Touch& touch : touches_) {
    const Wrench<S> on_b = (S(1) / dt) * touch.on_b;
    if (!has_finite_square(on_b.force) || !has_finite_square(on_b.torque)) {
      clear_impulses(*touch.scratch, *touch.pair);
      ++step.report.discarded;
      continue;
    }
    apply(touch.patch->body.index, -on_b.shifted(-touch.pair->arm_a));
    apply(touch.pair->body_b, on_b.shifted(-touch.pair->arm_b));
  }
  for (const std::uint32_t i : near_something_) {
    SensorPatch<S>& patch = state.patches.at(i);
    if (!patch.has_hits && !patch.was_active) continue;
    fill_readings<S>(patch, scratch_[i], state.bodies.at(patch.body.index).center_pose.translation,
                     dt, [&](std::uint32_t slot) { return state.bodies.handle(slot); });
  }
}

}  // namespace bristle::inline BRISTLE_ABI::detail
