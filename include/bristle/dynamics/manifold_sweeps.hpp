/// @file
/// Sweeps over contacts by manifold: the fast path of large islands.
///
/// All points of a manifold keep their own normal impulse but share one friction: two tangents at
/// the centre of pressure and a torsion about the normal, bounded by what the normal impulses
/// allow. What it gives up is friction that differs from point to point within one patch, which
/// rigid bodies leave undetermined anyway.
///
/// A manifold sees six numbers: the velocity of b relative to a at the centre of pressure and the
/// relative angular velocity, along its axes. With the point's lever e = r x n about the centre,
///     v_n = V_n + e_1 w_1 + e_2 w_2,
/// and a unit impulse there changes V_n, w_1, w_2 by three numbers that are known beforehand. So
/// two bodies are read once, all points and the friction are solved among these six numbers, and
/// one force and one torque are given to the bodies, however many points there are.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/contact_aim.hpp>
#include <bristle/dynamics/manifold_mobility.hpp>
#include <bristle/dynamics/solver_types.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace bristle {

/// Scratch memory and the sweeps. One object serves many islands, one after the other.
template <Scalar S>
class ManifoldSweeps {
 public:
  /// Sets up an island's manifolds. Contacts of one manifold follow each other.
  void start(const Island& island, const Constraints<S>& constraints,
             std::span<const SolverBody<S>> bodies);

  /// Starts a part of the step, in which arms, axes and masses are those that were set up: aims the
  /// contacts and takes over the impulses they have.
  void aim(const Island& island, Constraints<S>& constraints, std::span<const SolverBody<S>> bodies,
           const SolveContext<S>& context);

  /// Adds what all impulses do to the bodies' velocities.
  void apply(std::span<SolverBody<S>> bodies) const {
    for (const Manifold& m : manifolds_) {
      Load load;
      for (const Point& p : points_of(m)) load.add(p, p.impulse);
      SolverBody<S>& a = bodies[m.a];
      SolverBody<S>& b = bodies[m.b];
      push(m, {load.n, m.friction_impulse[0], m.friction_impulse[1]}, {m.torsion, load.l1, load.l2},
           a, b, a.twist, b.twist);
    }
  }

  /// One sweep over all contacts, there or back.
  /// @return [m/s] Largest velocity change.
  S sweep(std::span<SolverBody<S>> bodies, bool backwards) {
    return for_each_manifold(backwards, [&](Manifold& m) { return solve(m, bodies); });
  }

  /// Starts the position problem: shares of the impulses (`place_contact`), which `store` must
  /// have written back.
  void start_placing(const Island& island, Constraints<S>& constraints,
                     std::span<const SolverBody<S>> bodies, Integrator integrator) const {
    for_each_speed(island, constraints, bodies, velocity_of,
                   [&](ContactConstraint<S>& c, S speed) { place_contact(c, speed, integrator); });
  }

  /// Lets gaps follow the motion of a part of the step.
  void move_gaps(const Island& island, Constraints<S>& constraints,
                 std::span<const SolverBody<S>> bodies, S dt) const {
    for_each_speed(island, constraints, bodies, motion_of,
                   [&](ContactConstraint<S>& c, S speed) { c.gap += dt * speed; });
  }

  /// One sweep of the position problem.
  S place(const Island& island, Constraints<S>& constraints, std::span<SolverBody<S>> bodies, S dt,
          bool backwards) {
    const S per_step = S(1) / dt;
    return for_each_manifold(backwards, [&](const Manifold& m) {
      return place(m, island, constraints, bodies, per_step);
    });
  }

  /// Writes the impulses back to the constraints: friction is spread over the points in proportion
  /// to their normal impulses, so that its force and its torsion stay what they are.
  void store(const Island& island, Constraints<S>& constraints) const;

 private:
  /// Three numbers without Eigen around them: in a function as large as a sweep its products would
  /// become calls and its vectors memory.
  struct Triple {
    S x, y, z;
  };
  [[nodiscard]] static Triple triple(const Vec3<S>& v) { return {v[0], v[1], v[2]}; }
  [[nodiscard]] static Triple cross(const Triple& u, const Triple& v) {
    return {u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
  }
  [[nodiscard]] static S dot(const Triple& u, const Triple& v) {
    return u.x * v.x + u.y * v.y + u.z * v.z;
  }

  /// Velocity of b relative to a at a manifold's centre, along its axes.
  struct Relative {
    S n, v1, v2;     // Along the normal and the tangents.
    S spin, w1, w2;  // About them.
  };

  struct Point {
    /// Lever of a unit normal impulse about the centre of pressure, along the tangents.
    S e1 = S(0), e2 = S(0);
    /// What it does to the normal velocity of the centre, and to the turn about the tangents.
    S linear = S(0), turn1 = S(0), turn2 = S(0);
    S response = S(0);
    S inverse_response = S(0);
    S target = S(0);
    S impulse = S(0);
    S radius = S(0);  // Distance from the centre of pressure: the arm of torsion.

    [[nodiscard]] S speed(const Relative& v) const { return v.n + e1 * v.w1 + e2 * v.w2; }
  };

  struct Manifold {
    std::uint32_t a = 0;
    std::uint32_t b = 0;
    std::uint32_t first = 0;
    std::uint32_t count = 0;
    /// Normal and tangents, world axes.
    Triple n, t1, t2;
    /// From each centre of mass to the centre of pressure, world axes.
    Triple arm_a, arm_b;
    /// What normal impulses do across: velocity along the tangents and spin about the normal, for
    /// units of force along the normal and of torque about the tangents.
    std::array<std::array<S, 3>, 3> across;
    S friction = S(0);
    S radius = S(0);  // The largest of its points.
    ContactResponse<S> response;
    S torsion_response = S(0);
    S inverse_torsion_response = S(0);
    std::array<S, 2> friction_impulse{};
    S torsion = S(0);

    [[nodiscard]] Triple in_world(const Triple& v) const {
      return {n.x * v.x + t1.x * v.y + t2.x * v.z, n.y * v.x + t1.y * v.y + t2.y * v.z,
              n.z * v.x + t1.z * v.y + t2.z * v.z};
    }
  };

  [[nodiscard]] static Relative relative(const Manifold& m, const Twist<S>& a, const Twist<S>& b) {
    const Triple wa = triple(a.angular);
    const Triple wb = triple(b.angular);
    const Triple at_a = cross(wa, m.arm_a);
    const Triple at_b = cross(wb, m.arm_b);
    const Triple v{(b.linear[0] - a.linear[0]) + (at_b.x - at_a.x),
                   (b.linear[1] - a.linear[1]) + (at_b.y - at_a.y),
                   (b.linear[2] - a.linear[2]) + (at_b.z - at_a.z)};
    const Triple w{wb.x - wa.x, wb.y - wa.y, wb.z - wa.z};
    return {dot(m.n, v), dot(m.t1, v), dot(m.t2, v), dot(m.n, w), dot(m.t1, w), dot(m.t2, w)};
  }
  /// Gives b an impulse and an angular impulse at the centre, along the manifold's axes, and a
  /// their opposites.
  static void push(const Manifold& m, const Triple& along, const Triple& about,
                   const SolverBody<S>& a, const SolverBody<S>& b, Twist<S>& twist_a,
                   Twist<S>& twist_b) {
    const Triple force = m.in_world(along);
    const Triple torque = m.in_world(about);
    if (a.moves) push(a, S(-1), force, torque, m.arm_a, twist_a);
    if (b.moves) push(b, S(1), force, torque, m.arm_b, twist_b);
  }
  static void push(const SolverBody<S>& body, S sign, const Triple& force, const Triple& torque,
                   const Triple& arm, Twist<S>& twist) {
    const Triple lever = cross(arm, force);
    const Triple total{sign * (torque.x + lever.x), sign * (torque.y + lever.y),
                       sign * (torque.z + lever.z)};
    const S* m = body.inverse_mass.data();
    const S* I = body.inverse_inertia.data();  // Symmetric.
    S* v = twist.linear.data();
    S* w = twist.angular.data();
    v[0] += sign * m[0] * force.x;
    v[1] += sign * m[1] * force.y;
    v[2] += sign * m[2] * force.z;
    if (body.is_isotropic) {
      w[0] += I[0] * total.x;
      w[1] += I[0] * total.y;
      w[2] += I[0] * total.z;
    } else {
      w[0] += I[0] * total.x + I[1] * total.y + I[2] * total.z;
      w[1] += I[3] * total.x + I[4] * total.y + I[5] * total.z;
      w[2] += I[6] * total.x + I[7] * total.y + I[8] * total.z;
    }
  }

  /// Sums of a manifold's normal impulses: force, torque about the tangents.
  struct Load {
    S n = S(0), l1 = S(0), l2 = S(0);

    void add(const Point& p, S x) {
      n += x;
      l1 += x * p.e1;
      l2 += x * p.e2;
    }
    void add(const Point& p, S x, Relative& v) {
      add(p, x);
      v.n += x * p.linear;
      v.w1 += x * p.turn1;
      v.w2 += x * p.turn2;
    }
  };

  [[nodiscard]] std::span<const Point> points_of(const Manifold& m) const {
    return std::span(points_).subspan(m.first, m.count);
  }
  /// Calls use(contact, normal velocity) for all contacts.
  template <typename Of, typename Use>
  void for_each_speed(const Island& island, Constraints<S>& constraints,
                      std::span<const SolverBody<S>> bodies, Of&& of, Use&& use) const {
    for (const Manifold& m : manifolds_) {
      const Relative v = relative(m, of(bodies[m.a]), of(bodies[m.b]));
      for (std::uint32_t k = m.first; k < m.first + m.count; ++k) {
        use(constraints.contacts[island.contacts[k]], points_[k].speed(v));
      }
    }
  }

  template <typename Visit>
  S for_each_manifold(bool backwards, Visit&& visit) {
    S largest = S(0);
    const std::size_t count = manifolds_.size();
    for (std::size_t k = 0; k < count; ++k) {
      largest = std::max(largest, visit(manifolds_[backwards ? count - 1 - k : k]));
    }
    return largest;
  }

  void add_manifold(std::span<const std::uint32_t> contacts, const Constraints<S>& constraints,
                    std::span<const SolverBody<S>> bodies);
  S solve(Manifold& m, std::span<SolverBody<S>> bodies);
  S place(const Manifold& m, const Island& island, Constraints<S>& constraints,
          std::span<SolverBody<S>> bodies, S per_step);
  static S rub(Manifold& m, S most, S most_torsion, const Relative& v);

  std::vector<Manifold> manifolds_;
  std::vector<Point> points_;
};

// Implementation -----------------------------------------------------------------------------------

template <Scalar S>
void ManifoldSweeps<S>::start(const Island& island, const Constraints<S>& constraints,
                              std::span<const SolverBody<S>> bodies) {
  manifolds_.clear();
  points_.clear();
  const auto belong_together = [&](std::uint32_t i, std::uint32_t j) {
    return i + 1 == j && are_of_one_manifold(constraints.contacts[i], constraints.contacts[j]);
  };
  for (std::size_t k = 0; k < island.contacts.size();) {
    std::size_t end = k + 1;
    while (end < island.contacts.size() &&
           belong_together(island.contacts[end - 1], island.contacts[end])) {
      ++end;
    }
    add_manifold(island.contacts.subspan(k, end - k), constraints, bodies);
    k = end;
  }
}

template <Scalar S>
void ManifoldSweeps<S>::add_manifold(std::span<const std::uint32_t> contacts,
                                     const Constraints<S>& constraints,
                                     std::span<const SolverBody<S>> bodies) {
  using std::sqrt;
  const ContactConstraint<S>& one = constraints.contacts[contacts[0]];
  Manifold& m = manifolds_.emplace_back();
  m.a = one.body_a;
  m.b = one.body_b;
  m.first = static_cast<std::uint32_t>(points_.size());
  m.count = static_cast<std::uint32_t>(contacts.size());
  m.friction = one.friction;

  // The centre of pressure of the last step; of points that carried nothing, their middle.
  S sum = S(0);
  for (const std::uint32_t i : contacts) sum += constraints.contacts[i].impulse[0];
  const S even = S(1) / S(contacts.size());
  Vec3<S> arm_a = Vec3<S>::Zero();
  Vec3<S> arm_b = Vec3<S>::Zero();
  for (const std::uint32_t i : contacts) {
    const ContactConstraint<S>& c = constraints.contacts[i];
    const S weight = sum > S(0) ? c.impulse[0] / sum : even;
    arm_a += weight * c.arm_a;
    arm_b += weight * c.arm_b;
  }
  m.arm_a = triple(arm_a);
  m.arm_b = triple(arm_b);
  m.n = triple(one.axes[0]);
  m.t1 = triple(one.axes[1]);
  m.t2 = triple(one.axes[2]);

  const ManifoldMobility<S> w(one, bodies[m.a], bodies[m.b], arm_a, arm_b);
  m.response = w.linear;
  m.response.prepare();
  m.torsion_response = w.angular(0, 0);
  m.inverse_torsion_response = m.torsion_response > S(0) ? S(1) / m.torsion_response : S(0);
  m.across = {{{w.linear.n1, w.turn(1, 1), w.turn(2, 1)},
               {w.linear.n2, w.turn(1, 2), w.turn(2, 2)},
               {w.turn(0, 0), w.angular(0, 1), w.angular(0, 2)}}};

  for (const std::uint32_t i : contacts) {
    const ContactConstraint<S>& c = constraints.contacts[i];
    Point& p = points_.emplace_back();
    // A single point is the centre of pressure, and has no lever about it.
    if (m.count > 1) {
      const Triple from_center = triple(c.arm_a - arm_a);
      p.e1 = dot(from_center, m.t2);
      p.e2 = -dot(from_center, m.t1);
      p.radius = sqrt(p.e1 * p.e1 + p.e2 * p.e2);
      m.radius = std::max(m.radius, p.radius);
    }
    p.turn1 = w.turn(1, 0) + p.e1 * w.angular(1, 1) + p.e2 * w.angular(1, 2);
    p.turn2 = w.turn(2, 0) + p.e1 * w.angular(2, 1) + p.e2 * w.angular(2, 2);
    p.linear = w.linear.nn + p.e1 * w.turn(1, 0) + p.e2 * w.turn(2, 0);
    p.response = p.linear + p.e1 * p.turn1 + p.e2 * p.turn2;
    p.inverse_response = p.response > S(0) ? S(1) / p.response : S(0);
  }
}

template <Scalar S>
void ManifoldSweeps<S>::aim(const Island& island, Constraints<S>& constraints,
                            std::span<const SolverBody<S>> bodies, const SolveContext<S>& context) {
  for (Manifold& m : manifolds_) {
    const SolverBody<S>& a = bodies[m.a];
    const SolverBody<S>& b = bodies[m.b];
    const Relative start = relative(m, a.start, b.start);
    const Relative free = relative(m, a.free, b.free);
    const Relative motion = relative(m, a.free_motion, b.free_motion);
    m.friction_impulse = {};
    m.torsion = S(0);
    for (std::uint32_t k = m.first; k < m.first + m.count; ++k) {
      ContactConstraint<S>& c = constraints.contacts[island.contacts[k]];
      Point& p = points_[k];
      aim_contact<S>(c, {p.speed(start), p.speed(free), p.speed(motion)},
                     a.follows_joints || b.follows_joints, context);
      p.target = c.target;
      p.impulse = c.impulse[0];
      m.friction_impulse[0] += c.impulse[1];
      m.friction_impulse[1] += c.impulse[2];
      m.torsion -= p.e1 * c.impulse[1] + p.e2 * c.impulse[2];
    }
  }
}

template <Scalar S>
S ManifoldSweeps<S>::solve(Manifold& m, std::span<SolverBody<S>> bodies) {
  using std::abs;
  using std::max;
  SolverBody<S>& a = bodies[m.a];
  SolverBody<S>& b = bodies[m.b];
  Relative v = relative(m, a.twist, b.twist);
  Load load;
  S largest = S(0);
  S sum = S(0);
  S moment = S(0);
  for (std::uint32_t k = m.first; k < m.first + m.count; ++k) {
    Point& p = points_[k];
    const S wanted = max(S(0), p.impulse + (p.target - p.speed(v)) * p.inverse_response);
    const S change = wanted - p.impulse;
    p.impulse = wanted;
    sum += wanted;
    moment += wanted * p.radius;
    load.add(p, change, v);
    largest = max(largest, abs(change) * p.response);
  }
  v.v1 += m.across[0][0] * load.n + m.across[0][1] * load.l1 + m.across[0][2] * load.l2;
  v.v2 += m.across[1][0] * load.n + m.across[1][1] * load.l1 + m.across[1][2] * load.l2;
  v.spin += m.across[2][0] * load.n + m.across[2][1] * load.l1 + m.across[2][2] * load.l2;
  const std::array<S, 2> before = m.friction_impulse;
  const S before_torsion = m.torsion;
  largest = max(largest, rub(m, m.friction * sum, m.friction * moment, v));
  if (!(largest > S(0))) return largest;
  push(m, {load.n, m.friction_impulse[0] - before[0], m.friction_impulse[1] - before[1]},
       {m.torsion - before_torsion, load.l1, load.l2}, a, b, a.twist, b.twist);
  return largest;
}

/// Friction of a manifold: force and torsion together within an ellipsoid, whose axes are the force
/// `most` alone and the torsion `most_torsion` alone.
template <Scalar S>
S ManifoldSweeps<S>::rub(Manifold& m, S most, S most_torsion, const Relative& v) {
  using std::abs;
  using std::max;
  using std::sqrt;
  S x1 = m.friction_impulse[0];
  S x2 = m.friction_impulse[1];
  S torsion = S(0);
  if (most > S(0)) {
    detail::solve_friction(m.response, v.v1, v.v2, most, x1, x2);
    S size2 = (x1 * x1 + x2 * x2) / (most * most);
    if (most_torsion > S(0)) {
      torsion = m.torsion - v.spin * m.inverse_torsion_response;
      const S turn = torsion / most_torsion;
      size2 += turn * turn;
    }
    if (size2 > S(1)) {
      const S shrink = S(1) / sqrt(size2);
      torsion *= shrink;
      x1 *= shrink;
      x2 *= shrink;
    }
  } else {
    x1 = x2 = S(0);
  }
  const S change = max(
      max(abs(x1 - m.friction_impulse[0]), abs(x2 - m.friction_impulse[1])) * m.response.largest,
      abs(torsion - m.torsion) * m.torsion_response * m.radius);
  m.friction_impulse = {x1, x2};
  m.torsion = torsion;
  return change;
}

template <Scalar S>
S ManifoldSweeps<S>::place(const Manifold& m, const Island& island, Constraints<S>& constraints,
                           std::span<SolverBody<S>> bodies, S per_step) {
  using std::abs;
  using std::max;
  SolverBody<S>& a = bodies[m.a];
  SolverBody<S>& b = bodies[m.b];
  Relative v = relative(m, a.motion, b.motion);
  Load load;
  S largest = S(0);
  for (std::uint32_t k = m.first; k < m.first + m.count; ++k) {
    ContactConstraint<S>& c = constraints.contacts[island.contacts[k]];
    const Point& p = points_[k];
    if (c.parts) continue;
    const S left = c.gap * per_step + p.speed(v);
    const S wanted = max(c.least_placed, c.placed - left * p.inverse_response);
    const S change = wanted - c.placed;
    c.placed = wanted;
    load.add(p, change, v);
    largest = max(largest, abs(change) * p.response);
  }
  if (largest > S(0)) {
    push(m, {load.n, S(0), S(0)}, {S(0), load.l1, load.l2}, a, b, a.motion, b.motion);
  }
  return largest;
}

template <Scalar S>
void ManifoldSweeps<S>::store(const Island& island, Constraints<S>& constraints) const {
  using std::abs;
  using std::copysign;
  using std::min;
  using std::sqrt;
  for (const Manifold& m : manifolds_) {
    const std::span<const Point> points = points_of(m);
    S sum = S(0);
    S e1 = S(0);
    S e2 = S(0);
    for (const Point& p : points) {
      sum += p.impulse;
      e1 += p.impulse * p.e1;
      e2 += p.impulse * p.e2;
    }
    const S per_load = sum > S(0) ? S(1) / sum : S(0);
    e1 *= per_load;
    e2 *= per_load;
    // The force now acts at the centre of these impulses; what it did about the former one becomes
    // torsion.
    const S torsion = m.torsion + e1 * m.friction_impulse[0] + e2 * m.friction_impulse[1];
    S moment = S(0);
    S farthest2 = S(0);
    for (const Point& p : points) {
      const S r2 = (p.e1 - e1) * (p.e1 - e1) + (p.e2 - e2) * (p.e2 - e2);
      moment += p.impulse * r2;
      farthest2 = std::max(farthest2, r2);
    }
    // No point may carry more than its own friction, whatever torsion was found for others.
    const S twist =
        moment > S(0) ? copysign(min(abs(torsion / moment), m.friction / sqrt(farthest2)), torsion)
                      : S(0);
    for (std::uint32_t k = 0; k < m.count; ++k) {
      const Point& p = points[k];
      const S share = p.impulse * per_load;
      const S turn = twist * p.impulse;
      constraints.contacts[island.contacts[m.first + k]].impulse = {
          p.impulse, share * m.friction_impulse[0] - turn * (p.e1 - e1),
          share * m.friction_impulse[1] - turn * (p.e2 - e2)};
    }
  }
}

}  // namespace bristle
