/// @file
/// Explicit Runge-Kutta integration of fifth order with error control.
///
/// The pair of Dormand and Prince 1980, "A family of embedded Runge-Kutta formulae". Its seventh
/// stage is the derivative at the end. It is also the first stage of the next substep. So each
/// substep takes six evaluations, and the whole one more.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/math/math_constants.hpp>
#include <bristle/math/types.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

namespace bristle::inline BRISTLE_ABI::detail {

/// Integrator with its scratch memory.
template <Scalar S>
class DormandPrince {
 public:
  /// Advances y over `duration` in substeps that end exactly on it.
  ///
  /// The `system` has two members. Member `bool derivative(S t, const S* y, S* dy)` computes the
  /// derivative; false ends the integration. Member `S error_ratio(const S* y, const S* error, S
  /// h)` is the error [1] of a substep that ends in y. It is relative to the tolerance. It is
  /// called right after the derivative at y.
  ///
  /// @param y  Values, changed only on success.
  /// @param state  [-] Number of leading values on which the derivative depends. The others are
  ///               integrals along the way.
  /// @param max_substeps  [-] Most substeps tried.
  /// @return False if the system failed, an error was not a number, or the limit was reached.
  template <typename System>
  [[nodiscard]] bool advance(std::span<S> y, std::size_t state, S duration, System& system,
                             int max_substeps);

  /// Substeps tried in the last call, including rejected ones.
  [[nodiscard]] int substeps() const { return substeps_; }

 private:
  static constexpr std::size_t stages = 7;

  /// to := from + h * sum of weights[i] * slope i, over the first `count` entries.
  template <std::size_t n>
  void combine(const S* from, const std::array<S, n>& weights, S h, std::size_t count, S* to) const;

  std::array<DynamicArray<S>, stages> slopes_;
  DynamicArray<S> start_, end_, error_;
  int substeps_ = 0;
};

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
template <std::size_t n>
void DormandPrince<S>::combine(const S* from, const std::array<S, n>& weights, S h,
                               std::size_t count, S* to) const {
  std::array<const S*, n> k;
  std::array<S, n> c;
  for (std::size_t s = 0; s < n; ++s) {
    k[s] = slopes_[s].data();
    c[s] = h * weights[s];
  }
  for (std::size_t i = 0; i < count; ++i) {
    S sum = c[0] * k[0][i];
    for (std::size_t s = 1; s < n; ++s) sum += c[s] * k[s][i];
    to[i] = from[i] + sum;
  }
}

template <Scalar S>
template <typename System>
bool DormandPrince<S>::advance(std::span<S> y, std::size_t state, S duration, System& system,
                               int max_substeps) {
  using std::pow;
  const auto f = [](int above, int below) { return S(above) / S(below); };
  const std::array<S, 1> a2{f(1, 5)};
  const std::array<S, 2> a3{f(3, 40), f(9, 40)};
  const std::array<S, 3> a4{f(44, 45), f(-56, 15), f(32, 9)};
  const std::array<S, 4> a5{f(19372, 6561), f(-25360, 2187), f(64448, 6561), f(-212, 729)};
  const std::array<S, 5> a6{f(9017, 3168), f(-355, 33), f(46732, 5247), f(49, 176),
                            f(-5103, 18656)};
  const std::array<S, 6> b{f(35, 384), S(0), f(500, 1113), f(125, 192), f(-2187, 6784), f(11, 84)};
  // Weights of the error: fifth order less fourth order.
  const std::array<S, 7> e{f(71, 57600),      S(0),       f(-71, 16695), f(71, 1920),
                           f(-17253, 339200), f(22, 525), f(-1, 40)};

  for (DynamicArray<S>& slope : slopes_) slope.resize(y.size());
  start_.assign(y.begin(), y.end());
  end_.resize(y.size());
  error_.resize(state);

  substeps_ = 0;
  S t = S(0);
  S h = duration;
  bool is_last = true;
  if (!system.derivative(t, start_.data(), slopes_[0].data())) return false;
  while (true) {
    if (substeps_ == max_substeps) return false;
    ++substeps_;
    const auto stage = [&](S c, const auto& weights, std::size_t slope) {
      combine(start_.data(), weights, h, state, end_.data());
      return system.derivative(t + c * h, end_.data(), slopes_[slope].data());
    };
    if (!stage(f(1, 5), a2, 1) || !stage(f(3, 10), a3, 2) || !stage(f(4, 5), a4, 3) ||
        !stage(f(8, 9), a5, 4) || !stage(S(1), a6, 5)) {
      return false;
    }
    combine(start_.data(), b, h, y.size(), end_.data());
    if (!system.derivative(t + h, end_.data(), slopes_[6].data())) return false;
    std::fill(error_.begin(), error_.end(), S(0));
    combine(error_.data(), e, h, state, error_.data());

    const S ratio = system.error_ratio(end_.data(), error_.data(), h);
    if (!(ratio < infinity<S>)) return false;
    const bool is_accepted = ratio <= S(1);
    if (is_accepted) {
      t += h;
      std::swap(start_, end_);
      std::swap(slopes_[0], slopes_[6]);
      if (is_last) break;
    }
    // The error of a substep grows with the fifth power of its length. The target is a little below
    // the tolerance. One estimate changes the length by a bounded factor. The error is
    // taken without derivatives, so the ends of substeps carry none.
    const S error = S(value_of(ratio));
    const S factor = error > S(0) ? S(1 - chosen::substep_safety) * pow(error, S(-0.2))
                                  : S(chosen::substep_growth);
    h *= std::clamp(factor, S(chosen::substep_shrinkage),
                    is_accepted ? S(chosen::substep_growth) : S(1 - chosen::substep_safety));
    // The rest is cut into equal parts. So the last one is no sliver.
    const S rest = duration - t;
    is_last = h >= rest;
    if (is_last) {
      h = rest;
    } else if (S(2) * h > rest) {
      h = rest / S(2);
    }
  }
  std::copy(start_.begin(), start_.end(), y.begin());
  return true;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
