/// @file
/// Sensors in an external engine.
///
///     HostSensors<double> sensors;
///     World<double>& mirror = sensors.world();
///     const BodyId part = mirror.add_body({.shape = Box<double>{{0.02, 0.02, 0.02}}});
///     const BodyId finger = mirror.add_body({.motion = Motion::kinematic});
///     mirror.add_patch(finger, pad);
///     for (;;) {
///       sensors.step(engine, dt);  // before the engine's own step
///       engine.step(dt);
///     }
///
/// The engine keeps its bodies, contacts and solver. Its bodies with sensors, and those to sense,
/// are mirrored in a `World` that is never stepped. That world casts the rays, at shapes of the
/// mirrored bodies or by the engine. Like any world, it keeps patches, readings and snapshots. A
/// step solves all patches together, implicitly, against the motion that the engine's bodies will
/// have. It yields wrenches that are stable at any stiffness with a plain "add force" interface.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/kernel_scratch.hpp>
#include <bristle/core/no_index.hpp>
#include <bristle/hosts/hosts_constants.hpp>
#include <bristle/world/world.hpp>

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace bristle::inline BRISTLE_ABI {

/// State of an engine body before the engine's step, in world axes. Engines keep it in types of
/// their own, and only this record passes between them and the sensors.
template <Scalar S>
struct HostBody {
  /// [m] Pose of its shapes' and sensors' frame.
  Transform<S> pose{};
  /// [m] Centre of mass in the world.
  Vec3<S> center = detail::zero<Vec3<S>>();
  /// [m/s, rad/s] Velocity of the centre of mass.
  Twist<S> twist{};
  /// [m/s^2, rad/s^2] Acceleration that the engine adds by itself in its next step: gravity,
  /// applied forces, motors, gyroscopic terms. The patches solve for the velocity at the end of the
  /// step. An omission here is taken for motion: an omitted force f presses a stiff patch deeper by
  /// about f dt over its damping.
  Twist<S> acceleration{};
  /// [-] Mechanism of the body. Bodies of one mechanism (links of an arm) move each other; those of
  /// others do not.
  std::uint32_t mechanism = no_mechanism;

  /// [-] Mechanism of a body that is alone.
  static constexpr std::uint32_t no_mechanism = detail::no_index;
};

namespace detail {

/// Interface of an engine that sensors query, for mirrored bodies that are not fixed.
///
/// - `host.body(id)` is the present state of a body: a `HostBody<S>`, or nothing if it is gone.
/// - `host.mobility(i, j)` maps an impulse on body j about its centre of mass to the twist change
///   of body i about its own: `Mat6<S>`, world axes. For i = j it is symmetric and positive
///   semidefinite. It is zero for bodies that forces do not move. It is queried for bodies in
///   contact, and for two of them in one mechanism. `free_mobility` has it for free bodies.
/// - `host.apply_wrench(id, wrench)` adds a wrench [N, N m] about the centre of mass. It acts
///   during the engine's next step.
template <typename H, typename S>
concept SensorHost = Scalar<S> &&
    requires(H& host, const H& view, BodyId id, const Wrench<S>& wrench) {
  { view.body(id) } -> std::convertible_to<std::optional<HostBody<S>>>;
  { view.mobility(id, id) } -> std::convertible_to<Mat6<S>>;
  host.apply_wrench(id, wrench);
};

/// An engine that also casts rays, at geometry that is not mirrored.
///
/// `host.cast_rays(id, rays, hits)` offers to `hits` the nearest hit of each ray. Its tag is the
/// index of the mirrored body that was hit. The rays start from the centre of mass of the mirrored
/// body `id`, along its axes. They must not hit that body itself. A ray that starts inside a body
/// hits it at distance 0. Rays are `rays.extra_length` longer than in the layout. `hits` keeps one
/// entry for each ray.
template <typename H, typename S>
concept CastsRays = requires(const H& view, BodyId id, const RayBatch<S>& rays, RayHits<S>& hits) {
  view.cast_rays(id, rays, hits);
};

}  // namespace detail

/// [1/kg, 1/(kg m^2)] Mobility of a free body, about its centre of mass.
/// @param inverse_mass       [1/kg] Along each axis of the world; zero where locked.
/// @param inverse_inertia_W  [1/(kg m^2)] World axes.
template <Scalar S>
[[nodiscard]] Mat6<S> free_mobility(const Vec3<S>& inverse_mass, const Mat3<S>& inverse_inertia_W) {
  return detail::mobility<S>(inverse_mass, inverse_inertia_W, detail::zero<Vec3<S>>());
}
/// The same for one inverse mass [1/kg] along all axes.
template <Scalar S>
[[nodiscard]] Mat6<S> free_mobility(S inverse_mass, const Mat3<S>& inverse_inertia_W) {
  return free_mobility<S>(detail::filled<Vec3<S>>(inverse_mass), inverse_inertia_W);
}

/// Figures of a step of `HostSensors`.
struct HostReport {
  /// [-] Mirrored bodies without a finite engine state. They were not sensed; their own patches let
  /// go.
  std::size_t missing_bodies = 0;
  /// [-] Bodies in contact with a patch, summed over patches.
  std::size_t pairs = 0;
  /// [-] Solves of the patches: more than one if sensors changed state.
  int passes = 0;
  /// [-] Pairs whose impulses were not finite. They were not applied.
  std::size_t discarded = 0;
};

template <Scalar S, typename Backend = AnalyticBackend>
class HostSensors;

namespace detail {

/// A mirrored body in a step.
template <Scalar S>
struct HostEntry {
  HostBody<S> host{};
  /// [m/s, rad/s] Twist it will have without sensors, about the mirrored centre of mass.
  Twist<S> free{};
  /// [m] From the engine's centre of mass to the mirrored one, world axes.
  Vec3<S> shift = zero<Vec3<S>>();
  bool is_there = false;
  bool has_moved = false;
};

/// Mobility between two bodies in contact.
template <Scalar S>
struct HostMobility {
  std::uint32_t from = 0;
  std::uint32_t to = 0;
  Mat6<S> matrix = zero<Mat6<S>>();
};

/// Wrench to apply to a body.
template <Scalar S>
struct HostWrench {
  std::uint32_t body = 0;
  Wrench<S> wrench{};
};

/// First tag of bodies that the engine hit.
inline constexpr std::uint32_t first_host_tag = 0x80000000u;

/// Input and results of a step of an engine's sensors. The mirrored world is apart.
template <Scalar S>
struct HostStep {
  /// By index of mirrored bodies.
  DynamicArray<HostEntry<S>> bodies;
  /// [m/s] Speed of the fastest point of any body.
  S fastest = S(0);
  /// Indices of bodies that a patch touches, or whose own patch touches one, ascending.
  DynamicArray<std::uint32_t> touched;
  DynamicArray<HostMobility<S>> mobilities;
  DynamicArray<HostWrench<S>> wrenches;
  HostReport report{};

  /// Marks fixed bodies as present, all others as gone.
  void begin(const WorldState<S>& world);
  /// Moves a mirrored body to the engine's pose, if that is finite.
  void place(WorldState<S>& world, std::uint32_t slot, const std::optional<HostBody<S>>& found);
  /// Finds `fastest` once all bodies are placed.
  void find_fastest(const WorldState<S>& world);

  /// Returns whether the patch in a slot senses in this step.
  [[nodiscard]] bool is_sensing(const WorldState<S>& world, std::uint32_t slot) const {
    return world.is_sensing(slot) && bodies[world.patches.at(slot).body.index].is_there;
  }
  [[nodiscard]] bool are_coupled(std::uint32_t i, std::uint32_t j) const {
    return bodies[i].host.mechanism != HostBody<S>::no_mechanism &&
           bodies[i].host.mechanism == bodies[j].host.mechanism;
  }
  /// [m] Extra length of a patch's rays, for bodies that come closer within a step of dt [s].
  [[nodiscard]] S reach(const SensorPatch<S>& patch, S dt) const {
    const Twist<S>& own = bodies[patch.body.index].free;
    return dt * (own.linear.norm() + own.angular.norm() * patch.geometry->reach + fastest);
  }
};

/// Returns whether the engine moves a mirrored body.
template <Scalar S>
[[nodiscard]] bool is_moved_by_engine(const WorldState<S>& world, std::uint32_t slot) {
  return world.bodies.at(slot).motion != Motion::fixed;
}

/// Functions of `HostSensors` that are compiled for each instruction set, as `WorldKernels`.
template <Scalar S>
struct HostKernels {
  /// Creates a `HostStage`, and deletes it.
  void* (*make_scratch)();
  void (*delete_scratch)(void* stage);
  /// Functions of `HostStage`.
  void (*cast)(void* stage, WorldState<S>& world, const HostStep<S>& step, bool all_rays);
  void (*take_hits)(void* stage, std::uint32_t patch, const RayHits<S>& hits);
  void (*collect)(void* stage, WorldState<S>& world, HostStep<S>& step);
  void (*solve)(void* stage, WorldState<S>& world, HostStep<S>& step);
};

/// The table to use from here on.
template <Scalar S>
[[nodiscard]] const HostKernels<S>& host_kernels();

}  // namespace detail

/// The sensors of an engine. A value, as its world is.
///
/// Patches are integrated implicitly unless their definition asks for explicit integration or
/// AMBF's law. `PatchDef::explicit_below` is not used.
template <Scalar S, typename Backend>
class HostSensors {
 public:
  HostSensors() = default;

  /// The mirrored bodies, their shapes and patches; also for readings, queries and snapshots. The
  /// engine is queried for bodies that are not fixed in each step, whatever their kind of motion.
  /// Masses and joints are not used, and queries know mirrored shapes alone. Never step this world:
  /// the engine steps.
  [[nodiscard]] World<S, Backend>& world() noexcept { return world_; }
  /// The same world for reading.
  [[nodiscard]] const World<S, Backend>& world() const noexcept { return world_; }

  /// Senses, and applies the mean force of the next step to the engine's bodies. Applies only
  /// finite forces. Allocates only until warm, apart from what the engine's functions do.
  /// @param dt  [s] Length of the engine's next step.
  /// @throws InvalidArgument when dt is not finite and > 0, or when the engine hits a body that is
  ///         not mirrored; and any exception of the engine. Nothing was applied then, unless it was
  ///         `apply_wrench` that threw: the wrenches before it were.
  template <typename Host>
  requires detail::SensorHost<Host, S>
  void step(Host& host, S dt) {
    detail::require_positive("dt", dt);
    if (dt != world_.time_step()) world_.set_time_step(dt);
    step_.report = {};
    observe(host);
    stage_.kernels().cast(stage_.get(), state(), step_, detail::CastsRays<Host, S>);
    if constexpr (detail::CastsRays<Host, S>) add_hits_of(host);
    stage_.kernels().collect(stage_.get(), state(), step_);
    ask_mobilities(host);
    stage_.kernels().solve(stage_.get(), state(), step_);
    state().touch_log.update(state().patches);
    for (const detail::HostWrench<S>& applied : step_.wrenches) {
      host.apply_wrench(state().bodies.handle(applied.body), applied.wrench);
    }
  }

  /// Figures of the last step.
  [[nodiscard]] const HostReport& report() const noexcept { return step_.report; }

 private:
  [[nodiscard]] detail::WorldState<S>& state() noexcept { return world_.state_; }

  template <typename Host>
  void observe(const Host& host) {
    step_.begin(state());
    for (std::uint32_t i = 0; i < step_.bodies.size(); ++i) {
      if (!state().bodies.is_live(i)) continue;
      if (state().bodies.at(i).motion == Motion::fixed) continue;
      step_.place(state(), i, host.body(state().bodies.handle(i)));
    }
    step_.find_fastest(state());
    for (const std::uint32_t i : state().colliders.live_slots()) {
      if (step_.bodies[state().colliders.at(i).body.index].has_moved) world_.refresh_box(i);
    }
  }
  /// Queries the engine for each patch's ray hits.
  template <typename Host>
  void add_hits_of(const Host& host) {
    for (const std::uint32_t i : state().patches.live_slots()) {
      if (!step_.is_sensing(state(), i)) continue;
      const detail::SensorPatch<S>& patch = state().patches.at(i);
      host_hits_.reset(patch.size());
      host.cast_rays(patch.body, patch.geometry->rays(step_.reach(patch, world_.time_step())),
                     host_hits_);
      check_hits(patch);
      stage_.kernels().take_hits(stage_.get(), i, host_hits_);
    }
  }
  template <typename Host>
  void ask_mobilities(const Host& host) {
    const auto& touched = step_.touched;
    step_.mobilities.clear();
    for (std::size_t k = 0; k < touched.size(); ++k) {
      for (std::size_t l = 0; l <= k; ++l) {
        if (k == l ? !detail::is_moved_by_engine(state(), touched[k])
                   : !step_.are_coupled(touched[k], touched[l])) {
          continue;
        }
        step_.mobilities.push_back(
            {touched[k], touched[l],
             host.mobility(state().bodies.handle(touched[k]), state().bodies.handle(touched[l]))});
      }
    }
  }

  void check_hits(const detail::SensorPatch<S>& patch);

  World<S, Backend> world_{};
  detail::HostStep<S> step_{};
  RayHits<S> host_hits_{};
  detail::KernelScratch<detail::HostKernels<S>> stage_{detail::host_kernels<S>()};
};

}  // namespace bristle::inline BRISTLE_ABI

// Implementation ----------------------------------------------------------------------------------

#if BRISTLE_HAS_DEFINITIONS
#include <bristle/hosts/host_stage.hpp>

namespace bristle::inline BRISTLE_ABI {

template <Scalar S>
void detail::HostStep<S>::begin(const WorldState<S>& world) {
  bodies.resize(world.bodies.slot_count());
  for (std::uint32_t i = 0; i < bodies.size(); ++i) {
    bodies[i] = {};
    if (!world.bodies.is_live(i)) continue;
    const Body<S>& body = world.bodies.at(i);
    if (body.motion != Motion::fixed) continue;
    bodies[i].is_there = true;
    bodies[i].host.center = body.center_pose.translation;
  }
}

template <Scalar S>
void detail::HostStep<S>::place(WorldState<S>& world, std::uint32_t slot,
                                const std::optional<HostBody<S>>& found) {
  using std::abs;
  // This also fails for NaN or overflowing quaternions.
  if (!found ||
      !(abs(found->pose.rotation.squaredNorm() - S(1)) < S(chosen::host_rotation_error))) {
    ++report.missing_bodies;
    return;
  }
  Body<S>& body = world.bodies.at(slot);
  HostEntry<S>& entry = bodies[slot];
  const Transform<S> before = body.center_pose;
  body.set_pose({found->pose.rotation.normalized(), found->pose.translation});
  entry.shift = body.center_pose.translation - found->center;
  const Twist<S> twist = found->twist.shifted(entry.shift);
  entry.free = twist + world.def.time_step * found->acceleration.shifted(entry.shift);
  // The step computes with these: sums and products of finite numbers may overflow.
  if (!has_finite_square(body.center_pose.translation) || !has_finite_square(twist.linear) ||
      !has_finite_square(entry.free.linear) || !has_finite_square(entry.free.angular)) {
    body.center_pose = before;
    entry.free = {};
    ++report.missing_bodies;
    return;
  }
  body.twist = twist;
  entry.host = *found;
  entry.is_there = true;
  entry.has_moved = body.center_pose.translation != before.translation ||
                    body.center_pose.rotation.coeffs() != before.rotation.coeffs();
}

template <Scalar S>
void detail::HostStep<S>::find_fastest(const WorldState<S>& world) {
  fastest = S(0);
  for (const HostEntry<S>& entry : bodies) {
    fastest = std::max(fastest, entry.free.linear.norm());
  }
  for (const std::uint32_t i : world.colliders.live_slots()) {
    if (world.colliders.at(i).half_space) continue;
    const Twist<S>& free = bodies[world.colliders.at(i).body.index].free;
    fastest =
        std::max(fastest, free.linear.norm() + free.angular.norm() * world.colliders.at(i).radius);
  }
}

/// Removes the engine's hits that are no numbers, or on bodies that are missing.
template <Scalar S, typename Backend>
void HostSensors<S, Backend>::check_hits(const detail::SensorPatch<S>& patch) {
  const std::size_t n = patch.size();
  const std::size_t sizes[] = {host_hits_.distance.size(), host_hits_.normal.x.size(),
                               host_hits_.normal.y.size(), host_hits_.normal.z.size(),
                               host_hits_.tag.size()};
  for (const std::size_t size : sizes) {
    detail::require(size == n, "hits", size, "must keep one entry for each ray");
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (!host_hits_.is_hit(i)) continue;
    const std::uint32_t tag = host_hits_.tag[i];
    detail::require(state().bodies.is_live(tag) && tag != patch.body.index, "hits.tag", tag,
                    "must be the index of another body that is mirrored");
    const bool is_valid = host_hits_.distance[i] >= S(0) &&
                          detail::has_finite_square(host_hits_.normal[i]) &&
                          step_.bodies[tag].is_there;
    if (!is_valid) host_hits_.distance[i] = infinity<S>;
  }
}

}  // namespace bristle::inline BRISTLE_ABI
#endif

#if defined(BRISTLE_COMPILED) && BRISTLE_HAS_DEFINITIONS
namespace bristle::inline BRISTLE_ABI {

template <>
const detail::HostKernels<float>& detail::host_kernels<float>();
template <>
const detail::HostKernels<double>& detail::host_kernels<double>();
extern template struct detail::HostStep<float>;
extern template struct detail::HostStep<double>;
#define BRISTLE_COMPILED_HOSTS(S, Backend) extern template class HostSensors<S, Backend>;
BRISTLE_COMPILED_HOSTS(float, AnalyticBackend)
BRISTLE_COMPILED_HOSTS(double, AnalyticBackend)
#if defined(BRISTLE_WITH_FCL)
BRISTLE_COMPILED_HOSTS(float, FclBackend)
BRISTLE_COMPILED_HOSTS(double, FclBackend)
#endif
#undef BRISTLE_COMPILED_HOSTS

}  // namespace bristle::inline BRISTLE_ABI
#endif
