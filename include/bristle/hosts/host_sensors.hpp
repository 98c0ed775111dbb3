/// @file
/// Sensors in somebody else's engine.
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
/// The engine keeps its bodies, its contacts and its solver. Those of its bodies that have sensors,
/// or that sensors are to see, are mirrored in a `World` that is never stepped: it casts the rays,
/// at shapes that are given to the mirrored bodies or by the engine, and keeps patches, readings
/// and snapshots as any world does. A step solves all patches together, implicitly, against the
/// motion that the engine's bodies will have, and hands out wrenches that are stable at any
/// stiffness with a plain "add force" interface.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/kernel_scratch.hpp>
#include <bristle/world/world.hpp>

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// A body of the engine as it is before the engine's step, in world axes.
template <Scalar S>
struct HostBody {
  /// [m] Its frame, in which its shapes and sensors are given.
  Transform<S> pose{};
  /// [m] Its centre of mass in the world.
  Vec3<S> center = Vec3<S>::Zero();
  /// [m/s, rad/s] Of the centre of mass.
  Twist<S> twist{};
  /// [m/s^2, rad/s^2] What the engine will add by itself in its next step: gravity, applied forces,
  /// motors, what turns without torque. The patches solve for the velocity at the end of the step,
  /// so what is left out here is taken for motion: a force f left out presses a stiff patch deeper
  /// by about f dt over its damping.
  Twist<S> acceleration{};
  /// [-] Bodies of one mechanism (links of an arm) move each other; those of others do not.
  std::uint32_t mechanism = no_mechanism;

  static constexpr std::uint32_t no_mechanism = 0xffffffffu;
};

/// What sensors ask of an engine, about mirrored bodies that are not fixed.
///
/// - `host.body(id)` is the present state of a body: a `HostBody<S>`, or nothing where it is gone.
/// - `host.mobility(i, j)` is what an impulse on body j about its centre of mass adds to the twist
///   of body i about its own: `Mat6<S>`, world axes, for i = j symmetric and positive semidefinite;
///   zero for what forces do not move. It is asked for bodies that are touched, and for two of them
///   where they are of one mechanism. `free_mobility` has it for free bodies.
/// - `host.apply_wrench(id, wrench)` adds a wrench [N, N m] about the centre of mass that acts
///   during the engine's next step.
template <typename H, typename S>
concept SensorHost = Scalar<S> &&
    requires(H& host, const H& view, BodyId id, const Wrench<S>& wrench) {
  { view.body(id) } -> std::convertible_to<std::optional<HostBody<S>>>;
  { view.mobility(id, id) } -> std::convertible_to<Mat6<S>>;
  host.apply_wrench(id, wrench);
};

/// An engine that casts rays at geometry which is not mirrored, too.
///
/// `host.cast_rays(id, rays, hits)` offers to `hits` the nearest hit of each ray, the index of the
/// mirrored body that was hit as tag. The rays start from the centre of mass of the mirrored body
/// `id`, along its axes; that body itself is not to be hit. A ray that starts inside a body hits it
/// at distance 0. Rays are as long as in the layout and `rays.extra_length` longer.
template <typename H, typename S>
concept CastsRays = requires(const H& view, BodyId id, const RayBatch<S>& rays, RayHits<S>& hits) {
  view.cast_rays(id, rays, hits);
};

/// [1/kg, 1/(kg m^2)] Mobility of a body that nothing holds, about its centre of mass.
/// @param inverse_mass       [1/kg] Along each axis of the world; zero where it is locked.
/// @param inverse_inertia_W  [1/(kg m^2)] World axes.
template <Scalar S>
[[nodiscard]] Mat6<S> free_mobility(const Vec3<S>& inverse_mass, const Mat3<S>& inverse_inertia_W) {
  return mobility<S>(inverse_mass, inverse_inertia_W, Vec3<S>::Zero());
}
template <Scalar S>
[[nodiscard]] Mat6<S> free_mobility(S inverse_mass, const Mat3<S>& inverse_inertia_W) {
  return free_mobility<S>(Vec3<S>::Constant(inverse_mass), inverse_inertia_W);
}

/// What a step of `HostSensors` did.
struct HostReport {
  /// [-] Mirrored bodies that the engine had no state for, or one that was not finite: nobody saw
  /// them, and their patches let go.
  std::size_t missing_bodies = 0;
  /// [-] Bodies that a patch touched, summed over patches.
  std::size_t pairs = 0;
  /// [-] Times the patches were solved, since sensors changed state.
  int passes = 0;
  /// [-] Pairs whose impulses were not finite, and were not applied.
  std::size_t discarded = 0;
};

template <Scalar S, typename Backend = AnalyticBackend>
class HostSensors;

/// The functions of `HostSensors` that are compiled for each instruction set, as `WorldKernels`.
template <Scalar S, typename Backend>
struct HostKernels {
  /// A new `HostStage`, and its end.
  void* (*make_scratch)();
  void (*delete_scratch)(void* stage);
  /// `HostStage::cast`, `collect` and `solve`.
  void (*cast)(void* stage, HostSensors<S, Backend>& sensors, bool all_rays);
  void (*collect)(void* stage, HostSensors<S, Backend>& sensors);
  void (*solve)(void* stage, HostSensors<S, Backend>& sensors);
};

/// The table that is used from here on.
template <Scalar S, typename Backend>
[[nodiscard]] const HostKernels<S, Backend>& host_kernels();

namespace detail {

template <Scalar S, typename Backend>
class HostStage;

/// A mirrored body in a step.
template <Scalar S>
struct HostEntry {
  HostBody<S> host{};
  /// [m/s, rad/s] About the mirrored centre of mass: the twist it will have without sensors.
  Twist<S> free{};
  /// [m] From the engine's centre of mass to the mirrored one, world axes.
  Vec3<S> shift = Vec3<S>::Zero();
  bool is_there = false;
  bool has_moved = false;
};

/// What one touched body does to another.
template <Scalar S>
struct HostMobility {
  std::uint32_t from = 0;
  std::uint32_t to = 0;
  Mat6<S> matrix = Mat6<S>::Zero();
};

/// What a body is to be given.
template <Scalar S>
struct HostWrench {
  std::uint32_t body = 0;
  Wrench<S> wrench{};
};

/// Tags from here on are bodies that the engine hit.
inline constexpr std::uint32_t first_host_tag = 0x80000000u;

}  // namespace detail

/// The sensors of an engine. A value, as its world is.
///
/// Patches are integrated implicitly unless their definition asks for explicit integration or for
/// AMBF's law: `PatchDef::explicit_below` is not used.
template <Scalar S, typename Backend>
class HostSensors {
 public:
  HostSensors() = default;

  /// The mirrored bodies, their shapes and patches; for readings, queries and snapshots, too.
  /// Bodies that are not fixed are asked of the engine in each step, whatever their kind of motion;
  /// masses and joints are not used. Do not step it: the engine does.
  [[nodiscard]] World<S, Backend>& world() noexcept { return world_; }
  [[nodiscard]] const World<S, Backend>& world() const noexcept { return world_; }

  /// Senses, and gives the engine's bodies the mean force of its next step. Gives nothing that is
  /// not finite, and allocates only until warm.
  /// @param dt  [s] Length of the engine's next step.
  /// @throws InvalidArgument when dt is not finite and > 0, or when the engine hits what is no
  ///         mirrored body; and whatever the engine throws. Nothing was applied then.
  template <typename Host>
  requires SensorHost<Host, S>
  void step(Host& host, S dt) {
    detail::require_positive("dt", dt);
    if (dt != world_.time_step()) world_.set_time_step(dt);
    report_ = {};
    observe(host);
    stage_.kernels().cast(stage_.get(), *this, CastsRays<Host, S>);
    if constexpr (CastsRays<Host, S>) add_hits_of(host);
    stage_.kernels().collect(stage_.get(), *this);
    ask_mobilities(host);
    stage_.kernels().solve(stage_.get(), *this);
    for (const detail::HostWrench<S>& given : wrenches_) {
      host.apply_wrench(world_.state_.bodies.handle(given.body), given.wrench);
    }
  }

  /// What the last step did.
  [[nodiscard]] const HostReport& report() const noexcept { return report_; }

 private:
  friend class detail::HostStage<S, Backend>;
  using State = WorldState<S, Backend>;

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
  /// Asks the engine what the rays of each patch meet.
  template <typename Host>
  void add_hits_of(const Host& host) {
    for (std::uint32_t i = 0; i < state().patches.slot_count(); ++i) {
      if (!is_sensing(i)) continue;
      SensorPatch<S>& patch = state().patches.at(i);
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

  /// Whether the patch in a slot senses in this step.
  [[nodiscard]] bool is_sensing(std::uint32_t slot) {
    return state().is_sensing(slot) && bodies_[state().patches.at(slot).body.index].is_there;
  }
  /// Whether the engine moves a body.
  [[nodiscard]] bool is_mobile(std::uint32_t slot) {
    return state().bodies.at(slot).motion != Motion::fixed;
  }
  [[nodiscard]] bool are_coupled(std::uint32_t i, std::uint32_t j) const {
    return bodies_[i].host.mechanism != HostBody<S>::no_mechanism &&
           bodies_[i].host.mechanism == bodies_[j].host.mechanism;
  }

  /// [m] By how much longer the engine is to cast the rays of a patch: what may come closer.
  [[nodiscard]] S host_reach(const SensorPatch<S>& patch) const {
    const Twist<S>& own = bodies_[patch.body.index].free;
    return world_.time_step() * (own.linear.norm() + own.angular.norm() * patch.reach + fastest_);
  }

  void begin_observing();
  void place(std::uint32_t slot, const std::optional<HostBody<S>>& found);
  void end_observing();
  void take_hits(SensorPatch<S>& patch);

  World<S, Backend> world_{};
  /// By slots of mirrored bodies.
  std::vector<detail::HostEntry<S>> bodies_;
  /// [m/s] Speed of the fastest point of any body.
  S fastest_ = S(0);
  RayHits<S> host_hits_{};
  /// Slots of bodies that a patch touches, or that have one that does, ascending.
  std::vector<std::uint32_t> touched_;
  std::vector<detail::HostMobility<S>> mobilities_;
  std::vector<detail::HostWrench<S>> wrenches_;
  HostReport report_{};
  detail::KernelScratch<HostKernels<S, Backend>> stage_{host_kernels<S, Backend>()};
};

}  // namespace bristle::inline BRISTLE_ABI

// Implementation -----------------------------------------------------------------------------------

#if BRISTLE_HAS_DEFINITIONS
#include <bristle/hosts/host_stage.hpp>

namespace bristle::inline BRISTLE_ABI {

/// Takes the fixed bodies as they are, and all others for gone.
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

/// Moves a mirrored body to where the engine has it, if it says so in numbers.
template <Scalar S, typename Backend>
void HostSensors<S, Backend>::place(std::uint32_t slot, const std::optional<HostBody<S>>& found) {
  using std::abs;
  // A quaternion that is NaN or overflows has no such square, either.
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
  // What is computed with: sums and products of numbers that are finite need not be.
  if (!has_finite_square(body.center_pose.translation) || !has_finite_square(twist.linear) ||
      !has_finite_square(entry.free.linear) || !has_finite_square(entry.free.angular)) {
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

/// Takes over what the engine's rays met nearer than the mirrored shapes.
template <Scalar S, typename Backend>
void HostSensors<S, Backend>::take_hits(SensorPatch<S>& patch) {
  for (std::size_t i = 0; i < patch.size(); ++i) {
    if (!host_hits_.is_hit(i)) continue;
    const std::uint32_t tag = host_hits_.tag[i];
    detail::require(state().bodies.is_live(tag) && tag != patch.body.index, "hits.tag", tag,
                    "must be the index of another body that is mirrored");
    const RayHit<S> hit{host_hits_.distance[i], host_hits_.normal[i]};
    const bool is_valid = hit.distance >= S(0) && has_finite_square(hit.normal);
    if (is_valid && bodies_[tag].is_there) patch.hits.offer(i, hit, detail::first_host_tag | tag);
  }
}

}  // namespace bristle::inline BRISTLE_ABI
#endif

#if defined(BRISTLE_COMPILED) && BRISTLE_HAS_DEFINITIONS
namespace bristle::inline BRISTLE_ABI {

#define BRISTLE_COMPILED_HOSTS(S, Backend)                   \
  template <>                                                \
  const HostKernels<S, Backend>& host_kernels<S, Backend>(); \
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
