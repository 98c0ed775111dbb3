/// @file
/// Orthogonal reduction of many rows in few unknowns (Householder 1958).
///
/// Rows R of six unknowns are Q T. Q has orthonormal columns, and the triangle T has six rows. Rows
/// beyond six add no information. No pivot is divided by and no rank is decided. So rows that
/// repeat each other, nearly or exactly, need no care.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/types.hpp>

#include <array>
#include <cmath>
#include <cstddef>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// A row of six numbers.
template <Scalar S>
using Row6 = std::array<S, 6>;

/// The triangle T, and the scales of the reflections in Q.
template <Scalar S>
struct TallQr {
  /// [-] Triangle T: row k has its first entry in column k.
  std::array<Row6<S>, 6> triangle{};
  /// [1] Scale of each reflection I - scale v v^T. It is 0 if there is nothing to reflect.
  std::array<S, 6> scale{};
};

/// Reduces rows to a triangle.
/// @param rows  Six or more. In: R. Out: the reflections, column k from row k on.
template <Scalar S>
[[nodiscard]] TallQr<S> reduce_rows(std::span<Row6<S>> rows);

/// x := Q^T x. The first six entries belong to the rows of the triangle. No unknowns can change the
/// others.
template <Scalar S>
void to_triangle(const TallQr<S>& qr, std::span<const Row6<S>> rows, std::span<S> x);

/// x := Q x, for x that is zero beyond the first six entries.
template <Scalar S>
void from_triangle(const TallQr<S>& qr, std::span<const Row6<S>> rows, std::span<S> x);

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
TallQr<S> reduce_rows(std::span<Row6<S>> rows) {
  using std::sqrt;
  TallQr<S> qr;
  for (std::size_t k = 0; k < 6; ++k) {
    S square = S(0);
    for (std::size_t i = k; i < rows.size(); ++i) square += rows[i][k] * rows[i][k];
    // A length of zero has no derivative, and leaves nothing to reflect.
    if (square > S(0)) {
      const S head = rows[k][k];
      const S length = head > S(0) ? S(-sqrt(square)) : S(sqrt(square));
      // v = x - length e_k. The sign of the length keeps its head from cancelling.
      rows[k][k] = head - length;
      qr.scale[k] = S(-1) / (length * rows[k][k]);
      Row6<S> sums{};
      for (std::size_t i = k; i < rows.size(); ++i) {
        for (std::size_t j = k + 1; j < 6; ++j) sums[j] += rows[i][k] * rows[i][j];
      }
      for (S& sum : sums) sum *= qr.scale[k];
      for (std::size_t i = k; i < rows.size(); ++i) {
        for (std::size_t j = k + 1; j < 6; ++j) rows[i][j] -= rows[i][k] * sums[j];
      }
      qr.triangle[k][k] = length;
    }
    for (std::size_t j = k + 1; j < 6; ++j) qr.triangle[k][j] = rows[k][j];
  }
  return qr;
}

/// Reflects x by reflection k.
template <Scalar S>
void reflect(const TallQr<S>& qr, std::span<const Row6<S>> rows, std::size_t k, std::span<S> x) {
  S sum = S(0);
  for (std::size_t i = k; i < rows.size(); ++i) sum += rows[i][k] * x[i];
  sum *= qr.scale[k];
  for (std::size_t i = k; i < rows.size(); ++i) x[i] -= sum * rows[i][k];
}

template <Scalar S>
void to_triangle(const TallQr<S>& qr, std::span<const Row6<S>> rows, std::span<S> x) {
  for (std::size_t k = 0; k < 6; ++k) reflect(qr, rows, k, x);
}

template <Scalar S>
void from_triangle(const TallQr<S>& qr, std::span<const Row6<S>> rows, std::span<S> x) {
  for (std::size_t k = 6; k-- > 0;) reflect(qr, rows, k, x);
}

}  // namespace bristle::inline BRISTLE_ABI::detail
