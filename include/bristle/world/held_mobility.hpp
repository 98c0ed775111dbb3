/// @file
/// Response of a body to an impulse while the constraints of the last step hold on.
///
/// A haptic loop runs ahead of the world. Of the rest of the world it only needs to know how the
/// body under the tool yields. A box in the air yields by its mass. The same box on a table does
/// not yield downwards at all, nor sideways while it sticks.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/joints/joint_rows.hpp>
#include <bristle/world/patch_stiffness.hpp>
#include <bristle/world/world_constants.hpp>
#include <bristle/world/world_state.hpp>

#include <algorithm>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// Mobility of a body within its surroundings.
template <Scalar S>
struct HeldMobility {
  /// [1/kg and products with 1/m] Change of its twist by an impulse about its centre of mass, world
  /// axes. Symmetric, positive semidefinite.
  Mat6<S> matrix = zero<Mat6<S>>();
  /// True if anything but its inertia resists.
  bool is_held = false;
  /// True if it hit something in the last step: forces of that step then say little of the next.
  bool was_hit = false;
  /// [-] Integrator of its position: sensors, motors and limits require symplectic Euler.
  Integrator integrator = Integrator::trapezoidal;
};

/// Finds the mobility of bodies from the state that a step left behind.
///
/// Contacts that carried load stop the body along their normal, and across it where they stick.
/// Joints stop it along their locked axes, and along a driven axis while the motor has force to
/// spare. Patches of the world and springs add their stiffness and damping over a step. The body on
/// the other side counts as immovable.
template <Scalar S>
class HeldMobilityFinder {
 public:
  using State = WorldState<S>;

  [[nodiscard]] HeldMobility<S> find(const State& state, std::uint32_t slot) {
    HeldMobility<S> result;
    const Body<S>& body = state.bodies.at(slot);
    if (!body.moves()) return result;
    result.integrator = state.def.integrator;
    set_quarter<0, 0, S>(result.matrix, diagonal_matrix<S>(body.inverse_mass_W()));
    set_quarter<3, 3, S>(result.matrix, body.inverse_inertia_W());
    add_patches(state, slot, result);
    free_ = result.matrix;
    add_contacts(state, slot, result);
    add_joints(state, slot, result);
    return result;
  }

 private:
  /// Removes all motion along a row. A constraint balances impulses along it.
  void remove_motion(const Vec3<S>& direction, const Vec3<S>& angular,
                     HeldMobility<S>& held) const {
    const Vec6<S> row = stacked<S>(direction, angular);
    const Vec6<S> motion = held.matrix * row;
    const S response = row.dot(motion);
    held.is_held = true;
    // A row that others stop already holds only rounding.
    if (!(response > Tolerance<S>::equal() * row.dot(free_ * row))) return;
    held.matrix -= (motion / response) * motion.transpose();
  }

  void add_patches(const State& state, std::uint32_t slot, HeldMobility<S>& held) {
    const S dt = state.def.time_step;
    for (const std::uint32_t i : state.patches.live_slots()) {
      const SensorPatch<S>& patch = state.patches.at(i);
      const bool is_own = patch.body.index == slot;
      const auto is_it = [slot](const auto& other) { return other.body == slot; };
      const auto& sensed = patch.sensed;
      if (is_own ? sensed.empty() : std::none_of(sensed.begin(), sensed.end(), is_it)) continue;
      const auto is_wanted = [&](std::uint32_t body) { return is_own || body == slot; };
      patches_.find(state, i, is_wanted, [&](const BodyStiffness<S>& on) {
        soften(dt * dt * on.sum.stiffness + dt * on.sum.damping, is_own ? on.arm_a : on.arm_b,
               held);
      });
    }
  }

  /// Reduces the mobility by the stiffness and damping at the end of an arm within a step.
  /// @param soft  [N s^2/m and products with m] As `SoftBlock::matrix`.
  void soften(const Mat6<S>& soft, const Vec3<S>& arm, HeldMobility<S>& held) const {
    const Mat6<S> to_point = shift_matrix<S>(arm);
    const Mat6<S> at_center = to_point.transpose() * soft * to_point;
    const Mat6<S> grown = identity<Mat6<S>>() + held.matrix * at_center;
    held.matrix = solved(grown, held.matrix);
    held.is_held = true;
    held.integrator = Integrator::symplectic_euler;
  }

  void add_contacts(const State& state, std::uint32_t slot, HeldMobility<S>& held) const {
    for (const CachedManifold<S>& m : state.contacts.manifolds()) {
      const Collider<S>& a = state.colliders.at(m.shapes.a);
      const Collider<S>& b = state.colliders.at(m.shapes.b);
      if (a.body.index != slot && b.body.index != slot) continue;
      const S friction = state.material_of(a, b).friction;
      const Twist<S>& twist_a = state.body_of(a).twist;
      const Twist<S>& twist_b = state.body_of(b).twist;
      Vec3<S> t1, t2;
      tangent_basis<S>(m.normal, t1, t2);
      for (std::uint32_t i = m.first; i < m.first + m.count; ++i) {
        const CachedPoint<S>& point = state.contacts.points()[i];
        if (!(point.impulse[0] > S(0))) continue;
        if (point.took_impact) {
          held.was_hit = true;
          const S parting = m.normal.dot(twist_b.at(point.arm_b) - twist_a.at(point.arm_a));
          if (parting > state.def.restitution_speed) continue;
        }
        const Vec3<S>& arm = a.body.index == slot ? point.arm_a : point.arm_b;
        remove_motion(m.normal, arm.cross(m.normal), held);
        // Close to its limit, friction counts as sliding: it goes on as a force.
        const S most = S(chosen::sliding_share) * friction * point.impulse[0];
        if (friction_impulse(m, point).norm() >= most) continue;
        remove_motion(t1, arm.cross(t1), held);
        remove_motion(t2, arm.cross(t2), held);
      }
    }
  }

  void add_joints(const State& state, std::uint32_t slot, HeldMobility<S>& held) {
    for (const std::uint32_t i : state.joints.live_slots()) {
      Joint<S> joint = state.joints.at(i);
      const bool is_a = joint.def.body_a.index == slot;
      if (!is_a && joint.def.body_b.index != slot) continue;
      rows_.clear();
      add_joint_rows(joint, i, state.bodies.at(joint.def.body_a.index),
                     state.bodies.at(joint.def.body_b.index), state.def.time_step, rows_);
      for (const SoftBlock<S>& soft : rows_.soft) {
        soften(soft.matrix, is_a ? soft.arm_a : soft.arm_b, held);
      }
      for (const ConstraintBlock<S>& block : rows_.blocks) {
        if (block.kind != BlockKind::equality) held.integrator = Integrator::symplectic_euler;
        for (std::uint32_t r = block.first; r < block.first + block.count; ++r) {
          const ConstraintRow<S>& row = rows_.rows[r];
          const bool holds = block.kind == BlockKind::equality ||
                             (row.impulse > block.lower && row.impulse < block.upper);
          if (!holds) continue;
          const Vec3<S>& angular = is_a ? row.angular_a : row.angular_b;
          if (value_of(row.compliance) == 0) {
            remove_motion(row.direction, angular, held);
          } else {
            const Vec6<S> j = stacked<S>(row.direction, angular);
            soften((S(1) / row.compliance) * j * j.transpose(), zero<Vec3<S>>(), held);
          }
        }
      }
    }
  }

  Mat6<S> free_ = zero<Mat6<S>>();
  Constraints<S> rows_;
  StiffnessFinder<S> patches_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
