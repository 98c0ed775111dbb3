/// @file
/// The world: bodies, shapes, joints and patches of sensors, and one function that steps them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/kernel_scratch.hpp>
#include <bristle/geometry/backends/analytic_backend.hpp>
#include <bristle/sensors/tuning.hpp>
#include <bristle/world/contact_events.hpp>
#include <bristle/world/haptic_loop.hpp>
#include <bristle/world/kernels.hpp>
#include <bristle/world/proximity.hpp>
#include <bristle/world/ray_query.hpp>
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
/// Calls that take a definition check it and throw `InvalidArgument` before anything has changed;
/// so do calls with a handle that names nothing any more. `step` never throws, never lets a
/// non-finite number spread, and does not allocate once it has seen the scene's largest step.
///
/// A world is a value: a copy steps on exactly as the original would, and warms up scratch memory
/// of its own. One that was moved from may only be destroyed or assigned to. The same calls give
/// the same bits, run to run and for any `WorldDef::parallel_for`. One thread at a time may use a
/// world; const calls may run concurrently.
///
/// @tparam S        Scalar: float, double, or `Dual<double, n>` (docs/gradients.md).
/// @tparam Backend  What computes geometry; see `ShapeBackend`.
template <Scalar S, typename Backend = AnalyticBackend>
requires ShapeBackend<Backend, S>
class World {
 public:
  /// @throws InvalidArgument naming the field of the definition.
  explicit World(const WorldDef<S>& def = {});
  World(const World& other);
  World(World&& other) noexcept;
  World& operator=(const World& other);
  World& operator=(World&& other) noexcept;
  ~World();

  // Bodies and shapes
  // ------------------------------------------------------------------------------

  /// Adds a body, with the shapes it has.
  /// @throws InvalidArgument naming the field; or when the backend knows no contact between this
  ///         shape and one already here that it may meet (docs/backends.md lists the pairs).
  BodyId add_body(const BodyDef<S>& def);

  /// Adds a shape to a body; mass properties stay as they are.
  ShapeId add_shape(BodyId body, const ShapeDef<S>& def);

  /// Removes a body with its shapes, patches and joints. Sensors of others let go of it.
  void remove_body(BodyId id);
  void remove_shape(ShapeId id);

  [[nodiscard]] bool contains(BodyId id) const noexcept { return state_.bodies.contains(id); }
  /// Mass, pose and velocities of a body.
  [[nodiscard]] const Body<S>& body(BodyId id) const { return state_.bodies.get(id, "BodyId"); }
  /// Pose of the body frame in the world.
  [[nodiscard]] Transform<S> pose(BodyId id) const { return body(id).pose(); }
  /// [-] Number of bodies.
  [[nodiscard]] std::size_t body_count() const noexcept { return state_.bodies.size(); }

  /// Puts a body somewhere else at once; its velocity stays. Its contacts and bristles notice in
  /// the next step.
  void set_pose(BodyId id, const Transform<S>& X_WB);
  /// [m/s, rad/s] Sets the velocity of the centre of mass and the angular velocity, world axes. The
  /// body must not be fixed.
  void set_velocity(BodyId id, const Twist<S>& twist);
  /// Gives a kinematic body the velocity that brings it to a pose at the end of the next step; it
  /// keeps moving at it until told otherwise.
  void move_to(BodyId id, const Transform<S>& X_WB);
  /// [N, N m] Adds a wrench about the centre of mass, world axes, that acts during the next step.
  void apply_wrench(BodyId id, const Wrench<S>& wrench);
  /// [N] Adds a force at a point [m] of the world that acts during the next step.
  void apply_force(BodyId id, const Vec3<S>& force, const Vec3<S>& point);
  /// [-] Changes who may touch and sense a body.
  void set_filter(BodyId id, const CollisionFilter& filter);
  /// [kg] Gives a dynamic body another mass; its inertia changes in proportion, as that of the same
  /// solid of another density, and is rounded each time.
  /// @throws InvalidArgument when the body is not dynamic, the mass is not > 0, or the mass or the
  ///         inertia has no finite inverse.
  void set_mass(BodyId id, S mass);
  /// [1] Gives all shapes of a body the same other surface.
  /// @throws InvalidArgument naming the field of the material.
  void set_material(BodyId id, const Material<S>& material);

  /// Whether a body sleeps (`WorldDef::sleep`; off unless set). All calls above that change a body
  /// wake its island, and so does what comes to reach it.
  [[nodiscard]] bool is_asleep(BodyId id) const { return body(id).is_asleep(); }
  /// Wakes a body with its island; it has to be at rest for `SleepDef::time` to sleep again.
  void wake(BodyId id);

  // Joints
  // -----------------------------------------------------------------------------------------

  JointId add_joint(const JointDef<S>& def);
  void remove_joint(JointId id);
  /// Whether there is such a joint.
  [[nodiscard]] bool contains(JointId id) const noexcept { return state_.joints.contains(id); }
  /// Changes what drives a joint.
  void set_drive(JointId id, const JointDrive<S>& drive);
  /// Position, velocity and forces of a joint in the last step.
  [[nodiscard]] JointReading<S> reading(JointId id) const;

  // Sensors
  // ----------------------------------------------------------------------------------------

  /// Adds sensors to a body, in its frame. Shapes that the body gets later are not looked at.
  /// @throws InvalidArgument naming the field or the sensor that points into its own body.
  PatchId add_patch(BodyId body, PatchDef<S> def);
  /// A patch whose sensors share constants and integrate automatically.
  PatchId add_patch(BodyId body, SensorLayout<S> sensors, const SensorParameters<S>& parameters);
  /// The same with constants from physical wants; the patch is taken to carry the load alone.
  PatchId add_patch(BodyId body, SensorLayout<S> sensors, const Tuning<S>& tuning);
  void remove_patch(PatchId id);
  /// Switches a patch off or on. Switched off it lets go of what it holds, reads nothing and costs
  /// nothing; `patch(id).is_active` tells.
  void set_active(PatchId id, bool is_active);
  /// Gives all sensors of a patch the same constants, also where they had their own; bristles keep
  /// their stretch.
  void set_parameters(PatchId id, const SensorParameters<S>& parameters);
  /// What a patch felt in the last step; valid until the next one.
  [[nodiscard]] PatchReading<S> reading(PatchId id) const;
  /// Whether there is such a patch.
  [[nodiscard]] bool contains(PatchId id) const noexcept { return state_.patches.contains(id); }
  [[nodiscard]] const SensorPatch<S>& patch(PatchId id) const {
    return state_.patches.get(id, "PatchId");
  }

  /// [s] Longest step at which what the patch touched in the last step could be integrated
  /// explicitly; infinite when it touched nothing that moves.
  [[nodiscard]] S largest_stable_step(PatchId id) const;

  // Queries
  // ----------------------------------------------------------------------------------------

  /// Nearest hit of a ray with any shape. O(log n) of the number of shapes.
  [[nodiscard]] WorldRayHit<S> cast_ray(const Ray<S>& ray, const RayFilter& filter = {}) const;
  /// Nearest hits of many rays; `hits` has one entry a ray.
  void cast_rays(std::span<const Ray<S>> rays, const RayFilter& filter,
                 std::span<WorldRayHit<S>> hits) const;
  /// Measures distances with an array of rays on a body, given in its frame, as things are now.
  /// Several arrays may be filled at once from several threads.
  void sense(BodyId carrier, ProximityArray<S>& array) const;

  // Contacts
  // ---------------------------------------------------------------------------------------

  /// Calls visit(const ContactEvent&) for every two shapes that touched in the last step or in the
  /// one before it: first for touches that a removal ended, then in the order of slots. Costs
  /// nothing unless called; call it before the world is changed again.
  template <typename Visit>
  void for_each_contact_event(Visit&& visit) const;
  /// Calls visit(const ContactReading<S>&) for every two shapes that were within reach of each
  /// other in the last step, in the order of slots.
  template <typename Visit>
  void for_each_contact(Visit&& visit) const;
  /// [N s, N m s] What all contacts of a body gave it in the last step, about its centre of mass.
  [[nodiscard]] Wrench<S> contact_impulse(BodyId id) const;
  /// The same of those with one other body.
  [[nodiscard]] Wrench<S> contact_impulse(BodyId id, BodyId from) const;

  // State
  // ------------------------------------------------------------------------------------------

  /// All that changes from step to step or by the calls above, as bytes: poses, velocities, contact
  /// and joint impulses, bristles, readings, drives, filters, masses, surfaces, constants of
  /// sensors, step length and gravity. Not shapes and other definitions. For this version and
  /// machine.
  [[nodiscard]] std::vector<std::byte> snapshot() const;
  /// Puts the world into the state of a snapshot; it then steps on with the same bits. It must have
  /// the same bodies, shapes, joints and patches, under the same handles: be the world the snapshot
  /// was taken of, or built by the same calls. What the last step did (`report`, contact events) is
  /// not state and stays with the world that did it.
  /// @throws InvalidArgument naming what differs, or what is wrong with the bytes.
  void restore(std::span<const std::byte> bytes);
  /// [-] One number for what a snapshot would hold (`BitHash` of it, value by value): equal bits,
  /// equal number, and for different ones a different number but for a chance of 2^-64.
  [[nodiscard]] std::uint64_t state_hash() const;

  // Time
  // -------------------------------------------------------------------------------------------

  /// Advances the world by one time step.
  void step();

  /// Shows a haptic loop the world as it is, before its first ticks, and when the world has jumped:
  /// was restored, got another time step, or has bodies set elsewhere. The loop starts anew: it
  /// lets go of all it touched, and ticks since the last step give nothing to anybody. Tools stay
  /// where they were moved to last, at rest. A copy of a loop that goes with a snapshot is not
  /// opened.
  /// @throws InvalidArgument when a tool names a body that is not kinematic, or none that ever was;
  ///         the loop is unchanged then.
  void open(HapticLoop<S, Backend>& loop) const;
  /// Gives the bodies what the ticks of a loop gave them, moves the tools to where it has them,
  /// advances the world by one time step, and shows the loop the new state. Bodies that are gone
  /// get nothing, and tools whose body is gone feel nothing.
  /// @throws InvalidArgument when the loop has not done all its ticks, or for its tools as `open`;
  ///         nothing has changed then.
  void step(HapticLoop<S, Backend>& loop);

  /// [s] Length of the next step.
  [[nodiscard]] S time_step() const noexcept { return state_.def.time_step; }
  void set_time_step(S dt);
  void set_gravity(const Vec3<S>& gravity);
  [[nodiscard]] const WorldDef<S>& def() const noexcept { return state_.def; }
  /// What the last step did.
  [[nodiscard]] const StepReport<S>& report() const noexcept { return state_.report; }
  /// Contacts of the last step, by the slots of their shapes, with their impulses (N s; after
  /// `set_time_step`, scaled to the new step), as the solver keeps them. See `for_each_contact`.
  [[nodiscard]] const ContactCache<S>& contacts() const noexcept { return state_.contacts; }

 private:
  /// Senses with a world that mirrors somebody else's engine.
  friend class HostSensors<S, Backend>;
  /// Steps worlds in scratch memory that they share, and resets them in place.
  friend class WorldBatch<S, Backend>;

  using State = WorldState<S, Backend>;
  using Prepared = typename Backend::template Collidable<S>;

  void require_known_contacts(BodyId id, bool is_dynamic, const CollisionFilter& filter,
                              ShapeKind kind) const;
  [[nodiscard]] static Collider<S, Backend> make_collider(const Body<S>& body, Prepared prepared,
                                                          const Shape<S>& shape,
                                                          const Transform<S>& X_BS,
                                                          const Material<S>& material);
  ShapeId insert_shape(BodyId id, Collider<S, Backend> collider);
  template <typename Visit>
  void for_each_shape_of(BodyId id, Visit&& visit) const;
  void refresh_box(std::uint32_t tag);
  void set_twist(BodyId id, const Twist<S>& twist);
  /// Velocity that brings a kinematic body to a pose within a step.
  [[nodiscard]] Twist<S> twist_to(BodyId id, const Transform<S>& X_WB) const;
  void push(const HapticBody<S>& pushed);
  template <typename Visit>
  static void for_each_impulse(State& state, Visit&& visit);
  void require_tools(const HapticLoop<S, Backend>& loop) const;
  void erase_joint(std::uint32_t index);

  State state_;
  detail::KernelScratch<WorldKernels<S, Backend>> stepper_{world_kernels<S, Backend>()};
};

}  // namespace bristle::inline BRISTLE_ABI

#include <bristle/world/world_contacts_impl.hpp>
#if defined(BRISTLE_WITH_FCL)
#include <bristle/geometry/backends/fcl_backend.hpp>
#endif

#if BRISTLE_HAS_DEFINITIONS
#include <bristle/world/kernels_impl.hpp>
#include <bristle/world/world_bodies_impl.hpp>
#include <bristle/world/world_impl.hpp>
#endif

#if defined(BRISTLE_COMPILED) && BRISTLE_HAS_DEFINITIONS
namespace bristle::inline BRISTLE_ABI {

#define BRISTLE_COMPILED_WORLD(S, Backend)                       \
  template <>                                                    \
  const WorldKernels<S, Backend>& world_kernels<S, Backend>();   \
  template <>                                                    \
  const HapticKernels<S, Backend>& haptic_kernels<S, Backend>(); \
  extern template class World<S, Backend>;                       \
  extern template class HapticLoop<S, Backend>;
BRISTLE_COMPILED_WORLD(float, AnalyticBackend)
BRISTLE_COMPILED_WORLD(double, AnalyticBackend)
#if defined(BRISTLE_WITH_FCL)
BRISTLE_COMPILED_WORLD(float, FclBackend)
BRISTLE_COMPILED_WORLD(double, FclBackend)
#endif
#undef BRISTLE_COMPILED_WORLD

}  // namespace bristle::inline BRISTLE_ABI
#endif
