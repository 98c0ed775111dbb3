/// @file
/// Tells when the derivatives in an iteration have settled.
///
/// Iterations end when values have converged. Derivatives come to rest by the same iteration but
/// later: Newton's method has them one step behind the values, and where values start converged
/// (from the impulses of the last step, say) nothing may have moved derivatives at all.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/types.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// Watches the derivatives of the velocities that an iteration finds. For scalars without
/// derivatives there is nothing to watch, and nothing is compiled of it.
template <Scalar S>
class DerivativeWatch {
 public:
  /// Begins with a new iteration.
  void start() { last_.clear(); }

  /// Whether no derivative of any velocity has changed since the last call by more than `tolerance`
  /// [1], relative to the largest one by the same variable, of a velocity or of what an impulse
  /// gives. False in the first call.
  ///
  /// @param show  Is called with this watch, to show it all `velocity` and `impulse`, each time in
  ///              the same order.
  template <typename Show>
  [[nodiscard]] bool have_settled(S tolerance, Show&& show) {
    if constexpr (derivatives_of<S> == 0) {
      return true;
    } else {
      is_first_ = last_.empty();
      at_ = 0;
      change_ = size_ = {};
      show(*this);
      if (is_first_) return false;
      for (std::size_t k = 0; k < change_.size(); ++k) {
        if (change_[k] > value_of(tolerance) * size_[k]) return false;
      }
      return true;
    }
  }

  /// [m/s, rad/s]
  void velocity(const S& v) {
    if (is_first_) last_.emplace_back();
    Partials& last = last_[at_++];
    for (std::size_t k = 0; k < last.size(); ++k) {
      change_[k] = std::max(change_[k], std::abs(v.partial(k) - last[k]));
      size_[k] = std::max(size_[k], std::abs(v.partial(k)));
      last[k] = v.partial(k);
    }
  }
  /// [N s, N m s] With what it makes of a velocity: impulses that hold each other leave derivatives
  /// of velocities that are round-off.
  void impulse(const S& x, const S& response) {
    for (std::size_t k = 0; k < size_.size(); ++k) {
      size_[k] = std::max(size_[k], std::abs(value_of(response) * x.partial(k)));
    }
  }

 private:
  using Partials = std::array<double, derivatives_of<S>>;

  std::vector<Partials> last_;
  Partials change_{}, size_{};
  std::size_t at_ = 0;
  bool is_first_ = true;
};

}  // namespace bristle::inline BRISTLE_ABI
