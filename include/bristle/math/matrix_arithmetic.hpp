/// @file
/// Sums and products of small vectors and matrices, as values.
///
/// The operators of Eigen give expressions. Each formula has a type of its own, with some hundred
/// functions to make and inline. That was more than half of a compiler's work on this library.
/// Inside the namespace `bristle` the operators below are the better match where sizes are known.
/// Both sides are evaluated, and the result is a matrix. Sums have the order of Eigen's, so that
/// the bits are the same.
///
/// A member function of Eigen refers to its object. So its result on a temporary must not be kept.
/// In `const auto size = (a - b).cwiseAbs()` it refers to a difference that is gone. With `const
/// Vec3<S> size` it does not.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <Eigen/Core>

#include <concepts>
#include <type_traits>

namespace bristle::inline BRISTLE_ABI {

namespace detail {

/// An Eigen matrix, or an expression of one, whose size is known at compile time.
template <typename M>
concept SmallMatrix = std::is_base_of_v<Eigen::MatrixBase<M>, M> && M::SizeAtCompileTime >
0;

/// Two matrices of one size and scalar.
template <typename A, typename B>
concept SameSize =
    SmallMatrix<A> && SmallMatrix<B> && std::same_as<typename A::Scalar, typename B::Scalar> &&
        int{A::RowsAtCompileTime} == int{B::RowsAtCompileTime} &&
    int{A::ColsAtCompileTime} == int{B::ColsAtCompileTime};

/// Matrix type of results: `Vec3`, `Mat3`, ... From six rows or columns on it is unaligned, like
/// `Vec6` and `Mat6`.
template <typename S, int rows, int columns>
using SmallResult = Eigen::Matrix<S, rows, columns,
                                  (rows < 6 && columns < 6 ? 0 : int{Eigen::DontAlign}) |
                                      (rows == 1 && columns != 1 ? int{Eigen::RowMajor} : 0)>;
template <typename M>
using ValueOf = SmallResult<typename M::Scalar, M::RowsAtCompileTime, M::ColsAtCompileTime>;

/// The matrix itself if its entries are in memory, else its value.
template <SmallMatrix M>
[[nodiscard]] BRISTLE_FORCE_INLINE decltype(auto) stored(const M& m) {
  if constexpr ((int{M::Flags} & int{Eigen::DirectAccessBit}) != 0) {
    return (m);
  } else {
    return ValueOf<M>(m);
  }
}

/// Entry of a matrix that is in memory.
template <SmallMatrix M>
[[nodiscard]] BRISTLE_FORCE_INLINE const typename M::Scalar& entry(const M& m, int row, int column) {
  if constexpr (M::IsRowMajor) {
    return m.data()[row * m.outerStride() + column * m.innerStride()];
  } else {
    return m.data()[column * m.outerStride() + row * m.innerStride()];
  }
}

/// The matrix whose entries are `make(row, column)`.
template <typename Value, typename Make>
[[nodiscard]] BRISTLE_FORCE_INLINE Value matrix_of(const Make& make) {
  constexpr int rows = Value::RowsAtCompileTime;
  constexpr int columns = Value::ColsAtCompileTime;
  if constexpr (rows == 3 && columns == 1) {
    return {make(0, 0), make(1, 0), make(2, 0)};
  } else {
    Value value;
    for (int column = 0; column < columns; ++column) {
      for (int row = 0; row < rows; ++row) value.data()[column * rows + row] = make(row, column);
    }
    return value;
  }
}

}  // namespace detail

/// Sum of two matrices of one size, entry by entry.
template <typename A, typename B>
requires detail::SameSize<A, B>
[[nodiscard]] BRISTLE_FORCE_INLINE detail::ValueOf<A> operator+(const A& a, const B& b) {
  decltype(auto) x = detail::stored(a);
  decltype(auto) y = detail::stored(b);
  return detail::matrix_of<detail::ValueOf<A>>(
      [&](int i, int j) { return detail::entry(x, i, j) + detail::entry(y, i, j); });
}

/// Difference of two matrices of one size, entry by entry.
template <typename A, typename B>
requires detail::SameSize<A, B>
[[nodiscard]] BRISTLE_FORCE_INLINE detail::ValueOf<A> operator-(const A& a, const B& b) {
  decltype(auto) x = detail::stored(a);
  decltype(auto) y = detail::stored(b);
  return detail::matrix_of<detail::ValueOf<A>>(
      [&](int i, int j) { return detail::entry(x, i, j) - detail::entry(y, i, j); });
}

/// Negative of a matrix.
template <detail::SmallMatrix A>
[[nodiscard]] BRISTLE_FORCE_INLINE detail::ValueOf<A> operator-(const A& a) {
  decltype(auto) x = detail::stored(a);
  return detail::matrix_of<detail::ValueOf<A>>(
      [&](int i, int j) { return -detail::entry(x, i, j); });
}

/// A matrix times a number.
template <detail::SmallMatrix A, std::same_as<typename A::Scalar> S>
[[nodiscard]] BRISTLE_FORCE_INLINE detail::ValueOf<A> operator*(const S& k, const A& a) {
  decltype(auto) x = detail::stored(a);
  return detail::matrix_of<detail::ValueOf<A>>(
      [&](int i, int j) { return k * detail::entry(x, i, j); });
}

/// A matrix times a number.
template <detail::SmallMatrix A, std::same_as<typename A::Scalar> S>
[[nodiscard]] BRISTLE_FORCE_INLINE detail::ValueOf<A> operator*(const A& a, const S& k) {
  decltype(auto) x = detail::stored(a);
  return detail::matrix_of<detail::ValueOf<A>>(
      [&](int i, int j) { return detail::entry(x, i, j) * k; });
}

/// A matrix divided by a number, entry by entry.
template <detail::SmallMatrix A, std::same_as<typename A::Scalar> S>
[[nodiscard]] BRISTLE_FORCE_INLINE detail::ValueOf<A> operator/(const A& a, const S& k) {
  decltype(auto) x = detail::stored(a);
  return detail::matrix_of<detail::ValueOf<A>>(
      [&](int i, int j) { return detail::entry(x, i, j) / k; });
}

/// Not for a row times a column: Eigen's inner product converts to a number by itself.
template <detail::SmallMatrix A, detail::SmallMatrix B>
requires(int{A::ColsAtCompileTime} == int{B::RowsAtCompileTime} &&
         (int{A::RowsAtCompileTime} > 1 || int{B::ColsAtCompileTime} > 1) &&
         std::same_as<typename A::Scalar, typename B::Scalar>) [[nodiscard]] BRISTLE_FORCE_INLINE auto
operator*(const A& a, const B& b) {
  using S = typename A::Scalar;
  constexpr int inner = A::ColsAtCompileTime;
  decltype(auto) x = detail::stored(a);
  decltype(auto) y = detail::stored(b);
  return detail::matrix_of<detail::SmallResult<S, A::RowsAtCompileTime, B::ColsAtCompileTime>>(
      [&](int i, int j) -> S {
        S sum = detail::entry(x, i, 0) * detail::entry(y, 0, j);
        for (int k = 1; k < inner; ++k) sum += detail::entry(x, i, k) * detail::entry(y, k, j);
        return sum;
      });
}

namespace detail {

/// R M R^T of a symmetric M: only six entries are computed.
template <typename S>
[[nodiscard]] inline Eigen::Matrix<S, 3, 3> rotated(const Eigen::Matrix<S, 3, 3>& R,
                                                    const Eigen::Matrix<S, 3, 3>& M) {
  const Eigen::Matrix<S, 3, 3> half = M * R.transpose();
  Eigen::Matrix<S, 3, 3> result;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j <= i; ++j) {
      result(i, j) = result(j, i) =
          R(i, 0) * half(0, j) + R(i, 1) * half(1, j) + R(i, 2) * half(2, j);
    }
  }
  return result;
}

}  // namespace detail

}  // namespace bristle::inline BRISTLE_ABI
