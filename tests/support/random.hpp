/// @file
/// Seeded random numbers that are the same with every standard library.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/transform.hpp>

#include <cstddef>
#include <cstdint>
#include <random>

namespace bristle::test {

/// Numbers made from the bits of the engine alone; the distributions of <random> differ between
/// implementations.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  /// Uniform in [low, high).
  template <Scalar S>
  S uniform(S low, S high) {
    const double unit = static_cast<double>(engine_() >> 11) * 0x1p-53;
    return low + (high - low) * S(unit);
  }

  /// Uniform in [0, count).
  std::size_t index(std::size_t count) { return static_cast<std::size_t>(engine_() % count); }

  /// Uniform in the cube from -half to +half.
  template <Scalar S>
  Vec3<S> in_cube(S half) {
    const S x = uniform(-half, half);
    const S y = uniform(-half, half);
    const S z = uniform(-half, half);
    return {x, y, z};
  }

  /// Uniform on the unit sphere.
  template <Scalar S>
  Vec3<S> direction() {
    for (;;) {
      const Vec3<S> v = in_cube(S(1));
      const S length2 = v.squaredNorm();
      if (length2 > S(0.01) && length2 <= S(1)) return v.normalized();
    }
  }

  /// Uniform over all rotations.
  template <Scalar S>
  Quat<S> rotation() {
    for (;;) {
      const Vec3<S> v = in_cube(S(1));
      const S w = uniform(S(-1), S(1));
      const S length2 = v.squaredNorm() + w * w;
      if (length2 > S(0.01) && length2 <= S(1)) {
        return Quat<S>(w, v.x(), v.y(), v.z()).normalized();
      }
    }
  }

  /// Any attitude, somewhere in the cube from -half to +half.
  template <Scalar S>
  Transform<S> pose(S half) {
    const Quat<S> r = rotation<S>();
    return {r, in_cube(half)};
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace bristle::test
