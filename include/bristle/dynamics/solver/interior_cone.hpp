/// @file
/// Coulomb's cone in an interior-point method (interior_point.hpp).
///
/// In the coordinates (mu l_n, l_x, l_y) of its impulse and (u_n / mu, u_x, u_y) of its velocity
/// the cone and its dual are the same second-order cone n >= |(x, y)|. Their product is l . u. The
/// scaling of Nesterov and Todd (1997) maps u and l to the same vector, W u = W^-1 l, so that a
/// Newton step treats both alike.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/solver/island_row.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// A vector of the algebra of the cone n >= |(x, y)|.
template <typename Real>
struct ConeVector {
  Real n = Real(0), x = Real(0), y = Real(0);

  [[nodiscard]] ConeVector operator+(const ConeVector& o) const {
    return {n + o.n, x + o.x, y + o.y};
  }
  [[nodiscard]] ConeVector operator-(const ConeVector& o) const {
    return {n - o.n, x - o.x, y - o.y};
  }
  [[nodiscard]] ConeVector times(Real s) const { return {s * n, s * x, s * y}; }
  [[nodiscard]] ConeVector over(Real s) const { return {n / s, x / s, y / s}; }
  [[nodiscard]] Real dot(const ConeVector& o) const { return n * o.n + x * o.x + y * o.y; }
  /// The product a o b of the algebra. (1, 0, 0) is its one.
  [[nodiscard]] ConeVector product(const ConeVector& o) const {
    return {dot(o), n * o.x + o.n * x, n * o.y + o.n * y};
  }
  /// The b with a o b = c.
  [[nodiscard]] ConeVector quotient(const ConeVector& c) const {
    const Real b = (n * c.n - x * c.x - y * c.y) / determinant();
    return {b, (c.x - b * x) / n, (c.y - b * y) / n};
  }
  /// n^2 - x^2 - y^2, positive inside the cone.
  [[nodiscard]] Real determinant() const {
    const Real t = planar_length(x, y);
    return (n - t) * (n + t);
  }
  /// Share of a step at which this vector, inside the cone, reaches its boundary.
  [[nodiscard]] Real reach(const ConeVector& step) const {
    using std::sqrt;
    // determinant(a + s step) = a s^2 + 2 b s + c.
    const Real a = step.n * step.n - step.x * step.x - step.y * step.y;
    const Real b = n * step.n - x * step.x - y * step.y;
    const Real c = determinant();
    // By the reversed inequality of Cauchy and Schwarz the discriminant is never negative.
    const Real root = sqrt(std::max(Real(0), b * b - a * c));
    // Its roots. The first one that is positive is the boundary.
    const Real q = b > Real(0) ? -b - root : -b + root;
    Real share = infinity<Real>;
    if (a != Real(0) && q / a > Real(0)) share = q / a;
    if (q != Real(0) && c / q > Real(0)) share = std::min(share, c / q);
    return share;
  }
};

/// The impulse and velocity of one contact, both inside their cones, and a Newton step of them.
template <typename Real>
class InteriorCone {
 public:
  using Row = IslandRow<Real>;
  using Vector = ConeVector<Real>;

  /// @param k     Number of its first row.
  /// @param rows  Its three rows. Friction is positive.
  /// @param barrier  [J] Product of its impulse and velocity at the start.
  InteriorCone(std::size_t k, std::span<const Row> rows, Real barrier) : row_(k) {
    using std::sqrt;
    friction_ = rows[0].friction;
    // Both are on the axis, in the ratio of what the row by itself responds.
    impulse_.n = friction_ * sqrt(barrier / rows[0].response);
    velocity_.n = barrier / impulse_.n;
  }

  [[nodiscard]] std::size_t row() const { return row_; }
  [[nodiscard]] Real complementarity() const { return impulse_.dot(velocity_); }
  [[nodiscard]] static std::size_t pairs() { return 1; }
  /// The three impulses of the rows.
  [[nodiscard]] std::array<Real, 3> impulses() const { return to_rows(impulse_); }

  /// Prepares Newton steps from here.
  /// @param rows  Its three rows.
  /// @param v     Velocities of the bodies.
  /// @param yield Velocity that the rows yield per change of their impulse.
  void linearise(std::span<const Row> rows, const DynamicArray<Real>& v, Real yield) {
    using std::sqrt;
    yield_ = yield;
    rest_ =
        velocity_ - Vector{(rows[0].times(v) - rows[0].target + rows[0].shift) / friction_,
                           rows[1].times(v) - rows[1].target, rows[2].times(v) - rows[2].target};
    const Real of_impulse = sqrt(impulse_.determinant());
    const Real of_velocity = sqrt(velocity_.determinant());
    // Quotients, since g++ 12 fuses products with the sum and differences that follow, in spite of
    // -ffp-contract=off (rotation_matrix), and other bits would come of -O2 than of -O1.
    const Vector l = impulse_.over(of_impulse);
    const Vector u = velocity_.over(of_velocity);
    const Real scale = Real(1) / sqrt(Real(2) * (Real(1) + l.dot(u)));
    point_ = Vector{l.n + u.n, l.x - u.x, l.y - u.y}.times(scale);
    size_ = sqrt(of_impulse / of_velocity);
    const Real t = planar_length(point_.x, point_.y);
    cosine_ = t > Real(0) ? point_.x / t : Real(1);
    sine_ = t > Real(0) ? point_.y / t : Real(0);
    // The eigenvalues of W^2, for (1, t) and (1, -t) with the direction t of the point, and across.
    const Real sum = (point_.n + t) * (point_.n + t);
    const std::array<Real, 3> of_square{size_ * size_ * sum, size_ * size_ / sum, size_ * size_};
    for (std::size_t i = 0; i < 3; ++i) {
      shrink_[i] = Real(1) / (Real(1) + yield * of_square[i]);
      weight_[i] = shrink_[i] * of_square[i];
    }
  }

  /// h += J^T D J, with the D of `step`.
  void add_slope(std::span<const Row> rows, BlockCholesky<Real>& h) const {
    Row with = rows[0];
    Row against = rows[0];
    Row across = rows[0];
    const auto turn = [this](const auto& n, const auto& x, const auto& y, auto& w, auto& a,
                             auto& c) {
      for (std::size_t i = 0; i < 6; ++i) {
        const Vector j = to_axes({n[i] / friction_, x[i], y[i]});
        w[i] = j.n;
        a[i] = j.x;
        c[i] = j.y;
      }
    };
    turn(rows[0].jacobian_a, rows[1].jacobian_a, rows[2].jacobian_a, with.jacobian_a,
         against.jacobian_a, across.jacobian_a);
    turn(rows[0].jacobian_b, rows[1].jacobian_b, rows[2].jacobian_b, with.jacobian_b,
         against.jacobian_b, across.jacobian_b);
    add_square(h, weight_[0], with);
    add_square(h, weight_[1], against);
    add_square(h, weight_[2], across);
  }

  /// Starts a step towards a complementarity. It is what the impulse does if the bodies keep their
  /// velocities.
  /// @param is_corrected  True if the step before, from the same point, tells the second order.
  /// @return Impulses of the three rows.
  std::array<Real, 3> start_step(Real barrier, bool is_corrected) {
    const Vector z = scaled(velocity_, Real(1));
    Vector wanted = Vector{barrier, Real(0), Real(0)} - z.product(z);
    if (is_corrected) {
      wanted = wanted - scaled(velocity_step_, Real(1)).product(scaled(impulse_step_, Real(-1)));
    }
    impulse_step_ =
        along_axes(scaled(z.quotient(wanted), Real(1)), shrink_) + along_axes(rest_, weight_);
    return to_rows(impulse_step_);
  }
  /// Ends it with the change of the rows' velocities.
  void finish_step(std::span<const Row> rows, const DynamicArray<Real>& dv) {
    const Vector change{rows[0].times(dv) / friction_, rows[1].times(dv), rows[2].times(dv)};
    impulse_step_ = impulse_step_ - along_axes(change, weight_);
    velocity_step_ = change - rest_ + impulse_step_.times(yield_);
  }
  [[nodiscard]] Real reach() const {
    return std::min(impulse_.reach(impulse_step_), velocity_.reach(velocity_step_));
  }
  [[nodiscard]] bool is_inside() const {
    return impulse_.determinant() > Real(0) && velocity_.determinant() > Real(0);
  }
  void advance(Real share) {
    impulse_ = impulse_ + impulse_step_.times(share);
    velocity_ = velocity_ + velocity_step_.times(share);
  }

 private:
  [[nodiscard]] std::array<Real, 3> to_rows(const Vector& l) const {
    return {l.n / friction_, l.x, l.y};
  }
  /// Coordinates along the eigenvectors of W.
  [[nodiscard]] Vector to_axes(const Vector& a) const {
    constexpr double half = 0.70710678118654752;  // Of (1, 1), to have the length 1.
    const Real t = cosine_ * a.x + sine_ * a.y;
    return {Real(half) * (a.n + t), Real(half) * (a.n - t), cosine_ * a.y - sine_ * a.x};
  }
  [[nodiscard]] Vector from_axes(const Vector& a) const {
    constexpr double half = 0.70710678118654752;
    const Real t = Real(half) * (a.n - a.x);
    return {Real(half) * (a.n + a.x), cosine_ * t - sine_ * a.y, sine_ * t + cosine_ * a.y};
  }
  /// The vector times a factor along each eigenvector.
  [[nodiscard]] Vector along_axes(const Vector& a, const std::array<Real, 3>& factors) const {
    const Vector parts = to_axes(a);
    return from_axes({factors[0] * parts.n, factors[1] * parts.x, factors[2] * parts.y});
  }
  /// W a for a sign of 1, W^-1 a for -1: size (w0 n + w . t, t + (n + w . t / (1 + w0)) w), where
  /// the inverse has -w and 1 / size.
  [[nodiscard]] Vector scaled(const Vector& a, Real sign) const {
    const Real along = point_.x * a.x + point_.y * a.y;
    const Real part = sign * a.n + along / (Real(1) + point_.n);
    const Vector image{point_.n * a.n + sign * along, a.x + part * point_.x, a.y + part * point_.y};
    return image.times(sign > Real(0) ? size_ : Real(1) / size_);
  }

  std::size_t row_;
  Real friction_;
  Vector impulse_, velocity_;
  Vector rest_;  // What `velocity_` exceeds the velocity of the rows by.
  Vector impulse_step_, velocity_step_;
  // W = size P(point), with the unit vector of the tangent part of the point.
  Vector point_;
  Real size_ = Real(1), cosine_ = Real(1), sine_ = Real(0);
  Real yield_ = Real(0);
  std::array<Real, 3> shrink_{}, weight_{};  // 1 / (1 + yield W^2), and that times W^2.
};

}  // namespace bristle::inline BRISTLE_ABI::detail
