/// @file
/// One update of a sweep. It solves several manifolds, each with all others held still.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/contacts/contact_constraint.hpp>
#include <bristle/dynamics/contacts/manifold_block.hpp>

#include <cstddef>
#include <span>
#include <type_traits>
#include <utility>

namespace bristle::inline BRISTLE_ABI::detail {

/// Updates of one block.
template <Scalar S>
class ManifoldKernel : ManifoldMotion<S> {
  using Base = ManifoldMotion<S>;
  using typename Base::Block, typename Base::Points;
  using T = Pack<S>;

 public:
  ManifoldKernel(Block& block, std::span<Points> points) : Base(block, points) {}

  /// Adds the effect of all impulses.
  void apply(VelocityTable<S>& velocities) const {
    Load load;
    for (const Points& p : points_) load.add(p, row(p.impulse));
    apply_impulse(velocities, motion(velocities), load, row(m_.friction_impulse1),
                  row(m_.friction_impulse2), row(m_.torsion));
  }
  /// One update of the velocity problem.
  /// @return [m/s] Largest velocity change.
  BRISTLE_FORCE_INLINE T solve(VelocityTable<S>& velocities);
  /// One update of the position problem.
  BRISTLE_FORCE_INLINE T place(VelocityTable<S>& displacements);
  /// Calls use(impulses, residuals) for the rows of the velocity problem. A residual is a velocity
  /// less its target. That of friction which slides is zero: it gives all that it can.
  template <typename Use>
  BRISTLE_FORCE_INLINE void show_residuals(const VelocityTable<S>& velocities, Use&& use) const;
  /// The same for the rows of the position problem.
  template <typename Use>
  BRISTLE_FORCE_INLINE void show_position_residuals(const VelocityTable<S>& displacements,
                                                    Use&& use) const {
    const Relative v = relative(motion(displacements));
    for (const Points& p : points_) use(p.position_impulse, speed(p, v) - row(p.position_target));
  }

 private:
  using Base::m_, Base::motion, Base::points_, Base::apply_impulse, Base::relative, Base::row,
      Base::speed;
  using typename Base::Load, typename Base::Motion, typename Base::Relative, typename Base::Row;

  /// Tangential response for `solve_friction`.
  struct TangentialResponse {
    T a, b, c, inverse_determinant, inverse_largest;
  };

  [[nodiscard]] BRISTLE_FORCE_INLINE T across(std::size_t i, const Load& load) const {
    return row(m_.across[i][0]) * load.n + row(m_.across[i][1]) * load.l1 +
           row(m_.across[i][2]) * load.l2;
  }
  /// One update of all points. Impulses x bring normal velocities to their targets, within their
  /// bounds.
  /// @param v      Velocity without the effect of this update.
  /// @param bound  bound(point, x) returns the nearest impulse that the point may have.
  /// @param use    (point, x) called for each point.
  /// @return [m/s] Largest velocity change.
  template <typename Bound, typename Use>
  BRISTLE_FORCE_INLINE T solve_points(Relative v, Load& load, Row Points::*target,
                                      Row Points::*inverse, Row Points::*x, const Bound& bound,
                                      const Use& use);
  BRISTLE_FORCE_INLINE void solve_point_friction(const T& most, const T& most_torsion,
                                                 const Relative& v);
  /// [1] Square of the friction as a share of the most that there can be: 1 if it slides.
  [[nodiscard]] BRISTLE_FORCE_INLINE static T used_friction2(const T& most, const T& most_torsion,
                                                             const T& x1, const T& x2,
                                                             const T& torsion) {
    const T turn = select(most_torsion > T(S(0)), torsion / most_torsion, T(S(0)));
    return (x1 * x1 + x2 * x2) / (most * most) + turn * turn;
  }
};

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
BRISTLE_FORCE_INLINE Pack<S> ManifoldKernel<S>::solve(VelocityTable<S>& velocities) {
  const Motion before_turn = motion(velocities);
  Relative v = relative(before_turn);
  Load load;
  T sum = S(0);
  T moment = S(0);
  T largest = solve_points(
      v, load, &Points::target, &Points::inverse_response, &Points::impulse,
      [most = row(m_.most_impulse)](const Points&, const T& x) {
        // In this order a velocity that is NaN gives no impulse.
        return min(max(x, T(S(0))), most);
      },
      [&](const Points& p, const T& impulse) {
        sum += impulse;
        moment += impulse * row(p.radius);
      });
  v.v1 += across(0, load) - row(m_.drift1);
  v.v2 += across(1, load) - row(m_.drift2);
  v.spin += across(2, load);
  const T before1 = row(m_.friction_impulse1);
  const T before2 = row(m_.friction_impulse2);
  const T before_torsion = row(m_.torsion);
  solve_point_friction(row(m_.friction) * sum, row(m_.friction) * moment, v);
  const T change1 = row(m_.friction_impulse1) - before1;
  const T change2 = row(m_.friction_impulse2) - before2;
  const T twist = row(m_.torsion) - before_torsion;
  largest = max(max(abs(change1), abs(change2)) * row(m_.largest_response), largest);
  largest = max(abs(twist) * row(m_.torsion_response) * row(m_.radius), largest);
  if (any(largest > T(S(0)))) apply_impulse(velocities, before_turn, load, change1, change2, twist);
  return largest;
}

template <Scalar S>
template <typename Bound, typename Use>
BRISTLE_FORCE_INLINE Pack<S> ManifoldKernel<S>::solve_points(Relative v, Load& load,
                                                             Row Points::*target,
                                                             Row Points::*inverse, Row Points::*x,
                                                             const Bound& bound, const Use& use) {
  T largest = S(0);
  for (std::size_t first = 0; first < points_.size(); first += point_group) {
    const auto points = points_.subspan(first);
    T left[point_group], change[point_group];
    // The numbers of points are constants. So the values of each stay in registers.
    const auto for_each_of_group = [&](const auto& turn) {
      const auto unroll = [&]<std::size_t... k>(std::index_sequence<k...>) {
        ((k < points.size() ? turn(std::integral_constant<std::size_t, k>(), points[k]) : void()),
         ...);
      };
      unroll(std::make_index_sequence<point_group>());
    };
    for_each_of_group([&](auto k, const Points& p) { left[k] = row(p.*target) - speed(p, v); });
    for_each_of_group([&](auto k, Points& p) {
      const auto couple = [&]<std::size_t... i>(std::index_sequence<i...>) {
        ((left[k] -= row(p.coupling[i]) * change[i]), ...);
      };
      couple(std::make_index_sequence<k>());
      const T before = row(p.*x);
      const T wanted = bound(p, before + left[k] * row(p.*inverse));
      change[k] = wanted - before;
      wanted.store((p.*x).data());
      use(p, wanted);
      load.add(p, change[k]);
      largest = max(abs(change[k]) * row(p.response), largest);
    });
    if (points.size() <= point_group) break;
    for_each_of_group([&](auto k, const Points& p) {
      v.n += change[k] * row(p.linear);
      v.w1 += change[k] * row(p.turn1);
      v.w2 += change[k] * row(p.turn2);
    });
  }
  return largest;
}

/// Friction of a manifold: force and torsion in an ellipsoid. Its axes are the force `most` alone
/// and the torsion `most_torsion` alone.
template <Scalar S>
BRISTLE_FORCE_INLINE void ManifoldKernel<S>::solve_point_friction(const T& most,
                                                                  const T& most_torsion,
                                                                  const Relative& v) {
  const TangentialResponse K{row(m_.response_a), row(m_.response_b), row(m_.response_c),
                             row(m_.inverse_determinant), row(m_.inverse_largest)};
  const T zero = S(0);
  T x1 = row(m_.friction_impulse1);
  T x2 = row(m_.friction_impulse2);
  solve_friction(K, v.v1, v.v2, most, x1, x2);
  const Mask<S> twists = most_torsion > zero;
  T torsion = select(twists, row(m_.torsion) - v.spin * row(m_.inverse_torsion_response), zero);
  const T size2 = used_friction2(most, most_torsion, x1, x2, torsion);
  const Mask<S> is_beyond = size2 > T(S(1));
  if (any(is_beyond)) {
    const T shrink = select(is_beyond, T(S(1)) / sqrt(size2), T(S(1)));
    torsion *= shrink;
    x1 *= shrink;
    x2 *= shrink;
  }
  const Mask<S> presses = most > zero;
  select(presses, x1, zero).store(m_.friction_impulse1.data());
  select(presses, x2, zero).store(m_.friction_impulse2.data());
  select(presses, torsion, zero).store(m_.torsion.data());
}

template <Scalar S>
template <typename Use>
BRISTLE_FORCE_INLINE void ManifoldKernel<S>::show_residuals(const VelocityTable<S>& velocities,
                                                            Use&& use) const {
  const Relative v = relative(motion(velocities));
  T sum = S(0);
  T moment = S(0);
  for (const Points& p : points_) {
    const T impulse = row(p.impulse);
    sum += impulse;
    moment += impulse * row(p.radius);
  }
  const T most = row(m_.friction) * sum;
  const T size2 = used_friction2(most, row(m_.friction) * moment, row(m_.friction_impulse1),
                                 row(m_.friction_impulse2), row(m_.torsion));
  const Mask<S> holds = size2 < T(S(1) - Tolerance<S>::equal());
  const T zero = S(0);
  for (Points& p : points_) use(p.impulse, speed(p, v) - row(p.target));
  use(m_.friction_impulse1, select(holds, v.v1 - row(m_.drift1), zero));
  use(m_.friction_impulse2, select(holds, v.v2 - row(m_.drift2), zero));
  use(m_.torsion, select(holds, v.spin, zero));
}

template <Scalar S>
BRISTLE_FORCE_INLINE Pack<S> ManifoldKernel<S>::place(VelocityTable<S>& displacements) {
  const Motion before_turn = motion(displacements);
  Load load;
  const T largest = solve_points(
      relative(before_turn), load, &Points::position_target, &Points::inverse_position_response,
      &Points::position_impulse,
      [](const Points& p, const T& x) { return max(x, row(p.least_position_impulse)); },
      [](const Points&, const T&) {});
  const T zero = S(0);
  if (any(largest > zero)) apply_impulse(displacements, before_turn, load, zero, zero, zero);
  return largest;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
