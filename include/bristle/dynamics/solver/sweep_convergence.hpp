/// @file
/// When sweeps of sequential impulses have done enough, and when they are too slow.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/solver/solver_constants.hpp>
#include <bristle/math/types.hpp>

#include <algorithm>
#include <cmath>

namespace bristle::inline BRISTLE_ABI::detail {

/// Watches a sequence of residuals. Decides whether more sweeps are worthwhile.
template <Scalar S>
class SweepConvergence {
 public:
  /// @param first, later  Residuals at which the first sweep is the last, and at which a later
  ///               one is.
  SweepConvergence(S first, S later) : first_(first), tolerance_(later) {}

  /// Accepts residuals up to `enough` from now on.
  void accept(S enough) { tolerance_ = std::max(tolerance_, enough); }
  [[nodiscard]] bool is_done(S residual) {
    before_last_ = between_;
    between_ = last_;
    last_ = residual;
    ++count_;
    return residual <= (count_ == 1 ? first_ : tolerance_);
  }
  /// Returns whether the remaining sweeps would cost more than factorisations. Sweeps alternate
  /// their direction, so the rate of two sweeps counts.
  [[nodiscard]] bool is_slow() const {
    using std::log;
    if (count_ < chosen::least_sweeps_before_rate) return false;
    if (!(last_ < before_last_)) return true;
    const S of_direct_solve = S(chosen::sweeps_of_direct_solve);
    return S(2) * log(last_ / tolerance_) > of_direct_solve * log(before_last_ / last_);
  }

 private:
  S first_;
  S tolerance_;
  S last_ = infinity<S>;
  S between_ = infinity<S>;
  S before_last_ = infinity<S>;
  int count_ = 0;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
