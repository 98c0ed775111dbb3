/// @file
/// Second stage of a step: hits of the sensors, and their forces or soft blocks.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/no_index.hpp>
#include <bristle/sensors/patch_contacts.hpp>
#include <bristle/sensors/patch_explicit.hpp>
#include <bristle/sensors/patch_readings.hpp>
#include <bristle/world/near_shapes.hpp>
#include <bristle/world/patch_rays.hpp>
#include <bristle/world/world_constants.hpp>
#include <bristle/world/world_state.hpp>

#include <algorithm>
#include <functional>
#include <utility>

namespace bristle::inline BRISTLE_ABI::detail {

/// Senses with every patch. Then chooses explicit or implicit for each touched body.
template <Scalar S>
class SensorStage {
 public:
  using State = WorldState<S>;

  /// Patch and pair of a soft block.
  struct SoftOwner {
    std::uint32_t patch = 0;
    std::uint32_t pair = 0;
  };

  /// Casts the rays of all patches with a body in range and makes their contacts.
  void sense(State& state) {
    live_.clear();
    for (const std::uint32_t i : state.patches.live_slots()) {
      if (state.is_sensing(i)) live_.push_back(i);
    }
    scratch_.resize(std::max<std::size_t>(scratch_.size(), state.patches.slot_count()));
    for (const std::uint32_t i : live_) scratch_[i].begin(state.patches.at(i));
    const bool shares = !is_serial(state.def.parallel_for);
    // Patches write only to themselves and their scratch.
    const auto task = [this, &state, shares](std::size_t k) {
      sense_patch(state, live_[k], scratch_[live_[k]], shares);
    };
    std::size_t sensors = 0;
    measures_lambda_ = false;
    for (const std::uint32_t i : live_) {
      sensors += state.patches.at(i).size();
      measures_lambda_ =
          measures_lambda_ || state.patches.at(i).def.integration == Integration::automatic;
    }
    if (live_.size() > 1 && sensors >= chosen::fewest_shared_sensors) {
      state.def.parallel_for(live_.size(), std::cref(task));
    } else {
      for (std::size_t k = 0; k < live_.size(); ++k) task(k);
    }
    if (shares) sense_shared(state);
    state.report.patches = state.patches.size();
    std::size_t awake = 0;
    for (const std::uint32_t i : live_) {
      const Scratch& scratch = scratch_[i];
      const bool is_skipped = scratch.candidates.empty() || scratch.is_dormant;
      state.report.patches_near += is_skipped ? 0u : 1u;
      state.report.rays_cast += scratch.rays_cast;
      const std::size_t asked = is_skipped ? 0 : scratch.sensors_asked;
      state.report.sensors_skipped += state.patches.at(i).size() - asked;
      // From here on only sensed patches are listed.
      if (!scratch.is_dormant) live_[awake++] = i;
    }
    live_.resize(awake);
  }

  /// Finds the shapes that the rays of a patch may meet within the step. Their tags are sorted.
  void find_near(const State& state, const SensorPatch<S>& patch,
                 DynamicArray<std::uint32_t>& out) const;

  /// Calls visit(patch, tags) for each sensed patch, with the shapes in its range.
  template <typename Visit>
  void for_each_near(Visit&& visit) const {
    for (const std::uint32_t i : live_) visit(i, scratch_[i].candidates);
  }

  /// Applies the impulses of explicit pairs to bodies and makes soft blocks of the others.
  void apply(State& state) {
    owners_.clear();
    lambda_.assign(state.solver_bodies.size(), S(0));
    for_each_pair(state, [&](SensorPatch<S>& patch, PatchPair<S>& pair, SoftOwner) {
      const SolverBody<S>& a = state.solver_bodies[patch.body.index];
      const SolverBody<S>& b = state.solver_bodies[pair.body_b];
      // Effects of several patches on one body add up. Immovable bodies connect nothing.
      if (a.is_moving()) lambda_[patch.body.index] += pair.lambda;
      if (b.is_moving()) lambda_[pair.body_b] += pair.lambda;
    });
    for_each_pair(state, [&](SensorPatch<S>& patch, PatchPair<S>& pair, SoftOwner owner) {
      if (!pair.is_implicit && needs_implicit(state, patch, pair)) {
        linearise(state, patch, scratch_[owner.patch], pair, state.def.parallel_for);
      }
      if (pair.is_implicit) {
        add_soft_block(state, patch, pair, owner);
      } else {
        apply_explicit(state, patch, pair, owner);
      }
    });
  }

  /// Soft blocks of patches among those of an island, which ascend. They come before those of
  /// joints.
  [[nodiscard]] std::span<const std::uint32_t> of_patches(
      std::span<const std::uint32_t> soft) const {
    const auto end = std::lower_bound(soft.begin(), soft.end(), owners_.size());
    return soft.first(static_cast<std::size_t>(end - soft.begin()));
  }

  /// Sums the present linear models of a soft block's sensors into it.
  void fill(State& state, std::uint32_t soft) {
    fill_block(pair_of(soft), state.constraints.soft[soft]);
  }

  /// Evaluates the impulses of a soft block's sensors. Their sum is the impulse of the block.
  /// @return True if the sensors left the state they were linearised for: another solve is needed.
  bool answer(State& state, std::uint32_t soft, const SolvePass& pass) {
    const SensorPatch<S>& patch = state.patches.at(owners_[soft].patch);
    SoftBlock<S>& block = state.constraints.soft[soft];
    const PairResponse<S> found =
        evaluate(patch, scratch_[owners_[soft].patch], pair_of(soft), block.motion,
                 state.def.time_step, pass, state.def.parallel_for);
    block.impulse = stacked(found.impulse);
    return found.has_changed;
  }

  /// Clears the impulses of a soft block's sensors.
  void discard(State& state, std::uint32_t soft) {
    set_zero(state.constraints.soft[soft].impulse);
    clear_impulses(scratch_[owners_[soft].patch], pair_of(soft));
  }

  /// Turns all impulses into readings.
  void read(State& state) {
    for (const std::uint32_t i : live_) {
      SensorPatch<S>& patch = state.patches.at(i);
      PatchScratch<S>& scratch = scratch_[i];
      patch.last_impulses.clear();
      if (scratch.pairs.empty() && !patch.was_active) continue;
      for (const PatchPair<S>& pair : scratch.pairs) {
        if (!pair.is_implicit) continue;
        patch.last_impulses.push_back(
            {state.bodies.handle(pair.body_b), state.constraints.soft[pair.soft].impulse});
      }
      state.report.sensors_bottomed_out += fill_readings<S>(
          patch, scratch, state.bodies.at(patch.body.index).center_pose.translation,
          state.def.time_step, [&](std::uint32_t slot) { return state.bodies.handle(slot); },
          state.def.parallel_for);
      state.report.sensors_touching += patch.active_count();
    }
  }

 private:
  /// Scratch memory of a patch, with the shapes in its reach and what is to be done there.
  struct Scratch : PatchScratch<S> {
    DynamicArray<std::uint32_t> candidates;
    DynamicArray<ShapeInReach<S>> shapes;
    std::uint64_t rays_cast = 0;
    /// [-] Sensors whose rays were cast, or whose hits were extrapolated.
    std::size_t sensors_asked = 0;
    bool is_dormant = false;
    /// True if threads share its rays; and if these are to be cast.
    bool is_shared = false;
    bool has_cast = false;
    /// True if the thread that casts them also finds the hit mask.
    bool knows_hit_mask = false;
  };

  /// Some rays of a patch, by its index.
  struct SharedRays {
    std::uint32_t owner = 0;
    RayRange range{};
  };

  template <typename Visit>
  void for_each_pair(State& state, Visit&& visit) {
    for (const std::uint32_t i : live_) {
      DynamicArray<PatchPair<S>>& pairs = scratch_[i].pairs;
      for (std::uint32_t k = 0; k < pairs.size(); ++k) {
        if (pairs[k].count > 0) visit(state.patches.at(i), pairs[k], SoftOwner{i, k});
      }
    }
  }
  [[nodiscard]] PatchPair<S>& pair_of(std::uint32_t soft) {
    return scratch_[owners_[soft].patch].pairs[owners_[soft].pair];
  }

  /// [m] Farthest that a body can come closer to any ray of a patch within the step.
  [[nodiscard]] S approach(const State& state, const SensorPatch<S>& patch,
                           const Collider<S>& c) const {
    if (patch.def.integration == Integration::explicit_ || patch.def.options.law == Law::ambf) {
      return S(0);
    }
    const Twist<S>& a = state.solver_bodies[patch.body.index].free;
    const Twist<S>& b = state.solver_bodies[c.body.index].free;
    const Transform<S>& X_WA = state.bodies.at(patch.body.index).center_pose;
    return state.def.time_step *
           closing_speed(patch.geometry->box, X_WA, a, state.body_of(c).center_pose.translation, b);
  }

  /// Returns whether a patch keeps its readings. True if its body or one in its range sleeps, and
  /// none is active.
  [[nodiscard]] bool is_dormant(const State& state, const SensorPatch<S>& patch,
                                const DynamicArray<std::uint32_t>& near) const {
    if (state.sleeping_bodies == 0 || state.is_active(patch.body.index)) return false;
    bool is_asleep = state.bodies.at(patch.body.index).is_asleep();
    for (const std::uint32_t tag : near) {
      const std::uint32_t slot = state.colliders.at(tag).body.index;
      if (state.is_active(slot)) return false;
      is_asleep = is_asleep || state.bodies.at(slot).is_asleep();
    }
    return is_asleep;
  }

  void sense_patch(State& state, std::uint32_t index, Scratch& scratch, bool shares) const {
    SensorPatch<S>& patch = state.patches.at(index);
    const Body<S>& A = state.bodies.at(patch.body.index);
    scratch.rays_cast = 0;
    scratch.is_shared = false;
    scratch.knows_hit_mask = false;
    find_near(state, patch, scratch.candidates);
    scratch.is_dormant = is_dormant(state, patch, scratch.candidates);
    if (scratch.is_dormant) return;
    if (scratch.candidates.empty()) {
      clear_patch(patch);
      return;
    }
    scratch.shapes.clear();
    for (const std::uint32_t tag : scratch.candidates) {
      const Collider<S>& c = state.colliders.at(tag);
      scratch.shapes.push_back(shape_in_reach(
          patch, state.colliders.handle(tag), c,
          relative_pose(A.center_pose, state.body_of(c).center_pose), approach(state, patch, c)));
    }
    const std::span<const ShapeInReach<S>> shapes(scratch.shapes);
    const bool is_due = (state.steps + index) % patch.def.cast_every == 0;
    if (shares && patch.size() >= chosen::fewest_shared_rays &&
        !patch.geometry->ray_tree.ranges().empty() &&
        shapes.front().collider->shape.asks_ranges()) {
      scratch.has_cast = needs_rays<S>(patch, scratch, shapes, is_due);
      scratch.rays_cast = scratch.has_cast ? scratch.near_count() * shapes.size() : 0;
      scratch.is_shared = true;
      if (scratch.rays_cast > 0) begin_shared(patch, scratch);
      return;
    }
    scratch.rays_cast = find_hits<S>(patch, scratch, shapes, is_due);
    // This may be a task already. The hook need not allow nested calls.
    make_contacts(state, patch, scratch, serial_);
  }

  void make_contacts(State& state, SensorPatch<S>& patch, Scratch& scratch,
                     const ParallelFor& parallel_for) const {
    scratch.sensors_asked =
        scratch.rays_cast > 0 ? static_cast<std::size_t>(scratch.rays_cast) / scratch.shapes.size()
                              : scratch.near_count();
    collect_contacts(
        patch, scratch, state.bodies.at(patch.body.index),
        [&](std::uint32_t tag) {
          const Collider<S>& c = state.colliders.at(tag);
          return TouchedBody<S>{&state.body_of(c), c.body};
        },
        {.dt = state.def.time_step,
         .measures_lambda = measures_lambda_,
         .only_tag = scratch.candidates.size() == 1 ? scratch.candidates.front() : no_index,
         .knows_hit_mask = scratch.knows_hit_mask},
        parallel_for);
    for (PatchPair<S>& pair : scratch.pairs) {
      if (pair.count == 0) continue;
      measure_pair(patch, pair, state.solver_bodies[patch.body.index],
                   state.solver_bodies[pair.body_b], state.def.time_step);
      // Linearise while the contacts are in the cache, if other patches do not matter.
      if (patch.def.integration == Integration::implicit && needs_implicit(state, patch, pair)) {
        linearise(state, patch, scratch, pair, parallel_for);
      }
    }
  }

  static void linearise(const State& state, const SensorPatch<S>& patch,
                        const PatchScratch<S>& scratch, PatchPair<S>& pair,
                        const ParallelFor& parallel_for) {
    pair.is_implicit = true;
    start_linearisation(patch, scratch, pair, state.def.time_step, parallel_for);
  }

  /// Casts the rays of large patches, range by range, and makes their contacts. If the ranges of
  /// two shapes are not the same rays, it casts at one shape after the other.
  void sense_shared(State& state) {
    for (std::size_t round = 0;; ++round) {
      shared_.clear();
      for (const std::uint32_t i : live_) {
        const Scratch& scratch = scratch_[i];
        const RayTree<S>& ray_tree = state.patches.at(i).geometry->ray_tree;
        const std::size_t rounds = ray_tree.has_packets_in_ranges() ? 1 : scratch.shapes.size();
        if (!scratch.is_shared || scratch.rays_cast == 0 || round >= rounds) continue;
        for (const RayRange& range : ray_tree.ranges()) shared_.push_back({i, range});
      }
      if (shared_.empty()) break;
      const auto task = [this, &state, round](std::size_t i) { sense_from(state, i, round); };
      state.def.parallel_for(shared_.size(), std::cref(task));
    }
    for (const std::uint32_t i : live_) {
      Scratch& scratch = scratch_[i];
      if (!scratch.is_shared) continue;
      SensorPatch<S>& patch = state.patches.at(i);
      extrapolate_hits<S>(patch, scratch, scratch.shapes, scratch.has_cast);
      make_contacts(state, patch, scratch, state.def.parallel_for);
    }
  }

  /// Does the work that must precede the cast and that ranges cannot do alone.
  static void begin_shared(SensorPatch<S>& patch, Scratch& scratch) {
    if (!patch.geometry->ray_tree.has_packets_in_ranges()) return scratch.reset_near_hits();
    // If hits are extrapolated, only the extrapolated ones count.
    scratch.knows_hit_mask = patch.def.cast_every == 1;
    if (scratch.knows_hit_mask) begin_hit_mask(patch, scratch);
  }

  /// Casts one range of a large patch's rays.
  void sense_from(State& state, std::size_t i, std::size_t round) {
    const std::uint32_t owner = shared_[i].owner;
    Scratch& scratch = scratch_[owner];
    SensorPatch<S>& patch = state.patches.at(owner);
    if (patch.geometry->ray_tree.has_packets_in_ranges()) {
      sense_range(patch, scratch, shared_[i].range);
    } else {
      cast_rays_at<S>(patch, scratch, scratch.shapes[round], shared_[i].range);
    }
  }

  /// Casts the rays of a range at all shapes, while its hits are in the cache of this thread.
  static void sense_range(SensorPatch<S>& patch, Scratch& scratch, RayRange range) {
    scratch.reset_near_hits(range);
    for (const auto& shape : scratch.shapes) cast_rays_at<S>(patch, scratch, shape, range);
    if (scratch.knows_hit_mask) find_hit_mask(patch, scratch, range);
  }

  [[nodiscard]] bool needs_implicit(const State& state, const SensorPatch<S>& patch,
                                    const PatchPair<S>& pair) const {
    const PatchDef<S>& def = patch.def;
    if (def.integration == Integration::explicit_ || def.options.law == Law::ambf) return false;
    if (!patch.can_apply_force()) return false;
    if (!state.solver_bodies[patch.body.index].is_moving() &&
        !state.solver_bodies[pair.body_b].is_moving()) {
      return false;  // Nothing to solve: both velocities are prescribed.
    }
    if (def.integration == Integration::implicit) return true;
    return std::max(lambda_[patch.body.index], lambda_[pair.body_b]) > def.explicit_below;
  }

  void apply_explicit(State& state, SensorPatch<S>& patch, const PatchPair<S>& pair,
                      SoftOwner owner) {
    ++state.report.explicit_pairs;
    const Wrench<S> sum =
        explicit_impulses(patch, scratch_[owner.patch], pair, state.bodies.handle(pair.body_b),
                          state.def.time_step, state.def.parallel_for);
    SolverBody<S>& a = state.solver_bodies[patch.body.index];
    SolverBody<S>& b = state.solver_bodies[pair.body_b];
    // Sensors in contact that give nothing change nothing.
    if (sum.force.isZero(S(0)) && sum.torque.isZero(S(0))) return;
    const auto push = [](SolverBody<S>& body, const Vec3<S>& arm, const Wrench<S>& w) {
      body.free.linear += cwise_product(body.inverse_mass, w.force);
      body.free.angular += body.inverse_inertia * (w.torque + arm.cross(w.force));
    };
    push(a, pair.arm_a, -sum);
    push(b, pair.arm_b, sum);
    a.is_sensed = b.is_sensed = true;
  }

  void add_soft_block(State& state, SensorPatch<S>& patch, PatchPair<S>& pair, SoftOwner owner) {
    ++state.report.implicit_pairs;
    pair.soft = static_cast<std::uint32_t>(state.constraints.soft.size());
    SoftBlock<S> block;
    block.body_a = patch.body.index;
    block.body_b = pair.body_b;
    block.arm_a = pair.arm_a;
    block.arm_b = pair.arm_b;
    for (const PairImpulse<S>& last : patch.last_impulses) {
      if (last.body == state.bodies.handle(pair.body_b)) block.impulse = last.impulse;
    }
    state.constraints.soft.push_back(block);
    owners_.push_back(owner);
  }

  DynamicArray<std::uint32_t> live_;
  /// By index of the patch.
  DynamicArray<Scratch> scratch_;
  DynamicArray<SharedRays> shared_;
  ParallelFor serial_ = serial_for;
  DynamicArray<S> lambda_;
  bool measures_lambda_ = false;
  DynamicArray<SoftOwner> owners_;
};

template <Scalar S>
void SensorStage<S>::find_near(const State& state, const SensorPatch<S>& patch,
                               DynamicArray<std::uint32_t>& out) const {
  out.clear();
  const Body<S>& A = state.bodies.at(patch.body.index);
  const Twist<S>& free = state.solver_bodies[patch.body.index].free;
  const S own_reach =
      state.def.time_step *
      (free.linear.norm() + free.angular.norm() * (patch.geometry->box.center().norm() +
                                                   patch.geometry->box.half_extents().norm()));
  const Aabb<S> box = transformed(patch.geometry->box, A.center_pose);
  state.broad_phase.overlap(box.inflated(own_reach), [&](std::uint32_t tag) {
    const Collider<S>& c = state.colliders.at(tag);
    if (!senses(state, patch, c)) return true;
    // The set of shapes in range must not depend on the size of the box in the tree.
    if (state.broad_phase.is_loose(tag) && !swept_box(state, c).overlaps(box.inflated(own_reach))) {
      return true;
    }
    const S extra = approach(state, patch, c);
    const bool is_near = c.half_space ? state.reaches(box.inflated(extra), c)
                                      : transformed(patch.geometry->box.inflated(extra),
                                                    state.pose_from(A, c).inverse())
                                            .overlaps(c.bounds);
    if (is_near) out.push_back(tag);
    return true;
  });
  std::sort(out.begin(), out.end());
}

}  // namespace bristle::inline BRISTLE_ABI::detail
