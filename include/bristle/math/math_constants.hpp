/// @file
/// Constants of the mathematics that no formula gives.
///
/// `tests/constants` runs scenes with each at half and at twice its value.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

namespace bristle::inline BRISTLE_ABI::detail::chosen {

/// [1] Part by which a substep of an integrator is shorter than its error estimate allows. A
/// smaller value has more substeps rejected. A greater one takes more substeps.
inline constexpr double substep_safety = 0.1;

/// [1] Most that an integrator's substep grows by one estimate. A smaller value takes more substeps
/// after a short one. A greater one trusts estimates of a tiny error.
inline constexpr double substep_growth = 5.0;

/// [1] Least that an integrator's substep keeps of its length by one estimate. A smaller value
/// trusts estimates of a huge error. A greater one has more substeps rejected.
inline constexpr double substep_shrinkage = 0.2;

/// [rad] Turn in a step beyond which directions at its start tell little about its end. The chord
/// of a path then misses the arc by an eighth of the radius. A smaller value treats slower bodies
/// as fast ones, which costs time. A greater one lets them leave the arc.
inline constexpr double far_turn_of_step = 0.5;

}  // namespace bristle::inline BRISTLE_ABI::detail::chosen
