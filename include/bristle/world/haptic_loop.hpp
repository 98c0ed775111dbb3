/// @file
/// A haptic loop: sensors on tools that a user holds, sensed more often than the world steps.
///
///     HapticLoop<double> loop({.ticks = 16});
///     const ToolId tool = loop.add_tool(stylus);  // a kinematic body
///     loop.add_patch(tool, patch);
///     world.open(loop);
///     for (;;) {
///       for (int i = 0; i < 16; ++i) {
///         loop.move(tool, device.pose());
///         loop.tick();
///         device.send(loop.wrench(tool));
///       }
///       world.step(loop);
///     }
///
/// Ticks run ahead of the world: the bodies near a tool are predicted from the state in which the
/// last step left them (haptic_body.hpp), each tick evaluates the law of the loop's patches and
/// moves them on, and the step then gives the bodies of the world the sum of all impulses. Rays are
/// cast in each tick, or once a step (`PatchDef::cast_every` counts ticks here). A tick looks at
/// the loop alone. docs/decisions/0024-haptic-ticks.md says why it is built this way.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/backends/analytic_backend.hpp>
#include <bristle/sensors/patch.hpp>
#include <bristle/world/haptic_body.hpp>
#include <bristle/world/kernels.hpp>
#include <bristle/world/patch_rays.hpp>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI {
namespace detail {
template <Scalar S, typename Backend>
class HapticTick;
}  // namespace detail

/// Settings of a haptic loop.
template <Scalar S>
struct HapticDef {
  /// [-] Ticks in a step of the world, >= 1.
  std::uint32_t ticks = 16;
  /// [m/s] Fastest that any point of a tool moves, >= 0. What a tool could not reach at that speed
  /// within a step is not felt before the next one.
  S max_speed = S(1);
};

/// Names a tool of a haptic loop.
struct ToolId {
  std::uint32_t index = 0xffffffffu;
};
/// Names a patch of a haptic loop.
struct TickedPatchId {
  std::uint32_t index = 0xffffffffu;
};

/// What `World::open` and `World::step` give a haptic loop to see. A value: a copy goes on as the
/// original would, so that a copy of the loop goes with a snapshot of its world.
///
/// The patches of a loop belong to it alone; the world does not sense with them. They are always
/// implicit: `PatchDef::integration` and `explicit_below` are not used.
template <Scalar S, typename Backend>
class HapticLoop {
 public:
  /// @throws InvalidArgument naming the field.
  explicit HapticLoop(const HapticDef<S>& def) : def_(def) {
    detail::require(def.ticks > 0, "HapticDef::ticks", def.ticks, "must be > 0");
    detail::require_not_negative("HapticDef::max_speed", def.max_speed);
  }

  /// Adds a tool: a kinematic body of the world, which `World::open` and `World::step` check. Steps
  /// move it to where the ticks left it; until it is moved for the first time it is where its body
  /// is.
  ToolId add_tool(BodyId body) {
    tools_.emplace_back().body = body;
    return {static_cast<std::uint32_t>(tools_.size() - 1)};
  }
  /// Adds sensors to a tool, in the frame of its body. They feel from the next `World::open` or
  /// `World::step` on.
  /// @throws InvalidArgument naming the field; the law must be the paper's.
  TickedPatchId add_patch(ToolId tool, PatchDef<S> def) {
    const Tool& owner = tool_of(tool);
    detail::require(def.options.law == Law::paper, "LawOptions::law", "ambf",
                    "must be the paper's");
    def.integration = Integration::implicit;
    Skin skin;
    // About the origin of the body frame, which is the device's.
    skin.patch = make_patch(std::move(def), owner.body, Vec3<S>(Vec3<S>::Zero()));
    skin.tool = tool.index;
    skins_.push_back(std::move(skin));
    return {static_cast<std::uint32_t>(skins_.size() - 1)};
  }

  /// Says where a tool is now; its velocity is that since the last tick, zero in the first tick
  /// after `World::open`. Of several calls between two ticks the last one counts.
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
  /// @param twist  [m/s, rad/s] Of the origin of the body frame, world axes.
  void move(ToolId tool, const Transform<S>& X_WT, const Twist<S>& twist) {
    Tool& t = tool_of(tool);
    require_pose(X_WT);
    detail::require_all_finite("twist.linear", twist.linear);
    detail::require_all_finite("twist.angular", twist.angular);
    set_motion(t, X_WT, twist);
  }

  /// Senses and moves the bodies near the tools on by one tick. A tool that was not moved since the
  /// last tick stands still.
  /// @throws InvalidArgument when `World::open` was not called, or all ticks of the step are done.
  void tick();

  /// [N, N m] What the sensors of a tool felt in the last tick, about the origin of its body frame,
  /// world axes: the mean over the tick that begins, if the tool keeps its velocity.
  [[nodiscard]] const Wrench<S>& wrench(ToolId tool) const {
    require_tool(tool);
    return tools_[tool.index].wrench;
  }
  /// What a patch felt in the last tick; valid until the next one.
  [[nodiscard]] PatchReading<S> reading(TickedPatchId id) const {
    detail::require(id.index < skins_.size(), "TickedPatchId", id.index, "must name a patch");
    return skins_[id.index].patch.readings.view();
  }
  /// Bodies near the tools, as predicted by the ticks so far.
  [[nodiscard]] std::span<const HapticBody<S>> bodies() const { return bodies_; }
  /// [s] Length of a tick; 0 before `World::open`.
  [[nodiscard]] S tick_length() const { return h_; }
  /// [-] Ticks since the last step.
  [[nodiscard]] std::uint32_t ticks_done() const { return done_; }
  /// [-] Rays that were cast in the last tick, one a sensor and shape.
  [[nodiscard]] std::uint64_t rays_cast() const { return rays_cast_; }
  [[nodiscard]] const HapticDef<S>& def() const { return def_; }

 private:
  template <Scalar T, typename B>
  requires ShapeBackend<B, T>
  friend class World;
  friend class detail::HapticTick<S, Backend>;

  struct Tool {
    BodyId body{};
    Transform<S> pose{};
    Twist<S> twist{};
    Wrench<S> wrench{};
    /// [m] Where `move` had it in the last tick since the loop was opened.
    std::optional<Transform<S>> last_pose;
    /// Whether `move` ever said where it is; and since the last tick.
    bool is_placed = false;
    bool is_moved = false;

    /// [m] Where it is a tick of length h [s] after the last one began.
    [[nodiscard]] Transform<S> end_pose(S h) const {
      if (is_moved) return pose;
      return {step_rotation<S>(pose.rotation, twist.angular, h),
              Vec3<S>(pose.translation + h * twist.linear)};
    }
  };
  /// A shape near the tools. Its own copy, so that ticks need no world.
  struct NearShape {
    ShapeId id{};
    Collider<S, Backend> collider{};
    std::uint32_t body = 0;
  };
  struct Skin {
    SensorPatch<S> patch{};
    std::uint32_t tool = 0;
    /// [-] Which of the near shapes it may meet within the step.
    std::vector<std::uint32_t> near;
    std::vector<ShapeInReach<S, Backend>> in_reach;
    /// One for each pair, and the body that it pushes.
    std::vector<SoftBlock<S>> blocks;
    std::vector<std::uint32_t> touched;
  };

  void require_tool(ToolId tool) const {
    detail::require(tool.index < tools_.size(), "ToolId", tool.index, "must name a tool");
  }
  [[nodiscard]] Tool& tool_of(ToolId tool) {
    require_tool(tool);
    return tools_[tool.index];
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
    detail::require(h_ > S(0), "HapticLoop: tick_length", h_,
                    "must be > 0: call World::open first");
  }

  // What the world calls.
  void require_ticked() const {
    require_open();
    detail::require(done_ == def_.ticks, "HapticLoop: ticks", done_,
                    "must be HapticDef::ticks before a step");
  }
  void forget();
  void observe(const WorldState<S, Backend>& state);
  void find_near(const WorldState<S, Backend>& state, Skin& skin, S fastest);
  /// [m/s] Fastest that any point of a shape moves; of a half-space, its body.
  [[nodiscard]] static S speed_of(const WorldState<S, Backend>& state,
                                  const Collider<S, Backend>& c) {
    const Twist<S>& twist = state.body_of(c).twist;
    return twist.linear.norm() + (c.half_space ? S(0) : twist.angular.norm() * c.radius);
  }
  [[nodiscard]] std::uint32_t add_body(const WorldState<S, Backend>& state, BodyId id);
  [[nodiscard]] Vec6<S> other_force(const WorldState<S, Backend>& state, BodyId id,
                                    const HeldMobility<S>& held) const;

  const HapticKernels<S, Backend>* kernels_ = &haptic_kernels<S, Backend>();
  HapticDef<S> def_;
  std::vector<Tool> tools_;
  std::vector<Skin> skins_;
  std::vector<NearShape> shapes_;
  std::vector<HapticBody<S>> bodies_, last_bodies_;
  HeldMobilityFinder<S, Backend> finder_;
  S h_ = S(0);
  std::uint32_t done_ = 0;
  std::uint64_t ticks_ = 0;
  std::uint64_t rays_cast_ = 0;
};

}  // namespace bristle::inline BRISTLE_ABI

// Implementation -----------------------------------------------------------------------------------

#if BRISTLE_HAS_DEFINITIONS
#include <bristle/world/near_shapes.hpp>

#include <algorithm>

namespace bristle::inline BRISTLE_ABI {

/// Leaves the loop as if it had never ticked; tools stay where they are.
template <Scalar S, typename Backend>
void HapticLoop<S, Backend>::forget() {
  for (Tool& tool : tools_) {
    tool.twist = {};
    tool.wrench = {};
    tool.last_pose.reset();
  }
  for (Skin& skin : skins_) clear_patch(skin.patch);
  bodies_.clear();
  ticks_ = rays_cast_ = 0;
}

template <Scalar S, typename Backend>
void HapticLoop<S, Backend>::observe(const WorldState<S, Backend>& state) {
  h_ = state.def.time_step / S(def_.ticks);
  done_ = 0;
  std::swap(bodies_, last_bodies_);
  bodies_.clear();
  shapes_.clear();
  S fastest = S(0);
  for (std::uint32_t i = 0; i < state.colliders.slot_count(); ++i) {
    if (state.colliders.is_live(i)) {
      fastest = std::max(fastest, speed_of(state, state.colliders.at(i)));
    }
  }
  for (Tool& tool : tools_) {
    if (!tool.is_placed && state.bodies.contains(tool.body)) {
      tool.pose = state.bodies.at(tool.body.index).pose();
    }
  }
  for (Skin& skin : skins_) find_near(state, skin, fastest);
}

/// Finds the shapes that a patch may meet within a step.
template <Scalar S, typename Backend>
void HapticLoop<S, Backend>::find_near(const WorldState<S, Backend>& state, Skin& skin, S fastest) {
  const Tool& tool = tools_[skin.tool];
  skin.near.clear();
  if (!state.bodies.contains(tool.body)) return;
  const S dt = state.def.time_step;
  const S fall = dt * state.def.gravity.norm();
  const Aabb<S> box = transformed(skin.patch.box, tool.pose).inflated(dt * def_.max_speed);
  state.broad_phase.overlap(box.inflated(dt * (fastest + fall)), [&](std::uint32_t tag) {
    const Collider<S, Backend>& c = state.colliders.at(tag);
    if (!detail::sees(state, skin.patch, c)) return true;
    const Aabb<S> swept = box.inflated(dt * (speed_of(state, c) + fall));
    const bool is_near =
        c.half_space ? state.reaches(swept, c) : swept.overlaps(detail::box_of(state, c));
    if (is_near) skin.near.push_back(tag);
    return true;
  });
  std::sort(skin.near.begin(), skin.near.end());
  for (std::uint32_t& near : skin.near) {
    const ShapeId id = state.colliders.handle(near);
    const auto known = std::find_if(shapes_.begin(), shapes_.end(),
                                    [id](const NearShape& shape) { return shape.id == id; });
    near = static_cast<std::uint32_t>(known - shapes_.begin());
    if (known != shapes_.end()) continue;
    const Collider<S, Backend>& c = state.colliders.at(id.index);
    shapes_.push_back({id, c, add_body(state, c.body)});
  }
}

template <Scalar S, typename Backend>
std::uint32_t HapticLoop<S, Backend>::add_body(const WorldState<S, Backend>& state, BodyId id) {
  const auto known = std::find_if(bodies_.begin(), bodies_.end(),
                                  [id](const HapticBody<S>& body) { return body.id() == id; });
  if (known != bodies_.end()) return static_cast<std::uint32_t>(known - bodies_.begin());
  const HeldMobility<S> held = finder_.find(state, id.index);
  bodies_.push_back(
      {id, state.bodies.at(id.index), held, other_force(state, id, held), state.def.time_step});
  return static_cast<std::uint32_t>(bodies_.size() - 1);
}

/// [N, N m] What acts on a body besides the loop: what did in the last step, where that is known.
template <Scalar S, typename Backend>
Vec6<S> HapticLoop<S, Backend>::other_force(const WorldState<S, Backend>& state, BodyId id,
                                            const HeldMobility<S>& held) const {
  const Body<S>& body = state.bodies.at(id.index);
  const auto last = std::find_if(last_bodies_.begin(), last_bodies_.end(),
                                 [id](const HapticBody<S>& b) { return b.id() == id; });
  if (last == last_bodies_.end() || held.was_hit) {
    Vec6<S> weight = Vec6<S>::Zero();
    weight.template head<3>() = body.mass * body.gravity_scale * state.def.gravity;
    return weight;
  }
  Vec6<S> given;
  given << last->impulse().force, last->impulse().torque;
  return (HapticBody<S>::momentum(body) - last->start_momentum - given) / state.def.time_step;
}

template <Scalar S, typename Backend>
void HapticLoop<S, Backend>::tick() {
  require_open();
  detail::require(done_ < def_.ticks, "HapticLoop: ticks", done_ + 1,
                  "must be <= HapticDef::ticks between two steps");
  kernels_->tick(*this);
}

}  // namespace bristle::inline BRISTLE_ABI
#endif
