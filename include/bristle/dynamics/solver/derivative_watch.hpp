/// @file
/// Tells when the derivatives in an iteration have settled.
///
/// Iterations end when values have converged. Derivatives converge by the same iteration, but
/// later. Newton's method has them one step behind the values. Where values start converged (from a
/// warm start, say), nothing may have changed derivatives at all.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/math/types.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace bristle::inline BRISTLE_ABI::detail {

/// Watches the derivatives of the velocities that an iteration finds. It compiles to nothing for
/// scalars without derivatives.
template <Scalar S>
class DerivativeWatch {
 public:
  /// Starts a new iteration.
  void start() { last_.clear(); }

  /// Returns whether all derivatives of velocities have settled. None may have changed since the
  /// last call by more than `tolerance` [1]. That is relative to the largest derivative by the same
  /// variable. It counts velocities and velocity changes by impulses. False in the first call.
  ///
  /// @param show  Called with this watch. It passes all `velocity` and `impulse` values to it.
  ///              Their order is always the same.
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

  /// Adds a velocity [m/s, rad/s].
  void velocity(const S& v) {
    if (is_first_) last_.emplace_back();
    Partials& last = last_[at_++];
    for (std::size_t k = 0; k < last.size(); ++k) {
      change_[k] = std::max(change_[k], std::abs(v.partial(k) - last[k]));
      size_[k] = std::max(size_[k], std::abs(v.partial(k)));
      last[k] = v.partial(k);
    }
  }
  /// Adds an impulse [N s, N m s], and the response of a velocity to it. Impulses that balance each
  /// other leave derivatives of velocities that are round-off.
  void impulse(const S& x, const S& response) {
    for (std::size_t k = 0; k < size_.size(); ++k) {
      size_[k] = std::max(size_[k], std::abs(value_of(response) * x.partial(k)));
    }
  }

 private:
  using Partials = std::array<double, derivatives_of<S>>;

  DynamicArray<Partials> last_;
  Partials change_{}, size_{};
  std::size_t at_ = 0;
  bool is_first_ = true;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
