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
#include <bristle/world/world.hpp>

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace bristle::inline BRISTLE_ABI {

/// State of an engine body before the engine's step, in world axes.
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
  static constexpr std::uint32_t no_mechanism = 0xffffffffu;
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
/// hits it at distance 0. Rays are `rays.extra_length` longer than in the layout.
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

/// Functions of `HostSensors` that are compiled for each instruction set, as `WorldKernels`.
template <Scalar S, typename Backend>
struct HostKernels {
  /// Creates a `HostStage`, and deletes it.
  void* (*make_scratch)();
  void (*delete_scratch)(void* stage);
  /// `HostStage::cast`, `collect` and `solve`.
  void (*cast)(void* stage, HostSensors<S, Backend>& sensors, bool all_rays);
  void (*collect)(void* stage, HostSensors<S, Backend>& sensors);
  void (*solve)(void* stage, HostSensors<S, Backend>& sensors);
};

/// The table to use from here on.
template <Scalar S, typename Backend>
[[nodiscard]] const HostKernels<S, Backend>& host_kernels();

template <Scalar S, typename Backend>
class HostStage;

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
  /// Masses and joints are not used. Never step this world: the engine steps.
  [[nodiscard]] World<S, Backend>& world() noexcept { return world_; }
  /// The same world for reading.
  [[nodiscard]] const World<S, Backend>& world() const noexcept { return world_; }

  /// Senses, and applies the mean force of the next step to the engine's bodies. Applies only
  /// finite forces, and allocates only until warm.
  /// @param dt  [s] Length of the engine's next step.
  /// @throws InvalidArgument when dt is not finite and > 0, or when the engine hits a body that is
  ///         not mirrored; and any exception of the engine. Nothing was applied then.
  template <typename Host>
  requires detail::SensorHost<Host, S>
  void step(Host& host, S dt) {
    detail::require_positive("dt", dt);
    if (dt != world_.time_step()) world_.set_time_step(dt);
    report_ = {};
    observe(host);
    stage_.kernels().cast(stage_.get(), *this, detail::CastsRays<Host, S>);
    if constexpr (detail::CastsRays<Host, S>) add_hits_of(host);
    stage_.kernels().collect(stage_.get(), *this);
    ask_mobilities(host);
    stage_.kernels().solve(stage_.get(), *this);
    for (const detail::HostWrench<S>& given : wrenches_) {
      host.apply_wrench(world_.state_.bodies.handle(given.body), given.wrench);
    }
  }

  /// Figures of the last step.
  [[nodiscard]] const HostReport& report() const noexcept { return report_; }

 private:
  friend class detail::HostStage<S, Backend>;
  using State = detail::WorldState<S>;

  [[nodiscard]] State& state() noexcept { return world_.state_; }

  template <typename Host>
  void observe(const Host& host) {
    begin_observing();
    for (std::uint32_t i = 0; i < bodies_.size(); ++i) {
      if (!state().bodies.is_live(i)) continue;
      if (state().bodies.at(i).motion == Motion::fixed) continue;
      place(i, host.body(state().bodies.handle(i)));
    }
    end_observing();
  }
  /// Queries the engine for each patch's ray hits.
  template <typename Host>
  void add_hits_of(const Host& host) {
    for (std::uint32_t i = 0; i < state().patches.slot_count(); ++i) {
      if (!is_sensing(i)) continue;
      detail::SensorPatch<S>& patch = state().patches.at(i);
      host_hits_.reset(patch.size());
      host.cast_rays(patch.body, patch.rays(host_reach(patch)), host_hits_);
      take_hits(patch);
    }
  }
  template <typename Host>
  void ask_mobilities(const Host& host) {
    mobilities_.clear();
    for (std::size_t k = 0; k < touched_.size(); ++k) {
      for (std::size_t l = 0; l <= k; ++l) {
        if (k == l ? !is_mobile(touched_[k]) : !are_coupled(touched_[k], touched_[l])) continue;
        mobilities_.push_back({touched_[k], touched_[l],
                               host.mobility(state().bodies.handle(touched_[k]),
                                             state().bodies.handle(touched_[l]))});
      }
    }
  }

  /// Returns whether the patch in a slot senses in this step.
  [[nodiscard]] bool is_sensing(std::uint32_t slot) {
    return state().is_sensing(slot) && bodies_[state().patches.at(slot).body.index].is_there;
  }
  /// Returns whether the engine moves a body.
  [[nodiscard]] bool is_mobile(std::uint32_t slot) {
    return state().bodies.at(slot).motion != Motion::fixed;
  }
  [[nodiscard]] bool are_coupled(std::uint32_t i, std::uint32_t j) const {
    return bodies_[i].host.mechanism != HostBody<S>::no_mechanism &&
           bodies_[i].host.mechanism == bodies_[j].host.mechanism;
  }

  /// [m] Extra length of a patch's rays in the engine, for bodies that come closer.
  [[nodiscard]] S host_reach(const detail::SensorPatch<S>& patch) const {
    const Twist<S>& own = bodies_[patch.body.index].free;
    return world_.time_step() * (own.linear.norm() + own.angular.norm() * patch.reach + fastest_);
  }

  void begin_observing();
  void place(std::uint32_t slot, const std::optional<HostBody<S>>& found);
  void end_observing();
  void take_hits(detail::SensorPatch<S>& patch);

  World<S, Backend> world_{};
  /// By index of mirrored bodies.
  detail::DynamicArray<detail::HostEntry<S>> bodies_;
  /// [m/s] Speed of the fastest point of any body.
  S fastest_ = S(0);
  RayHits<S> host_hits_{};
  /// Indices of bodies that a patch touches, or whose own patch touches one, ascending.
  detail::DynamicArray<std::uint32_t> touched_;
  detail::DynamicArray<detail::HostMobility<S>> mobilities_;
  detail::DynamicArray<detail::HostWrench<S>> wrenches_;
  HostReport report_{};
  detail::KernelScratch<detail::HostKernels<S, Backend>> stage_{detail::host_kernels<S, Backend>()};
};

}  // namespace bristle::inline BRISTLE_ABI

// Implementation ----------------------------------------------------------------------------------

#if BRISTLE_HAS_DEFINITIONS
#include <bristle/hosts/host_stage.hpp>

namespace bristle::inline BRISTLE_ABI {

/// Marks fixed bodies as present, all others as gone.
template <Scalar S, typename Backend>
void HostSensors<S, Backend>::begin_observing() {
  bodies_.resize(state().bodies.slot_count());
  for (std::uint32_t i = 0; i < bodies_.size(); ++i) {
    bodies_[i] = {};
    if (!state().bodies.is_live(i)) continue;
    const Body<S>& body = state().bodies.at(i);
    if (body.motion != Motion::fixed) continue;
    bodies_[i].is_there = true;
    bodies_[i].host.center = body.center_pose.translation;
  }
}

/// Moves a mirrored body to the engine's pose, if that is finite.
template <Scalar S, typename Backend>
void HostSensors<S, Backend>::place(std::uint32_t slot, const std::optional<HostBody<S>>& found) {
  using std::abs;
  // This also fails for NaN or overflowing quaternions.
  if (!found || !(abs(found->pose.rotation.squaredNorm() - S(1)) < S(0.5))) {
    ++report_.missing_bodies;
    return;
  }
  Body<S>& body = state().bodies.at(slot);
  detail::HostEntry<S>& entry = bodies_[slot];
  const Transform<S> before = body.center_pose;
  body.set_pose({found->pose.rotation.normalized(), found->pose.translation});
  entry.shift = body.center_pose.translation - found->center;
  const Twist<S> twist = found->twist.shifted(entry.shift);
  entry.free = twist + state().def.time_step * found->acceleration.shifted(entry.shift);
  // The step computes with these: sums and products of finite numbers may overflow.
  if (!detail::has_finite_square(body.center_pose.translation) ||
      !detail::has_finite_square(twist.linear) || !detail::has_finite_square(entry.free.linear) ||
      !detail::has_finite_square(entry.free.angular)) {
    body.center_pose = before;
    entry.free = {};
    ++report_.missing_bodies;
    return;
  }
  body.twist = twist;
  entry.host = *found;
  entry.is_there = true;
  entry.has_moved = body.center_pose.translation != before.translation ||
                    body.center_pose.rotation.coeffs() != before.rotation.coeffs();
}

template <Scalar S, typename Backend>
void HostSensors<S, Backend>::end_observing() {
  fastest_ = S(0);
  for (const detail::HostEntry<S>& entry : bodies_) {
    fastest_ = std::max(fastest_, entry.free.linear.norm());
  }
  for (std::uint32_t i = 0; i < state().colliders.slot_count(); ++i) {
    if (!state().colliders.is_live(i)) continue;
    const detail::HostEntry<S>& entry = bodies_[state().colliders.at(i).body.index];
    if (entry.has_moved) world_.refresh_box(i);
    if (state().colliders.at(i).half_space) continue;
    fastest_ = std::max(fastest_, entry.free.linear.norm() +
                                      entry.free.angular.norm() * state().colliders.at(i).radius);
  }
}

/// Takes the engine's hits that are nearer than those on mirrored shapes.
template <Scalar S, typename Backend>
void HostSensors<S, Backend>::take_hits(detail::SensorPatch<S>& patch) {
  for (std::size_t i = 0; i < patch.size(); ++i) {
    if (!host_hits_.is_hit(i)) continue;
    const std::uint32_t tag = host_hits_.tag[i];
    detail::require(state().bodies.is_live(tag) && tag != patch.body.index, "hits.tag", tag,
                    "must be the index of another body that is mirrored");
    const RayHit<S> hit{host_hits_.distance[i], host_hits_.normal[i]};
    const bool is_valid = hit.distance >= S(0) && detail::has_finite_square(hit.normal);
    if (is_valid && bodies_[tag].is_there) patch.hits.offer(i, hit, detail::first_host_tag | tag);
  }
}

}  // namespace bristle::inline BRISTLE_ABI
#endif

#if defined(BRISTLE_COMPILED) && BRISTLE_HAS_DEFINITIONS
namespace bristle::inline BRISTLE_ABI {

#define BRISTLE_COMPILED_HOSTS(S, Backend)                                   \
  template <>                                                                \
  const detail::HostKernels<S, Backend>& detail::host_kernels<S, Backend>(); \
  extern template class HostSensors<S, Backend>;
BRISTLE_COMPILED_HOSTS(float, AnalyticBackend)
BRISTLE_COMPILED_HOSTS(double, AnalyticBackend)
#if defined(BRISTLE_WITH_FCL)
BRISTLE_COMPILED_HOSTS(float, FclBackend)
BRISTLE_COMPILED_HOSTS(double, FclBackend)
#endif
#undef BRISTLE_COMPILED_HOSTS

}  // namespace bristle::inline BRISTLE_ABI
#endif
