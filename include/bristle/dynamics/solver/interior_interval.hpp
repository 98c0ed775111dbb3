/// @file
/// A row without a cone in an interior-point method (interior_point.hpp): of a joint, a motor, a
/// limit, or a contact without friction.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/solver/island_row.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// The impulse l of one row strictly between its bounds, and a Newton step of it. The velocity w of
/// the row splits into that by which its impulse would leave each bound, w + compliance l = low -
/// high. Each of these and the distance from its bound are to have the same product.
template <typename Real>
class InteriorInterval {
 public:
  using Row = IslandRow<Real>;

  /// @param k        Number of its row.
  /// @param rows     The row.
  /// @param barrier  [J] Product of distance and velocity at the start.
  InteriorInterval(std::size_t k, std::span<const Row> rows, Real barrier) : row_(k) {
    using std::sqrt;
    const Row& row = rows[0];
    const bool pushes = row.kind == RowKind::cone;
    if (pushes || row.kind == RowKind::bounded) {
      bounds_[0].at = pushes ? Real(0) : row.lower;
      bounds_[1].at = row.upper;
    }
    const Real width = bounds_[1].at - bounds_[0].at;
    // The start is in the middle of two bounds at most.
    const Real margin = std::min(sqrt(barrier / row.response), Real(0.5) * width);
    impulse_ = std::max(bounds_[0].at + margin, std::min(row.lambda, bounds_[1].at - margin));
    is_fixed_ = !(width > Real(0));
    for (Bound& bound : bounds_) {
      if (exists(bound)) bound.velocity = barrier / bound.distance(impulse_);
    }
  }

  [[nodiscard]] std::size_t row() const { return row_; }
  [[nodiscard]] Real complementarity() const {
    Real sum = Real(0);
    for (const Bound& bound : bounds_) {
      if (exists(bound)) sum += bound.velocity * bound.distance(impulse_);
    }
    return sum;
  }
  /// [-] Bounds that count in it.
  [[nodiscard]] std::size_t pairs() const {
    return static_cast<std::size_t>(exists(bounds_[0])) +
           static_cast<std::size_t>(exists(bounds_[1]));
  }
  [[nodiscard]] std::array<Real, 1> impulses() const { return {impulse_}; }

  void linearise(std::span<const Row> rows, const DynamicArray<Real>& v, Real yield) {
    const Row& row = rows[0];
    rest_ = -(row.times(v) - row.target + row.compliance * impulse_);
    Real slope = row.compliance + yield;
    for (const Bound& bound : bounds_) {
      if (!exists(bound)) continue;
      rest_ += bound.sign * bound.velocity;
      slope += bound.velocity / bound.distance(impulse_);
    }
    weight_ = is_fixed_ ? Real(0) : Real(1) / slope;
  }
  void add_slope(std::span<const Row> rows, BlockCholesky<Real>& h) const {
    if (weight_ > Real(0)) add_square(h, weight_, rows[0]);
  }
  std::array<Real, 1> start_step(Real barrier, bool is_corrected) {
    Real wanted = rest_;
    for (Bound& bound : bounds_) {
      if (!exists(bound)) continue;
      // distance (velocity + step) + velocity sign dl = barrier less the product of both steps.
      const Real second = is_corrected ? bound.step * bound.sign * impulse_step_ : Real(0);
      bound.step = (barrier - second) / bound.distance(impulse_) - bound.velocity;
      wanted += bound.sign * bound.step;
    }
    impulse_step_ = weight_ * wanted;
    return {impulse_step_};
  }
  void finish_step(std::span<const Row> rows, const DynamicArray<Real>& dv) {
    impulse_step_ -= weight_ * rows[0].times(dv);
    for (Bound& bound : bounds_) {
      if (!exists(bound)) continue;
      bound.step -= bound.velocity * bound.sign * impulse_step_ / bound.distance(impulse_);
    }
  }
  /// Share of the step at which an impulse reaches a bound, or a velocity zero.
  [[nodiscard]] Real reach() const {
    Real share = infinity<Real>;
    for (const Bound& bound : bounds_) {
      if (!exists(bound)) continue;
      const Real approach = -bound.sign * impulse_step_;
      if (approach > Real(0)) share = std::min(share, bound.distance(impulse_) / approach);
      if (bound.step < Real(0)) share = std::min(share, -bound.velocity / bound.step);
    }
    return share;
  }
  [[nodiscard]] bool is_inside() const {
    using std::isfinite;
    return isfinite(impulse_) &&
           std::all_of(bounds_.begin(), bounds_.end(), [this](const Bound& b) {
             return !exists(b) || (b.distance(impulse_) > Real(0) && b.velocity > Real(0));
           });
  }
  void advance(Real share) {
    impulse_ += share * impulse_step_;
    for (Bound& bound : bounds_) bound.velocity += share * bound.step;
  }

 private:
  /// One end of the allowed impulses.
  struct Bound {
    Real sign;  // 1 below, -1 above.
    Real at;    // Infinite without a bound.
    Real velocity = Real(0);
    Real step = Real(0);

    [[nodiscard]] Real distance(Real impulse) const { return sign * (impulse - at); }
  };
  [[nodiscard]] bool exists(const Bound& bound) const {
    return bound.sign * bound.at > -infinity<Real> && !is_fixed_;
  }

  std::size_t row_;
  Real impulse_ = Real(0);
  std::array<Bound, 2> bounds_{Bound{Real(1), -infinity<Real>}, Bound{Real(-1), infinity<Real>}};
  bool is_fixed_ = false;  // True if there is one allowed impulse.
  Real rest_ = Real(0);    // What low - high exceeds the velocity of the row by.
  Real weight_ = Real(0);
  Real impulse_step_ = Real(0);
};

}  // namespace bristle::inline BRISTLE_ABI::detail
