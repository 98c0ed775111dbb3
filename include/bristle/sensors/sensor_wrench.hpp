/// @file
/// The whole law for one sensor, for a program that has bodies and rays of its own.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/rays/ray.hpp>
#include <bristle/math/spatial.hpp>
#include <bristle/math/transform.hpp>
#include <bristle/sensors/law.hpp>
#include <bristle/sensors/sensor_constants.hpp>
#include <bristle/sensors/sensor_parameters.hpp>

namespace bristle::inline BRISTLE_ABI {

/// State of one sensor between steps.
template <Scalar S>
struct SensorMemory {
  /// [-] True if the bristle is anchored.
  bool is_anchored = false;
  /// Its anchor.
  detail::Anchor<S> anchor{};
};

/// Wrench of one sensor on its own body A about A's centre of mass, in world axes. Updates its
/// memory. It is the whole law for one sensor, for embedding by hand and for reading. Patches run
/// the same functions over arrays.
///
/// @param ray       [m] From A's centre of mass, in A's axes.
/// @param distance  [m] Distance along the ray at which B was hit; infinite or >= length without a
///                  hit.
/// @param m         [1] Outward unit normal of B there, world axes.
/// @param X_WA, X_WB  Poses of the centres of mass of A and of B, which was hit.
/// @param V_WA, V_WB  [m/s, rad/s] Twists of A and B about their centres of mass, world axes.
/// @param dt        [s] Step length, > 0.
/// @return Exactly zero without a hit. The memory is then cleared: a new contact starts
///         unstretched. The wrench on B is `-wrench` about A's centre of mass.
template <Scalar S>
[[nodiscard]] Wrench<S> sensor_wrench(const SensorParameters<S>& p, const LawOptions& options,
                                      const Ray<S>& ray, S distance, const Vec3<S>& m,
                                      const Transform<S>& X_WA, const Twist<S>& V_WA,
                                      const Transform<S>& X_WB, const Twist<S>& V_WB, S dt,
                                      SensorMemory<S>& memory) {
  const Quat<S> into_A = X_WA.rotation.conjugate();
  const Vec3<S> m_A = into_A * m;
  const Vec3<S>& n = ray.direction;
  if (!(distance < ray.length) || !(m_A.dot(n) <= S(-detail::chosen::grazing_cosine))) {
    memory.is_anchored = false;
    return {};
  }
  const detail::PairPose<S> pair = detail::pair_pose(X_WA, X_WB);
  const Vec3<S> r_A = ray.origin + distance * n;
  const Vec3<S> r_W = X_WA.rotate(r_A);
  const S inverse_length = S(1) / ray.length;
  const detail::SensorContact<S> contact{
      detail::sensor_depth(distance, inverse_length), inverse_length, n,
      detail::depth_gradient<S>(n, m_A),
      into_A * (V_WA.at(r_W) - V_WB.at(r_W - (X_WB.translation - X_WA.translation)))};
  bool did_slip = false;
  const Vec3<S> stretch = detail::advance_anchor<S>(memory.anchor, memory.is_anchored, pair, n, r_A,
                                                    p.breakaway_distance, options.reset, did_slip);
  memory.is_anchored = true;
  return Wrench<S>::at(
      r_W, -X_WA.rotate(detail::sensor_force(p, options, contact, stretch, dt).total()));
}

}  // namespace bristle::inline BRISTLE_ABI
