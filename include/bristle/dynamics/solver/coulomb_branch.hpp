/// @file
/// Branches of a row's law. The law is linear on each branch.
///
/// Let K be the response of a row by itself, w its remaining velocity, l its impulse and c a
/// centre. Then w~ = w + eps K (l - c). The sign of p = l - w~ / K tells the branch:
///     open   (p_n <= 0):         l + dl = 0
///     normal:                    w~ + J dv + eps K dl = 0
///     stick  (|p_t| <= mu p_n):  the same of both tangents
///     slip   (d = p_t / |p_t|, e across, a = mu p_n / |p_t|):
///         d . (l_t + dl_t) = mu (l_n + dl_n)
///         e . (l_t + dl_t) = a e . (p_t + dp_t), by which the direction turns
///     full   (p_n > bound):      l + dl = bound of the normal, tangents with p_n = bound
///     bounded rows: as normal within their bounds, l + dl = bound beyond.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/solver/island_row.hpp>

#include <array>
#include <cstddef>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// Branch of a row's law.
enum class CoulombState : std::uint8_t { unknown, open, stick, slip, inside, at_lower, at_upper };

/// The law of a row on its branch: dl = constant + D J dv. For a cone it covers all three rows.
template <typename Real>
struct CoulombBranch {
  CoulombState state = CoulombState::unknown;
  bool is_full = false;  // Of a contact: the normal impulse is at its bound.
  /// D of the normal, or of a single row; then of the tangents by the normal; then of the tangents.
  Real normal = Real(0);
  std::array<Real, 2> drag{};
  Real xx = Real(0), xy = Real(0), yy = Real(0);
  std::array<Real, 3> constant{};

  /// Returns whether the impulse depends on velocities.
  [[nodiscard]] bool has_slope() const {
    return state == CoulombState::stick || state == CoulombState::slip ||
           state == CoulombState::inside;
  }
  [[nodiscard]] bool is_same_as(const CoulombBranch& other) const {
    return state == other.state && is_full == other.is_full;
  }
};

/// Branch of a row without a cone.
/// @param l, w  Its impulse, and w~.
template <typename Real>
[[nodiscard]] CoulombBranch<Real> branch_of_single(const IslandRow<Real>& row, Real l, Real w,
                                                   Real eps) {
  CoulombBranch<Real> branch;
  branch.state = CoulombState::open;
  if (!(row.response > Real(0))) return branch;
  const Real left = w + row.compliance * l;
  if (row.kind == RowKind::bounded) {
    const Real proposed = l - left / (row.response + row.compliance);
    if (!(proposed > row.lower) || !(proposed < row.upper)) {
      branch.state = proposed > row.lower ? CoulombState::at_upper : CoulombState::at_lower;
      branch.constant[0] = row.clamped(proposed) - l;
      return branch;
    }
  }
  branch.state = CoulombState::inside;
  branch.normal = Real(-1) / row.softness(eps);
  branch.constant[0] = branch.normal * left;
  return branch;
}

/// Branch of a contact.
/// @param row   Its normal row.
/// @param l, w  Impulses, and w~, of the normal and the tangents.
template <typename Real>
[[nodiscard]] CoulombBranch<Real> branch_of_cone(const IslandRow<Real>& row,
                                                 const std::array<Real, 3>& l,
                                                 const std::array<Real, 3>& w, Real eps) {
  CoulombBranch<Real> branch;
  branch.state = CoulombState::open;
  const Real K = row.response;
  if (!(K > Real(0))) return branch;
  const Real normal = l[0] - w[0] / K;
  if (!(normal > Real(0))) {
    branch.constant = {-l[0], -l[1], -l[2]};
    return branch;
  }
  const Real slope = Real(-1) / (eps * K);
  branch.is_full = normal > row.upper;
  branch.normal = branch.is_full ? Real(0) : slope;
  branch.constant[0] = branch.is_full ? row.upper - l[0] : slope * w[0];
  const Real px = l[1] - w[1] / K;
  const Real py = l[2] - w[2] / K;
  const Real length = planar_length(px, py);
  const Real bound = row.friction * row.clamped(normal);
  if (length <= bound) {
    branch.state = CoulombState::stick;
    branch.xx = branch.yy = slope;
    branch.constant[1] = slope * w[1];
    branch.constant[2] = slope * w[2];
    return branch;
  }
  branch.state = CoulombState::slip;
  const std::array<Real, 2> along{px / length, py / length};
  const std::array<Real, 2> across{-along[1], along[0]};
  const Real share = bound / length;
  const Real rest = Real(1) - share * (Real(1) - eps);
  const Real stiffness_across = share / (K * rest);
  const Real to_bound =
      row.friction * (l[0] + branch.constant[0]) - l[1] * along[0] - l[2] * along[1];
  const Real to_line = -(l[1] * across[0] + l[2] * across[1]) / rest;
  branch.xx = -stiffness_across * across[0] * across[0];
  branch.xy = -stiffness_across * across[0] * across[1];
  branch.yy = -stiffness_across * across[1] * across[1];
  for (std::size_t i = 0; i < 2; ++i) {
    branch.drag[i] = along[i] * row.friction * branch.normal;
    branch.constant[i + 1] = along[i] * to_bound + across[i] * to_line;
  }
  return branch;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
