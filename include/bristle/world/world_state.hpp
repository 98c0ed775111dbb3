/// @file
/// What a world holds, and what its stages share. Users meet `World`.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/collision/broadphase.hpp>
#include <bristle/collision/contact_cache.hpp>
#include <bristle/core/parallel.hpp>
#include <bristle/core/slot_map.hpp>
#include <bristle/dynamics/bodies/body.hpp>
#include <bristle/dynamics/joints/joint.hpp>
#include <bristle/dynamics/solver/solver_types.hpp>
#include <bristle/geometry/backends/shape_backend.hpp>
#include <bristle/sensors/patch.hpp>
#include <bristle/world/contact_events.hpp>
#include <bristle/world/report.hpp>

#include <algorithm>
#include <optional>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// When islands of bodies fall asleep. Asleep, they are not computed: nothing moves, contacts,
/// joints and sensors keep their impulses and readings, velocities are zero.
template <Scalar S>
struct SleepDef {
  /// [m/s] Speed of the centre of mass up to which a body is at rest, >= 0.
  S linear_speed = S(0.01);
  /// [rad/s] Angular speed up to which it is, >= 0.
  S angular_speed = S(0.05);
  /// [s] For how long all bodies of an island must be at rest, > 0. Infinite, the default: nothing
  /// ever sleeps (docs/decisions/0014-sleep-is-off.md says why).
  S time = infinity<S>;
};

/// Settings of a world.
template <Scalar S>
struct WorldDef {
  /// [m/s^2] Gravity.
  Vec3<S> gravity = Vec3<S>(S(0), S(0), S(-9.81));
  /// [s] Length of a step, > 0.
  S time_step = S(1) / S(240);
  /// [m/s] Impacts slower than this do not bounce, >= 0.
  S restitution_speed = S(0.01);
  /// [-] How positions follow from velocities.
  Integrator integrator = Integrator::trapezoidal;
  /// [-] The solver.
  SolverDef<S> solver{};
  /// [-] When bodies at rest are no longer computed.
  SleepDef<S> sleep{};
  /// [-] Runs independent tasks, on threads of the host if it likes; the results are the same.
  ParallelFor parallel_for = serial_for;
};

/// A shape on a body.
template <Scalar S, typename Backend>
struct Collider {
  BodyId body{};
  /// [m] Pose of the shape from the body's centre of mass, along the body's axes.
  Transform<S> X_CmS{};
  /// Whether that is the identity, as of most shapes.
  bool is_centered = false;
  typename Backend::template Collidable<S> shape{};
  ShapeKind kind = ShapeKind::sphere;
  Material<S> material{};
  /// [m] Box in the shape's own frame; infinite for a half-space.
  Aabb<S> bounds{};
  /// [m] Farthest point from the body's centre of mass.
  S radius = S(0);
  /// The half-space itself, since a box cannot bound it.
  std::optional<HalfSpace<S>> half_space{};
};

/// Everything that persists from step to step, and the bodies as the solver sees them.
template <Scalar S, typename Backend>
struct WorldState {
  WorldDef<S> def{};
  SlotMap<Body<S>, BodyTag> bodies;
  SlotMap<Collider<S, Backend>, ShapeTag> colliders;
  SlotMap<Joint<S>, JointTag> joints;
  SlotMap<SensorPatch<S>, PatchTag> patches;
  BroadPhase<S> broad_phase;
  ContactCache<S> contacts;
  /// Touches that ended because a shape was removed, for the events of the last step, and those
  /// since.
  std::vector<ContactEvent> ended, ended_since;
  /// Pairs of body slots that do not touch because a joint connects them, sorted.
  std::vector<ShapePair> unpaired;
  StepReport<S> report{};
  /// Bodies asleep, and whether all is: then a step has nothing to do.
  std::uint32_t sleeping_bodies = 0;
  bool is_idle = false;
  /// Whether a caller may have changed any body since the last step (`BodySleep::is_stirred`).
  bool is_any_stirred = false;
  /// [-] Steps so far in which anything could move.
  std::uint64_t steps = 0;

  /// This step's scratch: one entry a body slot, and all constraints.
  std::vector<SolverBody<S>> solver_bodies;
  Constraints<S> constraints;

  [[nodiscard]] const Body<S>& body_of(const Collider<S, Backend>& c) const {
    return bodies.at(c.body.index);
  }
  /// Whether a body may move in this step, or was changed by the caller since the last one.
  [[nodiscard]] bool is_active(std::uint32_t slot) const {
    const Body<S>& body = bodies.at(slot);
    if (body.sleep.is_stirred) return true;
    if (body.is_dynamic()) return !body.is_asleep();
    return !body.twist.linear.isZero(S(0)) || !body.twist.angular.isZero(S(0));
  }
  /// Whether there is a patch in a slot that is switched on.
  [[nodiscard]] bool is_sensing(std::uint32_t slot) const {
    return patches.is_live(slot) && patches.at(slot).is_active;
  }
  /// [m] Pose of a shape in the frame of A's centre of mass.
  [[nodiscard]] Transform<S> pose_from(const Body<S>& A, const Collider<S, Backend>& c) const {
    return relative_pose(A.center_pose, body_of(c).center_pose) * c.X_CmS;
  }
  /// Whether a box in the world reaches a shape that has no box itself; true for shapes that do.
  [[nodiscard]] bool reaches(const Aabb<S>& box, const Collider<S, Backend>& c) const {
    if (!c.half_space) return true;
    const Transform<S> X_WS = body_of(c).center_pose * c.X_CmS;
    const Vec3<S> n = X_WS.rotate(c.half_space->normal);
    const S height = n.dot(box.center() - X_WS.translation) - c.half_space->offset;
    return height <= n.cwiseAbs().dot(box.half_extents());
  }
};

}  // namespace bristle::inline BRISTLE_ABI
