/// @file
/// One constraint row of `IslandRows`: its Jacobian, its multiplier and the bounds of that.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>
#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/no_index.hpp>
#include <bristle/core/unrolled.hpp>
#include <bristle/dynamics/solver/solver_constants.hpp>
#include <bristle/math/block6.hpp>
#include <bristle/math/block_cholesky.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

namespace bristle::inline BRISTLE_ABI::detail {

/// Allowed values of the multiplier of a row.
enum class RowKind : std::uint8_t {
  /// Any value.
  free,
  /// Values within [lower, upper].
  bounded,
  /// Normal row of a point with Coulomb's cone. Two `tangent` rows follow.
  cone,
  /// See `cone`.
  tangent
};

/// Side of its bounds that a row is on.
enum class RowSide : std::uint8_t {
  inside,
  at_bound,
  sliding,
  /// Of a cone: at its end, and within the disk there. The tangents are free.
  at_end
};

/// A row over the velocities of two bodies. Velocities are relative to the row's target.
template <typename Real>
struct IslandRow {
  // Fields that decide the branch of a row fill the first cache line.
  std::uint32_t a = no_index;  // First unknown of each body; `no_index` if it has none.
  std::uint32_t b = no_index;
  RowKind kind = RowKind::free;
  RowSide side = RowSide::inside;
  Real response = Real(0);    // K: velocity per own impulse; 0 for a row that is left out.
  Real compliance = Real(0);  // Velocity yielded per impulse.
  Real friction = Real(0);
  Real lower = Real(0);  // Bounds of a single row, or of the normal of a cone.
  Real upper = infinity<Real>;
  Real target = Real(0);
  std::array<Real, 6> jacobian_a{};
  std::array<Real, 6> jacobian_b{};
  Real bias = Real(0);   // Part of the target that is no body's motion: a bounce, a gap.
  Real shift = Real(0);  // Of a cone: opening speed of sliding.
  Real lambda = Real(0);
  Real velocity = Real(0);
  Real change = Real(0);  // Of the velocity, along the whole Newton step.

  /// J v.
  [[nodiscard]] Real times(const DynamicArray<Real>& v) const {
    Real sum = Real(0);
    if (a != no_index) sum += dot6(jacobian_a.data(), v.data() + a);
    if (b != no_index) sum += dot6(jacobian_b.data(), v.data() + b);
    return sum;
  }
  /// g += J^T x.
  void add_to(DynamicArray<Real>& g, Real x) const {
    if (a != no_index) unrolled<6>([&](auto i) { g[a + i] += x * jacobian_a[i]; });
    if (b != no_index) unrolled<6>([&](auto i) { g[b + i] += x * jacobian_b[i]; });
  }
  /// The nearest allowed value of a row without a cone.
  [[nodiscard]] Real clamped(Real x) const {
    return kind == RowKind::free ? x : std::min(std::max(x, lower), upper);
  }
  /// [velocity per impulse] R = eps K. A large eps keeps a step from leaving the branch of its law.
  /// A row without bounds has one branch, so its eps is the least at once.
  [[nodiscard]] Real regularisation(Real eps) const {
    return (kind == RowKind::free ? std::min(eps, Real(chosen::least_eps)) : eps) * response;
  }
  /// [velocity per impulse] R plus the row's own compliance. It is the inverse of the slope of
  /// lambda+.
  [[nodiscard]] Real softness(Real eps) const { return regularisation(eps) + compliance; }
  /// The multiplier without its bounds, at a share s of the way along the step.
  [[nodiscard]] Real proposed(Real eps, Real s) const {
    if (!(response > Real(0))) return Real(0);
    return lambda - (velocity + shift + s * change + compliance * lambda) / softness(eps);
  }
};

/// Length of (x, y). The squares of all states are finite, so built-in numbers need no `hypot`,
/// which takes ten times as long. Derivatives need it at zero.
template <typename Real>
[[nodiscard]] Real planar_length(const Real& x, const Real& y) {
  if constexpr (std::is_floating_point_v<Real>) {
    return std::sqrt(x * x + y * y);
  } else {
    using std::hypot;
    return hypot(x, y);
  }
}

/// Moves a point into a disk, radially.
template <typename Real>
void shrink(Real radius, Real& x, Real& y) {
  const Real length = planar_length(x, y);
  if (length <= radius) return;
  x *= radius / length;
  y *= radius / length;
}

/// Moves (n, x, y) to the nearest point of a friction cone that ends at `most`. The cone may be as
/// narrow as a line.
template <typename Real>
void project_on_cone(Real friction, Real most, Real& n, Real& x, Real& y) {
  const Real t = planar_length(x, y);
  const bool is_inside = n >= Real(0) && t <= friction * n;
  if (!is_inside) {
    if (friction * t <= -n) {
      n = x = y = Real(0);
      return;
    }
    n = (n + friction * t) / (Real(1) + friction * friction);
    const Real scale = t > Real(0) ? friction * n / t : Real(0);
    x *= scale;
    y *= scale;
  }
  if (!(n > most)) return;
  // All that would be beyond the end of the cone is nearest to a point of the disk there.
  n = most;
  shrink(friction * most, x, y);
}

/// h += weight j j^T, with the Jacobian j of a row.
template <typename Real>
void add_square(BlockCholesky<Real>& h, Real weight, const IslandRow<Real>& row) {
  const std::uint32_t unknown[2] = {row.a, row.b};
  const std::array<Real, 6>* j[2] = {&row.jacobian_a, &row.jacobian_b};
  for (std::size_t k = 0; k < 2; ++k) {
    if (unknown[k] == no_index) continue;
    Real padded[Block6<Real>::stride] = {};
    std::copy_n(j[k]->data(), 6, padded);
    const Six<Real> left = Six<Real>::load(padded);
    for (std::size_t l = 0; l < 2; ++l) {
      if (unknown[l] == no_index || unknown[l] > unknown[k]) continue;
      Real* const block = h.block(h.pattern().block(unknown[k] / 6, unknown[l] / 6));
      unrolled<6>([&](auto q) {
        Real* const column = block + Block6<Real>::stride * q;
        Six<Real> sums = Six<Real>::load(column);
        sums.add(weight * (*j[l])[q], left);
        sums.store(column);
      });
    }
  }
}

/// Distance of a row from its law, as a velocity by the row's own response. A cone counts with its
/// tangents.
/// @param l, w  Impulses and velocities, of the row and those that follow.
template <typename Real>
[[nodiscard]] Real distance_from_law(const IslandRow<Real>& row, const Real* l, const Real* w) {
  using std::abs;
  const Real K = row.response;
  const Real proposed = l[0] - (w[0] + row.compliance * l[0]) / (K + row.compliance);
  if (row.kind != RowKind::cone) return K * abs(l[0] - row.clamped(proposed));
  Real x = l[1] - w[1] / K;
  Real y = l[2] - w[2] / K;
  shrink(row.friction * std::max(Real(0), l[0]), x, y);
  return std::max(K * abs(l[0] - row.clamped(proposed)),
                  K * planar_length(Real(l[1] - x), Real(l[2] - y)));
}

/// Distance of a cone from its law in the convex problem, where contacts open at their shifts, as a
/// velocity by the row's own response.
/// @param l, w  Impulses and velocities of its three rows.
template <typename Real>
[[nodiscard]] Real distance_from_cone(const IslandRow<Real>& row, const Real* l, const Real* w) {
  using std::abs;
  const Real K = row.response;
  Real n = l[0] - (w[0] + row.shift) / K;
  Real x = l[1] - w[1] / K;
  Real y = l[2] - w[2] / K;
  project_on_cone(row.friction, row.upper, n, x, y);
  return K * std::max(Real(abs(n - l[0])), planar_length(Real(x - l[1]), Real(y - l[2])));
}

/// Distance of a row from its law in the convex problem.
template <typename Real>
[[nodiscard]] Real distance_from_convex_law(const IslandRow<Real>& row, const Real* l,
                                            const Real* w) {
  return row.kind == RowKind::cone ? distance_from_cone(row, l, w) : distance_from_law(row, l, w);
}

/// Largest distance of a row that can act from a law, as a velocity by the row's own response.
/// @param lambda, velocity  Return the multiplier and the velocity of a row by its number.
/// @param distance          Returns that of one row from its impulses and velocities.
template <typename Real, typename Lambda, typename Velocity, typename Distance>
[[nodiscard]] Real largest_distance(std::span<const IslandRow<Real>> rows, const Lambda& lambda,
                                    const Velocity& velocity, const Distance& distance) {
  Real largest = Real(0);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const IslandRow<Real>& row = rows[i];
    if (!(row.response > Real(0)) || row.kind == RowKind::tangent) continue;
    Real l[3], w[3];
    for (std::size_t part = 0; part < (row.kind == RowKind::cone ? 3 : 1); ++part) {
      l[part] = lambda(i + part);
      w[part] = velocity(i + part);
    }
    largest = std::max(largest, distance(row, l, w));
  }
  return largest;
}
/// The same from Coulomb's law.
template <typename Real, typename Lambda, typename Velocity>
[[nodiscard]] Real distance_from_law(std::span<const IslandRow<Real>> rows, const Lambda& lambda,
                                     const Velocity& velocity) {
  return largest_distance<Real>(rows, lambda, velocity,
                                [](const IslandRow<Real>& row, const Real* l, const Real* w) {
                                  return distance_from_law(row, l, w);
                                });
}
/// The same in the convex problem.
template <typename Real, typename Lambda, typename Velocity>
[[nodiscard]] Real distance_from_convex_law(std::span<const IslandRow<Real>> rows,
                                            const Lambda& lambda, const Velocity& velocity) {
  return largest_distance<Real>(rows, lambda, velocity,
                                [](const IslandRow<Real>& row, const Real* l, const Real* w) {
                                  return distance_from_convex_law(row, l, w);
                                });
}

}  // namespace bristle::inline BRISTLE_ABI::detail
