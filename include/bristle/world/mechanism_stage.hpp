/// @file
/// The joint stage of a step: rows of joints, and mechanisms that follow their own smooth motion.
///
/// `MechanismIntegrator` moves bodies that only joints act on, and keeps their energy. Contacts on
/// them take that motion as free motion. The impulses of contacts, and the joints' response to
/// them, come on top.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/no_index.hpp>
#include <bristle/dynamics/joints/joint_pose.hpp>
#include <bristle/dynamics/joints/joint_projection.hpp>
#include <bristle/dynamics/joints/joint_rows.hpp>
#include <bristle/dynamics/joints/mechanism_integrator.hpp>
#include <bristle/dynamics/solver/island_solver.hpp>
#include <bristle/world/joint_stage.hpp>
#include <bristle/world/world_constants.hpp>
#include <bristle/world/world_state.hpp>

#include <algorithm>

namespace bristle::inline BRISTLE_ABI::detail {

/// Constrains the bodies of joints, and moves the mechanisms, one island at a time.
template <Scalar S>
class MechanismStage final : public JointStage<S> {
 public:
  using State = WorldState<S>;

  void add_constraints(State& state) override {
    begin_step(state);
    for (const std::uint32_t i : state.joints.live_slots()) {
      if (!is_awake_joint(state, i)) continue;
      Joint<S>& joint = state.joints.at(i);
      add_joint_rows(joint, i, state.bodies.at(joint.def.body_a.index),
                     state.bodies.at(joint.def.body_b.index), state.def.time_step,
                     state.constraints);
      const JointGap<S> gap = joint_gap(joint, state.constraints);
      state.report.joint_gap = std::max(state.report.joint_gap, gap.distance);
      state.report.joint_tilt = std::max(state.report.joint_tilt, gap.angle);
      const S arm2 = std::max(joint.X_CmA_J.translation.squaredNorm(),
                              joint.X_CmB_J.translation.squaredNorm());
      const S wide = S(chosen::wide_joint_gap);
      is_open_[i] = arm2 > S(0) && gap.distance * gap.distance > wide * wide * arm2;
    }
  }

  bool follow(State& state, const Island& island, const SolveContext<S>& context) override {
    return applies_to(state, island, context) && advance(state, island);
  }

  /// Rows that follow their mechanism are at their instants already.
  void time_rows(State& state, const Island& island, const SolveContext<S>& context) override {
    if (context.is_large()) return;
    for (const std::uint32_t i : island.blocks) {
      const ConstraintBlock<S>& block = state.constraints.blocks[i];
      if (block.kind != BlockKind::equality || state.solver_bodies[block.body_a].follows_joints ||
          state.solver_bodies[block.body_b].follows_joints) {
        continue;
      }
      time_joint_rows(state.joints.at(block.joint), state.bodies.at(block.body_a),
                      state.bodies.at(block.body_b), context.integrator, context.dt,
                      state.constraints);
    }
  }

  void close_wide_gaps(State& state, const Island& island) override {
    if (!has_joints(island, state.constraints)) return;
    if (!has_open_joints(state, island) && !has_far_turns(state, island)) return;
    find_groups(state, island);
    for (const std::uint32_t slot : island.bodies) {
      if (parent_[slot] == slot && gather(state, island, slot)) close_wide_gaps(state);
    }
  }

  void move(Body<S>& body, const SolverBody<S>& solved, std::uint32_t slot, S dt) const override {
    const Twist<S> rest = solved.motion - mean_motions_[slot];
    body.center_pose = end_poses_[slot];
    body.center_pose.translation += dt * rest.linear;
    if (rest.angular != zero<Vec3<S>>()) {
      body.center_pose.rotation = step_rotation(body.center_pose.rotation, rest.angular, dt);
    }
  }

  void store_impulses(State& state) const override {
    for (const std::uint32_t i : state.joints.live_slots()) {
      if (!is_awake_joint(state, i)) continue;
      store_joint_impulses(state.joints.at(i), state.constraints);
      if (has_mechanism_) state.joints.at(i).total += joint_impulses_[i];
    }
  }

  void follow_angles(State& state) const override {
    for (const std::uint32_t i : state.joints.live_slots()) {
      if (!is_awake_joint(state, i)) continue;
      Joint<S>& joint = state.joints.at(i);
      if (!has_angle(joint.def.kind)) continue;
      const std::uint32_t a = joint.def.body_a.index;
      const std::uint32_t b = joint.def.body_b.index;
      const Body<S>& body_a = state.bodies.at(a);
      const Body<S>& body_b = state.bodies.at(b);
      joint.angle =
          tracked_position(joint, joint_pose(joint, body_a.center_pose, body_b.center_pose),
                           {state.solver_bodies[a].start, body_a.twist},
                           {state.solver_bodies[b].start, body_b.twist}, state.def.time_step);
    }
  }

 private:
  [[nodiscard]] static bool is_awake_joint(const State& state, std::uint32_t index) {
    if (!state.joints.is_live(index)) return false;
    const JointDef<S>& def = state.joints.at(index).def;
    return !state.bodies.at(def.body_a.index).is_asleep() &&
           !state.bodies.at(def.body_b.index).is_asleep();
  }

  /// Clears the mechanisms of the last step.
  void begin_step(const State& state) {
    has_mechanism_ = false;
    if (state.joints.size() == 0) return;
    end_poses_.resize(std::max<std::size_t>(end_poses_.size(), state.bodies.slot_count()));
    parent_.resize(std::max<std::size_t>(parent_.size(), state.bodies.slot_count()));
    local_.resize(std::max<std::size_t>(local_.size(), state.bodies.slot_count()), no_index);
    contact_impulses_.assign(end_poses_.size(), Wrench<S>{});
    mean_motions_.resize(end_poses_.size());
    is_open_.assign(state.joints.slot_count(), false);
    responses_.assign(state.joints.slot_count(), Wrench<S>{});
    joint_impulses_.assign(state.joints.slot_count(), Wrench<S>{});
  }

  /// Returns whether an island has a mechanism whose motion may be integrated. Motors and active
  /// limits rule it out: they are decisions of a step, not forces. So do springs that are stiff for
  /// the step, and sensors, whose law is integrated with symplectic Euler. Inactive limits are
  /// harmless unless contacts may push there.
  [[nodiscard]] static bool applies_to(const State& state, const Island& island,
                                       const SolveContext<S>& context) {
    if (!has_joints(island, state.constraints)) return false;
    if (state.def.integrator != Integrator::trapezoidal) return false;
    bool has_limits = false;
    std::size_t springs = 0;
    for (const std::uint32_t i : island.blocks) {
      const ConstraintBlock<S>& block = state.constraints.blocks[i];
      if (!block.is_of_joint()) continue;
      if (block.kind == BlockKind::equality) {
        const Joint<S>& joint = state.joints.at(block.joint);
        springs += joint.is_sprung && joint.is_resolved ? 1u : 0u;
        continue;
      }
      const ConstraintRow<S>& row = state.constraints.rows[block.first];
      const bool is_free =
          block.kind == BlockKind::limit && row.impulse == S(0) && row.error > S(0);
      if (!is_free) return false;
      has_limits = true;
    }
    if (springs != island.soft.size()) return false;  // The others are stiff springs or patches.
    if (!island.contacts.empty() && (has_limits || context.is_large())) return false;
    return std::none_of(island.bodies.begin(), island.bodies.end(),
                        [&](std::uint32_t slot) { return state.solver_bodies[slot].is_sensed; });
  }

  /// Integrates the mechanisms of an island. Sets the free velocities and displacements of its
  /// bodies, and turns the rows of its joints to their end poses.
  /// @return False when that failed or passed a limit: the island is then as before.
  bool advance(State& state, const Island& island) {
    find_groups(state, island);
    saved_.clear();
    for (const std::uint32_t slot : island.bodies) saved_.push_back(state.solver_bodies[slot]);
    if ((!lean(state, island) && !advance_groups(state, island)) || !keeps_limits(state, island)) {
      restore(state, island);
      return false;
    }
    has_mechanism_ = true;
    for (const std::uint32_t i : island.blocks) {
      if (state.constraints.blocks[i].kind != BlockKind::equality) continue;
      const Joint<S>& joint = state.joints.at(state.constraints.blocks[i].joint);
      if (joint.is_sprung) set_zero(state.constraints.soft[joint.soft_block].impulse);
      const std::uint32_t a = joint.def.body_a.index;
      const std::uint32_t b = joint.def.body_b.index;
      turn_joint_rows(joint, end_pose(state, a), end_pose(state, b), mean_motion_of(state, a),
                      mean_motion_of(state, b), state.def.time_step, state.constraints);
      const Wrench<S>& response = responses_[state.constraints.blocks[i].joint];
      for (std::uint32_t r = 0; r < state.constraints.blocks[i].count; ++r) {
        ConstraintRow<S>& row = state.constraints.rows[state.constraints.blocks[i].first + r];
        row.impulse = row.direction.isZero(S(0)) ? row.angular_b.dot(response.torque)
                                                 : row.direction.dot(response.force);
      }
    }
    return true;
  }

  /// Lets mechanisms move with what holds them.
  /// @return False if nothing does, or if impulses that go on as they were spin light bodies. The
  ///         island is then as before.
  [[nodiscard]] bool lean(State& state, const Island& island) {
    if (!find_contact_impulses(state, island)) return false;
    if (advance_groups(state, island) && !turn_far(state, island)) return true;
    restore(state, island);
    for (const std::uint32_t slot : island.bodies) contact_impulses_[slot] = {};
    return false;
  }

  /// Sums the impulses of the last step that contacts are expected to repeat, by body. A mechanism
  /// that leans on something moves little. Without what holds it, it would fall in its free motion,
  /// and contacts would have to push it back along the directions at the end of that fall.
  /// @return True if there are any.
  [[nodiscard]] bool find_contact_impulses(const State& state, const Island& island) {
    bool has_any = false;
    for (const std::uint32_t slot : island.bodies) contact_impulses_[slot] = {};
    const auto add = [&](std::uint32_t slot, const Wrench<S>& impulse) {
      if (state.solver_bodies[slot].moves) contact_impulses_[slot] += impulse;
    };
    for (const std::uint32_t i : island.contacts) {
      const ContactConstraint<S>& c = state.constraints.contacts[i];
      if (c.is_fresh || !(c.impulse[0] > S(0))) continue;
      has_any = true;
      const Vec3<S> impulse = c.impulse_W();
      add(c.body_a, Wrench<S>::at(c.arm_a, -impulse));
      add(c.body_b, Wrench<S>::at(c.arm_b, impulse));
    }
    for (const std::uint32_t i : island.blocks) {
      const ConstraintBlock<S>& block = state.constraints.blocks[i];
      if (block.is_of_joint()) continue;
      const ConstraintRow<S>& row = state.constraints.rows[block.first];
      add(block.body_a, {zero<Vec3<S>>(), -row.impulse * row.angular_a});
      add(block.body_b, {zero<Vec3<S>>(), row.impulse * row.angular_b});
    }
    return has_any;
  }

  /// Returns whether a mechanism turns a body so far that the directions of its contacts are lost.
  [[nodiscard]] bool turn_far(const State& state, const Island& island) const {
    return std::any_of(island.bodies.begin(), island.bodies.end(), [&](std::uint32_t slot) {
      return state.solver_bodies[slot].follows_joints &&
             turns_far<S>(mean_motions_[slot].angular, state.def.time_step);
    });
  }

  /// Brings back the bodies and joints of an island as they were before `advance`.
  void restore(State& state, const Island& island) {
    for (std::size_t k = 0; k < saved_.size(); ++k) {
      state.solver_bodies[island.bodies[k]] = saved_[k];
    }
    for (const std::uint32_t i : island.blocks) {
      const ConstraintBlock<S>& block = state.constraints.blocks[i];
      if (!block.is_of_joint()) continue;
      joint_impulses_[block.joint] = {};
      responses_[block.joint] = {};
    }
  }

  /// Velocity change of a body by an impulse.
  [[nodiscard]] static Twist<S> impulse_response(const SolverBody<S>& body,
                                                 const Wrench<S>& impulse) {
    Twist<S> change{};
    body.apply_impulse(change, impulse.force, impulse.torque);
    return change;
  }

  /// Mean motion of a body in the step of its mechanism, or in free motion.
  [[nodiscard]] Twist<S> mean_motion_of(const State& state, std::uint32_t slot) const {
    const SolverBody<S>& body = state.solver_bodies[slot];
    return body.follows_joints ? mean_motions_[slot] : body.mean_free;
  }

  /// Joins the bodies of each mechanism: `parent_` leads to the lowest index of its movable bodies.
  /// Contacts join nothing here.
  void find_groups(const State& state, const Island& island) {
    for (const std::uint32_t slot : island.bodies) parent_[slot] = slot;
    const auto root = [&](std::uint32_t slot) {
      while (parent_[slot] != slot) slot = parent_[slot] = parent_[parent_[slot]];
      return slot;
    };
    for (const std::uint32_t i : island.blocks) {
      const ConstraintBlock<S>& block = state.constraints.blocks[i];
      if (!block.is_of_joint() || !state.solver_bodies[block.body_a].moves ||
          !state.solver_bodies[block.body_b].moves) {
        continue;
      }
      const std::uint32_t a = root(block.body_a);
      const std::uint32_t b = root(block.body_b);
      parent_[std::max(a, b)] = std::min(a, b);
    }
    for (const std::uint32_t slot : island.bodies) parent_[slot] = root(slot);
  }

  bool advance_groups(State& state, const Island& island) {
    return std::all_of(island.bodies.begin(), island.bodies.end(), [&](std::uint32_t slot) {
      return parent_[slot] != slot || advance_group(state, island, slot);
    });
  }

  /// Returns whether all joints stay within their limits.
  [[nodiscard]] bool keeps_limits(const State& state, const Island& island) const {
    return std::all_of(island.blocks.begin(), island.blocks.end(), [&](std::uint32_t i) {
      const ConstraintBlock<S>& block = state.constraints.blocks[i];
      if (block.kind != BlockKind::limit) return true;
      const Joint<S>& joint = state.joints.at(block.joint);
      const SolverBody<S>& a = state.solver_bodies[block.body_a];
      const SolverBody<S>& b = state.solver_bodies[block.body_b];
      const JointPose<S> pose =
          joint_pose(joint, end_pose(state, block.body_a), end_pose(state, block.body_b));
      const S position = tracked_position(joint, pose, {a.start, a.twist}, {b.start, b.twist},
                                          state.def.time_step);
      return is_within_limits(joint.def, pose, position);
    });
  }

  /// Lists the bodies and joints of a group. False if it has no joints: a lone body that contacts
  /// connect to a mechanism.
  bool gather(const State& state, const Island& island, std::uint32_t group) {
    bodies_.clear();
    joints_.clear();
    slots_.clear();
    joint_slots_.clear();
    const auto number = [&](std::uint32_t slot) {
      if (local_[slot] == no_index) {
        local_[slot] = static_cast<std::uint32_t>(slots_.size());
        slots_.push_back(slot);
        bodies_.push_back(mechanism_body(state.bodies.at(slot), state.def.gravity));
      }
      return local_[slot];
    };
    for (const std::uint32_t i : island.blocks) {
      const ConstraintBlock<S>& block = state.constraints.blocks[i];
      if (block.kind != BlockKind::equality) continue;
      const bool is_a = state.solver_bodies[block.body_a].moves;
      if (parent_[is_a ? block.body_a : block.body_b] != group) continue;
      const Joint<S>& joint = state.joints.at(block.joint);
      joints_.push_back({joint.def.kind, number(block.body_a), number(block.body_b), joint.X_CmA_J,
                         joint.X_CmB_J, joint.def.spring, joint.angle});
      joint_slots_.push_back(block.joint);
    }
    for (const std::uint32_t slot : slots_) local_[slot] = no_index;
    return !joints_.empty();
  }

  bool advance_group(State& state, const Island& island, std::uint32_t group) {
    if (!gather(state, island, group)) return true;
    for (std::size_t k = 0; k < slots_.size(); ++k) {
      if (!bodies_[k].moves_by_forces) continue;
      bodies_[k].load += (S(1) / state.def.time_step) * contact_impulses_[slots_[k]];
    }
    poses_.resize(bodies_.size());
    twists_.resize(bodies_.size());
    impulses_.resize(joints_.size());
    if (!integrator_.advance(bodies_, joints_, state.def.time_step, poses_, twists_, impulses_)) {
      return false;
    }
    state.report.mechanism_evaluations += static_cast<std::uint64_t>(integrator_.evaluations());
    for (std::size_t k = 0; k < slots_.size(); ++k) write(state, slots_[k], k);
    if (!take_out_contacts(state)) return false;
    for (std::size_t k = 0; k < joint_slots_.size(); ++k) {
      joint_impulses_[joint_slots_[k]] = impulses_[k];
      responses_[joint_slots_[k]] = -without_contacts_[k];
    }
    return true;
  }

  /// Finds the free motion of the gathered group, and what joints do against the impulses of
  /// contacts. Rows have both impulses, too. With them, free motion is the integrated one.
  /// @return False if its matrix is singular.
  bool take_out_contacts(State& state) {
    without_contacts_.assign(joints_.size(), Wrench<S>{});
    const bool has_contacts = std::any_of(slots_.begin(), slots_.end(), [&](std::uint32_t slot) {
      const Wrench<S>& impulse = contact_impulses_[slot];
      return impulse.force != zero<Vec3<S>>() || impulse.torque != zero<Vec3<S>>();
    });
    if (!has_contacts) return true;
    for (std::size_t k = 0; k < slots_.size(); ++k) {
      bodies_[k].center_pose = poses_[k];
      if (!bodies_[k].moves_by_forces) continue;
      bodies_[k].twist = twists_[k] - impulse_response(state.solver_bodies[slots_[k]],
                                                       contact_impulses_[slots_[k]]);
    }
    system_.set(bodies_, joints_);
    system_.place();
    if (!system_.factor()) return false;
    projection_.close_velocities(system_, without_contacts_);
    for (std::size_t k = 0; k < slots_.size(); ++k) {
      if (!bodies_[k].moves_by_forces) continue;
      // The system has the inertias of the end, and rows those of the start.
      const auto& node = system_.nodes()[k];
      const Twist<S> by_joints = node.now.twist - bodies_[k].twist;
      const Mat3<S>& R = node.now.R;
      const Vec3<S> turning_B = R.transpose() * by_joints.angular;
      SolverBody<S>& body = state.solver_bodies[slots_[k]];
      body.free = bodies_[k].twist;
      body.free.linear += by_joints.linear;
      body.free.angular += body.inverse_inertia * (R * (bodies_[k].inertia_B * turning_B));
      body.mean_free =
          body.motion - usual_share<S>(Integrator::trapezoidal) * (body.twist - body.free);
    }
    for (std::size_t k = 0; k < joints_.size(); ++k) impulses_[k] += without_contacts_[k];
    return true;
  }

  void write(State& state, std::uint32_t slot, std::size_t k) {
    SolverBody<S>& body = state.solver_bodies[slot];
    if (!body.moves) return;
    const Transform<S>& start = state.bodies.at(slot).center_pose;
    const S dt = state.def.time_step;
    body.free = body.twist = twists_[k];
    body.mean_free = {(poses_[k].translation - start.translation) / dt,
                      log_rotation<S>(poses_[k].rotation * start.rotation.conjugate()) / dt};
    body.motion = body.mean_free;
    body.follows_joints = true;
    end_poses_[slot] = poses_[k];
    mean_motions_[slot] = body.motion;
  }

  /// Returns whether a joint was wide open at the start of the step.
  [[nodiscard]] bool has_open_joints(const State& state, const Island& island) const {
    return std::any_of(island.blocks.begin(), island.blocks.end(), [&](std::uint32_t i) {
      const ConstraintBlock<S>& block = state.constraints.blocks[i];
      return block.is_of_joint() && is_open_[block.joint];
    });
  }

  /// Returns whether joints hold a body that turns far.
  [[nodiscard]] bool has_far_turns(const State& state, const Island& island) const {
    return std::any_of(island.bodies.begin(), island.bodies.end(), [&](std::uint32_t slot) {
      const SolverBody<S>& body = state.solver_bodies[slot];
      const Twist<S> solved = body.follows_joints ? body.motion - mean_motions_[slot] : body.motion;
      return turns_far<S>(solved.angular, state.def.time_step);
    });
  }

  /// Closes gaps of the gathered group at the end of the step, if they are wide.
  void close_wide_gaps(State& state) {
    for (std::size_t k = 0; k < slots_.size(); ++k) {
      bodies_[k].center_pose = end_of_step(state, slots_[k]);
    }
    system_.set(bodies_, joints_);
    system_.place();
    const S most = S(chosen::wide_joint_gap) * system_.size();
    if (projection_.find_gaps(system_) <= most) return;
    // The next position correction closes the remaining gap.
    if (!projection_.close_wide_gaps(system_, S(chosen::closed_wide_gap_share) * most)) return;
    for (std::size_t k = 0; k < slots_.size(); ++k) {
      SolverBody<S>& body = state.solver_bodies[slots_[k]];
      if (!body.moves) continue;
      // `move` takes the body there.
      mean_motions_[slots_[k]] = body.motion;
      body.follows_joints = true;
      const auto& found = system_.nodes()[k].now;
      end_poses_[slots_[k]] = {found.q.normalized(), found.x};
    }
  }

  /// Pose of a body at the end of the step, by the solved motion.
  [[nodiscard]] Transform<S> end_of_step(const State& state, std::uint32_t slot) const {
    const SolverBody<S>& solved = state.solver_bodies[slot];
    if (!solved.moves) return end_pose(state, slot);
    Body<S> body = state.bodies.at(slot);
    if (solved.follows_joints) {
      move(body, solved, slot, state.def.time_step);
    } else {
      step_pose(body, solved.motion, state.def.time_step);
    }
    return body.center_pose;
  }

  /// Pose of a body after the smooth motion.
  [[nodiscard]] Transform<S> end_pose(const State& state, std::uint32_t slot) const {
    if (state.solver_bodies[slot].follows_joints) return end_poses_[slot];
    Body<S> body = state.bodies.at(slot);
    if (body.motion == Motion::kinematic) step_pose(body, body.twist, state.def.time_step);
    return body.center_pose;
  }

  MechanismIntegrator<S> integrator_{};
  JointSystem<S> system_;
  JointProjection<S> projection_;
  bool has_mechanism_ = false;
  DynamicArray<Transform<S>> end_poses_;        // By body index, for integrated bodies.
  DynamicArray<Twist<S>> mean_motions_;         // The same.
  DynamicArray<Wrench<S>> contact_impulses_;    // By body index.
  DynamicArray<bool> is_open_;                  // By joint index.
  DynamicArray<Wrench<S>> responses_;           // Of joints to these, by joint index.
  DynamicArray<Wrench<S>> joint_impulses_;      // By joint index.
  DynamicArray<std::uint32_t> parent_, local_;  // By body index.
  DynamicArray<SolverBody<S>> saved_;
  DynamicArray<MechanismBody<S>> bodies_;
  DynamicArray<MechanismJoint<S>> joints_;
  DynamicArray<std::uint32_t> slots_, joint_slots_;
  DynamicArray<Transform<S>> poses_;
  DynamicArray<Twist<S>> twists_;
  DynamicArray<Wrench<S>> impulses_, without_contacts_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
