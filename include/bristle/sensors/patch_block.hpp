/// @file
/// The implicit patch: all sensors that touch one body as one soft 6x6 constraint.
///
/// Every sensor's impulse is made an affine function of the velocity at the end of the step; since
/// all of them see the same relative motion of two rigid bodies, their sum is one 6x6 matrix and
/// one 6-vector, whatever their number. Sensors that change state within the step (touch, let go,
/// slip) are linearised anew around the last solution, a few passes at most. docs/sensors.md
/// derives every line; the equations are numbered there.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/soft_block.hpp>
#include <bristle/sensors/patch.hpp>

namespace bristle {

/// Sets the weights of the implicit scheme from x = w (dt^2 sum k_t + dt sum mu_V): for soft
/// bristles nearly conservative and fourth-order in phase, for stiff ones implicit Euler.
/// @param w  [1/kg] Mobility of the pair at c: a third of the trace of its linear part.
template <Scalar S>
void set_scheme(PatchPair<S>& pair, S bristle_sum, S viscous_sum, S w, S dt);

/// Linearises all contacts of a pair for the first pass, around the motion at the start of the
/// step.
template <Scalar S>
void start_linearisation(SensorPatch<S>& patch, PatchPair<S>& pair, S dt);

/// Moves the linearisation to the motion that was found, after `evaluate_impulses` there.
/// @param motion        u at the end of the step, as the solver found it.
/// @param pass          Number of the solve that found it, from 1.
/// @param is_last_pass  Whether there is one more solve only.
/// @return Whether anything changed that matters: another solve is needed.
template <Scalar S>
bool update_linearisation(SensorPatch<S>& patch, PatchPair<S>& pair, const Vec6<S>& motion, S dt,
                          int pass, bool is_last_pass);

/// Sums the linear models of all contacts of a pair into its soft block.
template <Scalar S>
void fill_block(const SensorPatch<S>& patch, const PatchPair<S>& pair, SoftBlock<S>& block);

/// Evaluates the impulse of every contact at the motion that was found.
/// @return [N s, N m s] Their sum on B about c.
template <Scalar S>
Wrench<S> evaluate_impulses(SensorPatch<S>& patch, const PatchPair<S>& pair, const Vec6<S>& motion);

// Implementation -----------------------------------------------------------------------------------

template <Scalar S>
void set_scheme(PatchPair<S>& pair, S bristle_sum, S viscous_sum, S w, S dt) {
  const S x = w * (dt * dt * bristle_sum + dt * viscous_sum);
  pair.alpha = x / (S(1) + x);
  pair.beta = (S(1) - pair.alpha) * (S(1) - pair.alpha) / S(12);
  pair.theta = (S(1) + pair.alpha) / S(2);
}

namespace detail {

/// Velocity of A relative to B at a contact for the motion u at c.
template <Scalar S>
[[nodiscard]] Vec3<S> contact_velocity(const Vec6<S>& u, const Vec3<S>& rho) {
  const Vec3<S> W = u.template tail<3>();
  return u.template head<3>() + W.cross(rho);
}

/// Normal part: J_n = dt K_N e_N + a_n g.v' while touching; before, the spring and the damper act
/// on the depth that is reached within the step only, so that nothing pushes across a gap.
template <Scalar S>
void linearise_normal(const SensorParameters<S>& p, PatchContact<S>& c, S dt) {
  const S slope = dt * p.normal_stiffness + p.normal_damping;
  c.normal_constant = c.is_touching ? dt * p.normal_stiffness * c.depth : slope * c.depth;
  c.a_normal = dt * slope / c.length;
}

/// Constant part of the impulse from the normal: along g, plus, where the force shall point along
/// the ray, the difference to n with the impulse of the last pass. (With that impulse inside, the
/// matrix would be unsymmetric and oblique rays would be kicked.)
template <Scalar S>
[[nodiscard]] Vec3<S> normal_constant(const PatchContact<S>& c, NormalDirection direction) {
  if (!c.is_pushing) return Vec3<S>::Zero();
  Vec3<S> sum = c.normal_constant * c.g;
  if (direction == NormalDirection::ray) sum += c.normal_impulse * (c.n - c.g);
  return sum;
}

/// Friction of a bristle that sticks throughout the step.
template <Scalar S>
[[nodiscard]] Vec3<S> linearise_stuck(const SensorParameters<S>& p, const LawOptions& options,
                                      const PatchPair<S>& pair, PatchContact<S>& c, S dt) {
  const S k_t = bristle_stiffness(p, options.scaling, c.force, c.depth);
  const Vec3<S> v0 = tangential(c.start_velocity, c.n);
  c.a_across = c.a_along =
      (pair.alpha + pair.beta) * dt * dt * k_t + pair.theta * dt * p.sliding_friction;
  c.along.setZero();
  return dt * k_t * (c.stretch - pair.beta * dt * v0) +
         (S(1) - pair.theta) * dt * p.sliding_friction * v0;
}

/// Mean stretch of a bristle over a step in which it slips with the tangential velocity v.
template <Scalar S>
[[nodiscard]] Vec3<S> mean_slip_stretch(const PatchPair<S>& pair, const PatchContact<S>& c,
                                        const Vec3<S>& v, S sigma, SlipReset reset, S dt) {
  using std::min;
  const S speed = v.norm();
  const bool passes_whole_stretches = speed * dt >= sigma;
  if (reset == SlipReset::release) {
    return passes_whole_stretches ? Vec3<S>((sigma / (S(2) * speed)) * v)
                                  : wrapped<S>(c.stretch + pair.alpha * dt * v, sigma);
  }
  if (!passes_whole_stretches) return clipped<S>(c.stretch + pair.alpha * dt * v, sigma);
  // Dragging: the stretch grows to sigma along the slip, then stays there.
  const Vec3<S> h = (c.stretch + dt * v).normalized();
  const S start = min(sigma, c.stretch.dot(h));
  const S fraction = min(S(1), (sigma - start) / (speed * dt));
  return (fraction * (start + sigma) / S(2) + (S(1) - fraction) * sigma) * h;
}

/// Friction of a bristle that slips, linearised around the tangential velocity v.
template <Scalar S>
[[nodiscard]] Vec3<S> linearise_slip(const SensorParameters<S>& p, const LawOptions& options,
                                     const PatchPair<S>& pair, PatchContact<S>& c, const Vec3<S>& v,
                                     S dt) {
  using std::max;
  using std::min;
  using std::sqrt;
  const S k_t = bristle_stiffness(p, options.scaling, c.force, c.depth);
  const Vec3<S> mean = mean_slip_stretch(pair, c, v, p.breakaway_distance, options.reset, dt);
  const S speed2 = v.squaredNorm();
  const S stiffest = (pair.alpha + pair.beta) * dt * dt * k_t;
  const S secant =
      speed2 > S(0) ? min(dt * k_t * max(S(0), mean.dot(v)) / speed2, stiffest) : stiffest;
  const S viscous = pair.theta * dt * p.sliding_friction;
  const Vec3<S> v0 = tangential(c.start_velocity, c.n);
  Vec3<S> sum = dt * k_t * mean + (S(1) - pair.theta) * dt * p.sliding_friction * v0;
  c.a_across = secant + viscous;
  if (c.is_damping_slip || !(speed2 > S(0))) {
    // Secant on all directions: pure damping, which cannot reverse the slip.
    c.a_along = c.a_across;
    c.along.setZero();
    sum -= secant * v;
  } else {
    // Newton: friction does not grow with the speed, but turns with its direction.
    c.a_along = viscous;
    c.along = v / sqrt(speed2);
  }
  return sum;
}

/// Linear model of one contact around the tangential velocity v.
template <Scalar S>
void linearise(const SensorPatch<S>& patch, const PatchPair<S>& pair, PatchContact<S>& c,
               const Vec3<S>& v, S dt) {
  const SensorParameters<S>& p = patch.parameters(c.sensor);
  const LawOptions& options = patch.def.options;
  c.constant = normal_constant(c, options.normal);
  if (!c.is_touching) {
    c.a_across = c.a_along = S(0);
    c.along.setZero();
    return;
  }
  c.constant += c.is_slipping ? linearise_slip(p, options, pair, c, v, dt)
                              : linearise_stuck(p, options, pair, c, dt);
}

/// Impulse of a contact's linear model at the velocity v.
template <Scalar S>
[[nodiscard]] Vec3<S> model_impulse(const PatchContact<S>& c, const Vec3<S>& v) {
  Vec3<S> sum = c.constant + c.a_across * tangential(v, c.n) +
                ((c.a_along - c.a_across) * c.along.dot(v)) * c.along;
  if (c.is_pushing) sum += (c.a_normal * c.g.dot(v)) * c.g;
  return sum;
}

}  // namespace detail

template <Scalar S>
void start_linearisation(SensorPatch<S>& patch, PatchPair<S>& pair, S dt) {
  for (std::uint32_t k = pair.first; k < pair.first + pair.count; ++k) {
    PatchContact<S>& c = patch.contacts[k];
    const SensorParameters<S>& p = patch.parameters(c.sensor);
    detail::linearise_normal(p, c, dt);
    c.is_pushing = c.normal_constant + c.a_normal * c.g.dot(c.start_velocity) > S(0);
    c.force = c.is_touching ? normal_force(p, c.depth, c.g.dot(c.start_velocity) / c.length) : S(0);
    c.normal_impulse = dt * c.force;
    c.is_slipping = false;
    detail::linearise(patch, pair, c, tangential(c.start_velocity, c.n), dt);
  }
}

namespace detail {

/// What moving the linearisation found.
template <Scalar S>
struct PassChange {
  bool did_switch = false;
  bool has_slip = false;
  S force_sum = S(0);
  S force_change = S(0);
};

/// Whether the normal part of a contact acts at the motion that was found, and with what force.
template <Scalar S>
void update_normal(PatchContact<S>& c, const Vec3<S>& v, S dt, PassChange<S>& change) {
  using std::abs;
  const S normal = c.normal_constant + c.a_normal * c.g.dot(v);
  const bool is_pushing = normal > S(0);
  change.did_switch = change.did_switch || is_pushing != c.is_pushing;
  c.is_pushing = is_pushing;
  c.normal_impulse = is_pushing ? normal : S(0);
  const S force = c.normal_impulse / dt;
  change.force_change += abs(force - c.force);
  change.force_sum += force;
  c.force = force;
}

/// Whether a touching sensor slips at the tangential velocity v that was found, and whether its
/// slip has to be damped because it turns around from pass to pass.
template <Scalar S>
void update_slip(PatchContact<S>& c, const Vec3<S>& v, S sigma, SlipReset reset, S dt, int pass,
                 bool is_last_pass, PassChange<S>& change) {
  const bool overshoots = (c.stretch + dt * v).squaredNorm() > sigma * sigma;
  // A released bristle has let go for this step; a dragged one may be found sticking after all.
  const bool is_slipping = overshoots || (c.is_slipping && reset == SlipReset::release);
  change.did_switch = change.did_switch || is_slipping != c.is_slipping;
  change.has_slip = change.has_slip || is_slipping;
  if (c.is_slipping && is_slipping) {
    const S along_last = v.dot(c.last_slip);
    if ((pass >= 2 && along_last <= S(0)) ||
        (is_last_pass && along_last <= c.last_slip.squaredNorm() / S(4))) {
      c.is_damping_slip = true;
    }
  }
  c.is_slipping = is_slipping;
  c.last_slip = v;
}

}  // namespace detail

template <Scalar S>
bool update_linearisation(SensorPatch<S>& patch, PatchPair<S>& pair, const Vec6<S>& motion, S dt,
                          int pass, bool is_last_pass) {
  // Changes count when they reach a thousandth of what the patch carries: friction follows the
  // normal force of the pass before.
  const S negligible = S(1e-3);
  detail::PassChange<S> change;
  for (std::uint32_t k = pair.first; k < pair.first + pair.count; ++k) {
    PatchContact<S>& c = patch.contacts[k];
    const Vec3<S> v = detail::contact_velocity(motion, c.rho);
    detail::update_normal(c, v, dt, change);
    if (!c.is_touching) continue;
    detail::update_slip(c, tangential(v, c.n), patch.parameters(c.sensor).breakaway_distance,
                        patch.def.options.reset, dt, pass, is_last_pass, change);
  }
  const bool has_changed = change.did_switch || change.force_change > negligible * change.force_sum;
  if (!has_changed && !change.has_slip) return false;

  S friction_sum = S(0);
  S friction_change = S(0);
  for (std::uint32_t k = pair.first; k < pair.first + pair.count; ++k) {
    PatchContact<S>& c = patch.contacts[k];
    const Vec3<S> v = detail::contact_velocity(motion, c.rho);
    const Vec3<S> before = tangential(c.impulse, c.n);
    // Normal forces that have not settled by the last pass point along the gradient, which cannot
    // give energy, and not along the ray with an impulse that was wrong the pass before.
    if (is_last_pass && has_changed) c.normal_impulse = S(0);
    detail::linearise(patch, pair, c, tangential(v, c.n), dt);
    friction_change += (tangential(detail::model_impulse(c, v), c.n) - before).norm();
    friction_sum += before.norm();
  }
  return has_changed || friction_change > negligible * friction_sum;
}

template <Scalar S>
void fill_block(const SensorPatch<S>& patch, const PatchPair<S>& pair, SoftBlock<S>& block) {
  // sum a (I - n n^T) over sensors needs only the moments of `a` up to second order; what depends
  // on a direction d is the square of the 6-vector [d; rho x d].
  S m0 = S(0);
  Vec3<S> m1 = Vec3<S>::Zero();
  Mat3<S> m2 = Mat3<S>::Zero();
  Mat6<S> A = Mat6<S>::Zero();
  Vec6<S> offset = Vec6<S>::Zero();
  const auto add_square = [&A](S a, const Vec3<S>& rho, const Vec3<S>& d) {
    Vec6<S> q;
    q << d, rho.cross(d);
    A.noalias() += (a * q) * q.transpose();
  };
  for (std::uint32_t k = pair.first; k < pair.first + pair.count; ++k) {
    const PatchContact<S>& c = patch.contacts[k];
    if (c.is_pushing) add_square(c.a_normal, c.rho, c.g);
    if (c.a_across > S(0)) {
      m0 += c.a_across;
      m1 += c.a_across * c.rho;
      m2 += (c.a_across * c.rho) * c.rho.transpose();
      add_square(-c.a_across, c.rho, c.n);
    }
    if (c.a_along != c.a_across) add_square(c.a_along - c.a_across, c.rho, c.along);
    offset.template head<3>() += c.constant;
    offset.template tail<3>() += c.rho.cross(c.constant);
  }
  const Mat3<S> X = skew(m1);
  A.template topLeftCorner<3, 3>() += m0 * Mat3<S>::Identity();
  A.template topRightCorner<3, 3>() -= X;
  A.template bottomLeftCorner<3, 3>() += X;
  A.template bottomRightCorner<3, 3>() += m2.trace() * Mat3<S>::Identity() - m2;
  block.matrix = A;
  block.offset = offset;
}

template <Scalar S>
Wrench<S> evaluate_impulses(SensorPatch<S>& patch, const PatchPair<S>& pair,
                            const Vec6<S>& motion) {
  Wrench<S> sum;
  for (std::uint32_t k = pair.first; k < pair.first + pair.count; ++k) {
    PatchContact<S>& c = patch.contacts[k];
    const Vec3<S> v = detail::contact_velocity(motion, c.rho);
    c.impulse = detail::model_impulse(c, v);
    c.normal_impulse = c.is_pushing ? c.impulse.dot(c.n) : S(0);
    if (c.normal_impulse < S(0)) {
      // The passes ran out before this sensor was seen to part: it must not pull.
      c.impulse = tangential(c.impulse, c.n);
      c.normal_impulse = S(0);
    }
    sum += Wrench<S>::at(c.rho, c.impulse);
  }
  return sum;
}

}  // namespace bristle
