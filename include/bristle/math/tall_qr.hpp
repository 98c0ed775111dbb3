/// @file
/// Orthogonal reduction of many rows in few unknowns (Householder 1958).
///
/// Rows R of six unknowns are Q T, with orthonormal columns in Q and a triangle T of six rows: the
/// rows beyond six say nothing new. No pivot is divided by and no rank is decided, so that rows
/// which repeat each other, nearly or exactly, need no care.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/types.hpp>

#include <array>
#include <cmath>
#include <cstddef>
#include <span>

namespace bristle::inline BRISTLE_ABI {

/// A row of six numbers.
template <Scalar S>
using Row6 = std::array<S, 6>;

/// The triangle T, and what Q needs beside the reflections.
template <Scalar S>
struct TallQr {
  /// [-] Row k has its first entry in column k.
  std::array<Row6<S>, 6> triangle{};
  /// [1] Of each reflection I - scale v v^T, 0 where there is nothing to reflect.
  std::array<S, 6> scale{};
};

/// Reduces rows to a triangle.
/// @param rows  Six or more. In: R. Out: the reflections, column k from row k on.
template <Scalar S>
[[nodiscard]] TallQr<S> reduce_rows(std::span<Row6<S>> rows);

/// x := Q^T x, of which the first six belong to the rows of the triangle. What stands in the others
/// no unknowns can change.
template <Scalar S>
void to_triangle(const TallQr<S>& qr, std::span<const Row6<S>> rows, std::span<S> x);

/// x := Q x, for x that is zero but for the first six.
template <Scalar S>
void from_triangle(const TallQr<S>& qr, std::span<const Row6<S>> rows, std::span<S> x);

// Implementation -----------------------------------------------------------------------------------

template <Scalar S>
TallQr<S> reduce_rows(std::span<Row6<S>> rows) {
  using std::sqrt;
  TallQr<S> qr;
  for (std::size_t k = 0; k < 6; ++k) {
    S square = S(0);
    for (std::size_t i = k; i < rows.size(); ++i) square += rows[i][k] * rows[i][k];
    // A length of zero has no derivative, and nothing is left to reflect.
    if (square > S(0)) {
      const S head = rows[k][k];
      const S length = head > S(0) ? S(-sqrt(square)) : S(sqrt(square));
      // v = x - length e_k; the sign of the length keeps its head from cancelling.
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

namespace detail {

/// Reflects x by reflection k.
template <Scalar S>
void reflect(const TallQr<S>& qr, std::span<const Row6<S>> rows, std::size_t k, std::span<S> x) {
  S sum = S(0);
  for (std::size_t i = k; i < rows.size(); ++i) sum += rows[i][k] * x[i];
  sum *= qr.scale[k];
  for (std::size_t i = k; i < rows.size(); ++i) x[i] -= sum * rows[i][k];
}

}  // namespace detail

template <Scalar S>
void to_triangle(const TallQr<S>& qr, std::span<const Row6<S>> rows, std::span<S> x) {
  for (std::size_t k = 0; k < 6; ++k) detail::reflect(qr, rows, k, x);
}

template <Scalar S>
void from_triangle(const TallQr<S>& qr, std::span<const Row6<S>> rows, std::span<S> x) {
  for (std::size_t k = 6; k-- > 0;) detail::reflect(qr, rows, k, x);
}

}  // namespace bristle::inline BRISTLE_ABI
