/// @file
/// The law as the paper's own simulator (AMBF) computes it, for comparison with the paper's law.
///
/// It follows AMBF's source, 2019 to 2024. K_D multiplies a difference that is always zero.
/// Stretches and sliding speeds below 1e-4 (SI units) enter as their cubes. A bristle beyond
/// sigma_a gives no friction then. The next step anchors it anew, again without friction. Sliding
/// is projected on B's surface, not on the sensor's plane, and grows with the normal force. Two
/// features are left out. One is a spring-rate term (0.1 N/m by default, absent from the paper).
/// The other is the one-step lag of its ray origins.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/sensors/law.hpp>

namespace bristle::inline BRISTLE_ABI::detail {

/// [m] and [m/s] Below this size AMBF multiplies by a vector that it has not normalised.
template <Scalar S>
inline constexpr S ambf_dead_zone = S(1e-4);

/// AMBF's projection of a tangential vector: `a` itself above the dead zone, |a|^2 a within it.
template <Scalar S>
[[nodiscard]] Vec3<S> ambf_projected(const Vec3<S>& a) {
  const S size2 = a.squaredNorm();
  return size2 > ambf_dead_zone<S> * ambf_dead_zone<S> ? a : Vec3<S>(size2 * a);
}

/// Force of one sensor on B under AMBF's law, and the bristle's next state.
///
/// @param m  [1] Outward unit normal of B at the hit.
/// @param[in,out] is_anchored  True if the bristle is anchored; cleared when it lets go.
/// @param[out] did_slip      True if the bristle let go in this step.
template <Scalar S>
[[nodiscard]] SensorForce<S> ambf_sensor_force(const SensorParameters<S>& p,
                                               FrictionScaling scaling, const SensorContact<S>& c,
                                               const Vec3<S>& m, const PairPose<S>& pair,
                                               const Vec3<S>& r_A, Anchor<S>& anchor,
                                               bool& is_anchored, bool& did_slip) {
  SensorForce<S> f;
  did_slip = false;
  f.normal = p.normal_stiffness * c.depth;
  f.normal_vector = f.normal * c.n;
  const S weight = scaling == FrictionScaling::normal_force ? f.normal : S(1);
  if (is_anchored) {
    const Vec3<S> stretch = ambf_projected<S>(anchor_stretch(anchor, pair, c.n));
    const S size2 = stretch.squaredNorm();
    if (size2 > S(0) && size2 <= p.breakaway_distance * p.breakaway_distance) {
      f.shear = (p.static_friction * weight) * stretch;
    } else {
      is_anchored = false;
      did_slip = size2 > S(0);
    }
  } else {
    anchor = anchored<S>(pair, r_A, zero<Vec3<S>>());
    is_anchored = true;
  }
  f.shear += (p.sliding_friction * weight) * ambf_projected<S>(tangential<S>(c.v, m));
  return f;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
