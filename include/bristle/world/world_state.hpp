/// @file
/// The state of a world, shared by its stages.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/collision/broadphase.hpp>
#include <bristle/collision/contact_cache.hpp>
#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/slot_map.hpp>
#include <bristle/dynamics/bodies/body.hpp>
#include <bristle/dynamics/joints/joint.hpp>
#include <bristle/dynamics/solver/solver_types.hpp>
#include <bristle/geometry/shapes/inner_ball.hpp>
#include <bristle/sensors/patch.hpp>
#include <bristle/world/contact_events.hpp>
#include <bristle/world/joint_stage.hpp>
#include <bristle/world/prepared_shape.hpp>
#include <bristle/world/report.hpp>
#include <bristle/world/shapes_of_bodies.hpp>
#include <bristle/world/touch_events.hpp>
#include <bristle/world/world_def.hpp>

#include <algorithm>
#include <optional>

namespace bristle::inline BRISTLE_ABI::detail {

/// A shape on a body.
template <Scalar S>
struct Collider {
  BodyId body{};
  /// [m] Pose of the shape relative to the body's centre of mass, in the body's axes.
  Transform<S> X_CmS{};
  /// True if that is the identity: most shapes.
  bool is_centered = false;
  PreparedShape<S> shape{};
  ShapeKind kind = ShapeKind::sphere;
  Material<S> material{};
  /// True if it reports contacts and pushes nothing.
  bool is_trigger = false;
  std::uint64_t user_data = 0;
  /// [m] Box in the shape's own frame; infinite for a half-space.
  Aabb<S> bounds{};
  /// [m] Farthest point from the body's centre of mass.
  S radius = S(0);
  /// A ball within, relative to the body's centre of mass, in the body's axes.
  InnerBall<S> inner{};
  /// The half-space itself, which a box cannot bound.
  std::optional<HalfSpace<S>> half_space{};
};

/// All state that persists from step to step, and the solver bodies.
template <Scalar S>
struct WorldState {
  WorldDef<S> def{};
  SlotMap<Body<S>, BodyTag> bodies;
  SlotMap<Collider<S>, ShapeTag> colliders;
  ShapesOfBodies shapes_of_bodies;
  SlotMap<Joint<S>, JointTag> joints;
  /// Null until the first joint is added.
  const JointKernels<S>* joint_kernels = nullptr;
  SlotMap<SensorPatch<S>, PatchTag> patches;
  BroadPhase<S> broad_phase;
  ContactCache<S> contacts;
  /// Contacts that ended because a shape was removed: for the events of the last step, and since
  /// then.
  DynamicArray<ContactEvent> ended, ended_since;
  /// Begins and ends of contacts, if `WorldDef::keeps_contact_events`.
  DynamicArray<ContactEvent> kept_events;
  TouchLog touch_log;
  /// The body of joints to the world. Names none before the first.
  BodyId ground{};
  /// Body index pairs whose contact a joint disables, sorted.
  DynamicArray<ShapePair> unpaired;
  StepReport<S> report{};
  /// Number of bodies asleep. `is_idle` if all are: a step then has nothing to do.
  std::uint32_t sleeping_bodies = 0;
  bool is_idle = false;
  /// True if a caller may have changed any body since the last step (`BodySleep::is_dirty`).
  bool is_any_dirty = false;
  /// [-] Steps so far in which anything could move.
  std::uint64_t steps = 0;

  /// Scratch of this step: one entry a body index, and all constraints.
  DynamicArray<SolverBody<S>> solver_bodies;
  Constraints<S> constraints;

  [[nodiscard]] const Body<S>& body_of(const Collider<S>& c) const {
    return bodies.at(c.body.index);
  }
  /// Material of two shapes in contact.
  [[nodiscard]] Material<S> material_of(const Collider<S>& a, const Collider<S>& b) const {
    const Material<S> material = def.combine(a.material, b.material);
    return is_valid_state(material) ? material : combined(a.material, b.material);
  }
  /// [m/s] Velocity of a's surface on its body less that of b's on its own, world axes, at the end
  /// of the step if bodies turn on.
  [[nodiscard]] Vec3<S> drift_of(const Collider<S>& a, const Collider<S>& b) const {
    Vec3<S> drift = zero<Vec3<S>>();
    const auto add = [&](S sign, const Collider<S>& c) {
      if (c.material.surface_velocity == zero<Vec3<S>>()) return;
      const Body<S>& body = body_of(c);
      const Quat<S> R_WS = body.center_pose.rotation * c.X_CmS.rotation;
      const Vec3<S> velocity = R_WS * c.material.surface_velocity;
      drift += sign * (velocity + def.time_step * body.twist.angular.cross(velocity));
    };
    add(S(1), a);
    add(S(-1), b);
    return drift;
  }
  /// Returns whether a body may move in this step, or was changed by the caller since the last one.
  [[nodiscard]] bool is_active(std::uint32_t slot) const {
    const Body<S>& body = bodies.at(slot);
    if (body.sleep.is_dirty) return true;
    if (body.is_dynamic()) return !body.is_asleep();
    return !body.twist.linear.isZero(S(0)) || !body.twist.angular.isZero(S(0));
  }
  /// Returns whether a slot holds an active patch.
  [[nodiscard]] bool is_sensing(std::uint32_t slot) const {
    return patches.is_live(slot) && patches.at(slot).is_active;
  }
  /// [m] Pose of a shape in the frame of A's centre of mass.
  [[nodiscard]] Transform<S> pose_from(const Body<S>& A, const Collider<S>& c) const {
    return relative_pose(A.center_pose, body_of(c).center_pose) * c.X_CmS;
  }
  /// Returns whether a box in the world reaches a shape without a box. True for shapes with a box.
  [[nodiscard]] bool reaches(const Aabb<S>& box, const Collider<S>& c) const {
    if (!c.half_space) return true;
    const Transform<S> X_WS = body_of(c).center_pose * c.X_CmS;
    const Vec3<S> n = X_WS.rotate(c.half_space->normal);
    const S height = n.dot(box.center() - X_WS.translation) - c.half_space->offset;
    return height <= cwise_abs(n).dot(box.half_extents());
  }
};

}  // namespace bristle::inline BRISTLE_ABI::detail
