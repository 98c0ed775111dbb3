/// @file
/// Sums, products, comparisons, inverses and constants of small vectors and matrices, as values.
///
/// The operators of Eigen give expressions. Each formula has a type of its own, with some hundred
/// functions to make and inline. That was more than half of a compiler's work on this library.
/// Inside the namespace `bristle` the operators below are the better match where sizes are known.
/// Both sides are evaluated, and the result is a matrix. Sums have the order of Eigen's, so that
/// the bits are the same.
///
/// A member function of Eigen refers to its object. So its result on a temporary must not be kept.
/// In `const auto turned = (A * B).transpose()` it refers to a product that is gone. With `const
/// Mat3<S> turned` it does not.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <concepts>
#include <type_traits>

namespace bristle::inline BRISTLE_ABI {

namespace detail {

/// Accepts what derives from an expression of Eigen.
template <typename Derived>
void accept_expression(const Eigen::MatrixBase<Derived>&);

/// An Eigen matrix, or an expression of one, whose size is known at compile time.
template <typename M>
concept SmallMatrix = requires(const M& m) {
  accept_expression(m);
  requires(int{M::SizeAtCompileTime} > 0);
};

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
template <SmallMatrix Value, typename Make>
[[nodiscard]] BRISTLE_FORCE_INLINE Value matrix_of(const Make& make) {
  constexpr int rows = Value::RowsAtCompileTime;
  constexpr int columns = Value::ColsAtCompileTime;
  constexpr int row_step = Value::IsRowMajor ? columns : 1;
  constexpr int column_step = Value::IsRowMajor ? 1 : rows;
  if constexpr (rows == 3 && columns == 1) {
    return {make(0, 0), make(1, 0), make(2, 0)};
  } else {
    Value value;
    BRISTLE_UNROLL
    for (int column = 0; column < columns; ++column) {
      BRISTLE_UNROLL
      for (int row = 0; row < rows; ++row) {
        value.data()[column * column_step + row * row_step] = make(row, column);
      }
    }
    return value;
  }
}

/// The matrix whose entries all have one value.
template <SmallMatrix Value>
[[nodiscard]] BRISTLE_FORCE_INLINE Value filled(const typename Value::Scalar& value) {
  return matrix_of<Value>([&](int, int) BRISTLE_FORCE_INLINE_LAMBDA { return value; });
}
template <SmallMatrix Value>
[[nodiscard]] BRISTLE_FORCE_INLINE Value zero() {
  return filled<Value>(typename Value::Scalar(0));
}
template <SmallMatrix Value>
BRISTLE_FORCE_INLINE void set_zero(Value& value) {
  value = zero<Value>();
}
template <SmallMatrix Value>
[[nodiscard]] BRISTLE_FORCE_INLINE Value identity() {
  using S = typename Value::Scalar;
  return matrix_of<Value>([](int i, int j) BRISTLE_FORCE_INLINE_LAMBDA { return S(i == j); });
}
/// The unit vector along an axis: 0 is x.
template <SmallMatrix Value>
requires(int{Value::ColsAtCompileTime} == 1)  //
    [[nodiscard]] BRISTLE_FORCE_INLINE Value unit_vector(Eigen::Index axis) {
  using S = typename Value::Scalar;
  return matrix_of<Value>([&](int i, int) BRISTLE_FORCE_INLINE_LAMBDA { return S(i == axis); });
}
template <SmallMatrix Value>
[[nodiscard]] BRISTLE_FORCE_INLINE Value unit_x() {
  return unit_vector<Value>(0);
}
template <SmallMatrix Value>
[[nodiscard]] BRISTLE_FORCE_INLINE Value unit_y() {
  return unit_vector<Value>(1);
}
template <SmallMatrix Value>
[[nodiscard]] BRISTLE_FORCE_INLINE Value unit_z() {
  return unit_vector<Value>(2);
}

/// The matrix of f of each entry, or of each two entries.
template <SmallMatrix A, typename F>
[[nodiscard]] BRISTLE_FORCE_INLINE ValueOf<A> each(const A& a, const F& f) {
  decltype(auto) x = stored(a);
  return matrix_of<ValueOf<A>>([&](int i, int j)
                                   BRISTLE_FORCE_INLINE_LAMBDA { return f(entry(x, i, j)); });
}
template <SmallMatrix A, SmallMatrix B, typename F>
[[nodiscard]] BRISTLE_FORCE_INLINE ValueOf<A> each(const A& a, const B& b, const F& f) {
  decltype(auto) x = stored(a);
  decltype(auto) y = stored(b);
  return matrix_of<ValueOf<A>>(
      [&](int i, int j) BRISTLE_FORCE_INLINE_LAMBDA { return f(entry(x, i, j), entry(y, i, j)); });
}

}  // namespace detail

/// Sum of two matrices of one size, entry by entry.
template <typename A, typename B>
requires detail::SameSize<A, B>
[[nodiscard]] BRISTLE_FORCE_INLINE detail::ValueOf<A> operator+(const A& a, const B& b) {
  return detail::each(a, b, [](const auto& x, const auto& y) { return x + y; });
}

/// Difference of two matrices of one size, entry by entry.
template <typename A, typename B>
requires detail::SameSize<A, B>
[[nodiscard]] BRISTLE_FORCE_INLINE detail::ValueOf<A> operator-(const A& a, const B& b) {
  return detail::each(a, b, [](const auto& x, const auto& y) { return x - y; });
}

/// Negative of a matrix.
template <detail::SmallMatrix A>
[[nodiscard]] BRISTLE_FORCE_INLINE detail::ValueOf<A> operator-(const A& a) {
  return detail::each(a, [](const auto& x) { return -x; });
}

/// A matrix times a number.
template <detail::SmallMatrix A, std::same_as<typename A::Scalar> S>
[[nodiscard]] BRISTLE_FORCE_INLINE detail::ValueOf<A> operator*(const S& k, const A& a) {
  return detail::each(a, [&](const auto& x) { return k * x; });
}

/// A matrix times a number.
template <detail::SmallMatrix A, std::same_as<typename A::Scalar> S>
[[nodiscard]] BRISTLE_FORCE_INLINE detail::ValueOf<A> operator*(const A& a, const S& k) {
  return detail::each(a, [&](const auto& x) { return x * k; });
}

/// A matrix divided by a number, entry by entry.
template <detail::SmallMatrix A, std::same_as<typename A::Scalar> S>
[[nodiscard]] BRISTLE_FORCE_INLINE detail::ValueOf<A> operator/(const A& a, const S& k) {
  return detail::each(a, [&](const auto& x) { return x / k; });
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
      [&](int i, int j) BRISTLE_FORCE_INLINE_LAMBDA -> S {
        S sum = detail::entry(x, i, 0) * detail::entry(y, 0, j);
        BRISTLE_UNROLL
        for (int k = 1; k < inner; ++k) sum += detail::entry(x, i, k) * detail::entry(y, k, j);
        return sum;
      });
}

/// Returns whether all entries are equal.
template <typename A, typename B>
requires detail::SameSize<A, B>
[[nodiscard]] BRISTLE_FORCE_INLINE bool operator==(const A& a, const B& b) {
  decltype(auto) x = detail::stored(a);
  decltype(auto) y = detail::stored(b);
  for (int j = 0; j < A::ColsAtCompileTime; ++j) {
    for (int i = 0; i < A::RowsAtCompileTime; ++i) {
      if (!(detail::entry(x, i, j) == detail::entry(y, i, j))) return false;
    }
  }
  return true;
}

/// Returns whether any entries differ.
template <typename A, typename B>
requires detail::SameSize<A, B>
[[nodiscard]] BRISTLE_FORCE_INLINE bool operator!=(const A& a, const B& b) { return !(a == b); }

/// Sizes of the entries.
template <detail::SmallMatrix A>
[[nodiscard]] BRISTLE_FORCE_INLINE detail::ValueOf<A> cwise_abs(const A& a) {
  using std::abs;
  return detail::each(a, [](const auto& x) { return abs(x); });
}

/// Squares of the entries.
template <detail::SmallMatrix A>
[[nodiscard]] BRISTLE_FORCE_INLINE detail::ValueOf<A> cwise_square(const A& a) {
  return detail::each(a, [](const auto& x) { return x * x; });
}

/// Inverses of the entries.
template <detail::SmallMatrix A>
[[nodiscard]] BRISTLE_FORCE_INLINE detail::ValueOf<A> cwise_inverse(const A& a) {
  using S = typename A::Scalar;
  return detail::each(a, [](const S& x) -> S { return S(1) / x; });
}

/// The entries, moved into [-limit, limit].
template <detail::SmallMatrix A, std::same_as<typename A::Scalar> S>
[[nodiscard]] BRISTLE_FORCE_INLINE detail::ValueOf<A> cwise_clamp(const A& a, const S& limit) {
  using std::max;
  using std::min;
  return detail::each(a, [&](const S& x) -> S { return min(max(x, S(-limit)), limit); });
}

/// Products of the entries of two matrices.
template <typename A, typename B>
requires detail::SameSize<A, B>
[[nodiscard]] BRISTLE_FORCE_INLINE detail::ValueOf<A> cwise_product(const A& a, const B& b) {
  return detail::each(a, b, [](const auto& x, const auto& y) { return x * y; });
}

/// The smaller of each two entries.
template <typename A, typename B>
requires detail::SameSize<A, B>
[[nodiscard]] BRISTLE_FORCE_INLINE detail::ValueOf<A> cwise_min(const A& a, const B& b) {
  using std::min;
  return detail::each(a, b, [](const auto& x, const auto& y) { return min(x, y); });
}

/// The larger of each two entries.
template <typename A, typename B>
requires detail::SameSize<A, B>
[[nodiscard]] BRISTLE_FORCE_INLINE detail::ValueOf<A> cwise_max(const A& a, const B& b) {
  using std::max;
  return detail::each(a, b, [](const auto& x, const auto& y) { return max(x, y); });
}

/// Returns whether no entry of A is above the entry of B. False for NaN.
template <typename A, typename B>
requires detail::SameSize<A, B>
[[nodiscard]] BRISTLE_FORCE_INLINE bool all_at_most(const A& a, const B& b) {
  decltype(auto) x = detail::stored(a);
  decltype(auto) y = detail::stored(b);
  for (int j = 0; j < A::ColsAtCompileTime; ++j) {
    for (int i = 0; i < A::RowsAtCompileTime; ++i) {
      if (!(detail::entry(x, i, j) <= detail::entry(y, i, j))) return false;
    }
  }
  return true;
}

namespace detail {

/// Row `i` of a matrix, as a column.
template <SmallMatrix M>
[[nodiscard]] BRISTLE_FORCE_INLINE auto row_of(const M& m, Eigen::Index i) {
  return matrix_of<SmallResult<typename M::Scalar, M::ColsAtCompileTime, 1>>(
      [&](int k, int) BRISTLE_FORCE_INLINE_LAMBDA { return entry(m, static_cast<int>(i), k); });
}
/// Column `j` of a matrix.
template <SmallMatrix M>
[[nodiscard]] BRISTLE_FORCE_INLINE auto column_of(const M& m, Eigen::Index j) {
  return matrix_of<SmallResult<typename M::Scalar, M::RowsAtCompileTime, 1>>(
      [&](int k, int) BRISTLE_FORCE_INLINE_LAMBDA { return entry(m, k, static_cast<int>(j)); });
}
/// Writes a vector into row `i` of a matrix.
template <SmallMatrix M, SmallMatrix V>
BRISTLE_FORCE_INLINE void set_row(M& m, Eigen::Index i, const V& v) {
  for (Eigen::Index k = 0; k < int{M::ColsAtCompileTime}; ++k) m(i, k) = v[k];
}
/// Writes a vector into column `j` of a matrix.
template <SmallMatrix M, SmallMatrix V>
BRISTLE_FORCE_INLINE void set_column(M& m, Eigen::Index j, const V& v) {
  for (Eigen::Index k = 0; k < int{M::RowsAtCompileTime}; ++k) m(k, j) = v[k];
}
/// The first two coordinates.
template <typename S>
[[nodiscard]] BRISTLE_FORCE_INLINE Eigen::Matrix<S, 2, 1> xy_of(const Eigen::Matrix<S, 3, 1>& v) {
  return {v[0], v[1]};
}
/// The diagonal of a matrix.
template <typename S>
[[nodiscard]] BRISTLE_FORCE_INLINE Eigen::Matrix<S, 3, 1> diagonal_of(
    const Eigen::Matrix<S, 3, 3>& m) {
  return {m(0, 0), m(1, 1), m(2, 2)};
}
/// The matrix with a diagonal, and zeros elsewhere.
template <typename S>
[[nodiscard]] BRISTLE_FORCE_INLINE Eigen::Matrix<S, 3, 3> diagonal_matrix(
    const Eigen::Matrix<S, 3, 1>& v) {
  return matrix_of<Eigen::Matrix<S, 3, 3>>(
      [&](int i, int j) BRISTLE_FORCE_INLINE_LAMBDA { return i == j ? v[i] : S(0); });
}
/// The symmetric matrix with these entries on and above its diagonal.
template <typename S>
[[nodiscard]] BRISTLE_FORCE_INLINE Eigen::Matrix<S, 3, 3> symmetric(S xx, S xy, S xz, S yy, S yz,
                                                                    S zz) {
  Eigen::Matrix<S, 3, 3> m;
  set_row(m, 0, Eigen::Matrix<S, 3, 1>(xx, xy, xz));
  set_row(m, 1, Eigen::Matrix<S, 3, 1>(xy, yy, yz));
  set_row(m, 2, Eigen::Matrix<S, 3, 1>(xz, yz, zz));
  return m;
}
/// The transpose, as a matrix of its own.
template <SmallMatrix M>
[[nodiscard]] BRISTLE_FORCE_INLINE auto transposed(const M& m) {
  return matrix_of<SmallResult<typename M::Scalar, M::ColsAtCompileTime, M::RowsAtCompileTime>>(
      [&](int i, int j) BRISTLE_FORCE_INLINE_LAMBDA { return entry(m, j, i); });
}

/// The inverse of a matrix by its cofactors. Not finite where the determinant is 0.
template <typename S>
[[nodiscard]] Eigen::Matrix<S, 3, 3> inverse_of(const Eigen::Matrix<S, 3, 3>& m) {
  const auto cofactor = [&](int i, int j) BRISTLE_FORCE_INLINE_LAMBDA -> S {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
    return m(i1, j1) * m(i2, j2) - m(i1, j2) * m(i2, j1);
  };
  const Eigen::Matrix<S, 3, 1> first{cofactor(0, 0), cofactor(1, 0), cofactor(2, 0)};
  const S determinant = first[0] * m(0, 0) + (first[1] * m(1, 0) + first[2] * m(2, 0));
  const S scale = S(1) / determinant;
  return matrix_of<Eigen::Matrix<S, 3, 3>>(
      [&](int i, int j) BRISTLE_FORCE_INLINE_LAMBDA -> S { return cofactor(j, i) * scale; });
}

/// R M R^T of a symmetric M: only six entries are computed.
template <typename S>
[[nodiscard]] inline Eigen::Matrix<S, 3, 3> rotated(const Eigen::Matrix<S, 3, 3>& R,
                                                    const Eigen::Matrix<S, 3, 3>& M) {
  const Eigen::Matrix<S, 3, 3> half = M * R.transpose();
  Eigen::Matrix<S, 3, 3> result;
  BRISTLE_UNROLL
  for (int i = 0; i < 3; ++i) {
    BRISTLE_UNROLL
    for (int j = 0; j <= i; ++j) {
      result(i, j) = result(j, i) =
          R(i, 0) * half(0, j) + R(i, 1) * half(1, j) + R(i, 2) * half(2, j);
    }
  }
  return result;
}

}  // namespace detail

}  // namespace bristle::inline BRISTLE_ABI
