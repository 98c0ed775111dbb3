/// @file
/// The loop of solves while sensors change state.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <algorithm>

namespace bristle::inline BRISTLE_ABI::detail {

/// One solve of a step.
struct SolvePass {
  /// [-] Its number, from 1; solves left after it.
  int number = 1;
  int left = 0;
};

/// Solves, and solves anew while sensors end in another state than they were linearised for (stuck
/// to slipping, in contact to free, another normal force). At most `max_passes` times.
///
/// @param solve     solve(): fills the soft blocks and finds velocities.
/// @param evaluate  bool evaluate(pass), after every solve: evaluates the impulses. If a solve is
///                  left, it returns whether another is needed, and moves the linearisation there.
/// @return Number of solves.
template <typename Solve, typename Evaluate>
int solve_in_passes(int max_passes, Solve&& solve, Evaluate&& evaluate) {
  SolvePass pass{1, std::max(1, max_passes) - 1};
  for (;; ++pass.number, --pass.left) {
    solve();
    if (!evaluate(pass) || pass.left == 0) return pass.number;
  }
}

}  // namespace bristle::inline BRISTLE_ABI::detail
