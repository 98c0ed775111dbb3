/// @file
/// All scenes of rigid bodies by name.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scenes/rigid/trial.hpp"

#include <vector>

namespace bristle::scenes {

/// Scenes in the order they are reported in. Groups: matrix, load, heap, drop, published,
/// perturbed, moving, unseen (nothing is ever tuned on these), long.
[[nodiscard]] std::vector<Recipe> catalogue();

}  // namespace bristle::scenes
