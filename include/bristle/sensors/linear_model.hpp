/// @file
/// The impulse of one sensor as an affine function of the velocity at the end of the step.
///
/// It holds the formulas of the implicit patch (docs/sensors.md, section 4), for one contact or for
/// one register of contacts.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/sensors/patch_scratch.hpp>
#include <bristle/sensors/sensor_constants.hpp>

#include <array>

namespace bristle::inline BRISTLE_ABI::detail {

/// Velocity of A relative to B at the arm rho from c, for the motion (linear, angular) at c.
template <Value T>
[[nodiscard]] BRISTLE_FORCE_INLINE Vector3<T> velocity_at(const Vector3<T>& linear,
                                                          const Vector3<T>& angular,
                                                          const Vector3<T>& rho) {
  return linear + cross(angular, rho);
}

/// Normal part in contact: J_n = dt K_N e_N + a_n g.v'. Before contact, spring and damper act only
/// on the depth reached within the step. Nothing pushes across a gap.
template <Value T>
BRISTLE_FORCE_INLINE void linearise_normal(const SensorParameters<T>& p, PatchContact<T>& c,
                                           ScalarOf<T> dt) {
  const T spring = T(dt) * p.normal_stiffness;
  const T slope = spring + p.normal_damping;
  c.normal_constant = select(c.is_in_contact, spring, slope) * c.depth;
  c.a_normal = T(dt) * slope * c.inverse_length;
}

/// [N] Mean normal force of a step that ends with the velocity v. Zero for contacts that are not
/// loaded (`is_loaded`). The normal part is as `linearise_normal` leaves it.
template <Value T>
[[nodiscard]] BRISTLE_FORCE_INLINE T force_at(const PatchContact<T>& c, const Vector3<T>& v,
                                              ScalarOf<T> dt) {
  const T normal = c.normal_constant + c.a_normal * dot(c.g, v);
  return select(c.is_loaded, normal, T(0)) * T(ScalarOf<T>(1) / dt);
}

/// Constant part of the normal impulse, along g. For a force along the ray, the difference to n is
/// added, with the impulse of the last pass. With that impulse inside, the matrix would be
/// unsymmetric and oblique rays would be kicked.
template <Value T>
[[nodiscard]] BRISTLE_FORCE_INLINE Vector3<T> normal_constant(const PatchContact<T>& c,
                                                              NormalDirection direction) {
  Vector3<T> sum = c.normal_constant * c.g;
  if (direction == NormalDirection::ray) sum += c.normal_impulse * Vector3<T>(c.n - c.g);
  return select(c.is_loaded, sum, zero_vector<T>());
}

/// Friction of a bristle that sticks throughout the step.
template <Value T>
[[nodiscard]] BRISTLE_FORCE_INLINE Vector3<T> linearise_stuck(const SensorParameters<T>& p,
                                                              const LawOptions& options,
                                                              const PatchPair<ScalarOf<T>>& pair,
                                                              PatchContact<T>& c, ScalarOf<T> dt) {
  using S = ScalarOf<T>;
  const T k_t = bristle_stiffness(p, options.scaling, c.force, c.depth);
  const Vector3<T> v0 = tangential<T>(c.start_velocity, c.n);
  const T viscous = T(dt) * p.sliding_friction;
  c.a_across = c.a_along = T((pair.alpha + pair.beta) * dt * dt) * k_t + T(pair.theta) * viscous;
  c.along = zero_vector<T>();
  return (T(dt) * k_t) * c.stretch +
         (T(S(1) - pair.theta) * viscous - T(pair.beta * dt * dt) * k_t) * v0;
}

/// Mean stretch of a bristle over a step in which it slips with the tangential velocity v.
template <Value T>
[[nodiscard]] BRISTLE_FORCE_INLINE Vector3<T> mean_slip_stretch(const PatchPair<ScalarOf<T>>& pair,
                                                                const PatchContact<T>& c,
                                                                const Vector3<T>& v, T sigma,
                                                                SlipReset reset, ScalarOf<T> dt) {
  using std::min;
  using std::sqrt;
  const T speed = sqrt(dot(v, v));
  const T passed = speed * T(dt);
  const Truth<T> passes_whole_stretches = passed >= sigma;
  const Vector3<T> reached = c.stretch + T(pair.alpha * dt) * v;
  const Vector3<T> within = after_reset<T>(reached, sigma, reset);
  if (!any(passes_whole_stretches)) return within;
  if (reset == SlipReset::release) {
    return select(passes_whole_stretches, (sigma / (T(2) * speed)) * v, within);
  }
  // Drag: the stretch grows to sigma along the slip, then stays there.
  const Vector3<T> h = c.stretch + T(dt) * v;
  const T size = sqrt(dot(h, h));
  const T per_size = select(size > T(0), T(1) / size, T(0));
  const T start = min(sigma, T(dot(c.stretch, h) * per_size));
  const T fraction = min(T(1), T((sigma - start) / passed));
  const T mean = fraction * (start + sigma) / T(2) + (T(1) - fraction) * sigma;
  return select(passes_whole_stretches, (mean * per_size) * h, within);
}

/// Friction of a slipping bristle, linearised around the tangential velocity v.
template <Value T>
[[nodiscard]] BRISTLE_FORCE_INLINE Vector3<T> linearise_slip(const SensorParameters<T>& p,
                                                             const LawOptions& options,
                                                             const PatchPair<ScalarOf<T>>& pair,
                                                             PatchContact<T>& c,
                                                             const Vector3<T>& v, ScalarOf<T> dt) {
  using std::max;
  using std::min;
  using std::sqrt;
  using S = ScalarOf<T>;
  const T k_t = bristle_stiffness(p, options.scaling, c.force, c.depth);
  const Vector3<T> mean = mean_slip_stretch<T>(pair, c, v, p.breakaway_distance, options.reset, dt);
  const T speed2 = dot(v, v);
  const Truth<T> moves = speed2 > T(0);
  const T stiffest = T((pair.alpha + pair.beta) * dt * dt) * k_t;
  const T secant =
      select(moves, min(T(T(dt) * k_t * max(T(0), T(dot(mean, v))) / speed2), stiffest), stiffest);
  const T viscous = T(pair.theta * dt) * p.sliding_friction;
  const Vector3<T> v0 = tangential<T>(c.start_velocity, c.n);
  const Vector3<T> sum =
      (T(dt) * k_t) * mean + (T((S(1) - pair.theta) * dt) * p.sliding_friction) * v0;
  c.a_across = secant + viscous;
  // Newton: friction does not grow with the speed, but turns with its direction. Otherwise a secant
  // on all directions: pure damping, which cannot reverse the slip.
  const Truth<T> is_newton = moves & !c.is_damping_slip;
  c.a_along = select(is_newton, viscous, c.a_across);
  c.along = select(is_newton, T(T(1) / sqrt(speed2)) * v, zero_vector<T>());
  return select(is_newton, sum, Vector3<T>(sum - secant * v));
}

/// Linear model of one contact around the tangential velocity v.
template <Value T>
BRISTLE_FORCE_INLINE void linearise(const SensorParameters<T>& p, const LawOptions& options,
                                    const PatchPair<ScalarOf<T>>& pair, PatchContact<T>& c,
                                    const Vector3<T>& v, ScalarOf<T> dt) {
  Vector3<T> friction = linearise_stuck<T>(p, options, pair, c, dt);
  if (any(c.is_slipping)) {
    PatchContact<T> slipping = c;
    const Vector3<T> slip_friction = linearise_slip<T>(p, options, pair, slipping, v, dt);
    friction = select(c.is_slipping, slip_friction, friction);
    c.a_across = select(c.is_slipping, slipping.a_across, c.a_across);
    c.a_along = select(c.is_slipping, slipping.a_along, c.a_along);
    c.along = select(c.is_slipping, slipping.along, c.along);
  }
  c.a_across = select(c.is_in_contact, c.a_across, T(0));
  c.a_along = select(c.is_in_contact, c.a_along, T(0));
  c.constant =
      normal_constant<T>(c, options.normal) + select(c.is_in_contact, friction, zero_vector<T>());
}

/// Impulse of a contact's linear model at the velocity v. `a_normal` is 0 where it is not loaded.
template <Value T>
[[nodiscard]] BRISTLE_FORCE_INLINE Vector3<T> model_impulse(const PatchContact<T>& c,
                                                            const Vector3<T>& v) {
  Vector3<T> sum =
      c.constant + c.a_across * tangential<T>(v, c.n) + T(c.a_normal * dot(c.g, v)) * c.g;
  if (any(c.is_slipping)) sum += T((c.a_along - c.a_across) * dot(c.along, v)) * c.along;
  return sum;
}

/// Sum of linear models about c.
///
/// Each model is J = constant + K v with a symmetric 3x3 matrix K at the arm rho. With X = [rho]x
/// it adds [K, -K X; X K, -X K X] and [constant; rho x constant].
template <Value T>
struct ModelSum {
  using S = ScalarOf<T>;
  T xx = S(0), xy = S(0), xz = S(0), yy = S(0), yz = S(0), zz = S(0);
  /// Rows of -K X.
  Vector3<T> top_x = zero_vector<T>(), top_y = zero_vector<T>(), top_z = zero_vector<T>();
  T low_xx = S(0), low_xy = S(0), low_xz = S(0), low_yy = S(0), low_yz = S(0), low_zz = S(0);
  Vector3<T> linear = zero_vector<T>(), angular = zero_vector<T>();

  /// Adds a contact; `a_normal` is 0 unless loaded.
  BRISTLE_FORCE_INLINE void add(const PatchContact<T>& c) {
    const Vector3<T> ag = c.a_normal * c.g;
    const Vector3<T> an = c.a_across * c.n;
    T kxx = x(ag) * x(c.g) - x(an) * x(c.n) + c.a_across;
    T kxy = x(ag) * y(c.g) - x(an) * y(c.n);
    T kxz = x(ag) * z(c.g) - x(an) * z(c.n);
    T kyy = y(ag) * y(c.g) - y(an) * y(c.n) + c.a_across;
    T kyz = y(ag) * z(c.g) - y(an) * z(c.n);
    T kzz = z(ag) * z(c.g) - z(an) * z(c.n) + c.a_across;
    if (any(c.is_slipping)) {
      const Vector3<T> aa = T(c.a_along - c.a_across) * c.along;
      kxx += x(aa) * x(c.along);
      kxy += x(aa) * y(c.along);
      kxz += x(aa) * z(c.along);
      kyy += y(aa) * y(c.along);
      kyz += y(aa) * z(c.along);
      kzz += z(aa) * z(c.along);
    }
    xx += kxx;
    xy += kxy;
    xz += kxz;
    yy += kyy;
    yz += kyz;
    zz += kzz;
    // Row k of K gives the row -k X = rho x k of the adjacent block.
    const Vector3<T> bx = cross(c.rho, vector(kxx, kxy, kxz));
    const Vector3<T> by = cross(c.rho, vector(kxy, kyy, kyz));
    const Vector3<T> bz = cross(c.rho, vector(kxz, kyz, kzz));
    top_x += bx;
    top_y += by;
    top_z += bz;
    // X applied to the columns of that block. The result is symmetric.
    const T rx = x(c.rho), ry = y(c.rho), rz = z(c.rho);
    low_xx += ry * x(bz) - rz * x(by);
    low_xy += ry * y(bz) - rz * y(by);
    low_xz += ry * z(bz) - rz * z(by);
    low_yy += rz * y(bx) - rx * y(bz);
    low_yz += rz * z(bx) - rx * z(bz);
    low_zz += rx * z(by) - ry * z(bx);
    linear += c.constant;
    angular += cross(c.rho, c.constant);
  }

  ModelSum& operator+=(const ModelSum& more) {
    xx += more.xx;
    xy += more.xy;
    xz += more.xz;
    yy += more.yy;
    yz += more.yz;
    zz += more.zz;
    top_x += more.top_x;
    top_y += more.top_y;
    top_z += more.top_z;
    low_xx += more.low_xx;
    low_xy += more.low_xy;
    low_xz += more.low_xz;
    low_yy += more.low_yy;
    low_yz += more.low_yz;
    low_zz += more.low_zz;
    linear += more.linear;
    angular += more.angular;
    return *this;
  }

  /// The sum over all lanes.
  void get(Mat6<S>& matrix, Vec6<S>& offset) const {
    Mat3<S> top;
    set_row(top, 0, sum_of_lanes(top_x));
    set_row(top, 1, sum_of_lanes(top_y));
    set_row(top, 2, sum_of_lanes(top_z));
    set_quarter<0, 0, S>(
        matrix, symmetric<S>(sum_of_lanes(xx), sum_of_lanes(xy), sum_of_lanes(xz), sum_of_lanes(yy),
                             sum_of_lanes(yz), sum_of_lanes(zz)));
    set_quarter<0, 3, S>(matrix, top);
    set_quarter<3, 0, S>(matrix, transposed(top));
    set_quarter<3, 3, S>(
        matrix, symmetric<S>(sum_of_lanes(low_xx), sum_of_lanes(low_xy), sum_of_lanes(low_xz),
                             sum_of_lanes(low_yy), sum_of_lanes(low_yz), sum_of_lanes(low_zz)));
    offset = stacked<S>(sum_of_lanes(linear), sum_of_lanes(angular));
  }

 private:
  [[nodiscard]] BRISTLE_FORCE_INLINE static T x(const Vector3<T>& v) { return coordinate<0>(v); }
  [[nodiscard]] BRISTLE_FORCE_INLINE static T y(const Vector3<T>& v) { return coordinate<1>(v); }
  [[nodiscard]] BRISTLE_FORCE_INLINE static T z(const Vector3<T>& v) { return coordinate<2>(v); }
  template <int axis>
  [[nodiscard]] BRISTLE_FORCE_INLINE static T coordinate(const Vector3<T>& v) {
    if constexpr (Scalar<T>) {
      return v[axis];
    } else {
      return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
    }
  }
  [[nodiscard]] BRISTLE_FORCE_INLINE static Vector3<T> vector(const T& x, const T& y, const T& z) {
    return {x, y, z};
  }
};

/// Result of moving the linearisation.
template <Value T>
struct PassChange {
  bool did_switch = false;
  bool has_slip = false;
  T force_sum = ScalarOf<T>(0);
  T force_change = ScalarOf<T>(0);

  PassChange& operator+=(const PassChange& more) {
    did_switch = did_switch || more.did_switch;
    has_slip = has_slip || more.has_slip;
    force_sum += more.force_sum;
    force_change += more.force_change;
    return *this;
  }
};

/// Decides whether the normal part of a contact acts at the velocity `v`, and with which force.
template <Value T>
BRISTLE_FORCE_INLINE void update_normal(PatchContact<T>& c, const Truth<T>& is_in_range,
                                        const Vector3<T>& v, ScalarOf<T> dt,
                                        PassChange<T>& change) {
  using std::abs;
  using std::max;
  const T normal = c.normal_constant + c.a_normal * dot(c.g, v);
  const Truth<T> is_loaded = is_in_range & (normal > T(0));
  change.did_switch = change.did_switch || any(is_loaded ^ c.is_loaded);
  c.is_loaded = is_loaded;
  const T force = force_at<T>(c, v, dt);
  change.force_change += select(is_in_range, abs(force - c.force), T(0));
  change.force_sum += force;
  c.force = force;
}

/// Decides whether a sensor in contact slips at the tangential velocity `v`. Damps slip that
/// reverses from pass to pass.
template <Value T>
BRISTLE_FORCE_INLINE void update_slip(PatchContact<T>& c, const Vector3<T>& v, T sigma,
                                      SlipReset reset, ScalarOf<T> dt, int pass, bool is_last_pass,
                                      PassChange<T>& change) {
  const Vector3<T> reached = c.stretch + T(dt) * v;
  const Truth<T> overshoots = c.is_in_contact & (dot(reached, reached) > sigma * sigma);
  // A released bristle stays released for this step. A dragged one may turn out to stick.
  const Truth<T> is_slipping =
      reset == SlipReset::release ? overshoots | c.is_slipping : overshoots;
  change.did_switch = change.did_switch || any(is_slipping ^ c.is_slipping);
  change.has_slip = change.has_slip || any(is_slipping);
  const Truth<T> slips_on = c.is_slipping & is_slipping;
  if ((pass >= 2 || is_last_pass) && any(slips_on)) {
    const T along_last = dot(v, c.last_slip);
    const T bound =
        is_last_pass
            ? T(dot(c.last_slip, c.last_slip) / T(ScalarOf<T>(chosen::damped_slip_reduction)))
            : T(0);
    const Truth<T> turns = along_last <= bound;
    c.is_damping_slip = c.is_damping_slip | (slips_on & turns);
  }
  c.is_slipping = is_slipping;
  c.last_slip = v;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
