/// @file
/// A haptic loop: sensors on tools that a user holds, sensed more often than the world steps.
///
///     HapticLoop<double> loop({.substeps = 16});
///     const ToolId tool = loop.add_tool(stylus);  // a kinematic body
///     loop.add_patch(tool, patch);
///     world.open(loop);
///     for (;;) {
///       for (int i = 0; i < 16; ++i) {
///         loop.move(tool, device.pose());
///         loop.substep();
///         device.send(loop.wrench(tool));
///       }
///       world.step(loop);
///     }
///
/// Substeps run ahead of the world. They predict the bodies near a tool from the state that the
/// last step left (haptic_body.hpp). Each substep evaluates the law of the loop's patches and
/// advances the bodies. The step then applies the sum of all impulses to the bodies of the world.
/// Rays are cast in each substep, or once a step (`PatchDef::cast_every` counts substeps here). A
/// substep reads the loop alone. docs/decisions/0024-haptic-ticks.md gives the reasons.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/no_index.hpp>
#include <bristle/geometry/backends/analytic_backend.hpp>
#include <bristle/sensors/patch.hpp>
#include <bristle/sensors/patch_scratch.hpp>
#include <bristle/world/haptic_body.hpp>
#include <bristle/world/kernels.hpp>
#include <bristle/world/patch_rays.hpp>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>

namespace bristle::inline BRISTLE_ABI {
namespace detail {
template <Scalar S>
class HapticSubstep;
}  // namespace detail

/// Settings of a haptic loop.
template <Scalar S>
struct HapticDef {
  /// [-] Substeps of a world step, >= 1.
  std::uint32_t substeps = 16;
  /// [m/s] Fastest speed of any tool point, >= 0. A body out of reach at that speed within a step
  /// is not felt before the next one.
  S max_speed = S(1);
};

/// Handle of a tool of a haptic loop.
struct ToolId {
  /// [-] Index of the tool; the default names none.
  std::uint32_t index = detail::no_index;
};
/// Handle of a patch of a haptic loop.
struct ToolPatchId {
  /// [-] Index of the patch; the default names none.
  std::uint32_t index = detail::no_index;
};

/// A haptic loop. `World::open` and `World::step` show it the world. It is a value: a copy goes on
/// as the original would, so a copy of the loop goes with a snapshot of its world.
///
/// The patches of a loop belong to it alone. The world does not sense with them. They are always
/// implicit; `PatchDef::integration` and `explicit_below` are ignored.
template <Scalar S>
class HapticLoop {
 public:
  /// @throws InvalidArgument naming the field.
  explicit HapticLoop(const HapticDef<S>& def) : def_(def) {
    detail::require(def.substeps > 0, "HapticDef::substeps", def.substeps, "must be > 0");
    detail::require_not_negative("HapticDef::max_speed", def.max_speed);
  }

  /// Adds a tool: a kinematic body of the world. `World::open` and `World::step` check it. Steps
  /// move it to its pose after the substeps. Until its first `move` a tool is at the pose of its
  /// body.
  ToolId add_tool(BodyId body) {
    tools_.emplace_back().body = body;
    return {static_cast<std::uint32_t>(tools_.size() - 1)};
  }
  /// Adds sensors to a tool, in the frame of its body. They sense from the next `World::open` or
  /// `World::step` on. That call refuses rays that end inside the tool's own shapes, unless
  /// `PatchDef::may_point_inwards`, until the patch is removed.
  /// @throws InvalidArgument naming the field; the law must be the paper's.
  ToolPatchId add_patch(ToolId tool, PatchDef<S> def) {
    const Tool& owner = tool_of(tool);
    detail::require(def.options.law == Law::paper, "LawOptions::law", "ambf",
                    "must be the paper's");
    def.integration = Integration::implicit;
    ToolPatch tool_patch;
    // About the origin of the body frame, the device's.
    tool_patch.patch = detail::make_patch(std::move(def), owner.body, detail::zero<Vec3<S>>());
    tool_patch.tool = tool.index;
    tool_patches_.push_back(std::move(tool_patch));
    return {static_cast<std::uint32_t>(tool_patches_.size() - 1)};
  }

  /// Removes a patch. It lets go of the bodies in contact, which keep what it gave them so far, and
  /// its handle names nothing any more. `wrench` is without it from the next substep on. Its place
  /// in the loop remains, so switch a patch off that is to come back.
  /// @throws InvalidArgument when there is no such patch.
  void remove_patch(ToolPatchId id);
  /// Switches a patch off or on. A patch that is off has let go, reads zero and costs nothing;
  /// `wrench` is without it from the next substep on. One that is on again senses from the next
  /// `World::open` or `World::step` on, as a new one does.
  /// @throws InvalidArgument when there is no such patch.
  void set_active(ToolPatchId id, bool is_active);
  /// Sets the constants of all sensors of a patch, also where they had their own. Bristles keep
  /// their stretch.
  /// @throws InvalidArgument naming the field, or when there is no such patch.
  void set_parameters(ToolPatchId id, const SensorParameters<S>& parameters);
  /// Returns whether there is such a patch.
  [[nodiscard]] bool contains(ToolPatchId id) const noexcept {
    return id.index < tool_patches_.size() && !tool_patches_[id.index].is_removed;
  }

  /// Sets the pose of a tool. Its velocity follows from its pose in the last substep; it is zero in
  /// the first substep after `World::open`. Of several calls between two substeps the last one
  /// counts.
  /// @param X_WT  [m] Pose of the body frame in the world.
  /// @throws InvalidArgument when it is not finite or no rotation; the loop is unchanged then.
  void move(ToolId tool, const Transform<S>& X_WT) {
    Tool& t = tool_of(tool);
    require_pose(X_WT);
    Twist<S> twist;
    if (t.last_pose) {
      twist = {(X_WT.translation - t.last_pose->translation) / h_,
               log_rotation<S>(X_WT.rotation * t.last_pose->rotation.conjugate()) / h_};
      detail::require_all_finite("X_WT.translation: velocity", twist.linear);
      detail::require_all_finite("X_WT.rotation: angular velocity", twist.angular);
    }
    set_motion(t, X_WT, twist);
  }
  /// The same for a device that knows its velocity.
  /// @param twist  [m/s, rad/s] Velocity of the origin of the body frame, world axes.
  void move(ToolId tool, const Transform<S>& X_WT, const Twist<S>& twist) {
    Tool& t = tool_of(tool);
    require_pose(X_WT);
    detail::require_all_finite("twist.linear", twist.linear);
    detail::require_all_finite("twist.angular", twist.angular);
    set_motion(t, X_WT, twist);
  }

  /// Senses, and advances bodies near tools by one substep. A tool that was not moved since the
  /// last substep stands still.
  /// @throws InvalidArgument when `World::open` was not called, or all substeps of the step are
  ///         done.
  void substep();

  /// [N, N m] Wrench on the sensors of a tool in the last substep, about the origin of its body
  /// frame, world axes. If the tool keeps its velocity, it is the mean over the substep that
  /// begins.
  [[nodiscard]] const Wrench<S>& wrench(ToolId tool) const {
    require_tool(tool);
    return tools_[tool.index].wrench;
  }
  /// Reading of a patch in the last substep; valid until the next one.
  [[nodiscard]] PatchReading<S> reading(ToolPatchId id) const {
    require_patch(id);
    return tool_patches_[id.index].patch.readings.view();
  }
  /// Bodies near the tools, as predicted so far.
  [[nodiscard]] std::span<const detail::HapticBody<S>> bodies() const { return bodies_; }
  /// [s] Length of a substep; 0 before `World::open`.
  [[nodiscard]] S substep_length() const { return h_; }
  /// [-] Substeps since the last step.
  [[nodiscard]] std::uint32_t substeps_done() const { return done_; }
  /// [-] Rays cast in the last substep, one a sensor and shape.
  [[nodiscard]] std::uint64_t rays_cast() const { return rays_cast_; }
  /// Settings of the loop.
  [[nodiscard]] const HapticDef<S>& def() const { return def_; }

 private:
  template <Scalar T, typename B>
  requires ShapeBackend<B, T>
  friend class World;
  friend class detail::HapticSubstep<S>;

  struct Tool {
    BodyId body{};
    Transform<S> pose{};
    Twist<S> twist{};
    Wrench<S> wrench{};
    /// [m] Pose by `move` in the last substep since the loop was opened.
    std::optional<Transform<S>> last_pose;
    /// True if `move` ever gave a pose; and if it did since the last substep.
    bool is_placed = false;
    bool is_moved = false;

    /// [m] Pose of the tool a substep of length h [s] after the last one began.
    [[nodiscard]] Transform<S> end_pose(S h) const {
      if (is_moved) return pose;
      return {step_rotation<S>(pose.rotation, twist.angular, h),
              Vec3<S>(pose.translation + h * twist.linear)};
    }
  };
  /// A shape near the tools. A copy, so that substeps need no world.
  struct NearShape {
    ShapeId id{};
    detail::Collider<S> collider{};
    std::uint32_t body = 0;
  };
  struct ToolPatch {
    detail::SensorPatch<S> patch{};
    detail::PatchScratch<S> scratch{};
    std::uint32_t tool = 0;
    /// True from the first time on that the loop's world has seen it, and checked its rays.
    bool is_seen = false;
    /// True for what is left of a patch that was removed: a place, so that others keep theirs.
    bool is_removed = false;
    /// [-] Shapes that it may meet within the step.
    detail::DynamicArray<std::uint32_t> near;
    detail::DynamicArray<detail::ShapeInReach<S>> in_reach;
    /// One for each pair, and its body.
    detail::DynamicArray<detail::SoftBlock<S>> blocks;
    detail::DynamicArray<std::uint32_t> touched;
  };

  void require_tool(ToolId tool) const {
    detail::require(tool.index < tools_.size(), "ToolId", tool.index,
                    "must name a tool of this loop");
  }
  [[nodiscard]] Tool& tool_of(ToolId tool) {
    require_tool(tool);
    return tools_[tool.index];
  }
  void require_patch(ToolPatchId id) const {
    detail::require(contains(id), "ToolPatchId", id.index, "must name a patch of this loop");
  }
  static void require_pose(const Transform<S>& X_WT) {
    detail::require_all_finite("X_WT.translation", X_WT.translation);
    detail::require_unit<S>("X_WT.rotation", X_WT.rotation);
  }
  static void set_motion(Tool& tool, const Transform<S>& X_WT, const Twist<S>& twist) {
    tool.pose = {X_WT.rotation.normalized(), X_WT.translation};
    tool.twist = twist;
    tool.is_placed = tool.is_moved = true;
  }

  void require_open() const {
    detail::require(h_ > S(0), "HapticLoop: substep_length", h_,
                    "must be > 0: call World::open first");
  }

  // Functions that the world calls.
  void require_complete() const {
    require_open();
    detail::require(done_ == def_.substeps, "HapticLoop: substeps", done_,
                    "must be HapticDef::substeps before a step");
  }
  void forget();
  void observe(const detail::WorldState<S>& state);
  void find_near(const detail::WorldState<S>& state, ToolPatch& tool_patch, S fastest);
  /// [m/s] Fastest speed of any point of a shape; of a half-space, the speed of its body.
  [[nodiscard]] static S speed_of(const detail::WorldState<S>& state,
                                  const detail::Collider<S>& c) {
    const Twist<S>& twist = state.body_of(c).twist;
    return twist.linear.norm() + (c.half_space ? S(0) : twist.angular.norm() * c.radius);
  }
  [[nodiscard]] std::uint32_t add_body(const detail::WorldState<S>& state, BodyId id);
  [[nodiscard]] Vec6<S> other_force(const detail::WorldState<S>& state, BodyId id,
                                    const detail::HeldMobility<S>& held) const;

  const detail::HapticKernels<S>* kernels_ = &detail::haptic_kernels<S>();
  HapticDef<S> def_;
  detail::DynamicArray<Tool> tools_;
  detail::DynamicArray<ToolPatch> tool_patches_;
  detail::DynamicArray<NearShape> shapes_;
  detail::DynamicArray<detail::HapticBody<S>> bodies_, last_bodies_;
  detail::HeldMobilityFinder<S> finder_;
  S h_ = S(0);
  std::uint32_t done_ = 0;
  std::uint64_t substeps_ = 0;
  std::uint64_t rays_cast_ = 0;
};

}  // namespace bristle::inline BRISTLE_ABI

// Implementation ----------------------------------------------------------------------------------

#if BRISTLE_HAS_DEFINITIONS
#include <bristle/world/near_shapes.hpp>

#include <algorithm>

namespace bristle::inline BRISTLE_ABI {

template <Scalar S>
void HapticLoop<S>::remove_patch(ToolPatchId id) {
  require_patch(id);
  ToolPatch rest;
  rest.tool = tool_patches_[id.index].tool;
  rest.is_removed = true;
  rest.patch.is_active = false;
  tool_patches_[id.index] = std::move(rest);
}

template <Scalar S>
void HapticLoop<S>::set_active(ToolPatchId id, bool is_active) {
  require_patch(id);
  ToolPatch& tool_patch = tool_patches_[id.index];
  tool_patch.patch.is_active = is_active;
  if (is_active) return;
  tool_patch.near.clear();
  clear_patch(tool_patch.patch);
}

template <Scalar S>
void HapticLoop<S>::set_parameters(ToolPatchId id, const SensorParameters<S>& parameters) {
  require_patch(id);
  detail::set_constants(tool_patches_[id.index].patch, parameters);
}

/// Resets the loop, as before its first substep. Tools keep their poses.
template <Scalar S>
void HapticLoop<S>::forget() {
  for (Tool& tool : tools_) {
    tool.twist = {};
    tool.wrench = {};
    tool.last_pose.reset();
  }
  for (ToolPatch& tool_patch : tool_patches_) clear_patch(tool_patch.patch);
  bodies_.clear();
  substeps_ = rays_cast_ = 0;
}

template <Scalar S>
void HapticLoop<S>::observe(const detail::WorldState<S>& state) {
  h_ = state.def.time_step / S(def_.substeps);
  done_ = 0;
  std::swap(bodies_, last_bodies_);
  bodies_.clear();
  shapes_.clear();
  S fastest = S(0);
  for (const std::uint32_t i : state.colliders.live_slots()) {
    fastest = std::max(fastest, speed_of(state, state.colliders.at(i)));
  }
  for (Tool& tool : tools_) {
    if (!tool.is_placed && state.bodies.contains(tool.body)) {
      tool.pose = state.bodies.at(tool.body.index).pose();
    }
  }
  for (ToolPatch& tool_patch : tool_patches_) {
    tool_patch.is_seen = true;
    find_near(state, tool_patch, fastest);
  }
}

/// Finds shapes that a patch may meet in a step.
template <Scalar S>
void HapticLoop<S>::find_near(const detail::WorldState<S>& state, ToolPatch& tool_patch,
                              S fastest) {
  const Tool& tool = tools_[tool_patch.tool];
  tool_patch.near.clear();
  if (!tool_patch.patch.is_active || !state.bodies.contains(tool.body)) return;
  const S dt = state.def.time_step;
  const S fall = dt * state.def.gravity.norm();
  const Aabb<S> box =
      transformed(tool_patch.patch.geometry->box, tool.pose).inflated(dt * def_.max_speed);
  state.broad_phase.overlap(box.inflated(dt * (fastest + fall)), [&](std::uint32_t tag) {
    const detail::Collider<S>& c = state.colliders.at(tag);
    if (!detail::senses(state, tool_patch.patch, c)) return true;
    const Aabb<S> swept = box.inflated(dt * (speed_of(state, c) + fall));
    const bool is_near =
        c.half_space ? state.reaches(swept, c) : swept.overlaps(detail::box_of(state, c));
    if (is_near) tool_patch.near.push_back(tag);
    return true;
  });
  std::sort(tool_patch.near.begin(), tool_patch.near.end());
  for (std::uint32_t& near : tool_patch.near) {
    const ShapeId id = state.colliders.handle(near);
    const auto known = std::find_if(shapes_.begin(), shapes_.end(),
                                    [id](const NearShape& shape) { return shape.id == id; });
    near = static_cast<std::uint32_t>(known - shapes_.begin());
    if (known != shapes_.end()) continue;
    const detail::Collider<S>& c = state.colliders.at(id.index);
    shapes_.push_back({id, c, add_body(state, c.body)});
  }
}

template <Scalar S>
std::uint32_t HapticLoop<S>::add_body(const detail::WorldState<S>& state, BodyId id) {
  const auto known =
      std::find_if(bodies_.begin(), bodies_.end(),
                   [id](const detail::HapticBody<S>& body) { return body.id() == id; });
  if (known != bodies_.end()) return static_cast<std::uint32_t>(known - bodies_.begin());
  const detail::HeldMobility<S> held = finder_.find(state, id.index);
  bodies_.push_back(
      {id, state.bodies.at(id.index), held, other_force(state, id, held), state.def.time_step});
  return static_cast<std::uint32_t>(bodies_.size() - 1);
}

/// [N, N m] Forces on a body besides the loop's, taken from the last step where they are known.
template <Scalar S>
Vec6<S> HapticLoop<S>::other_force(const detail::WorldState<S>& state, BodyId id,
                                   const detail::HeldMobility<S>& held) const {
  const Body<S>& body = state.bodies.at(id.index);
  const auto last = std::find_if(last_bodies_.begin(), last_bodies_.end(),
                                 [id](const detail::HapticBody<S>& b) { return b.id() == id; });
  if (last == last_bodies_.end() || held.was_hit) {
    return detail::stacked<S>(body.mass * body.gravity_scale * state.def.gravity,
                              detail::zero<Vec3<S>>());
  }
  const Vec6<S> given = detail::stacked(last->impulse());
  return (detail::HapticBody<S>::momentum(body) - last->start_momentum - given) /
         state.def.time_step;
}

template <Scalar S>
void HapticLoop<S>::substep() {
  require_open();
  detail::require(done_ < def_.substeps, "HapticLoop: substeps", done_ + 1,
                  "must be <= HapticDef::substeps between two steps");
  kernels_->substep(*this);
}

}  // namespace bristle::inline BRISTLE_ABI
#endif
