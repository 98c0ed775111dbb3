/// @file
/// Soft six-dimensional constraint between two bodies. Patches of sensors and springs of joints use
/// it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/cholesky.hpp>
#include <bristle/math/spatial.hpp>
#include <bristle/math/types.hpp>

#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// Impulse that is affine in the relative motion at the end of the step.
///
/// Let u = [V; W] be the twist of A minus that of B about the point c. Body B receives the impulse
/// p = offset + matrix u about c. Body A receives -p. The `matrix` is symmetric positive
/// semidefinite. So the block only takes energy out of the motion about which it is linearised.
template <Scalar S>
struct SoftBlock {
  /// [-] Slots of the two bodies.
  std::uint32_t body_a = 0;
  std::uint32_t body_b = 0;
  /// [m] From each centre of mass to c, world axes.
  Vec3<S> arm_a = zero<Vec3<S>>();
  Vec3<S> arm_b = zero<Vec3<S>>();
  /// [N s^2/m and products with m] A6: slope of the impulse by u.
  Mat6<S> matrix = zero<Mat6<S>>();
  /// [N s; N m s] p6: the impulse at u = 0.
  Vec6<S> offset = zero<Vec6<S>>();

  /// [m/s; rad/s] u, as solved.
  Vec6<S> motion = zero<Vec6<S>>();
  /// [N s; N m s] p on B about c, as applied.
  Vec6<S> impulse = zero<Vec6<S>>();
};

/// u of a block for given twists.
template <Scalar S>
[[nodiscard]] Vec6<S> relative_motion(const SoftBlock<S>& block, const Twist<S>& a,
                                      const Twist<S>& b) {
  return stacked<S>(a.at(block.arm_a) - b.at(block.arm_b), a.angular - b.angular);
}

/// [1/kg] Mean mobility, over all directions, of the point at `arm` [m] from the centre of mass of
/// a body. It follows from the mobility about that centre.
template <Scalar S>
[[nodiscard]] S mean_mobility(const Mat6<S>& about_center, const Vec3<S>& arm) {
  const Mat6<S> G = shift_matrix<S>(arm);
  return quarter<0, 0, S>(G * about_center * G.transpose()).trace() / S(3);
}

/// Mobility W of one body about the point at `arm` from its centre of mass. It is the change of its
/// twist there per unit impulse there.
template <Scalar S>
[[nodiscard]] Mat6<S> mobility(const Vec3<S>& inverse_mass, const Mat3<S>& inverse_inertia_W,
                               const Vec3<S>& arm) {
  const Mat3<S> X = skew(arm);
  Mat6<S> W;
  set_quarter<0, 0, S>(W, diagonal_matrix<S>(inverse_mass) - X * inverse_inertia_W * X);
  set_quarter<0, 3, S>(W, -X * inverse_inertia_W);
  set_quarter<3, 0, S>(W, inverse_inertia_W * X);
  set_quarter<3, 3, S>(W, inverse_inertia_W);
  return W;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
