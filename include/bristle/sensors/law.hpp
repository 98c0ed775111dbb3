/// @file
/// The law of a resistive sensor (Eqs. 1-11 of Munawar et al.) as pure functions.
///
/// A sensor sits on body A. Its ray runs along the unit vector n out of A. It meets body B at P,
/// where B has the outward unit normal m. All vectors of one call are in the same axes; patches use
/// those of A, where rays stand still. v is the velocity of A's point at P relative to B's. F is
/// the force ON B. A gets -F at the same point, so momentum is conserved exactly. docs/sensors.md
/// lists where and why the printed equations are corrected.
///
/// Functions over a `Value` T serve one sensor (T = S) or one register of sensors (T = `Pack<S>`).
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/lane_value.hpp>
#include <bristle/math/spatial.hpp>
#include <bristle/math/transform.hpp>
#include <bristle/math/types.hpp>
#include <bristle/sensors/sensor_parameters.hpp>

namespace bristle::inline BRISTLE_ABI::detail {

/// [1] Depth e_N of a hit at `distance` [m] along a ray of length L, given as 1 / L [1/m]. 0 at
/// first contact, 1 fully pressed, negative for a surface beyond the ray's end. (Eq. 4, sign and
/// end corrected.)
template <Value T>
[[nodiscard]] BRISTLE_FORCE_INLINE T sensor_depth(T distance, T inverse_length) {
  return ScalarOf<T>(1) - distance * inverse_length;
}

/// Gradient g = m / (m . n) of the depth times the ray's length: d e_N / dt = g . v / L. It equals
/// n where the surface faces the ray. Always g . n = 1.
template <Value T>
[[nodiscard]] BRISTLE_FORCE_INLINE Vector3<T> depth_gradient(const Vector3<T>& m, T cosine) {
  return T(ScalarOf<T>(1) / cosine) * m;
}
template <Value T>
[[nodiscard]] BRISTLE_FORCE_INLINE Vector3<T> depth_gradient(const Vector3<T>& n,
                                                             const Vector3<T>& m) {
  return depth_gradient<T>(m, T(dot(m, n)));
}

/// [N] Normal force F_N of Eq. 3 from depth e_N [1] and its rate [1/s]. It never pulls.
template <Value T>
[[nodiscard]] BRISTLE_FORCE_INLINE T normal_force(const SensorParameters<T>& p, T depth, T rate) {
  const T force = p.normal_stiffness * depth + p.normal_damping * rate;
  return select(force > T(0), force, T(0));
}

/// [N/m] Stiffness k_t of the bristle against stretch (Eq. 1 or Eq. 11).
template <Value T>
[[nodiscard]] BRISTLE_FORCE_INLINE T bristle_stiffness(const SensorParameters<T>& p,
                                                       FrictionScaling scaling, T normal_force,
                                                       T depth) {
  switch (scaling) {
    case FrictionScaling::normal_force:
      return p.static_friction * normal_force;
    case FrictionScaling::depth:
      return p.static_friction * depth;
    case FrictionScaling::none:
      break;
  }
  return p.static_friction;
}

/// Part of `a` across the unit vector n.
template <Value T>
[[nodiscard]] BRISTLE_FORCE_INLINE Vector3<T> tangential(const Vector3<T>& a, const Vector3<T>& n) {
  return a - dot(n, a) * n;
}

/// [m] Wraps a stretch: it lets go at each multiple of `sigma` and keeps the remainder.
template <Value T>
[[nodiscard]] BRISTLE_FORCE_INLINE Vector3<T> wrapped(const Vector3<T>& stretch, T sigma) {
  using std::fmod;
  using std::sqrt;
  const T size = sqrt(dot(stretch, stretch));
  const Truth<T> is_over = size > sigma;
  if (!any(is_over)) return stretch;
  return select(is_over, (fmod(size, sigma) / size) * stretch, stretch);
}

/// [m] Clips a stretch to at most `sigma`.
template <Value T>
[[nodiscard]] BRISTLE_FORCE_INLINE Vector3<T> clipped(const Vector3<T>& stretch, T sigma) {
  using std::sqrt;
  const T size = sqrt(dot(stretch, stretch));
  const Truth<T> is_over = size > sigma;
  if (!any(is_over)) return stretch;
  return select(is_over, (sigma / size) * stretch, stretch);
}

/// Applies a reset rule to a stretch. A stretch up to sigma_a stays (Eq. 2).
template <Value T>
[[nodiscard]] BRISTLE_FORCE_INLINE Vector3<T> after_reset(const Vector3<T>& stretch, T sigma,
                                                          SlipReset reset) {
  return reset == SlipReset::drag ? clipped<T>(stretch, sigma) : wrapped<T>(stretch, sigma);
}

/// Anchor of a bristle: one point on each body.
template <Value T>
struct Anchor {
  /// [m] Anchor on A, from A's centre of mass, in A's axes (Q_C^A).
  Vector3<T> q_A = zero_vector<T>();
  /// [m] Anchor on B, from B's centre of mass, in B's axes (Q_C^B).
  Vector3<T> q_B = zero_vector<T>();
};

/// Pose of B relative to A, about their centres of mass. Positions enter only as differences, so
/// float keeps its precision far from the world's origin.
template <Scalar S>
struct PairPose {
  /// [1] Axes of B in those of A.
  Mat3<S> R_AB = identity<Mat3<S>>();
  /// [m] From A's centre of mass to B's, in A's axes.
  Vec3<S> p_AB = zero<Vec3<S>>();
};

template <Scalar S>
[[nodiscard]] PairPose<S> pair_pose(const Transform<S>& X_WA, const Transform<S>& X_WB) {
  const Transform<S> X_AB = relative_pose(X_WA, X_WB);
  return {X_AB.rotation_matrix(), X_AB.translation};
}

/// [m] Stretch e_T of a bristle: displacement of its anchor on A from its anchor on B, across n. In
/// A's axes, like n.
template <Value T>
[[nodiscard]] BRISTLE_FORCE_INLINE Vector3<T> anchor_stretch(const Anchor<T>& anchor,
                                                             const PairPose<ScalarOf<T>>& pair,
                                                             const Vector3<T>& n) {
  return tangential<T>(anchor.q_A - pair.R_AB * anchor.q_B - broadcast<T>(pair.p_AB), n);
}

/// Anchors a bristle at P with a given stretch.
/// @param r_A  [m] From A's centre of mass to P, in A's axes.
template <Value T>
[[nodiscard]] BRISTLE_FORCE_INLINE Anchor<T> anchored(const PairPose<ScalarOf<T>>& pair,
                                                      const Vector3<T>& r_A,
                                                      const Vector3<T>& stretch) {
  const Mat3<ScalarOf<T>> R_BA = transposed(pair.R_AB);
  return {r_A, R_BA * Vector3<T>(r_A - broadcast<T>(pair.p_AB) - stretch)};
}

/// The part of `advance_anchor` that needs the stretch.
///
/// @param[in,out] stretch  [m] In: e_T of `anchor_stretch`. Out: e_T after the reset rule, zero
///                         where the bristle is anchored anew.
template <Value T>
BRISTLE_FORCE_INLINE void anchor_where_needed(Anchor<T>& anchor, const Truth<T>& is_anchored,
                                              Vector3<T>& stretch,
                                              const PairPose<ScalarOf<T>>& pair,
                                              const Vector3<T>& r_A, T sigma, SlipReset reset,
                                              Truth<T>& did_slip) {
  const Truth<T> is_within = dot(stretch, stretch) <= sigma * sigma;
  const Truth<T> is_kept = is_anchored & is_within;
  did_slip = is_anchored & !is_within;
  if (all(is_kept)) return;
  // Unanchored lanes hold garbage; zero them so that they do not trigger the slow branch.
  const Vector3<T> held = select(is_anchored, stretch, zero_vector<T>());
  stretch = select(is_anchored, after_reset<T>(held, sigma, reset), zero_vector<T>());
  const Anchor<T> moved = anchored<T>(pair, r_A, stretch);
  anchor.q_A = select(is_kept, anchor.q_A, moved.q_A);
  anchor.q_B = select(is_kept, anchor.q_B, moved.q_B);
}

/// Algorithm 1 with its gaps closed, once per sensor and step, before forces. It anchors the
/// bristle at first contact and keeps the anchor while the stretch is at most sigma_a. Beyond, it
/// applies the reset rule.
///
/// @param is_anchored  True if `anchor` is anchored in this same body B.
/// @param[out] did_slip  True if the reset rule was applied.
/// @return [m] The resulting stretch e_T.
template <Value T>
[[nodiscard]] BRISTLE_FORCE_INLINE Vector3<T> advance_anchor(
    Anchor<T>& anchor, const Truth<T>& is_anchored, const PairPose<ScalarOf<T>>& pair,
    const Vector3<T>& n, const Vector3<T>& r_A, T sigma, SlipReset reset, Truth<T>& did_slip) {
  Vector3<T> stretch = anchor_stretch(anchor, pair, n);
  anchor_where_needed<T>(anchor, is_anchored, stretch, pair, r_A, sigma, reset, did_slip);
  return stretch;
}

/// Force of one sensor on the body in contact, by its parts.
template <Value T>
struct SensorForce {
  /// [N] F_N, along the ray (or the gradient).
  T normal = T(0);
  /// [N] Normal part as a vector.
  Vector3<T> normal_vector = zero_vector<T>();
  /// [N] F_S + F_V, across the ray.
  Vector3<T> shear = zero_vector<T>();

  /// [N] Total force on B (Eq. 9).
  [[nodiscard]] BRISTLE_FORCE_INLINE Vector3<T> total() const { return normal_vector + shear; }
};

/// Hit of one sensor, as input of the law.
template <Value T>
struct SensorContact {
  /// [1] Depth e_N, > 0.
  T depth = T(0);
  /// [1/m] Inverse length of the ray, 1 / L.
  T inverse_length = T(1);
  /// [1] Direction of the ray, n.
  Vector3<T> n = zero_vector<T>();
  /// [1] Gradient g of the depth (`depth_gradient`).
  Vector3<T> g = zero_vector<T>();
  /// [m/s] Velocity of A at P relative to B.
  Vector3<T> v = zero_vector<T>();
};

/// Force of one sensor on B at the start of a step (Eqs. 1, 3, 5, 8, 9): F = F_N n + k_t e_T + mu_V
/// v_T.
///
/// @param stretch  [m] e_T from `advance_anchor`.
/// @param dt       [s] Length of the step that the force acts for. A bristle that passes more than
///                 one sigma_a within it (release only) counts with its mean stretch, sigma_a / 2
///                 along the slip. Otherwise friction would alias with the step.
template <Value T>
[[nodiscard]] BRISTLE_FORCE_INLINE SensorForce<T> sensor_force(const SensorParameters<T>& p,
                                                               const LawOptions& options,
                                                               const SensorContact<T>& c,
                                                               const Vector3<T>& stretch,
                                                               ScalarOf<T> dt) {
  using std::sqrt;
  SensorForce<T> f;
  f.normal = normal_force(p, c.depth, T(dot(c.g, c.v) * c.inverse_length));
  // Not a conditional between c.g and c.n: that would put both into memory.
  if (options.normal == NormalDirection::gradient) {
    f.normal_vector = f.normal * c.g;
  } else {
    f.normal_vector = f.normal * c.n;
  }
  const T k_t = bristle_stiffness(p, options.scaling, f.normal, c.depth);
  const Vector3<T> v_T = tangential<T>(c.v, c.n);
  const T sigma = p.breakaway_distance;
  Vector3<T> effective = stretch;
  if (options.reset == SlipReset::release) {
    const T passed2 = T(dt * dt) * dot(v_T, v_T);
    const Truth<T> passes_whole_stretches = passed2 >= sigma * sigma;
    if (any(passes_whole_stretches)) {
      effective =
          select(passes_whole_stretches, (T(dt) * sigma / (T(2) * sqrt(passed2))) * v_T, stretch);
    }
  }
  f.shear = k_t * effective + p.sliding_friction * v_T;
  return f;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
