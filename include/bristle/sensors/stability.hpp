/// @file
/// Longest stable explicit step.
///
/// Symplectic Euler with an explicit damper integrates a mode of stiffness k, damping c and mass m
/// stably if and only if k dt^2 / m + 2 c dt / m < 4 (docs/sensors.md). For a whole patch the same
/// holds for the largest eigenvalue of W (dt^2 K + 2 dt D). W is the mobility of the two bodies.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/solver/soft_block.hpp>
#include <bristle/math/spatial.hpp>
#include <bristle/sensors/patch.hpp>
#include <bristle/sensors/patch_touch.hpp>
#include <bristle/sensors/sensor_constants.hpp>

namespace bristle::inline BRISTLE_ABI {

namespace detail {

/// One mode and its longest stable explicit step.
template <Scalar S>
struct Mode {
  /// [kg] Mass that moves.
  S mass = S(1);
  /// [N/m] Stiffness.
  S stiffness = S(0);
  /// [N s/m] Damping.
  S damping = S(0);

  /// [s] Longest stable explicit step; infinite without stiffness and damping. The positive root of
  /// k dt^2 + 2 c dt = 4 m, free of cancellation.
  [[nodiscard]] S largest_stable_step() const {
    using std::sqrt;
    const S sum = damping + sqrt(damping * damping + S(4) * mass * stiffness);
    return sum > S(0) ? S(4) * mass / sum : infinity<S>;
  }
};

/// Stiffness and damping of a patch's contacts with one body, in world axes, about the middle of
/// the patch's box.
template <Scalar S>
struct ContactStiffness {
  /// [N/m, N, N m] and [N s/m, N s, N m s].
  Mat6<S> stiffness = zero<Mat6<S>>(), damping = zero<Mat6<S>>();

  /// [s] Longest explicit step at which symplectic Euler is stable, in all six directions of two
  /// bodies of a mobility about that point. Infinite if nothing can move or nothing touches.
  [[nodiscard]] S largest_stable_step(const Mat6<S>& mobility) const;
};

/// Sums the sensors whose hits are on one body.
/// @param is_of_body  Callable: bool is_of_body(tag), of the tags of `hits`.
/// @param R_WA        Axes of A in the world.
/// @param motion      [m/s, rad/s] Of A relative to the body about A's centre of mass, A's axes.
template <Scalar S, typename IsOfBody>
[[nodiscard]] ContactStiffness<S> sum_stiffness(const SensorPatch<S>& patch, const RayHits<S>& hits,
                                                IsOfBody&& is_of_body, const Mat3<S>& R_WA,
                                                const Twist<S>& motion) {
  ContactStiffness<S> sum;
  for (std::size_t i = 0; i < patch.size(); ++i) {
    if (!hits.is_hit(i) || !is_of_body(hits.tag[i])) continue;
    const auto [n, g, point, depth, per_length] = touch_of(*patch.geometry, hits, i);
    if (!(depth > S(0) && hits.normal[i].dot(n) <= S(-chosen::grazing_cosine))) continue;
    const SensorParameters<S>& p = patch.parameters(i);
    const S rate = g.dot(motion.at(point)) * per_length;
    const S k_t =
        bristle_stiffness(p, patch.def.options.scaling, normal_force(p, depth, rate), depth);
    const Vec3<S> rho = R_WA * (point - patch.geometry->box.center());
    const auto add = [&](const Vec3<S>& d_A, S stiffness, S damping) {
      const Vec3<S> d = R_WA * d_A;
      const Vec6<S> j = stacked<S>(d, rho.cross(d));
      sum.stiffness += (stiffness * j) * j.transpose();
      sum.damping += (damping * j) * j.transpose();
    };
    const Vec3<S> t1 = patch.geometry->packets[i / packet_size].tangent[i % packet_size];
    add(t1, k_t, p.sliding_friction);
    add(n.cross(t1), k_t, p.sliding_friction);
    add(g, p.normal_stiffness * per_length, p.normal_damping * per_length);
  }
  return sum;
}

// Implementation ----------------------------------------------------------------------------------

/// L with L L^T = W for a mobility W. Axes without motion make W semidefinite; L then has columns
/// of zeros.
template <Scalar S>
[[nodiscard]] Mat6<S> mobility_root(const Mat6<S>& W) {
  using std::sqrt;
  Mat6<S> root = zero<Mat6<S>>();
  for (int j = 0; j < 6; ++j) {
    Vec6<S> rest = column_of(W, j);
    for (int k = 0; k < j; ++k) rest = rest - root(j, k) * column_of(root, k);
    if (!(rest[j] > S(chosen::locked_mobility_round_offs) * Tolerance<S>::round_off() * W(j, j)))
      continue;
    // No block expressions: with unknown length, GCC 12 sees whole AVX-512 registers read and
    // warns.
    for (int i = j; i < 6; ++i) root(i, j) = rest[i] / sqrt(rest[j]);
  }
  return root;
}

/// Returns whether all eigenvalues of W (dt^2 K + 2 dt D) are below 4, with K and D as L^T K L and
/// L^T D L. 4 - dt^2 K - 2 dt D is then positive definite, which a Cholesky factorisation decides.
template <Scalar S>
[[nodiscard]] bool is_stable_step(const Mat6<S>& K, const Mat6<S>& D, S dt) {
  Mat6<S> rest = S(4) * identity<Mat6<S>>() - dt * dt * K - S(2) * dt * D;
  return factor_cholesky(rest.data(), 6);
}

template <Scalar S>
S ContactStiffness<S>::largest_stable_step(const Mat6<S>& mobility) const {
  const Mat6<S> root = mobility_root<S>(mobility);
  const Mat6<S> K = root.transpose() * stiffness * root;
  const Mat6<S> D = root.transpose() * damping * root;
  if (!(K.trace() + D.trace() > S(0))) return infinity<S>;
  // The criterion is monotone in dt. Bracket by doubling, then bisect to round-off. One of six
  // eigenvalues is a sixth of the trace or more. So no step of six times `high` is stable, and the
  // fourth test fails at the latest.
  S low = S(0);
  S high = Mode<S>{S(1), K.trace(), D.trace()}.largest_stable_step();
  for (int i = 0; i < 4 && is_stable_step(K, D, high); ++i) {
    low = high;
    high *= S(2);
  }
  // Halves once for each bit of a number if any step is stable. If none is, it halves until `high`
  // is 0: as many times more as the scalar has powers of two below it.
  while (high - low > Tolerance<S>::round_off() * high) {
    const S middle = S(0.5) * (low + high);
    (is_stable_step(K, D, middle) ? low : high) = middle;
  }
  return low;
}

}  // namespace detail
}  // namespace bristle::inline BRISTLE_ABI
