/// @file
/// One substep of a haptic loop: its patches sense, all are solved together, bodies and tools
/// receive the impulses.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/no_index.hpp>
#include <bristle/math/finite.hpp>
#include <bristle/sensors/patch_contacts.hpp>
#include <bristle/sensors/patch_readings.hpp>
#include <bristle/sensors/solve_passes.hpp>
#include <bristle/world/haptic_loop.hpp>
#include <bristle/world/near_shapes.hpp>

#include <cstddef>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// Implements `HapticLoop::substep`. The loop is open and has a substep left.
template <Scalar S>
class HapticSubstep {
 public:
  explicit HapticSubstep(HapticLoop<S>& loop) : loop_(loop) {}

  void run();

 private:
  using Loop = HapticLoop<S>;
  using Tool = typename Loop::Tool;
  using NearShape = typename Loop::NearShape;
  using ToolPatch = typename Loop::ToolPatch;

  void sense(ToolPatch& tool_patch, std::uint32_t number);
  void start(ToolPatch& tool_patch);
  void solve_once();
  [[nodiscard]] bool answer(const SolvePass& pass);
  void deliver(ToolPatch& tool_patch);

  /// [m/s, rad/s] Motion of a tool at the point of a block.
  [[nodiscard]] Vec6<S> motion_of(const ToolPatch& tool_patch, const SoftBlock<S>& block) const {
    const Twist<S>& twist = loop_.tools_[tool_patch.tool].twist;
    return stacked<S>(twist.at(block.arm_a), twist.angular);
  }
  /// [-] Index of the predicted body with an index of the world.
  [[nodiscard]] std::uint32_t number_of(std::uint32_t slot) const {
    std::uint32_t i = 0;
    while (loop_.bodies_[i].id().index != slot) ++i;
    return i;
  }

  Loop& loop_;
};

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
void HapticSubstep<S>::run() {
  for (Tool& tool : loop_.tools_) {
    if (!tool.is_moved) tool.twist = {};
    if (tool.is_placed) tool.last_pose = tool.pose;
    tool.is_moved = false;
    tool.wrench = {};
  }
  for (HapticBody<S>& body : loop_.bodies_) body.begin_substep();
  loop_.rays_cast_ = 0;
  bool has_contacts = false;
  for (std::uint32_t i = 0; i < loop_.tool_patches_.size(); ++i) {
    sense(loop_.tool_patches_[i], i);
    start(loop_.tool_patches_[i]);
    has_contacts = has_contacts || !loop_.tool_patches_[i].blocks.empty();
  }
  if (has_contacts) {
    solve_in_passes(
        SolverDef<S>{}.max_passes, [this] { solve_once(); },
        [this](const SolvePass& pass) { return answer(pass); });
  } else {
    solve_once();
  }
  for (ToolPatch& tool_patch : loop_.tool_patches_) deliver(tool_patch);
  for (HapticBody<S>& body : loop_.bodies_) body.end_substep(loop_.h_);
  ++loop_.done_;
  ++loop_.substeps_;
}

template <Scalar S>
void HapticSubstep<S>::sense(ToolPatch& tool_patch, std::uint32_t number) {
  const Tool& tool = loop_.tools_[tool_patch.tool];
  SensorPatch<S>& patch = tool_patch.patch;
  PatchScratch<S>& scratch = tool_patch.scratch;
  tool_patch.in_reach.clear();
  for (const std::uint32_t i : tool_patch.near) {
    const NearShape& shape = loop_.shapes_[i];
    const Body<S>& body = loop_.bodies_[shape.body].body();
    const S speed = closing_speed(patch.geometry->box, tool.pose, tool.twist,
                                  body.center_pose.translation, body.twist);
    const auto seen = shape_in_reach(patch, shape.id, shape.collider,
                                     relative_pose(tool.pose, body.center_pose), loop_.h_ * speed);
    if (seen.is_near(patch.geometry->box)) tool_patch.in_reach.push_back(seen);
  }
  if (tool_patch.in_reach.empty()) {
    clear_patch(patch);
    scratch.pairs.clear();
    return;
  }
  scratch.begin(patch);
  const bool is_due = (loop_.substeps_ + number) % patch.def.cast_every == 0;
  loop_.rays_cast_ += find_hits<S>(patch, scratch, tool_patch.in_reach, is_due);
  Body<S> A;
  A.center_pose = tool.pose;
  A.twist = tool.twist;
  collect_contacts(
      patch, scratch, A,
      [&](std::uint32_t tag) {
        std::size_t i = 0;
        while (tool_patch.in_reach[i].tag != tag) ++i;
        const BodyId id = tool_patch.in_reach[i].collider->body;
        return TouchedBody<S>{&loop_.bodies_[number_of(id.index)].body(), id};
      },
      {.dt = loop_.h_,
       .measures_lambda = false,
       .only_tag = tool_patch.in_reach.size() == 1 ? tool_patch.in_reach.front().tag : no_index});
}

/// Makes a soft block of each pair.
template <Scalar S>
void HapticSubstep<S>::start(ToolPatch& tool_patch) {
  tool_patch.blocks.clear();
  tool_patch.touched.clear();
  for (PatchPair<S>& pair : tool_patch.scratch.pairs) {
    const std::uint32_t number = number_of(pair.body_b);
    set_scheme(pair, pair.stiffness.bristle_sum, pair.stiffness.viscous_sum,
               loop_.bodies_[number].mobility_at(pair.arm_b), loop_.h_);
    start_linearisation(tool_patch.patch, tool_patch.scratch, pair, loop_.h_);
    SoftBlock<S> block;
    block.arm_a = pair.arm_a;
    block.arm_b = pair.arm_b;
    tool_patch.blocks.push_back(block);
    tool_patch.touched.push_back(number);
  }
}

template <Scalar S>
void HapticSubstep<S>::solve_once() {
  for (HapticBody<S>& body : loop_.bodies_) body.clear_system();
  for (ToolPatch& tool_patch : loop_.tool_patches_) {
    for (std::size_t k = 0; k < tool_patch.blocks.size(); ++k) {
      SoftBlock<S>& block = tool_patch.blocks[k];
      fill_block(tool_patch.scratch.pairs[k], block);
      loop_.bodies_[tool_patch.touched[k]].add(block, motion_of(tool_patch, block));
    }
  }
  for (HapticBody<S>& body : loop_.bodies_) body.solve(loop_.h_);
  for (ToolPatch& tool_patch : loop_.tool_patches_) {
    for (std::size_t k = 0; k < tool_patch.blocks.size(); ++k) {
      SoftBlock<S>& block = tool_patch.blocks[k];
      block.motion = motion_of(tool_patch, block) -
                     loop_.bodies_[tool_patch.touched[k]].motion_at(block.arm_b);
    }
  }
}

template <Scalar S>
bool HapticSubstep<S>::answer(const SolvePass& pass) {
  bool has_changed = false;
  for (ToolPatch& tool_patch : loop_.tool_patches_) {
    for (std::size_t k = 0; k < tool_patch.blocks.size(); ++k) {
      SoftBlock<S>& block = tool_patch.blocks[k];
      const PairResponse<S> found =
          evaluate(tool_patch.patch, tool_patch.scratch, tool_patch.scratch.pairs[k], block.motion,
                   loop_.h_, pass);
      block.impulse = stacked(found.impulse);
      has_changed = found.has_changed || has_changed;
    }
  }
  return has_changed;
}

/// Applies the impulses of a patch to tool and bodies, and turns them into readings.
template <Scalar S>
void HapticSubstep<S>::deliver(ToolPatch& tool_patch) {
  Tool& tool = loop_.tools_[tool_patch.tool];
  const S left = S(loop_.def_.substeps - loop_.done_) * loop_.h_;
  for (std::size_t k = 0; k < tool_patch.blocks.size(); ++k) {
    const SoftBlock<S>& block = tool_patch.blocks[k];
    if (!all_finite(block.impulse)) {
      clear_impulses(tool_patch.scratch, tool_patch.scratch.pairs[k]);
      continue;
    }
    const Wrench<S> on_b = wrench_of<S>(block.impulse);
    loop_.bodies_[tool_patch.touched[k]].apply_impulse(on_b.shifted(-block.arm_b), left);
    tool.wrench += (S(-1) / loop_.h_) * on_b.shifted(-block.arm_a);
  }
  if (tool_patch.scratch.pairs.empty() && !tool_patch.patch.was_active) return;
  fill_readings<S>(tool_patch.patch, tool_patch.scratch, tool.pose.translation, loop_.h_,
                   [&](std::uint32_t slot) { return loop_.bodies_[number_of(slot)].id(); });
}

}  // namespace bristle::inline BRISTLE_ABI::detail
