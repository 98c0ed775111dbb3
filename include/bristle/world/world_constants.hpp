/// @file
/// Constants of the stages of a step that no formula gives.
///
/// `tests/constants` runs scenes with each at half and at twice its value.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <cstddef>

namespace bristle::inline BRISTLE_ABI::detail::chosen {

/// [-] Pairs in a task of the narrow phase. A pair costs a microsecond, waking a thread several. So
/// a task is work worth taking. Greater ones leave threads idle at the end
/// (docs/decisions/0013-chunks-of-pairs.md).
inline constexpr std::size_t pairs_per_task = 16;

/// [-] Pairs from which on threads share the narrow phase. Fewer are done before a thread wakes.
inline constexpr std::size_t fewest_shared_pairs = 64;

/// [-] Sensors of all patches from which on threads share patches. A sensor costs ten nanoseconds,
/// waking a thread microseconds.
inline constexpr std::size_t fewest_shared_sensors = 256;

/// [-] Sensors of a patch from which on threads share its rays. Fewer are cast in some
/// microseconds. It exceeds `RayTree::range_size`, as one range is nothing to share.
inline constexpr std::size_t fewest_shared_rays = 1537;

/// [-] Worlds of a batch's task. Their steps share scratch memory. More leave threads idle at the
/// end. Fewer read the scratch memory of more tasks.
inline constexpr std::size_t most_worlds_per_task = 16;

/// [-] Tasks of a batch that keep all threads busy. Fewer leave threads idle at the end. More make
/// small tasks (docs/decisions/0040-batches-are-worlds.md).
inline constexpr std::size_t fewest_batch_tasks = 64;

/// [1] Way for which contacts are advanced, in the way of a step. Edges that meet just at the end
/// of a step do not tell in which plane. A smaller one leaves them so. A greater one looks for
/// contacts that the step does not reach.
inline constexpr double contact_lookahead = 1.015625;

/// [1] Length that cached planes stay valid for, as a part of the shortest ray, if rays are not
/// cast in each step. A smaller one casts more often. A greater one asks more shapes.
inline constexpr double plane_cache_margin = 0.25;

/// [1] Share of its limit from which on friction counts as sliding for the mobility of a held body.
/// It then goes on as a force. A smaller one softens what sticks. With 1 round-off decides.
inline constexpr double sliding_share = 0.999;

/// [1] Share of the change of velocities up to which positions take over the residual of velocities
/// as their tolerance. A smaller one takes more sweeps of positions. A greater one leaves overlaps.
inline constexpr double position_residual_share = 1e-2;

/// [1] Gap of a joint, as a part of its arms, that steps do not close by themselves. A smaller one
/// takes Newton's steps where position corrections do. A greater one leaves joints torn
/// (docs/decisions/0047-mechanisms-that-lean.md).
inline constexpr double wide_joint_gap = 3e-2;

/// [1] Share of a wide gap at which Newton's steps end. Position corrections close the rest. A
/// smaller one takes more steps. A greater one leaves gaps that are soon wide again.
inline constexpr double closed_wide_gap_share = 0.1;

}  // namespace bristle::inline BRISTLE_ABI::detail::chosen
