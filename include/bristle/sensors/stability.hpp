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

}  // namespace detail

/// [s] Longest explicit step at which symplectic Euler is stable for the present contacts of a
/// patch, in all six directions of each body in contact. Infinite without a contact with a body
/// that moves.
///
/// Several patches on one body add up: this function regards one alone.
/// @param mobility_of  Callable: `Mat6<S> mobility_of(pair)`, the mobility of the pair's two bodies
///                     about its point c.
template <Scalar S, typename MobilityOf>
[[nodiscard]] S largest_stable_step(const detail::SensorPatch<S>& patch, MobilityOf&& mobility_of);

// Implementation ----------------------------------------------------------------------------------

namespace detail {

/// Stiffness and damping of a pair's contacts about c.
template <Scalar S>
void sum_stiffness(const SensorPatch<S>& patch, const PatchPair<S>& pair, Mat6<S>& K, Mat6<S>& D) {
  set_zero(K);
  set_zero(D);
  for (std::uint32_t k = pair.first; k < pair.first + pair.count; ++k) {
    const ContactPacket<S>& contacts = patch.contacts[k];
    const RayPacket<S>& rays = patch.geometry->packets[contacts.packet];
    for (std::size_t i = 0; i < packet_size; ++i) {
      if ((contacts.is_touching >> i & 1u) == 0) continue;
      const std::size_t sensor = contacts.packet * packet_size + i;
      const SensorParameters<S>& p = patch.parameters(sensor);
      const auto [n, g, point, depth, per_length] = touch_of(patch, sensor);
      const S rate = g.dot(pair.start_motion.at(point)) * per_length;
      const S k_t =
          bristle_stiffness(p, patch.def.options.scaling, normal_force(p, depth, rate), depth);
      const Vec3<S> rho = pair.R_WA * (point - pair.center);
      const auto add = [&](const Vec3<S>& d_A, S stiffness, S damping) {
        const Vec3<S> d = pair.R_WA * d_A;
        const Vec6<S> j = stacked<S>(d, rho.cross(d));
        K += (stiffness * j) * j.transpose();
        D += (damping * j) * j.transpose();
      };
      const Vec3<S> t1 = rays.tangent[i];
      add(t1, k_t, p.sliding_friction);
      add(n.cross(t1), k_t, p.sliding_friction);
      add(g, p.normal_stiffness * per_length, p.normal_damping * per_length);
    }
  }
}

/// L with L L^T = W for a mobility W. Axes without motion make W semidefinite; L then has columns
/// of zeros.
template <Scalar S>
[[nodiscard]] Mat6<S> mobility_root(const Mat6<S>& W) {
  using std::sqrt;
  Mat6<S> root = zero<Mat6<S>>();
  for (int j = 0; j < 6; ++j) {
    Vec6<S> rest = column_of(W, j);
    for (int k = 0; k < j; ++k) rest = rest - root(j, k) * column_of(root, k);
    if (!(rest[j] > S(8) * Tolerance<S>::round_off() * W(j, j))) continue;
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

}  // namespace detail

template <Scalar S, typename MobilityOf>
S largest_stable_step(const detail::SensorPatch<S>& patch, MobilityOf&& mobility_of) {
  S smallest = infinity<S>;
  for (const detail::PatchPair<S>& pair : patch.pairs) {
    if (pair.count == 0) continue;
    Mat6<S> K, D;
    detail::sum_stiffness(patch, pair, K, D);
    const Mat6<S> root = detail::mobility_root<S>(mobility_of(pair));
    K = root.transpose() * K * root;
    D = root.transpose() * D * root;
    if (!(K.trace() + D.trace() > S(0))) continue;
    // The criterion is monotone in dt. Bracket by doubling, then bisect to round-off.
    S low = S(0);
    S high = detail::Mode<S>{S(1), K.trace(), D.trace()}.largest_stable_step();
    for (int i = 0; i < 200 && detail::is_stable_step(K, D, high); ++i) {
      low = high;
      high *= S(2);
    }
    // Halves once for each bit of a number if any step is stable. If none is, it halves until
    // `high` is 0: as many times more as the scalar has powers of two below it.
    while (high - low > detail::Tolerance<S>::round_off() * high) {
      const S middle = S(0.5) * (low + high);
      (detail::is_stable_step(K, D, middle) ? low : high) = middle;
    }
    smallest = std::min(smallest, low);
  }
  return smallest;
}

}  // namespace bristle::inline BRISTLE_ABI
