/// @file
/// Constants of sensors that no formula gives.
///
/// `tests/constants` runs scenes with each at half and at twice its value.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <cstddef>

namespace bristle::inline BRISTLE_ABI::detail::chosen {

/// [1] Cosine between a ray and the surface against it, below which a hit is grazing and counts as
/// none. The gradient of the depth grows as the inverse of the cosine. A smaller value makes stiff
/// springs of contacts from the side. A greater one loses contacts at the edge of a pad on a curved
/// surface.
inline constexpr double grazing_cosine = 0.1;

/// [-] Packets of a range at most. Patch sums add up range sums (`sum_in_ranges`). A sweep over 512
/// sensors takes about a microsecond, and starting and summing a range takes 40 ns
/// (docs/measurements/0026-slices-of-patches.md). Shorter ranges cost more sums, longer ones wait
/// for the thread with one range more.
inline constexpr std::size_t range_packets = 32;

/// [-] Ranges from which on threads share a sweep. Fewer are done before the first thread wakes. A
/// greater value leaves patches of several thousand sensors to one thread.
inline constexpr std::size_t fewest_shared_ranges = 8;

/// [1] Share of the load, or of the friction, of a pair up to which a change from pass to pass
/// counts as none. Friction follows the normal force of the pass before. A smaller value takes more
/// passes, a greater one leaves that share of the friction behind.
inline constexpr double negligible_pass_change = 1e-3;

/// [1] Reduction of a slip within a pass from which on the last pass damps it. Such a slip is about
/// to reverse, and no pass is left to see it. A smaller value damps slips that settle, a greater
/// one lets a slip reverse undamped.
inline constexpr double damped_slip_reduction = 4.0;

/// [1] Round-offs of a diagonal entry of a mobility, up to which the rest of it counts as none.
/// Elimination leaves that much along a locked axis. A smaller value takes round-off for mobility,
/// a greater one locks the weakest of six directions.
inline constexpr double locked_mobility_round_offs = 8.0;

/// [-] Shifts of a ball at most, until it presses its deepest sensor to the depth of a spec. One is
/// exact where rays are parallel. A smaller value presses balls too deep into hollow skins, a
/// greater one costs a sweep over the layout for each.
inline constexpr int ball_shifts = 4;

/// [-] Places of a layout at most, where a ball is tried for the most loaded sensors. A smaller
/// value may miss the middle of a skin: a ball meets fewer sensors on a border. A greater one costs
/// a sweep over the layout for each.
inline constexpr std::size_t tried_ball_places = 64;

/// [1] Share of the longest stable step that is recommended for explicit sensors. A step has the
/// Lambda of `PatchDef::explicit_below` = 0.5 at sqrt(0.5 / 4) of the longest one. A smaller value
/// costs steps, a greater one leaves less room for a patch whose load grows.
inline constexpr double recommended_step_share = 0.35;

/// [1] Share of a ray outside of its own body, below which it is reported as buried. The body
/// itself then touches before the sensor has sensed much. A smaller
/// value overlooks buried rays, a greater one warns of pads that lie deep on purpose.
inline constexpr double buried_ray_share = 0.1;

/// [1] Load of a patch over the weight of the heaviest body, above which a slip of units is
/// reported: grams for kilograms. A smaller value warns of
/// firm grips, a greater one overlooks the slip.
inline constexpr double suspicious_load_ratio = 1000.0;

}  // namespace bristle::inline BRISTLE_ABI::detail::chosen
