/// @file
/// Traits for formulas that serve a single scalar and a Pack of scalars.
///
/// A formula over a `Value` T uses the operators, `dot`, `cross` and `select`. It uses `any` and
/// `all` where a branch may skip work that no lane needs. For T = S it is the plain scalar formula.
/// For T = `Pack<S>` it is the same lane by lane. So a test of the first tests the second.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/pack3.hpp>
#include <bristle/math/simd.hpp>
#include <bristle/math/types.hpp>

#include <cmath>

namespace bristle::inline BRISTLE_ABI::detail {

/// Types that belong to a value. These are its scalar, its vector and the result of a comparison.
template <typename T>
struct ValueTraits {};

template <Scalar S>
struct ValueTraits<S> {
  using One = S;
  using Vector = Vec3<S>;
  using Truth = bool;
};

template <Scalar S>
struct ValueTraits<Pack<S>> {
  using One = S;
  using Vector = Pack3<S>;
  using Truth = Mask<S>;
};

/// A scalar, or a scalar for each lane.
template <typename T>
concept Value = requires {
  typename ValueTraits<T>::One;
};

/// The scalar of a value: S of S and of Pack<S>.
template <Value T>
using ScalarOf = typename ValueTraits<T>::One;
/// Three values: Vec3<S> or Pack3<S>.
template <Value T>
using Vector3 = typename ValueTraits<T>::Vector;
/// Result of a comparison: bool or Mask<S>.
template <Value T>
using Truth = typename ValueTraits<T>::Truth;

// The functions of simd.hpp and pack3.hpp, for single values.
[[nodiscard]] BRISTLE_FORCE_INLINE bool any(bool m) { return m; }
[[nodiscard]] BRISTLE_FORCE_INLINE bool all(bool m) { return m; }
template <Scalar S>
[[nodiscard]] BRISTLE_FORCE_INLINE S select(bool m, S yes, S no) {
  return m ? yes : no;
}
template <typename A, typename B>
[[nodiscard]] BRISTLE_FORCE_INLINE Vec3<typename A::Scalar> select(bool m,
                                                                   const Eigen::MatrixBase<A>& yes,
                                                                   const Eigen::MatrixBase<B>& no) {
  if (m) return yes;
  return no;
}
template <typename A, typename B>
[[nodiscard]] BRISTLE_FORCE_INLINE typename A::Scalar dot(const Eigen::MatrixBase<A>& a,
                                                          const Eigen::MatrixBase<B>& b) {
  return a.dot(b);
}
template <typename A, typename B>
[[nodiscard]] BRISTLE_FORCE_INLINE Vec3<typename A::Scalar> cross(const Eigen::MatrixBase<A>& a,
                                                                  const Eigen::MatrixBase<B>& b) {
  return a.cross(b);
}

/// The zero vector.
template <Value T>
[[nodiscard]] BRISTLE_FORCE_INLINE Vector3<T> zero_vector() {
  if constexpr (Scalar<T>) {
    return zero<Vec3<T>>();
  } else {
    return {T(ScalarOf<T>(0)), T(ScalarOf<T>(0)), T(ScalarOf<T>(0))};
  }
}

/// The same vector for all lanes.
template <Value T>
[[nodiscard]] BRISTLE_FORCE_INLINE Vector3<T> broadcast(const Vec3<ScalarOf<T>>& v) {
  if constexpr (Scalar<T>) {
    return v;
  } else {
    return Pack3<ScalarOf<T>>::all(v);
  }
}

/// Sum over the lanes.
template <Scalar S>
[[nodiscard]] BRISTLE_FORCE_INLINE S sum_of_lanes(S a) {
  return a;
}
template <Scalar S>
[[nodiscard]] BRISTLE_FORCE_INLINE Vec3<S> sum_of_lanes(const Pack3<S>& a) {
  return {sum_of_lanes(a.x), sum_of_lanes(a.y), sum_of_lanes(a.z)};
}

/// The remainder of a / b, with the sign of a, exactly. If every a is in [0, 2 b), it is a
/// difference. That is exact there (Sterbenz). Else it is computed lane by lane.
template <Scalar S>
[[nodiscard]] BRISTLE_FORCE_INLINE Pack<S> fmod(const Pack<S>& a, const Pack<S>& b) {
  using std::fmod;
  if (all((a >= Pack<S>(S(0))) & (a < b + b))) return select(a < b, a, a - b);
  S rest[lanes<S>];
  for (std::size_t i = 0; i < lanes<S>; ++i) rest[i] = fmod(a[i], b[i]);
  return Pack<S>::load(rest);
}

}  // namespace bristle::inline BRISTLE_ABI::detail
