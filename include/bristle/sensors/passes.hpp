/// @file
/// The loop around a solve whose sensors change state within the step.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <algorithm>

namespace bristle::inline BRISTLE_ABI {

/// One of the solves of a step.
struct SolvePass {
  /// [-] Its number, from 1, and how many there may be after it.
  int number = 1;
  int left = 0;
};

/// Solves, and solves anew while sensors find themselves in another state than they were linearised
/// for (stuck to slipping, touching to free, another normal force), at most `max_passes` times.
///
/// @param solve   solve(): fills the soft blocks and finds velocities.
/// @param answer  bool answer(pass), after every solve: evaluates the impulses and, if there is a
///                solve left, says whether that is needed, with the linearisation moved to there.
/// @return Number of solves.
template <typename Solve, typename Answer>
int solve_in_passes(int max_passes, Solve&& solve, Answer&& answer) {
  SolvePass pass{1, std::max(1, max_passes) - 1};
  for (;; ++pass.number, --pass.left) {
    solve();
    if (!answer(pass) || pass.left == 0) return pass.number;
  }
}

}  // namespace bristle::inline BRISTLE_ABI
