/// @file
/// Twists and wrenches: six-dimensional velocity and force about a point.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/types.hpp>

namespace bristle::inline BRISTLE_ABI {

/// Velocity of a rigid body about a reference point, both parts in the same frame.
template <Scalar S>
struct Twist {
  /// [m/s] Velocity of the reference point.
  Vec3<S> linear = detail::zero<Vec3<S>>();
  /// [rad/s] Angular velocity.
  Vec3<S> angular = detail::zero<Vec3<S>>();

  /// [m/s] Velocity of the body's point at `r` [m] from the reference point.
  [[nodiscard]] BRISTLE_FORCE_INLINE Vec3<S> at(const Vec3<S>& r) const {
    return linear + angular.cross(r);
  }

  /// The same motion about the point at `r` [m] from the reference point.
  [[nodiscard]] Twist shifted(const Vec3<S>& r) const { return {at(r), angular}; }

  friend Twist operator-(const Twist& a, const Twist& b) {
    return {a.linear - b.linear, a.angular - b.angular};
  }
  friend Twist operator+(const Twist& a, const Twist& b) {
    return {a.linear + b.linear, a.angular + b.angular};
  }
  friend Twist operator*(S k, const Twist& a) { return {k * a.linear, k * a.angular}; }
};

/// Force and torque about a reference point. Also used for impulses [N s, N m s].
template <Scalar S>
struct Wrench {
  /// [N] Force.
  Vec3<S> force = detail::zero<Vec3<S>>();
  /// [N m] Torque about the reference point.
  Vec3<S> torque = detail::zero<Vec3<S>>();

  /// Wrench of a force `f` that acts at `r` [m] from the reference point.
  [[nodiscard]] static Wrench at(const Vec3<S>& r, const Vec3<S>& f) { return {f, r.cross(f)}; }

  /// The same load about the point at `r` [m] from the reference point.
  [[nodiscard]] Wrench shifted(const Vec3<S>& r) const { return {force, torque - r.cross(force)}; }

  /// Adds a load about the same reference point.
  Wrench& operator+=(const Wrench& other) {
    force += other.force;
    torque += other.torque;
    return *this;
  }
  friend Wrench operator+(Wrench a, const Wrench& b) { return a += b; }
  friend Wrench operator-(const Wrench& a) { return {-a.force, -a.torque}; }
  friend Wrench operator*(S k, const Wrench& a) { return {k * a.force, k * a.torque}; }
};

namespace detail {

/// One vector of two halves.
template <Scalar S>
[[nodiscard]] BRISTLE_FORCE_INLINE Vec6<S> stacked(const Vec3<S>& first, const Vec3<S>& second) {
  Vec6<S> v;
  for (Eigen::Index i = 0; i < 3; ++i) v[i] = first[i];
  for (Eigen::Index i = 0; i < 3; ++i) v[3 + i] = second[i];
  return v;
}
template <Scalar S>
[[nodiscard]] BRISTLE_FORCE_INLINE Vec3<S> first_half(const Vec6<S>& v) {
  return {v[0], v[1], v[2]};
}
template <Scalar S>
[[nodiscard]] BRISTLE_FORCE_INLINE Vec3<S> second_half(const Vec6<S>& v) {
  return {v[3], v[4], v[5]};
}
/// Twists and wrenches as vectors, the linear half first.
template <Scalar S>
[[nodiscard]] BRISTLE_FORCE_INLINE Vec6<S> stacked(const Twist<S>& t) {
  return stacked<S>(t.linear, t.angular);
}
template <Scalar S>
[[nodiscard]] BRISTLE_FORCE_INLINE Vec6<S> stacked(const Wrench<S>& w) {
  return stacked<S>(w.force, w.torque);
}
template <Scalar S>
[[nodiscard]] BRISTLE_FORCE_INLINE Twist<S> twist_of(const Vec6<S>& v) {
  return {first_half<S>(v), second_half<S>(v)};
}
template <Scalar S>
[[nodiscard]] BRISTLE_FORCE_INLINE Wrench<S> wrench_of(const Vec6<S>& v) {
  return {first_half<S>(v), second_half<S>(v)};
}

/// Quarter of a matrix, by the row and column of its first entry.
template <Eigen::Index row, Eigen::Index column, Scalar S>
[[nodiscard]] BRISTLE_FORCE_INLINE Mat3<S> quarter(const Mat6<S>& m) {
  return matrix_of<Mat3<S>>([&](int i, int j) { return m(row + i, column + j); });
}
/// Writes a quarter of a matrix.
template <Eigen::Index row, Eigen::Index column, Scalar S>
BRISTLE_FORCE_INLINE void set_quarter(Mat6<S>& m, const Mat3<S>& value) {
  for (Eigen::Index j = 0; j < 3; ++j) {
    for (Eigen::Index i = 0; i < 3; ++i) m(row + i, column + j) = value(i, j);
  }
}

}  // namespace detail

/// The matrix of `Twist::shifted(r)`; its transpose is that of `Wrench::shifted(-r)`.
template <Scalar S>
[[nodiscard]] Mat6<S> shift_matrix(const Vec3<S>& r) {
  Mat6<S> G = detail::identity<Mat6<S>>();
  detail::set_quarter<0, 3, S>(G, -skew(r));
  return G;
}

}  // namespace bristle::inline BRISTLE_ABI
