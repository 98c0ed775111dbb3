/// @file
/// Sleep: islands at rest stop being computed, and wake when a body reaches them.
///
/// An island, here, is a set of bodies that may come to act on each other. They do so by contacts
/// within the reach of a step, by joints, or by patches with bodies in the range of their rays. The
/// same reach wakes. So an island next to a moving body does not fall asleep and wake in turns.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/disjoint_sets.hpp>
#include <bristle/core/dynamic_array.hpp>
#include <bristle/world/near_shapes.hpp>
#include <bristle/world/sensor_stage.hpp>
#include <bristle/world/solve_stage.hpp>
#include <bristle/world/waking.hpp>

#include <algorithm>

namespace bristle::inline BRISTLE_ABI::detail {

/// Wakes islands before the stages of a step, and puts islands to sleep after them.
template <Scalar S>
class SleepStage {
 public:
  using State = WorldState<S>;

  /// Wakes every island that an active body reaches in this step, and those that it reaches in
  /// turn.
  void wake_reached(State& state, SolveStage<S>& solve, const SensorStage<S>& sensors) {
    if (state.sleeping_bodies == 0) return;
    active_since_.assign(state.bodies.slot_count(), 0);
    for (round_ = 1; find_fresh(state); ++round_) {
      if (round_ > 1) {
        for (const std::uint32_t slot : fresh_) solve.prepare_body(state, slot);
      }
      if (state.sleeping_bodies == 0) continue;
      wake_by_contact(state);
      wake_by_joint(state);
      wake_by_patch(state, sensors);
    }
  }

  /// Puts islands to sleep that rested long enough.
  void fall_asleep(State& state, const SensorStage<S>& sensors) {
    const std::uint32_t asleep = state.sleeping_bodies;
    if (state.def.sleep.time < infinity<S> && measure_rest(state)) {
      connect(state, sensors);
      put_to_sleep(state);
    }
    state.report.sleeping_bodies = state.sleeping_bodies;
    state.report.awake_bodies -= state.sleeping_bodies - asleep;
    // If all bodies are awake and none was changed, no flag needs an update.
    if (!state.is_any_dirty && state.sleeping_bodies == 0) return;
    bool is_any_active = false;
    for (const std::uint32_t i : state.bodies.live_slots()) {
      state.bodies.at(i).sleep.is_dirty = false;
      is_any_active = is_any_active || state.is_active(i);
    }
    state.is_any_dirty = false;
    state.is_idle = state.sleeping_bodies > 0 && !is_any_active;
  }

 private:
  /// Collects bodies that became active since the last round.
  [[nodiscard]] bool find_fresh(const State& state) {
    fresh_.clear();
    for (const std::uint32_t i : state.bodies.live_slots()) {
      if (active_since_[i] != 0 || !state.is_active(i)) continue;
      active_since_[i] = round_;
      fresh_.push_back(i);
    }
    return !fresh_.empty();
  }

  [[nodiscard]] bool is_fresh(std::uint32_t slot) const { return active_since_[slot] == round_; }

  void wake_by_contact(State& state) {
    for (const std::uint32_t i : state.colliders.live_slots()) {
      const Collider<S>& c = state.colliders.at(i);
      if (!is_fresh(c.body.index)) continue;
      const auto visit = [&](std::uint32_t other) {
        const std::uint32_t slot = state.colliders.at(other).body.index;
        if (state.bodies.at(slot).is_asleep() && meets(state, i, other)) {
          wake_island(state, slot);
        }
        return true;
      };
      if (!c.half_space) {
        const Aabb<S> swept = swept_box(state, c);
        state.broad_phase.move(i, swept);
        state.broad_phase.overlap(swept, visit);
        continue;
      }
      for (const std::uint32_t other : state.colliders.live_slots()) visit(other);
    }
  }

  /// Returns whether two shapes push each other.
  [[nodiscard]] bool meets(State& state, std::uint32_t a, std::uint32_t b) {
    if (state.colliders.at(a).is_trigger || state.colliders.at(b).is_trigger) return false;
    ++state.report.pairs_tested;
    if (!detail::may_touch(state, a, b)) return false;
    ++state.report.pairs_collided;
    found_.clear();
    return collide_pair(state, {std::min(a, b), std::max(a, b)}, found_) == ContactStatus::ok &&
           !found_.empty();
  }

  void wake_by_joint(State& state) const {
    for (const std::uint32_t i : state.joints.live_slots()) {
      const JointDef<S>& def = state.joints.at(i).def;
      if (is_fresh(def.body_a.index)) wake_island(state, def.body_b.index);
      if (is_fresh(def.body_b.index)) wake_island(state, def.body_a.index);
    }
  }

  void wake_by_patch(State& state, const SensorStage<S>& sensors) {
    for (const std::uint32_t i : state.patches.live_slots()) {
      if (!state.is_sensing(i)) continue;
      const SensorPatch<S>& patch = state.patches.at(i);
      sensors.find_near(state, patch, near_);
      bool is_reached = is_fresh(patch.body.index);
      for (const std::uint32_t tag : near_) {
        is_reached = is_reached || is_fresh(state.colliders.at(tag).body.index);
      }
      if (!is_reached) continue;
      // A patch senses all or nothing: all bodies that it may meet must be awake.
      wake_island(state, patch.body.index);
      for (const std::uint32_t tag : near_) {
        wake_island(state, state.colliders.at(tag).body.index);
      }
    }
  }

  /// Updates the rest time of bodies. Returns whether any body has rested for long enough.
  [[nodiscard]] static bool measure_rest(State& state) {
    const SleepDef<S>& def = state.def.sleep;
    bool is_any_ready = false;
    for (const std::uint32_t i : state.bodies.live_slots()) {
      Body<S>& body = state.bodies.at(i);
      if (!body.is_dynamic() || body.is_asleep()) continue;
      const bool is_slow =
          body.twist.linear.squaredNorm() <= def.linear_speed * def.linear_speed &&
          body.twist.angular.squaredNorm() <= def.angular_speed * def.angular_speed;
      body.sleep.rest_time = is_slow ? body.sleep.rest_time + state.def.time_step : S(0);
      is_any_ready = is_any_ready || body.sleep.rest_time >= def.time;
    }
    return is_any_ready;
  }

  void connect(State& state, const SensorStage<S>& sensors) {
    sets_.reset(state.bodies.slot_count());
    is_held_awake_.assign(state.bodies.slot_count(), 0);
    const auto join = [&](std::uint32_t a, std::uint32_t b) {
      const bool is_dynamic_a = state.bodies.at(a).is_dynamic();
      const bool is_dynamic_b = state.bodies.at(b).is_dynamic();
      if (is_dynamic_a && is_dynamic_b) {
        sets_.join(a, b);
      } else if (is_dynamic_a ? state.is_active(b) : state.is_active(a)) {
        is_held_awake_[is_dynamic_a ? a : b] = 1;
      }
    };
    for (const CachedManifold<S>& m : state.contacts.manifolds()) {
      if (m.is_trigger) continue;
      const Collider<S>& a = state.colliders.at(m.shapes.a);
      const Collider<S>& b = state.colliders.at(m.shapes.b);
      if (state.drift_of(a, b) != zero<Vec3<S>>()) {
        // A body on a belt moves, however slowly.
        is_held_awake_[a.body.index] = is_held_awake_[b.body.index] = 1;
      }
      join(a.body.index, b.body.index);
    }
    for (const std::uint32_t i : state.joints.live_slots()) {
      join(state.joints.at(i).def.body_a.index, state.joints.at(i).def.body_b.index);
    }
    // All bodies in range of a patch belong together, also if the patch itself stands still.
    sensors.for_each_near([&](std::uint32_t patch, const DynamicArray<std::uint32_t>& near) {
      const std::uint32_t own = state.patches.at(patch).body.index;
      std::uint32_t anchor = own;
      for (const std::uint32_t tag : near) {
        if (state.bodies.at(anchor).is_dynamic()) break;
        anchor = state.colliders.at(tag).body.index;
      }
      join(own, anchor);
      for (const std::uint32_t tag : near) join(anchor, state.colliders.at(tag).body.index);
    });
  }

  void put_to_sleep(State& state) {
    const std::uint32_t count = state.bodies.slot_count();
    rest_time_.assign(count, infinity<S>);
    const auto is_candidate = [&](std::uint32_t i) {
      return state.bodies.is_live(i) && state.bodies.at(i).is_dynamic() &&
             !state.bodies.at(i).is_asleep();
    };
    for (std::uint32_t i = 0; i < count; ++i) {
      if (!is_candidate(i)) continue;
      S& time = rest_time_[sets_.find(i)];
      time = is_held_awake_[i] != 0 ? S(0) : std::min(time, state.bodies.at(i).sleep.rest_time);
    }
    bool has_slept = false;
    for (std::uint32_t i = 0; i < count; ++i) {
      if (!is_candidate(i) || rest_time_[sets_.find(i)] < state.def.sleep.time) continue;
      Body<S>& body = state.bodies.at(i);
      body.sleep.island = sets_.find(i);
      body.twist = {};
      ++state.sleeping_bodies;
      has_slept = true;
    }
    if (!has_slept) return;
    // Boxes shrink to the shapes at rest.
    for (const std::uint32_t i : state.colliders.live_slots()) {
      const Collider<S>& c = state.colliders.at(i);
      if (state.body_of(c).is_asleep()) state.broad_phase.move(i, box_of(state, c));
    }
  }

  /// Round, from 1, in which each body was found active; and the present round.
  DynamicArray<std::uint32_t> active_since_;
  std::uint32_t round_ = 0;
  DynamicArray<std::uint32_t> fresh_, near_;
  DynamicArray<char> is_held_awake_;
  DynamicArray<S> rest_time_;
  DisjointSets sets_;
  ContactManifolds<S> found_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
