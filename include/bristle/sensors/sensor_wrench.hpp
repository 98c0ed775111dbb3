/// @file
/// The whole law for one sensor, for a program that has bodies and rays of its own.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/spatial.hpp>
#include <bristle/math/transform.hpp>
#include <bristle/sensors/law.hpp>
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

/// Pose and motion about a body's centre of mass.
template <Scalar S>
struct BodyMotion {
  /// [m] Pose of the body's axes at its centre of mass, in the world.
  Transform<S> pose{};
  /// [m/s, rad/s] Velocity about the centre of mass, world axes.
  Twist<S> twist{};
};

/// One resistive sensor that met one body.
template <Scalar S>
struct SensorRay {
  /// [m] Start of the ray from A's centre of mass, in A's axes.
  Vec3<S> p_AStart = Vec3<S>::Zero();
  /// [1] Unit direction, out of A, in A's axes.
  Vec3<S> d_A = Vec3<S>::UnitX();
  /// [m] Length, > 0.
  S length = S(0.01);
};

/// Wrench of one sensor on its own body A about A's centre of mass, in world axes. Updates its
/// memory. It is the whole law for one sensor, for embedding by hand and for reading. Patches run
/// the same functions over arrays.
///
/// @param distance  [m] Distance along the ray at which B was hit; infinite or >= length without a
///                  hit.
/// @param m         [1] Outward unit normal of B there, world axes.
/// @param B         The body that was hit. Its wrench is `-wrench` about A's centre of mass.
/// @param dt        [s] Step length, > 0.
/// @return Exactly zero without a hit. The memory is then cleared: a new contact starts
///         unstretched.
template <Scalar S>
[[nodiscard]] Wrench<S> sensor_wrench(const SensorParameters<S>& p, const LawOptions& options,
                                      const SensorRay<S>& ray, S distance, const Vec3<S>& m,
                                      const BodyMotion<S>& A, const BodyMotion<S>& B, S dt,
                                      SensorMemory<S>& memory) {
  const Quat<S> into_A = A.pose.rotation.conjugate();
  const Vec3<S> m_A = into_A * m;
  if (!(distance < ray.length) || !(m_A.dot(ray.d_A) <= detail::grazing_cosine<S>)) {
    memory.is_anchored = false;
    return {};
  }
  const detail::PairPose<S> pair = detail::pair_pose(A.pose, B.pose);
  const Vec3<S> r_A = ray.p_AStart + distance * ray.d_A;
  const Vec3<S> r_W = A.pose.rotate(r_A);
  const S inverse_length = S(1) / ray.length;
  const detail::SensorContact<S> contact{
      detail::sensor_depth(distance, inverse_length), inverse_length, ray.d_A,
      detail::depth_gradient<S>(ray.d_A, m_A),
      into_A * (A.twist.at(r_W) - B.twist.at(r_W - (B.pose.translation - A.pose.translation)))};
  bool did_slip = false;
  const Vec3<S> stretch =
      detail::advance_anchor<S>(memory.anchor, memory.is_anchored, pair, ray.d_A, r_A,
                                p.breakaway_distance, options.reset, did_slip);
  memory.is_anchored = true;
  return Wrench<S>::at(
      r_W, -A.pose.rotate(detail::sensor_force(p, options, contact, stretch, dt).total()));
}

}  // namespace bristle::inline BRISTLE_ABI
