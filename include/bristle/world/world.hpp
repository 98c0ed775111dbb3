/// @file
/// The world: bodies, shapes, joints and patches of sensors, and one function that steps them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/kernel_scratch.hpp>
#include <bristle/geometry/backends/analytic_backend.hpp>
#include <bristle/sensors/patch_report.hpp>
#include <bristle/sensors/tuning.hpp>
#include <bristle/world/contact_events.hpp>
#include <bristle/world/haptic_loop.hpp>
#include <bristle/world/kernels.hpp>
#include <bristle/world/proximity.hpp>
#include <bristle/world/ray_query.hpp>
#include <bristle/world/touch_events.hpp>
#include <bristle/world/world_state.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

template <Scalar S, typename Backend>
class HostSensors;
template <Scalar S, typename Backend>
class WorldBatch;

/// A minimal rigid-body world whose hands can hold things.
///
/// Calls that take a definition check it and throw `InvalidArgument` before anything changes. So do
/// calls with a handle that names nothing. `step` never throws and never lets a non-finite number
/// spread. It does not allocate once it has seen the scene's largest step.
///
/// A world is a value. A copy steps on exactly as the original would, and warms up scratch memory
/// of its own. Only destroy a moved-from world, or assign to it. The same calls give the same bits,
/// run to run and for any `WorldDef::parallel_for`. One thread at a time may use a world; const
/// calls may run concurrently.
///
/// @tparam S        Scalar: float, double, or `Dual<double, n>` (docs/gradients.md).
/// @tparam Backend  Computes geometry; see `ShapeBackend`.
template <Scalar S, typename Backend = AnalyticBackend>
requires ShapeBackend<Backend, S>
class World {
 public:
  /// Creates an empty world.
  /// @throws InvalidArgument naming the field of the definition.
  explicit World(const WorldDef<S>& def = {});
  /// A copy has the same state and handles, and scratch memory of its own.
  World(const World& other);
  /// The other world may only be destroyed or assigned to.
  World(World&& other) noexcept;
  /// Replaces this world by a copy.
  World& operator=(const World& other);
  /// Replaces this world. The other one may only be destroyed or assigned to.
  World& operator=(World&& other) noexcept;
  ~World();

  // Bodies and shapes -----------------------------------------------------------------------------

  /// Adds a body with its shapes.
  /// @throws InvalidArgument naming the field; or when the backend knows no contact between a shape
  ///         and one already here that it may meet (docs/backends.md lists the pairs).
  BodyId add_body(const BodyDef<S>& def);

  /// Adds a shape to a body. Mass properties stay.
  /// @throws InvalidArgument as `add_body`.
  ShapeId add_shape(BodyId body, const ShapeDef<S>& def);

  /// Removes a body with its shapes, patches and joints. Other bodies' sensors let go of it.
  void remove_body(BodyId id);
  /// Removes a shape. Mass properties stay.
  void remove_shape(ShapeId id);

  /// Returns whether there is such a body.
  [[nodiscard]] bool contains(BodyId id) const noexcept { return state_.bodies.contains(id); }
  /// Returns whether there is such a shape.
  [[nodiscard]] bool contains(ShapeId id) const noexcept { return state_.colliders.contains(id); }
  /// Mass, pose and velocities of a body.
  [[nodiscard]] const Body<S>& body(BodyId id) const { return state_.bodies.get(id, "BodyId"); }
  /// Pose of the body frame in the world.
  [[nodiscard]] Transform<S> pose(BodyId id) const { return body(id).pose(); }
  /// The body that stands for the world in joints: fixed, without shapes, its frame the world's.
  /// The first call, or the first joint with an unset body, adds it. It is a body like any other:
  /// it shows in lists, what moves it moves its joints, and its removal removes them.
  BodyId ground();
  /// [-] The caller's number of a body, shape, joint or patch, as its definition or
  /// `set_user_data` gave it. It means nothing to the world, and is in no snapshot.
  template <typename Tag>
  [[nodiscard]] std::uint64_t user_data(detail::Id<Tag> id) const {
    return user_data_in(state_, id);
  }
  /// Sets the caller's number of a body, shape, joint or patch.
  template <typename Tag>
  void set_user_data(detail::Id<Tag> id, std::uint64_t value) {
    user_data_in(state_, id) = value;
  }
  /// [-] Number of bodies.
  [[nodiscard]] std::size_t body_count() const noexcept { return state_.bodies.size(); }

  /// Moves a body to a pose at once. Its velocity stays. Contacts and bristles follow in the next
  /// step.
  /// @param X_WB  [m] Pose of the body frame in the world.
  void set_pose(BodyId id, const Transform<S>& X_WB);
  /// [m/s, rad/s] Sets the velocity of the centre of mass and the angular velocity, world axes. The
  /// body must not be fixed.
  void set_velocity(BodyId id, const Twist<S>& twist);
  /// Sets the velocity of a kinematic body that brings it to a pose at the end of the next step, if
  /// the length of a step stays as it is.
  /// The body keeps that velocity until told otherwise.
  void move_to(BodyId id, const Transform<S>& X_WB);
  /// [N, N m] Adds a wrench about the centre of mass, world axes. It acts during the next step.
  void apply_wrench(BodyId id, const Wrench<S>& wrench);
  /// [N] Adds a force at a point [m] of the world. It acts during the next step.
  void apply_force(BodyId id, const Vec3<S>& force, const Vec3<S>& point);
  /// [N s] Changes the velocity of a dynamic body at once by an impulse at a point [m] of the
  /// world. Locked axes stay still.
  /// @throws InvalidArgument when the body is not dynamic, or the new velocity not finite.
  void apply_impulse(BodyId id, const Vec3<S>& impulse, const Vec3<S>& point);
  /// [-] Changes which bodies may touch and sense a body.
  void set_filter(BodyId id, const CollisionFilter& filter);
  /// [kg] Sets the mass of a dynamic body. Its inertia changes in proportion, as for the same solid
  /// of another density. It is rounded each time.
  /// @throws InvalidArgument when the body is not dynamic, the mass is not > 0, or the mass or the
  ///         inertia has no finite inverse.
  void set_mass(BodyId id, S mass);
  /// [1/s] Sets the rates at which the velocity and the angular momentum of a dynamic body decay.
  /// @throws InvalidArgument when the body is not dynamic, or a rate negative or not finite.
  void set_damping(BodyId id, S linear, S angular);
  /// [1] Sets the factor of a dynamic body on the world's gravity.
  /// @throws InvalidArgument when the body is not dynamic, or the factor not finite.
  void set_gravity_scale(BodyId id, S scale);
  /// Sets the material of all shapes of a body.
  /// @throws InvalidArgument naming the field of the material.
  void set_material(BodyId id, const Material<S>& material);
  /// The same for one shape.
  void set_material(ShapeId id, const Material<S>& material);

  /// Returns whether a body sleeps (`WorldDef::sleep`; off unless set). Calls above that change a
  /// body wake its island. So does a body that comes to reach it.
  [[nodiscard]] bool is_asleep(BodyId id) const { return body(id).is_asleep(); }
  /// Wakes a body with its island. It sleeps again after `SleepDef::time` at rest.
  void wake(BodyId id);

  // Joints ----------------------------------------------------------------------------------------

  /// Adds a joint between two bodies, of which at least one is dynamic.
  /// @throws InvalidArgument naming the field.
  JointId add_joint(const JointDef<S>& def);
  /// Removes a joint.
  void remove_joint(JointId id);
  /// Returns whether there is such a joint.
  [[nodiscard]] bool contains(JointId id) const noexcept { return state_.joints.contains(id); }
  /// Changes the motor of a joint.
  void set_motor(JointId id, const JointMotor<S>& motor);
  /// Changes the limits of a joint's position [m] or [rad]. The joint moves into them as it would
  /// back into limits that it broke.
  /// @throws InvalidArgument naming the field of `JointDef`.
  void set_limits(JointId id, S lower, S upper);
  /// Changes the passive spring of a joint.
  /// @throws InvalidArgument naming the field.
  void set_spring(JointId id, const JointSpring<S>& spring);
  /// Definition of a joint, its frames about the centres of mass, and its impulses.
  [[nodiscard]] const detail::Joint<S>& joint(JointId id) const {
    return state_.joints.get(id, "JointId");
  }
  /// Last step's position, velocity and forces of a joint.
  [[nodiscard]] JointReading<S> reading(JointId id) const;

  // Sensors ---------------------------------------------------------------------------------------

  /// Adds sensors to a body, in its frame. Shapes added later are not checked against the rays.
  /// @throws InvalidArgument naming the field or the sensor that points into its own body.
  PatchId add_patch(BodyId body, PatchDef<S> def);
  /// Adds a patch with shared constants and automatic integration.
  PatchId add_patch(BodyId body, SensorLayout<S> sensors, const SensorParameters<S>& parameters);
  /// The same with constants from a spec. The patch is assumed to carry the load alone.
  PatchId add_patch(BodyId body, SensorLayout<S> sensors, const Tuning<S>& tuning);
  /// Removes a patch. It lets go of the bodies in contact.
  void remove_patch(PatchId id);
  /// Switches a patch off or on. A patch that is off has let go, reads zero and costs nothing.
  /// `patch(id).is_active` tells.
  void set_active(PatchId id, bool is_active);
  /// Sets the constants of all sensors of a patch, also where they had their own. Bristles keep
  /// their stretch.
  void set_parameters(PatchId id, const SensorParameters<S>& parameters);
  /// Reading of a patch in the last step; valid until the next one.
  [[nodiscard]] PatchReading<S> reading(PatchId id) const;
  /// Writes the reading as a set of points, out[sensor][6]: the displacement dx, dy, dz [m] of the
  /// skin at the sensor and the force Fx, Fy, Fz [N] on it, in the axes of the patch's body. The
  /// displacement is that at the start of the last step: against the ray by depth times the ray's
  /// length, and across it by the stretch of the bristle, towards where the other body took it.
  /// Zeros without a contact.
  /// @throws InvalidArgument when `out` has another size.
  void taxel_points(PatchId id, std::span<S> out) const;
  /// Figures of a patch on its body and among the bodies that it may sense, and what is likely to
  /// be wrong with it (`PatchReport::warnings`). O(shapes of the world); meant for setting up a
  /// scene.
  [[nodiscard]] PatchReport<S> patch_report(PatchId id) const;
  /// Returns whether there is such a patch.
  [[nodiscard]] bool contains(PatchId id) const noexcept { return state_.patches.contains(id); }
  /// The patch itself, with its bristles and contacts.
  [[nodiscard]] const detail::SensorPatch<S>& patch(PatchId id) const {
    return state_.patches.get(id, "PatchId");
  }

  /// [s] Longest step at which the present contacts of a patch could be integrated explicitly.
  /// Infinite without a contact with a body that moves. Casts all rays of the patch and allocates
  /// memory for their hits.
  [[nodiscard]] S largest_stable_step(PatchId id) const;

  // Queries ---------------------------------------------------------------------------------------

  /// Nearest hit of a ray with any shape. O(log n) in the number of shapes.
  /// @throws InvalidArgument when the ray is not finite, has no unit direction or no length.
  [[nodiscard]] WorldHit<S> cast_ray(const Ray<S>& ray, const QueryFilter& filter = {}) const;
  /// Nearest hits of many rays; `hits` has one entry a ray.
  /// @throws InvalidArgument as `cast_ray`, or when the sizes differ.
  void cast_rays(std::span<const Ray<S>> rays, const QueryFilter& filter,
                 std::span<WorldHit<S>> hits) const;
  /// Hits of a ray with every shape on its way, nearest first: where it enters each.
  /// @throws InvalidArgument as `cast_ray`.
  [[nodiscard]] std::vector<WorldHit<S>> cast_ray_through(const Ray<S>& ray,
                                                          const QueryFilter& filter = {}) const;
  /// Shapes that a convex shape at the pose X_WQ overlaps or touches, in the order of their slots.
  /// @throws InvalidArgument when the shape is not valid or not convex, or the pose not finite.
  [[nodiscard]] std::vector<WorldHit<S>> overlaps(
      const Shape<S>& shape, const Transform<S>& X_WQ,
      const QueryFilter& filter = {}) const requires detail::ShowsSolids<Backend, S>;
  /// The shape nearest to a convex shape at the pose X_WQ, no farther from it than `reach` [m],
  /// and its nearest point. Of shapes that are as near it is the one of the lowest slot.
  /// @throws InvalidArgument as `overlaps`, or when `reach` is not > 0. It may be infinite.
  [[nodiscard]] WorldHit<S> closest(
      const Shape<S>& shape, const Transform<S>& X_WQ, S reach,
      const QueryFilter& filter = {}) const requires detail::ShowsSolids<Backend, S>;
  /// The shape nearest to a point [m] of the world.
  /// @throws InvalidArgument when the point is not finite or `reach` is not > 0.
  [[nodiscard]] WorldHit<S> closest(const Vec3<S>& point, S reach, const QueryFilter& filter = {})
      const requires detail::ShowsSolids<Backend, S>;
  /// First shape that a convex shape touches as it moves by `way` [m] from the pose X_WQ without a
  /// turn. It stops short by a part of at most 1.5e-8 of its size, in float 1.9e-6. A shape that
  /// it touches by as little at the start is in the way only where it approaches.
  /// @throws InvalidArgument as `overlaps`, or when `way` is not finite or zero.
  [[nodiscard]] WorldHit<S> cast_shape(
      const Shape<S>& shape, const Transform<S>& X_WQ, const Vec3<S>& way,
      const QueryFilter& filter = {}) const requires detail::ShowsSolids<Backend, S>;
  /// Measures present distances with an array of rays on a body, given in its frame. Several
  /// threads may fill several arrays at once.
  void sense(BodyId carrier, ProximityArray<S>& array) const;

  // Lists of its contents -------------------------------------------------------------------------

  /// Calls visit(BodyId) for each body, in the order of slots. Nothing may be added or removed
  /// meanwhile.
  template <typename Visit>
  void for_each_body(Visit&& visit) const;
  /// Calls visit(JointId) for each joint, under the same rules.
  template <typename Visit>
  void for_each_joint(Visit&& visit) const;
  /// Calls visit(PatchId) for each patch, under the same rules.
  template <typename Visit>
  void for_each_patch(Visit&& visit) const;
  /// Calls visit(ShapeId, const ShapeDef<S>&) for each shape of a body, as the backend tells it.
  /// O(shapes of the world), and copies meshes.
  template <typename Visit>
  void for_each_shape(BodyId id, Visit&& visit) const requires detail::TellsShapes<Backend, S>;

  // Contacts --------------------------------------------------------------------------------------

  /// Calls visit(const ContactEvent&) for every two shapes that touched in the last step or in the
  /// one before it. Contacts that a removal ended come first, the others in the order of indices.
  /// Costs nothing unless called. Call it before the world changes again.
  template <typename Visit>
  void for_each_contact_event(Visit&& visit) const;
  /// Begins and ends of contacts since the last `clear_contact_events`, in the order of steps:
  /// nothing is lost where a frame has several steps. Empty unless
  /// `WorldDef::keeps_contact_events`, and after `restore`. An end may name what was removed: ask
  /// `contains`. Valid until the next step or `clear_contact_events`.
  [[nodiscard]] std::span<const ContactEvent> contact_events() const noexcept {
    return state_.kept_events;
  }
  /// Forgets all events kept so far.
  void clear_contact_events() noexcept { state_.kept_events.clear(); }
  /// Calls visit(const ContactReading<S>&) for every two shapes within reach of each other in the
  /// last step, in the order of indices.
  template <typename Visit>
  void for_each_contact(Visit&& visit) const;
  /// [N s, N m s] Impulse of all contacts of a body in the last step, about its centre of mass.
  [[nodiscard]] Wrench<S> contact_impulse(BodyId id) const;
  /// The same for the contacts with one other body.
  [[nodiscard]] Wrench<S> contact_impulse(BodyId id, BodyId from) const;

  // Touches of patches ----------------------------------------------------------------------------

  /// Starts or ends to keep events of touches. After a start the next step reports all bodies that
  /// patches touch then. Each later step compares its readings with what was reported. A world that
  /// does not keep them pays nothing. No state of snapshots: after `restore` the next step reports
  /// what differs.
  void keep_touch_events(bool is_on) { state_.touch_log.listen(is_on); }
  /// Begins and ends of touches since the last `clear_touch_events`, in the order of steps. In a
  /// step ends come first, then by patch and body. Valid until the next step.
  [[nodiscard]] std::span<const TouchEvent> touch_events() const noexcept {
    return state_.touch_log.events();
  }
  /// Forgets all events of touches kept so far.
  void clear_touch_events() noexcept { state_.touch_log.clear_events(); }

  // State -----------------------------------------------------------------------------------------

  /// Returns all state as bytes: poses, velocities, contact and joint impulses, bristles, readings,
  /// motors, filters, masses, materials, constants of sensors, step length and gravity. Shapes and
  /// other definitions are not included. Valid for this version and machine.
  [[nodiscard]] std::vector<std::byte> snapshot() const;
  /// Restores the state of a snapshot. The world then steps on with the same bits. It must have the
  /// same bodies, shapes, joints and patches under the same handles. So it is the source of the
  /// snapshot, or was built by the same calls. Results of the last step (`report`, contact events)
  /// are not state and stay with the world that made them.
  /// @throws InvalidArgument naming the difference, or the error in the bytes.
  void restore(std::span<const std::byte> bytes);
  /// [-] Hash of a snapshot's content (`BitHash`, value by value). Equal bits give equal hashes.
  /// Different bits collide with a chance of 2^-64.
  [[nodiscard]] std::uint64_t state_hash() const;

  // Time ------------------------------------------------------------------------------------------

  /// Advances the world by one time step.
  void step();

  /// Shows the world to a loop before its substeps. Call it also when the world jumped: was
  /// restored, got another time step, or had bodies moved. The loop starts anew. It lets go of all
  /// contacts, and the impulses of substeps since the last step are dropped. Tools keep their last
  /// poses, at rest. Do not open a copy of a loop that goes with a snapshot.
  /// @throws InvalidArgument when a tool names a body that is not kinematic, or that never existed,
  ///         or when a ray of a new patch ends inside its own body. The loop is unchanged then.
  void open(HapticLoop<S>& loop) const;
  /// Applies the impulses of a loop's substeps to the bodies and moves the tools to their poses.
  /// Then advances the world by one time step and shows the loop the new state. Removed bodies
  /// receive nothing. Tools whose body was removed feel nothing.
  /// @throws InvalidArgument when the loop has substeps left, or for its tools as `open`. Nothing
  ///         has changed then.
  void step(HapticLoop<S>& loop);

  /// [s] Length of the next step.
  [[nodiscard]] S time_step() const noexcept { return state_.def.time_step; }
  /// [s] Sets the length of the next steps and wakes all bodies. Forces go on: impulses of the last
  /// step are scaled.
  /// @throws InvalidArgument when `dt` is not finite and > 0, or an impulse would overflow.
  void set_time_step(S dt);
  /// [m/s^2] Sets gravity, world axes.
  /// @throws InvalidArgument when it is not finite.
  void set_gravity(const Vec3<S>& gravity);
  /// Settings of the world.
  [[nodiscard]] const WorldDef<S>& def() const noexcept { return state_.def; }
  /// Figures of the last step.
  [[nodiscard]] const StepReport<S>& report() const noexcept { return state_.report; }
  /// Contacts of the last step as the solver keeps them, by the indices of their shapes. Impulses
  /// are in N s; `set_time_step` scales them to the new step. See `for_each_contact`.
  [[nodiscard]] const detail::ContactCache<S>& contacts() const noexcept { return state_.contacts; }

 private:
  /// Senses with a world that mirrors an external engine.
  friend class HostSensors<S, Backend>;
  /// Steps worlds in shared scratch; resets them in place.
  friend class WorldBatch<S, Backend>;

  using State = detail::WorldState<S>;
  using Prepared = typename Backend::template Collidable<S>;

  void require_known_contacts(BodyId id, bool is_dynamic, const CollisionFilter& filter,
                              ShapeKind kind) const;
  [[nodiscard]] detail::Collider<S> make_collider(const Body<S>& body, Prepared prepared,
                                                  const ShapeDef<S>& def);
  ShapeId insert_shape(BodyId id, detail::Collider<S> collider);
  template <typename AnyState>
  static auto& user_data_in(AnyState& state, BodyId id) {
    return state.bodies.get(id, "BodyId").user_data;
  }
  template <typename AnyState>
  static auto& user_data_in(AnyState& state, ShapeId id) {
    return state.colliders.get(id, "ShapeId").user_data;
  }
  template <typename AnyState>
  static auto& user_data_in(AnyState& state, JointId id) {
    return state.joints.get(id, "JointId").def.user_data;
  }
  template <typename AnyState>
  static auto& user_data_in(AnyState& state, PatchId id) {
    return state.patches.get(id, "PatchId").def.user_data;
  }
  void refresh_box(std::uint32_t tag);
  void set_twist(BodyId id, const Twist<S>& twist);
  /// Velocity that brings a kinematic body to a pose within a step.
  [[nodiscard]] Twist<S> twist_to(BodyId id, const Transform<S>& X_WB) const;
  void push(const detail::HapticBody<S>& pushed);
  template <typename Visit>
  static void for_each_impulse(State& state, Visit&& visit);
  /// @param opens  Of an open loop only new patches are checked.
  void require_tools(const HapticLoop<S>& loop, bool opens) const;
  void erase_joint(std::uint32_t index);

  State state_;
  detail::KernelScratch<detail::WorldKernels<S>> stepper_{detail::world_kernels<S, Backend>()};
};

}  // namespace bristle::inline BRISTLE_ABI

#include <bristle/world/world_contacts_impl.hpp>
#include <bristle/world/world_lists_impl.hpp>
#if defined(BRISTLE_WITH_FCL)
#include <bristle/geometry/backends/fcl_backend.hpp>
#endif

#if BRISTLE_HAS_DEFINITIONS
#include <bristle/world/kernels_impl.hpp>
#include <bristle/world/world_bodies_impl.hpp>
#include <bristle/world/world_impl.hpp>
#include <bristle/world/world_queries_impl.hpp>
#endif

#if defined(BRISTLE_COMPILED) && BRISTLE_HAS_DEFINITIONS
namespace bristle::inline BRISTLE_ABI {

#define BRISTLE_COMPILED_LOOPS(S)                              \
  template <>                                                  \
  const detail::JointKernels<S>& detail::joint_kernels<S>();   \
  template <>                                                  \
  const detail::HapticKernels<S>& detail::haptic_kernels<S>(); \
  extern template class HapticLoop<S>;
BRISTLE_COMPILED_LOOPS(float)
BRISTLE_COMPILED_LOOPS(double)
#undef BRISTLE_COMPILED_LOOPS
#define BRISTLE_COMPILED_WORLD(S, Backend)                            \
  template <>                                                         \
  const detail::WorldKernels<S>& detail::world_kernels<S, Backend>(); \
  extern template class World<S, Backend>;
BRISTLE_COMPILED_WORLD(float, AnalyticBackend)
BRISTLE_COMPILED_WORLD(double, AnalyticBackend)
#if defined(BRISTLE_WITH_FCL)
BRISTLE_COMPILED_WORLD(float, FclBackend)
BRISTLE_COMPILED_WORLD(double, FclBackend)
#endif
#undef BRISTLE_COMPILED_WORLD

}  // namespace bristle::inline BRISTLE_ABI
#endif
