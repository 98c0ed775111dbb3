/// @file
/// Definitions of `World`: joints, patches, queries, time. Included by world.hpp.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/dynamics/joints/joint_pose.hpp>
#include <bristle/dynamics/joints/joint_rows.hpp>
#include <bristle/sensors/taxel_points.hpp>
#include <bristle/world/outward_rays.hpp>
#include <bristle/world/patch_stiffness.hpp>
#include <bristle/world/report_patch.hpp>
#include <bristle/world/snapshot.hpp>
#include <bristle/world/waking.hpp>
#include <bristle/world/world.hpp>

namespace bristle::inline BRISTLE_ABI {

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S> World<S, Backend>::World(const WorldDef<S>& def) {
  const auto require_tolerance = [](const char* field, const S& value) {
    using std::isfinite;
    detail::require(isfinite(value) && value > S(0), field, value, "must be finite and > 0");
  };
  detail::require_all_finite("WorldDef::gravity", def.gravity);
  detail::require_positive("WorldDef::time_step", def.time_step);
  detail::require_not_negative("WorldDef::restitution_speed", def.restitution_speed);
  detail::require_not_negative("SleepDef::linear_speed", def.sleep.linear_speed);
  detail::require_not_negative("SleepDef::angular_speed", def.sleep.angular_speed);
  detail::require(def.sleep.time > S(0), "SleepDef::time", def.sleep.time, "must be > 0");
  require_tolerance("SolverDef::tolerance", def.solver.tolerance);
  detail::require(def.solver.max_sweeps > 0, "SolverDef::max_sweeps", def.solver.max_sweeps,
                  "must be > 0");
  detail::require(def.solver.max_position_sweeps >= 0, "SolverDef::max_position_sweeps",
                  def.solver.max_position_sweeps, "must be >= 0");
  require_tolerance("SolverDef::position_tolerance", def.solver.position_tolerance);
  detail::require(def.solver.longest_substep > S(0), "SolverDef::longest_substep",
                  def.solver.longest_substep, "must be > 0");
  detail::require(def.solver.max_newton_steps > 0, "SolverDef::max_newton_steps",
                  def.solver.max_newton_steps, "must be > 0");
  detail::require(def.solver.large_sweeps > 0, "SolverDef::large_sweeps", def.solver.large_sweeps,
                  "must be > 0");
  detail::require(def.solver.large_position_sweeps >= 0, "SolverDef::large_position_sweeps",
                  def.solver.large_position_sweeps, "must be >= 0");
  detail::require(def.solver.max_passes > 0, "SolverDef::max_passes", def.solver.max_passes,
                  "must be > 0");
  detail::require(static_cast<bool>(def.parallel_for), "WorldDef::parallel_for", "empty",
                  "must be callable");
  detail::require(def.combine != nullptr, "WorldDef::combine", "null", "must be a function");
  state_.def = def;
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S> World<S, Backend>::World(const World& other)
= default;
template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S> World<S, Backend>::World(World&& other)
noexcept = default;
template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S> World<S, Backend>
&World<S, Backend>::operator=(const World& other) = default;
template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S> World<S, Backend>
&World<S, Backend>::operator=(World&& other) noexcept = default;
template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S> World<S, Backend>::~World() = default;

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S> JointId World<S, Backend>::add_joint(const JointDef<S>& def) {
  const Body<S> world{};
  const auto body_of = [&](BodyId id, const char* field) -> const Body<S>& {
    return id == BodyId{} ? world : state_.bodies.get(id, field);
  };
  const Body<S>& a = body_of(def.body_a, "JointDef::body_a");
  const Body<S>& b = body_of(def.body_b, "JointDef::body_b");
  validate(def);
  detail::require(def.body_a != def.body_b, "JointDef::body_b", def.body_b,
                  "must not equal body_a");
  detail::require(a.is_dynamic() || b.is_dynamic(), "JointDef::body_a", def.body_a,
                  "must be dynamic, or body_b must");
  detail::Joint<S> joint;
  joint.def = def;
  joint.X_CmA_J = def.X_AJ;
  joint.X_CmA_J.translation -= a.center_B;
  joint.X_CmB_J = def.X_BJ;
  joint.X_CmB_J.translation -= b.center_B;
  const detail::JointPose<S> pose = detail::joint_pose(joint, a.center_pose, b.center_pose);
  const S angle = detail::joint_position(def.kind, pose, S(0));
  joint.angle = nearest_turn(angle, std::min(std::max(angle, def.lower_limit), def.upper_limit));
  if (def.body_a == BodyId{}) joint.def.body_a = ground();
  if (def.body_b == BodyId{}) joint.def.body_b = ground();
  if (!def.bodies_collide) {
    const detail::ShapePair pair{std::min(joint.def.body_a.index, joint.def.body_b.index),
                                 std::max(joint.def.body_a.index, joint.def.body_b.index)};
    detail::DynamicArray<detail::ShapePair>& unpaired = state_.unpaired;
    unpaired.insert(std::lower_bound(unpaired.begin(), unpaired.end(), pair), pair);
  }
  detail::mark_bodies_dirty(state_, joint.def);
  state_.joint_kernels = &detail::joint_kernels<S>();
  return state_.joints.insert(joint);
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::erase_joint(std::uint32_t index) {
  const JointDef<S>& def = state_.joints.at(index).def;
  detail::mark_bodies_dirty(state_, def);
  if (!def.bodies_collide) {
    const detail::ShapePair pair{std::min(def.body_a.index, def.body_b.index),
                                 std::max(def.body_a.index, def.body_b.index)};
    detail::DynamicArray<detail::ShapePair>& unpaired = state_.unpaired;
    unpaired.erase(std::lower_bound(unpaired.begin(), unpaired.end(), pair));
  }
  state_.joints.erase(state_.joints.handle(index));
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::remove_joint(JointId id) {
  (void)state_.joints.get(id, "JointId");
  erase_joint(id.index);
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::set_motor(JointId id, const JointMotor<S>& motor) {
  detail::Joint<S>& joint = state_.joints.get(id, "JointId");
  validate(motor, joint.def.kind);
  joint.def.motor = motor;
  detail::mark_bodies_dirty(state_, joint.def);
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::set_limits(JointId id, S lower, S upper) {
  detail::Joint<S>& joint = state_.joints.get(id, "JointId");
  detail::require_limits(lower, upper, joint.def.kind);
  joint.def.lower_limit = lower;
  joint.def.upper_limit = upper;
  detail::mark_bodies_dirty(state_, joint.def);
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::set_spring(JointId id, const JointSpring<S>& spring) {
  detail::Joint<S>& joint = state_.joints.get(id, "JointId");
  validate(spring, joint.def.kind);
  joint.def.spring = spring;
  detail::mark_bodies_dirty(state_, joint.def);
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S> JointReading<S> World<S, Backend>::reading(JointId id)
const {
  const detail::Joint<S>& joint = state_.joints.get(id, "JointId");
  return read_joint(joint, state_.bodies.at(joint.def.body_a.index),
                    state_.bodies.at(joint.def.body_b.index), state_.def.time_step);
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S> PatchId World<S, Backend>::add_patch(BodyId body,
                                                                       PatchDef<S> def) {
  const Body<S>& owner = state_.bodies.get(body, "BodyId");
  for (const BodyId id : def.excluded) (void)state_.bodies.get(id, "PatchDef::excluded");
  detail::SensorPatch<S> patch = detail::make_patch(std::move(def), body, owner.center_B);
  detail::require_outward_rays(state_, body.index, patch, owner.center_B);
  detail::mark_dirty(state_, body);
  return state_.patches.insert(std::move(patch));
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S> PatchId World<S, Backend>::add_patch(
    BodyId body, SensorLayout<S> sensors, const SensorParameters<S>& parameters) {
  PatchDef<S> def;
  def.sensors = std::move(sensors);
  def.parameters = parameters;
  return add_patch(body, std::move(def));
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S> PatchId World<S, Backend>::add_patch(BodyId body,
                                                                       SensorLayout<S> sensors,
                                                                       const Tuning<S>& tuning) {
  return add_patch(body, tuning.patch(std::move(sensors)));
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::remove_patch(PatchId id) {
  detail::mark_dirty(state_, state_.patches.get(id, "PatchId").body);
  state_.patches.erase(id);
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::set_active(PatchId id, bool is_active) {
  detail::SensorPatch<S>& patch = state_.patches.get(id, "PatchId");
  if (patch.is_active == is_active) return;
  detail::mark_dirty(state_, patch.body);
  patch.is_active = is_active;
  if (!is_active) clear_patch(patch);
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::set_parameters(PatchId id, const SensorParameters<S>& parameters) {
  detail::SensorPatch<S>& patch = state_.patches.get(id, "PatchId");
  detail::set_constants(patch, parameters);
  detail::mark_dirty(state_, patch.body);
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S> PatchReport<S> World<S, Backend>::patch_report(PatchId id)
const { return detail::report_patch(state_, state_.patches.get(id, "PatchId")); }

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S> PatchReading<S> World<S, Backend>::reading(PatchId id)
const { return state_.patches.get(id, "PatchId").readings.view(); }

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::taxel_points(PatchId id, std::span<S> out) const {
  const detail::SensorPatch<S>& patch = state_.patches.get(id, "PatchId");
  detail::require(out.size() == detail::taxel_point_size * patch.size(), "out.size()", out.size(),
                  "must be six for each sensor");
  detail::write_taxel_points(patch, out.data());
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S> S World<S, Backend>::largest_stable_step(PatchId id)
const {
  (void)state_.patches.get(id, "PatchId");
  return detail::StiffnessFinder<S>().largest_stable_step(state_, id.index);
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S> WorldHit<S> World<S, Backend>::cast_ray(const Ray<S>& ray,
                                                                          const QueryFilter& filter)
const {
  WorldHit<S> hit;
  cast_rays(std::span(&ray, 1), filter, std::span(&hit, 1));
  return hit;
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::cast_rays(std::span<const Ray<S>> rays, const QueryFilter& filter,
                                  std::span<WorldHit<S>> hits) const {
  detail::require(rays.size() == hits.size(), "hits.size()", static_cast<double>(hits.size()),
                  "must equal the number of rays");
  for (const Ray<S>& ray : rays) detail::require_ray(ray);
  stepper_.kernels().cast_rays(state_, rays, filter, hits);
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::sense(BodyId carrier, ProximityArray<S>& array) const {
  (void)body(carrier);
  stepper_.kernels().sense(array, state_, carrier);
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S> std::vector<std::byte> World<S, Backend>::snapshot()
const { return detail::take_snapshot(state_); }

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S> std::uint64_t World<S, Backend>::state_hash()
const { return detail::state_hash(state_); }

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::restore(std::span<const std::byte> bytes) {
  detail::restore_snapshot(bytes, state_);
  state_.contacts.repeat();
  state_.ended.clear();
  state_.ended_since.clear();
  state_.kept_events.clear();
  state_.sleeping_bodies = 0;
  state_.is_any_dirty = false;
  for (const std::uint32_t i : state_.bodies.live_slots()) {
    if (state_.bodies.at(i).is_asleep()) ++state_.sleeping_bodies;
    state_.is_any_dirty = state_.is_any_dirty || state_.bodies.at(i).sleep.is_dirty;
  }
  for (const std::uint32_t i : state_.colliders.live_slots()) refresh_box(i);
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::set_time_step(S dt) {
  detail::require_positive("dt", dt);
  // Forces go on, so the impulses that warm-start the next step scale with the step.
  const S ratio = dt / state_.def.time_step;
  for_each_impulse(state_, [&](const S& impulse) {
    if (detail::has_finite_square(S(ratio * impulse))) return;
    detail::require(false, "dt", dt, "must be such that impulses of the last step stay finite");
  });
  detail::wake_all(state_);
  for_each_impulse(state_, [&](S& impulse) { impulse *= ratio; });
  state_.def.time_step = dt;
}

/// Calls visit(S&) for every warm-start impulse.
template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
template <typename Visit>
void World<S, Backend>::for_each_impulse(State& state, Visit&& visit) {
  const auto visit_vector = [&](auto& vector) {
    for (Eigen::Index i = 0; i < vector.size(); ++i) visit(vector[i]);
  };
  for (detail::CachedPoint<S>& point : state.contacts.points()) {
    for (S& impulse : point.impulse) visit(impulse);
    for (S& impulse : point.transient_impulse) visit(impulse);
    visit(point.position_excess);
  }
  for (detail::CachedManifold<S>& m : state.contacts.manifolds()) visit_vector(m.rolling_impulse);
  for (const std::uint32_t i : state.joints.live_slots()) {
    detail::Joint<S>& joint = state.joints.at(i);
    for (S& impulse : joint.impulses) visit(impulse);
    for (Wrench<S>* wrench : {&joint.spring_impulse, &joint.total}) {
      visit_vector(wrench->force);
      visit_vector(wrench->torque);
    }
  }
  for (const std::uint32_t i : state.patches.live_slots()) {
    for (detail::PairImpulse<S>& last : state.patches.at(i).last_impulses)
      visit_vector(last.impulse);
  }
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::set_gravity(const Vec3<S>& gravity) {
  detail::require_all_finite("gravity", gravity);
  detail::wake_all(state_);
  state_.def.gravity = gravity;
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::step() { stepper_.kernels().step(stepper_.get(), state_); }

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::require_tools(const HapticLoop<S>& loop, bool opens) const {
  for (std::size_t i = 0; i < loop.tools_.size(); ++i) {
    const auto& tool = loop.tools_[i];
    const std::uint32_t slot = tool.body.index;
    // A removed body had an index.
    const bool is_right = contains(tool.body) ? state_.bodies.at(slot).motion == Motion::kinematic
                                              : slot < state_.bodies.slot_count();
    // Text is made only on error: steps never allocate.
    if (is_right) continue;
    detail::require(false, "HapticLoop: BodyId of tool " + std::to_string(i), tool.body,
                    "must name a kinematic body");
  }
  for (const auto& skin : loop.tool_patches_) {
    const BodyId body = loop.tools_[skin.tool].body;
    if (skin.is_removed || (skin.is_seen && !opens) || !contains(body)) continue;
    // The loop knows no centre of mass: its patches are about the origin of the body.
    detail::require_outward_rays(state_, body.index, skin.patch, detail::zero<Vec3<S>>());
  }
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::open(HapticLoop<S>& loop) const {
  require_tools(loop, true);
  loop.forget();
  loop.observe(state_);
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::step(HapticLoop<S>& loop) {
  loop.require_complete();
  require_tools(loop, false);
  const auto is_moved = [&](const auto& tool) { return tool.is_placed && contains(tool.body); };
  for (const auto& tool : loop.tools_) {
    if (is_moved(tool)) (void)twist_to(tool.body, tool.end_pose(loop.h_));
  }
  // Nothing throws from here on.
  for (const auto& tool : loop.tools_) {
    if (is_moved(tool)) set_twist(tool.body, twist_to(tool.body, tool.end_pose(loop.h_)));
  }
  for (detail::HapticBody<S>& pushed : loop.bodies_) {
    if (!contains(pushed.id())) continue;
    pushed.start_momentum = detail::HapticBody<S>::momentum(state_.bodies.at(pushed.id().index));
    push(pushed);
  }
  step();
  loop.observe(state_);
}

/// Applies the impulse of a loop's substeps to a body. The step handles overflow: it stops such
/// bodies.
template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::push(const detail::HapticBody<S>& pushed) {
  const BodyId id = pushed.id();
  Body<S>& body = state_.bodies.at(id.index);
  const Wrench<S>& impulse = pushed.impulse();
  if (!body.is_dynamic() || (impulse.force.isZero(S(0)) && impulse.torque.isZero(S(0)))) return;
  body.applied += (S(1) / state_.def.time_step) * impulse;
  detail::mark_dirty(state_, id);
  Body<S> advanced = body;
  detail::step_pose(advanced, pushed.excess_displacement(), S(1));
  const Transform<S> X_WB = advanced.pose();
  if (!detail::is_pose(X_WB) || !detail::has_finite_square<S>(advanced.twist)) return;
  set_pose(id, X_WB);
  set_twist(id, advanced.twist);
}

}  // namespace bristle::inline BRISTLE_ABI
