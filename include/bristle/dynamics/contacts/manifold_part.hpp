/// @file
/// Work on manifolds between sweeps, at both ends of a substep.
///
/// Contact data stay in the rows of their block between the first substep and the last. Constraints
/// are 240 bytes each. Visiting them in every substep took a sixth of a long step.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/contacts/contact_target.hpp>
#include <bristle/dynamics/contacts/manifold_block.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// The contacts of one block.
template <Scalar S>
class ManifoldPart : ManifoldMotion<S> {
  using Base = ManifoldMotion<S>;
  using typename Base::Block, typename Base::Points;
  using T = Pack<S>;

 public:
  using Contacts = ManifoldContacts<S>;

  ManifoldPart(Block& block, std::span<Points> points, std::span<Contacts> contacts)
      : Base(block, points), contacts_(contacts.subspan(block.first_point, block.points)) {}

  /// Sets the velocity targets of the contacts (`target_at`). Starts from their impulses.
  /// @param start, free  Velocities at the start of the substep. Velocities of free motion at its
  ///               end.
  void target(const VelocityTable<S>& start, const VelocityTable<S>& free,
              const SolveContext<S>& context);

  /// Ends the sweeps. Friction is spread over the points in proportion to their normal impulses.
  /// Its force and its torsion stay the same. All impulses are added to the totals.
  void spread_friction();

  /// Sets the position impulses (`position_impulse_of`) for sweeps of the position problem.
  /// @param velocities  At the end of the substep. Null if nothing may bounce.
  void start_positions(const VelocityTable<S>* velocities, const SolveContext<S>& context);
  /// Adds `position_excess` to the position impulses, and the displacements by it.
  void start_from_excess(VelocityTable<S>& displacements);
  /// Ends sweeps of the position problem.
  void keep_excess() {
    for (std::size_t k = 0; k < points_.size(); ++k) {
      Contacts& c = contacts_[k];
      (row(points_[k].position_impulse) - row(c.usual_impulse)).store(c.position_excess.data());
    }
  }
  /// Adds the displacements of bounces. Their share is not the usual one.
  void move_by_restitution(VelocityTable<S>& displacements, Integrator integrator);

  /// Advances to the next substep. Gaps follow the motion of this one. Impulses of impacts are
  /// cleared. They do not predict the load that follows.
  void move_on(const VelocityTable<S>& displacements, S dt);

 private:
  using Base::m_, Base::motion, Base::points_, Base::apply_impulse, Base::relative, Base::row,
      Base::speed;
  using typename Base::Friction, typename Base::Load, typename Base::Relative;

  [[nodiscard]] BRISTLE_FORCE_INLINE static Mask<S> mask(std::uint32_t set) {
    return Mask<S>::from_bits(set);
  }
  /// Clears the impulses of lanes.
  BRISTLE_FORCE_INLINE static void clear(const Mask<S>& lanes_to_clear, Points& p, Contacts& c) {
    for (auto* impulse : {&p.impulse, &c.friction1, &c.friction2}) {
      select(lanes_to_clear, T(S(0)), row(*impulse)).store(impulse->data());
    }
  }

  std::span<Contacts> contacts_;
};

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
void ManifoldPart<S>::target(const VelocityTable<S>& start, const VelocityTable<S>& free,
                             const SolveContext<S>& context) {
  const Relative v_start = relative(motion(start));
  const Relative v_free = relative(motion(free));
  const Mask<S> follow_joints = mask(m_.follow_joints);
  const T zero = S(0);
  Friction friction;
  for (std::size_t k = 0; k < points_.size(); ++k) {
    Points& p = points_[k];
    Contacts& c = contacts_[k];
    NormalSpeeds<T> speeds{speed(p, v_start), speed(p, v_free), zero};
    speeds.mean_free = mean_free_velocity<S>(speeds.start, speeds.free, context.integrator);
    const ContactTarget<T> target = target_at<T>(row(c.gap), row(c.restitution), row(p.impulse),
                                                 speeds, follow_joints, context);
    target.target.store(p.target.data());
    target.restitution_share.store(c.restitution_share.data());
    c.impacts = bits(target.is_impact);
    // An impact does not predict the load that follows. Neither does the load predict the impact.
    if (c.impacts != 0) clear(target.is_impact, p, c);
    friction.add(p, row(c.friction1), row(c.friction2));
  }
  friction.along1.store(m_.friction_impulse1.data());
  friction.along2.store(m_.friction_impulse2.data());
  friction.spin.store(m_.torsion.data());
}

template <Scalar S>
void ManifoldPart<S>::spread_friction() {
  using std::max;
  using std::min;
  using std::sqrt;
  const T zero = S(0);
  const T friction1 = row(m_.friction_impulse1);
  const T friction2 = row(m_.friction_impulse2);
  Load load;
  for (const Points& p : points_) load.add(p, row(p.impulse));
  const T per_load = select(load.n > zero, T(S(1)) / load.n, zero);
  const T e1 = load.l1 * per_load;
  const T e2 = load.l2 * per_load;
  // The force now acts at the centre of these impulses. Its moment about the former centre becomes
  // torsion.
  const T torsion = row(m_.torsion) + e1 * friction1 + e2 * friction2;
  T moment = zero;
  T farthest2 = zero;
  for (const Points& p : points_) {
    const T r1 = row(p.e1) - e1;
    const T r2 = row(p.e2) - e2;
    const T distance2 = r1 * r1 + r2 * r2;
    moment += row(p.impulse) * distance2;
    farthest2 = max(farthest2, distance2);
  }
  // No point may carry more than its own friction. The torsion of the others does not matter.
  const T most = row(m_.friction) / sqrt(farthest2);
  const T twist = select(moment > zero, max(min(torsion / moment, most), -most), zero);
  for (std::size_t k = 0; k < points_.size(); ++k) {
    const Points& p = points_[k];
    Contacts& c = contacts_[k];
    const T impulse = row(p.impulse);
    const T share = impulse * per_load;
    const T turn = twist * impulse;
    const T x1 = share * friction1 - turn * (row(p.e1) - e1);
    const T x2 = share * friction2 - turn * (row(p.e2) - e2);
    x1.store(c.friction1.data());
    x2.store(c.friction2.data());
    const T whole[] = {impulse, x1, x2};
    for (std::size_t i = 0; i < 3; ++i) (row(c.total[i]) + whole[i]).store(c.total[i].data());
  }
}

template <Scalar S>
void ManifoldPart<S>::start_positions(const VelocityTable<S>* velocities,
                                      const SolveContext<S>& context) {
  const T zero = S(0);
  const T per_step = S(1) / context.dt;
  Relative v{zero, zero, zero, zero, zero, zero};
  if (velocities != nullptr) v = relative(motion(*velocities));
  for (std::size_t k = 0; k < points_.size(); ++k) {
    Points& p = points_[k];
    Contacts& c = contacts_[k];
    const ContactTarget<T> target{row(p.target), row(c.restitution_share), mask(c.impacts)};
    const PositionImpulse<T> found =
        position_impulse_of<T>(row(p.impulse), row(c.restitution), target, speed(p, v), context);
    (-row(c.gap) * per_step).store(p.position_target.data());
    for (auto* impulse : {&c.usual_impulse, &p.position_impulse}) {
      found.position_impulse.store(impulse->data());
    }
    select(found.is_separating, found.position_impulse, found.least_position_impulse)
        .store(p.least_position_impulse.data());
    select(found.is_separating, zero, row(p.inverse_response))
        .store(p.inverse_position_response.data());
  }
}

template <Scalar S>
void ManifoldPart<S>::start_from_excess(VelocityTable<S>& displacements) {
  const T zero = S(0);
  Load load;
  for (std::size_t k = 0; k < points_.size(); ++k) {
    Points& p = points_[k];
    const Contacts& c = contacts_[k];
    const T usual = row(c.usual_impulse);
    const T impulse = max(usual + row(c.position_excess), row(p.least_position_impulse));
    impulse.store(p.position_impulse.data());
    load.add(p, impulse - usual);
  }
  apply_impulse(displacements, motion(displacements), load, zero, zero, zero);
}

template <Scalar S>
void ManifoldPart<S>::move_by_restitution(VelocityTable<S>& displacements, Integrator integrator) {
  const T zero = S(0);
  const T usual = usual_share<S>(integrator);
  Load load;
  Friction friction;
  bool has_bounced = false;
  for (std::size_t k = 0; k < points_.size(); ++k) {
    const Points& p = points_[k];
    const Contacts& c = contacts_[k];
    const T share = row(c.restitution_share);
    const Mask<S> bounces = share >= zero;
    if (!any(bounces)) continue;
    has_bounced = true;
    const T more = select(bounces, share - usual, zero);
    load.add(p, more * row(p.impulse));
    friction.add(p, more * row(c.friction1), more * row(c.friction2));
  }
  if (!has_bounced) return;
  apply_impulse(displacements, motion(displacements), load, friction.along1, friction.along2,
                friction.spin);
}

template <Scalar S>
void ManifoldPart<S>::move_on(const VelocityTable<S>& displacements, S dt) {
  const Relative v = relative(motion(displacements));
  for (std::size_t k = 0; k < points_.size(); ++k) {
    Points& p = points_[k];
    Contacts& c = contacts_[k];
    (row(c.gap) + dt * speed(p, v)).store(c.gap.data());
    if (c.impacts != 0) clear(mask(c.impacts), p, c);
  }
}

}  // namespace bristle::inline BRISTLE_ABI::detail
