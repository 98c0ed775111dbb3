/// @file
/// Vectors in lanes: one point or direction per lane, coordinate by coordinate.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/simd.hpp>
#include <bristle/math/types.hpp>

#include <cstddef>

namespace bristle::inline BRISTLE_ABI::detail {

/// A vector for each lane. Like Pack, it is never stored.
template <Scalar S>
struct Pack3 {
  Pack<S> x, y, z;

  /// Loads each coordinate from an array of its own.
  [[nodiscard]] BRISTLE_FORCE_INLINE static Pack3 load(const S* x, const S* y, const S* z) {
    return {Pack<S>::load(x), Pack<S>::load(y), Pack<S>::load(z)};
  }
  /// The same vector in all lanes.
  [[nodiscard]] BRISTLE_FORCE_INLINE static Pack3 all(const Vec3<S>& v) {
    return {Pack<S>(v[0]), Pack<S>(v[1]), Pack<S>(v[2])};
  }
  BRISTLE_FORCE_INLINE void store(S* to_x, S* to_y, S* to_z) const {
    x.store(to_x);
    y.store(to_y);
    z.store(to_z);
  }
  [[nodiscard]] BRISTLE_FORCE_INLINE Vec3<S> operator[](std::size_t i) const {
    return {x[i], y[i], z[i]};
  }

  [[nodiscard]] BRISTLE_FORCE_INLINE friend Pack3 operator+(const Pack3& a, const Pack3& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  [[nodiscard]] BRISTLE_FORCE_INLINE friend Pack3 operator-(const Pack3& a, const Pack3& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  [[nodiscard]] BRISTLE_FORCE_INLINE friend Pack3 operator-(const Pack3& a) {
    return {-a.x, -a.y, -a.z};
  }
  [[nodiscard]] BRISTLE_FORCE_INLINE friend Pack3 operator*(const Pack<S>& s, const Pack3& a) {
    return {s * a.x, s * a.y, s * a.z};
  }
  BRISTLE_FORCE_INLINE Pack3& operator+=(const Pack3& b) { return *this = *this + b; }
  BRISTLE_FORCE_INLINE Pack3& operator-=(const Pack3& b) { return *this = *this - b; }
  [[nodiscard]] BRISTLE_FORCE_INLINE friend Pack<S> dot(const Pack3& a, const Pack3& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
  }
  [[nodiscard]] BRISTLE_FORCE_INLINE friend Pack3 cross(const Pack3& a, const Pack3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
  }
  [[nodiscard]] BRISTLE_FORCE_INLINE friend Pack3 select(const Mask<S>& m, const Pack3& yes,
                                                         const Pack3& no) {
    return {select(m, yes.x, no.x), select(m, yes.y, no.y), select(m, yes.z, no.z)};
  }
  /// M v in every lane. A friend, since an operator in namespace `detail` would hide those of
  /// matrix_arithmetic.hpp.
  [[nodiscard]] BRISTLE_FORCE_INLINE friend Pack3 operator*(const Mat3<S>& M, const Pack3& v) {
    const S* m = M.data();  // Column by column.
    return {m[0] * v.x + m[3] * v.y + m[6] * v.z, m[1] * v.x + m[4] * v.y + m[7] * v.z,
            m[2] * v.x + m[5] * v.y + m[8] * v.z};
  }
};

}  // namespace bristle::inline BRISTLE_ABI::detail
