/// @file
/// Constants of bodies, joints and contacts that no formula gives.
///
/// `tests/constants` runs scenes with each at half and at twice its value.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail::chosen {

/// [-] Newton's steps for a rotation of the free top. Fewer may leave energy beyond round-off.
inline constexpr int most_top_iterations = 8;

/// [-] Substeps, each of a radian, in which a free top turns. More follow faster spins.
/// Fewer bound the cost of a step. Beyond them a body keeps momentum but not energy.
inline constexpr int most_top_substeps = 4096;

/// [1] Roundings of a row's response that count as no mobility once other rows hold. Elimination
/// adds roundings up. A smaller number divides by round-off. A greater one gives up rows of light
/// bodies on heavy ones.
inline constexpr double no_mobility_roundings = 1000.0;

/// [1] Outer share of the friction cone in which a contact passes from holding to sliding. The time
/// of its impulse fades there. A smaller one lets small differences grow. A greater one takes
/// accuracy from contacts that hold.
inline constexpr double hold_fade = 0.1;

/// [1] Share of new contacts beyond which an island has no warm start. Such an island gets all
/// sweeps that settings allow. A smaller one costs sweeps. A greater one leaves contacts of a fall
/// half solved.
inline constexpr double cold_contact_share = 0.5;

/// [1] Energy that an extrapolation must gain, as a part of what the pair of sweeps gained. In
/// docs/measurements/0021-large-islands.md smaller ones cost piles up to 1.4 times as much. With 1
/// a tower of planks creeps by 2 mm.
inline constexpr double least_extrapolation_gain = 0.5;

/// [1] Share of its force by which a motor in position mode plans to brake. The rest is for loads.
/// A smaller one arrives later. A greater one passes the target under load.
inline constexpr double motor_braking_share = 0.5;

/// [-] Newton's steps that close the small gaps of a mechanism. More only cost where gaps do not
/// close.
inline constexpr int most_gap_passes = 8;

/// [1] Roundings of a mechanism's size that a closed gap may have. A smaller number takes one more
/// pass at most. A greater one leaves gaps that velocities then show.
inline constexpr double closed_gap_roundings = 256.0;

/// [1] Gap, as a part of a mechanism's size, from which a pass needs a new matrix. The matrix is
/// from nearby positions. A smaller one factors more often. A greater one takes more passes.
inline constexpr double stale_matrix_gap = 1e-3;

/// [-] Newton's steps that close the wide gaps of a mechanism. More only cost where gaps do not
/// close.
inline constexpr int most_wide_gap_passes = 32;

/// [rad] Rotation of a body to which such a step is shortened. A smaller one takes more steps. A
/// greater one leaves the range in which a step helps.
inline constexpr double most_wide_gap_turn = 0.5;

/// [-] Multiply-adds of the widest matrix of a mechanism that is factored. They take some
/// hundredths of a second. Wider ones are left to solvers with bounded cost. A smaller number gives
/// up the energy of hubs with many arms. A greater one makes the worst step longer.
inline constexpr std::uint64_t most_factor_work = 20'000'000;

/// [1] Velocity error of a mechanism's substep (`MechanismIntegrator`). In
/// docs/measurements/0016-mechanisms-by-integration.md it costs 4 % more evaluations at 240 Hz than
/// twice its value. A greater one loses energy of long chains.
inline constexpr double mechanism_tolerance = 5e-5;

/// [-] Substeps of a mechanism tried in a step. More follow faster motions. Fewer bound the cost of
/// a step. Beyond them the velocity solvers take over.
inline constexpr int most_mechanism_substeps = 64;

}  // namespace bristle::inline BRISTLE_ABI::detail::chosen
