/// @file
/// The loop around a solve whose sensors change state within the step.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

namespace bristle {

/// Solves, and solves anew while sensors find themselves in another state than they were linearised
/// for (stuck to slipping, touching to free, another normal force), at most `max_passes` times.
///
/// @param solve        solve(): fills the soft blocks, finds velocities, evaluates impulses.
/// @param relinearise  bool relinearise(pass, is_last_pass): moves the linearisation to the
/// solution
///                     and says whether that matters. Impulses evaluated before stay valid.
/// @return Number of solves.
template <typename Solve, typename Relinearise>
int solve_in_passes(int max_passes, Solve&& solve, Relinearise&& relinearise) {
  const int passes = std::max(1, max_passes);
  for (int pass = 1; pass < passes; ++pass) {
    solve();
    if (!relinearise(pass, pass + 1 == passes)) return pass;
  }
  solve();
  return passes;
}

}  // namespace bristle
