/// @file
/// Factorisation of a sparse symmetric matrix of 3x3 blocks within its envelope.
///
/// Each row is stored from its first nonzero block to the diagonal. All fill of the factorisation
/// falls inside (Jennings 1966). The joints of a mechanism, numbered end to end, have a narrow
/// envelope. Blocks keep the compiler in straight-line code. They take one division per row instead
/// of one per entry and a square root. That makes a chain more than three times cheaper.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/math/types.hpp>

#include <cstddef>
#include <cstdint>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// Lower triangle of a symmetric positive definite matrix of 3x3 blocks. Its factors replace it.
/// Rows and columns count blocks.
template <Scalar S>
class BlockEnvelope {
 public:
  /// Sets the shape. Entries keep old values, in disorder.
  /// @param first  Column of the first block of each row. At most the row's own number.
  void set_shape(std::span<const std::uint32_t> first);
  void set_zero() {
    for (Mat3<S>& block : blocks_) block = zero<Mat3<S>>();
  }

  [[nodiscard]] std::size_t size() const { return first_.size(); }
  /// Block of the lower triangle: first(i) <= j <= i. Of a diagonal block only its lower triangle
  /// counts.
  [[nodiscard]] Mat3<S>& at(std::size_t i, std::size_t j) { return blocks_[start_[i] + j]; }
  [[nodiscard]] const Mat3<S>& at(std::size_t i, std::size_t j) const {
    return blocks_[start_[i] + j];
  }

  /// Replaces the matrix A by its factors. A = L D L^T, with ones on the diagonal of L and 3x3
  /// blocks in D.
  /// @return False if a pivot is not positive or not finite. The matrix is then spoilt.
  [[nodiscard]] bool factor();

  /// x := A^-1 x, after `factor`.
  void solve(std::span<Vec3<S>> x) const;

 private:
  DynamicArray<std::uint32_t> first_;
  DynamicArray<std::size_t> start_;  // Index of each row in `blocks_`, less its first column.
  DynamicArray<Mat3<S>> blocks_;
  DynamicArray<Mat3<S>> row_;  // Blocks of the current row, times D.
};

// Implementation ----------------------------------------------------------------------------------

/// Inverse of a symmetric positive definite matrix by elimination. The closed form by cofactors is
/// no cheaper. It loses all digits where two rows are nearly the same.
/// @return False if a pivot is not positive or not finite.
template <Scalar S>
[[nodiscard]] bool invert_pivot(Mat3<S>& a) {
  const S d0 = a(0, 0);
  const S i0 = S(1) / d0;
  const S l1 = a(1, 0) * i0;
  const S l2 = a(2, 0) * i0;
  const S d1 = a(1, 1) - l1 * a(1, 0);
  const S i1 = S(1) / d1;
  const S l3 = (a(2, 1) - l2 * a(1, 0)) * i1;
  const S d2 = a(2, 2) - l2 * a(2, 0) - l3 * l3 * d1;
  const S i2 = S(1) / d2;
  const bool is_positive = d0 > S(0) && d1 > S(0) && d2 > S(0);
  if (!is_positive || !(d0 + d1 + d2 < infinity<S>)) return false;
  // L^-1 has -l1, -l3 below its diagonal and l1 l3 - l2 in its corner.
  const S corner = l1 * l3 - l2;
  a(2, 2) = i2;
  a(2, 1) = a(1, 2) = -l3 * i2;
  a(2, 0) = a(0, 2) = corner * i2;
  a(1, 1) = i1 + l3 * l3 * i2;
  a(1, 0) = a(0, 1) = -l1 * i1 - l3 * corner * i2;
  a(0, 0) = i0 + l1 * l1 * i1 + corner * corner * i2;
  return true;
}

template <Scalar S>
void BlockEnvelope<S>::set_shape(std::span<const std::uint32_t> first) {
  first_.assign(first.begin(), first.end());
  start_.resize(first.size());
  std::size_t size = 0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    start_[i] = size - first[i];  // Wraps around; only sums with a column are used.
    size += i - first[i] + 1;
  }
  blocks_.resize(size);
  row_.resize(first.size());
}

template <Scalar S>
bool BlockEnvelope<S>::factor() {
  for (std::size_t i = 0; i < size(); ++i) {
    const std::size_t first = first_[i];
    Mat3<S>& pivot = at(i, i);
    for (std::size_t j = first; j < i; ++j) {
      Mat3<S>& scaled = row_[j];  // L_ij D_j
      scaled = at(i, j);
      for (std::size_t k = first > first_[j] ? first : first_[j]; k < j; ++k) {
        scaled.noalias() -= row_[k] * at(j, k).transpose();
      }
      Mat3<S>& lower = at(i, j);
      lower.noalias() = scaled * at(j, j);
      pivot.noalias() -= lower * scaled.transpose();
    }
    if (!invert_pivot(pivot)) return false;
  }
  return true;
}

template <Scalar S>
void BlockEnvelope<S>::solve(std::span<Vec3<S>> x) const {
  for (std::size_t i = 0; i < size(); ++i) {
    for (std::size_t j = first_[i]; j < i; ++j) x[i].noalias() -= at(i, j) * x[j];
  }
  for (std::size_t i = 0; i < size(); ++i) x[i] = Vec3<S>(at(i, i) * x[i]);
  for (std::size_t i = size(); i-- > 0;) {
    for (std::size_t j = first_[i]; j < i; ++j) x[j].noalias() -= at(i, j).transpose() * x[i];
  }
}

}  // namespace bristle::inline BRISTLE_ABI::detail
