/// @file
/// The law of a resistive sensor (Eqs. 1-11 of Munawar et al.) as pure functions.
///
/// A sensor sits on body A, its ray runs along the unit vector n out of A and meets body B at P,
/// where B has the outward unit normal m. Everything is in world axes. v is the velocity of A's
/// point at P relative to B's; F is the force ON B; A gets -F at the same point, so momentum is
/// conserved exactly. docs/sensors.md lists where and why the printed equations are corrected.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/spatial.hpp>
#include <bristle/math/transform.hpp>
#include <bristle/math/types.hpp>
#include <bristle/sensors/sensor_parameters.hpp>

namespace bristle {

/// [1] Depth e_N of a hit at `distance` [m] along a ray of `length` [m]: 0 just touching, 1 fully
/// pressed, negative for a surface beyond the ray's end (Eq. 4 with sign and end corrected).
template <Scalar S>
[[nodiscard]] S sensor_depth(S distance, S length) {
  return S(1) - distance / length;
}

/// Cosine between surface normal and ray above which a hit counts as grazing, and as no hit: the
/// depth's gradient grows as its inverse and would make a stiff spring of a touch from the side.
template <Scalar S>
inline constexpr S grazing_cosine = S(-0.1);

/// Gradient g = m / (m . n) of the depth times the ray's length: d e_N / dt = g . v / L. Equals n
/// where the surface faces the ray, and g . n = 1 always.
template <Scalar S>
[[nodiscard]] Vec3<S> depth_gradient(const Vec3<S>& n, const Vec3<S>& m) {
  return m / m.dot(n);
}

/// [N] Normal force F_N of Eq. 3 from depth e_N [1] and its rate [1/s]; never adhesive.
template <Scalar S>
[[nodiscard]] S normal_force(const SensorParameters<S>& p, S depth, S rate) {
  const S force = p.normal_stiffness * depth + p.normal_damping * rate;
  return force > S(0) ? force : S(0);
}

/// [N/m] Stiffness k_t of the bristle against stretch (Eq. 1 or Eq. 11).
template <Scalar S>
[[nodiscard]] S bristle_stiffness(const SensorParameters<S>& p, FrictionScaling scaling,
                                  S normal_force, S depth) {
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
template <Scalar S>
[[nodiscard]] Vec3<S> tangential(const Vec3<S>& a, const Vec3<S>& n) {
  return a - n.dot(a) * n;
}

/// [m] A stretch that lets go at each multiple of `sigma` and keeps the remainder.
template <Scalar S>
[[nodiscard]] Vec3<S> wrapped(const Vec3<S>& stretch, S sigma) {
  using std::fmod;
  const S size = stretch.norm();
  return size > sigma ? Vec3<S>((fmod(size, sigma) / size) * stretch) : stretch;
}

/// [m] A stretch cut to at most `sigma`.
template <Scalar S>
[[nodiscard]] Vec3<S> clipped(const Vec3<S>& stretch, S sigma) {
  const S size = stretch.norm();
  return size > sigma ? Vec3<S>((sigma / size) * stretch) : stretch;
}

/// What a stretch becomes under a reset rule; unchanged while it is at most sigma_a (Eq. 2).
template <Scalar S>
[[nodiscard]] Vec3<S> after_reset(const Vec3<S>& stretch, S sigma, SlipReset reset) {
  return reset == SlipReset::drag ? clipped(stretch, sigma) : wrapped(stretch, sigma);
}

/// Where a bristle is rooted: one point on each body.
template <Scalar S>
struct Anchor {
  /// [m] Root on A, from A's centre of mass, in A's axes (Q_C^A).
  Vec3<S> q_A = Vec3<S>::Zero();
  /// [m] Root on B, from B's centre of mass, in B's axes (Q_C^B).
  Vec3<S> q_B = Vec3<S>::Zero();
};

/// Two bodies as a sensor sees them. Positions enter only as differences, so that float keeps its
/// precision far from the world's origin.
template <Scalar S>
struct PairPose {
  /// [1] Axes of A and B in the world.
  Mat3<S> R_WA = Mat3<S>::Identity();
  Mat3<S> R_WB = Mat3<S>::Identity();
  /// [m] From A's centre of mass to B's.
  Vec3<S> p_AB_W = Vec3<S>::Zero();
};

/// [m] Stretch e_T of a bristle: how far its root on A has moved from its root on B, across n.
template <Scalar S>
[[nodiscard]] Vec3<S> anchor_stretch(const Anchor<S>& anchor, const PairPose<S>& pair,
                                     const Vec3<S>& n) {
  return tangential<S>(pair.R_WA * anchor.q_A - pair.R_WB * anchor.q_B - pair.p_AB_W, n);
}

/// Roots a bristle at P with a given stretch.
/// @param r_A  [m] From A's centre of mass to P, world axes.
template <Scalar S>
[[nodiscard]] Anchor<S> rooted(const PairPose<S>& pair, const Vec3<S>& r_A,
                               const Vec3<S>& stretch) {
  return {pair.R_WA.transpose() * r_A,
          pair.R_WB.transpose() * Vec3<S>(r_A - pair.p_AB_W - stretch)};
}

/// Algorithm 1 with its gaps closed, once per sensor and step, before forces: roots the bristle on
/// first touch, keeps it while its stretch is at most sigma_a, and applies the reset rule beyond.
///
/// @param is_anchored  Whether `anchor` is rooted in this same body B.
/// @param[out] did_slip  Whether the reset rule was applied.
/// @return [m] The stretch e_T after all that.
template <Scalar S>
[[nodiscard]] Vec3<S> advance_anchor(Anchor<S>& anchor, bool is_anchored, const PairPose<S>& pair,
                                     const Vec3<S>& n, const Vec3<S>& r_A, S sigma, SlipReset reset,
                                     bool& did_slip) {
  did_slip = false;
  if (!is_anchored) {
    anchor = rooted<S>(pair, r_A, Vec3<S>::Zero());
    return Vec3<S>::Zero();
  }
  const Vec3<S> stretch = anchor_stretch(anchor, pair, n);
  if (stretch.squaredNorm() <= sigma * sigma) return stretch;
  did_slip = true;
  const Vec3<S> kept = after_reset(stretch, sigma, reset);
  anchor = rooted<S>(pair, r_A, kept);
  return kept;
}

/// Force of one sensor on the body it touches, by its parts.
template <Scalar S>
struct SensorForce {
  /// [N] F_N, along the ray (or the gradient).
  S normal = S(0);
  /// [N] Normal part as a vector.
  Vec3<S> normal_vector = Vec3<S>::Zero();
  /// [N] F_S + F_V, across the ray.
  Vec3<S> shear = Vec3<S>::Zero();

  /// [N] Eq. 9: everything, on B.
  [[nodiscard]] Vec3<S> total() const { return normal_vector + shear; }
};

/// One sensor's hit in world axes, as the law needs it.
template <Scalar S>
struct SensorContact {
  /// [1] Depth e_N, > 0.
  S depth = S(0);
  /// [m] Length of the ray, L.
  S length = S(1);
  /// [1] Direction of the ray, n.
  Vec3<S> n = Vec3<S>::UnitX();
  /// [1] Gradient g of the depth (`depth_gradient`).
  Vec3<S> g = Vec3<S>::UnitX();
  /// [m/s] Velocity of A at P relative to B.
  Vec3<S> v = Vec3<S>::Zero();
};

/// Force of one sensor on B at the start of a step: F = F_N n + k_t e_T + mu_V v_T (Eqs. 1, 3, 5,
/// 8, 9).
///
/// @param stretch  [m] e_T from `advance_anchor`.
/// @param dt       [s] Length of the step the force will act for. A bristle that passes more than
///                 one sigma_a within it (release only) counts with its mean stretch, sigma_a / 2
///                 along the slip; otherwise friction would alias with the step.
template <Scalar S>
[[nodiscard]] SensorForce<S> sensor_force(const SensorParameters<S>& p, const LawOptions& options,
                                          const SensorContact<S>& c, const Vec3<S>& stretch, S dt) {
  SensorForce<S> f;
  f.normal = normal_force(p, c.depth, c.g.dot(c.v) / c.length);
  f.normal_vector = f.normal * (options.normal == NormalDirection::gradient ? c.g : c.n);
  const S k_t = bristle_stiffness(p, options.scaling, f.normal, c.depth);
  const Vec3<S> v_T = tangential(c.v, c.n);
  const S sigma = p.breakaway_distance;
  Vec3<S> effective = stretch;
  if (options.reset == SlipReset::release) {
    const S speed = v_T.norm();
    if (speed * dt >= sigma) effective = (sigma / (S(2) * speed)) * v_T;
  }
  f.shear = k_t * effective + p.sliding_friction * v_T;
  return f;
}

/// What one sensor remembers from step to step.
template <Scalar S>
struct SensorMemory {
  /// [-] Whether the bristle is rooted.
  bool is_anchored = false;
  /// Its roots.
  Anchor<S> anchor{};
};

/// Pose and motion of a body about its centre of mass.
template <Scalar S>
struct BodyMotion {
  /// [m] Axes of the body, centre of mass, in the world.
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

/// Wrench of one sensor on its own body A about A's centre of mass, in world axes, and its new
/// memory: the whole law for one sensor, for embedding by hand and for reading. Patches run the
/// same functions over arrays.
///
/// @param distance  [m] Where along the ray B was hit; infinite or >= length when it was not.
/// @param m         [1] Outward unit normal of B there, world axes.
/// @param B         The body that was hit. Its wrench is `-wrench` about A's centre of mass.
/// @param dt        [s] Step length, > 0.
/// @return Exactly zero without a hit; the memory is then cleared, so a new touch starts
/// unstretched.
template <Scalar S>
[[nodiscard]] Wrench<S> sensor_wrench(const SensorParameters<S>& p, const LawOptions& options,
                                      const SensorRay<S>& ray, S distance, const Vec3<S>& m,
                                      const BodyMotion<S>& A, const BodyMotion<S>& B, S dt,
                                      SensorMemory<S>& memory) {
  const Vec3<S> n = A.pose.rotate(ray.d_A);
  if (!(distance < ray.length) || !(m.dot(n) <= grazing_cosine<S>)) {
    memory.is_anchored = false;
    return {};
  }
  const PairPose<S> pair{A.pose.rotation_matrix(), B.pose.rotation_matrix(),
                         B.pose.translation - A.pose.translation};
  const Vec3<S> r_A = pair.R_WA * (ray.p_AStart + distance * ray.d_A);
  const SensorContact<S> contact{sensor_depth(distance, ray.length), ray.length, n,
                                 depth_gradient(n, m),
                                 A.twist.at(r_A) - B.twist.at(r_A - pair.p_AB_W)};
  bool did_slip = false;
  const Vec3<S> stretch = advance_anchor(memory.anchor, memory.is_anchored, pair, n, r_A,
                                         p.breakaway_distance, options.reset, did_slip);
  memory.is_anchored = true;
  return Wrench<S>::at(r_A, -sensor_force(p, options, contact, stretch, dt).total());
}

}  // namespace bristle
