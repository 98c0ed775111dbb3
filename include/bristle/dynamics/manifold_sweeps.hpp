/// @file
/// Sweeps over contacts by manifold: the fast path of large islands.
///
/// All points of a manifold keep their own normal impulse but share one friction: two tangents at
/// the centre of pressure and a torsion about the normal, bounded by what the normal impulses
/// allow. A sweep over a box on a box is then four normals and one friction instead of four of
/// each, and the bodies are loaded and stored once. What it gives up is friction that differs from
/// point to point within one patch, which rigid bodies leave undetermined anyway.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/solver_types.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace bristle {

/// Scratch memory and the sweeps. One object serves many islands, one after the other.
template <Scalar S>
class ManifoldSweeps {
 public:
  /// Sets up the rows of an island's contacts, with the impulses there are. Contacts of one
  /// manifold follow each other.
  void start(const Island& island, const Constraints<S>& constraints,
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

  /// One sweep over all contacts, there or back.
  /// @return [m/s] Largest velocity change.
  S sweep(std::span<SolverBody<S>> bodies, bool backwards) {
    S largest = S(0);
    const std::size_t count = manifolds_.size();
    for (std::size_t k = 0; k < count; ++k) {
      largest = std::max(largest, sweep(manifolds_[backwards ? count - 1 - k : k], bodies));
    }
    return largest;
  }

  /// One sweep of the position problem.
  S place(const Island& island, Constraints<S>& constraints, std::span<SolverBody<S>> bodies, S dt,
          bool backwards) {
    using std::abs;
    using std::max;
    S largest = S(0);
    const S per_step = S(1) / dt;
    const std::size_t count = manifolds_.size();
    for (std::size_t n = 0; n < count; ++n) {
      const Manifold& m = manifolds_[backwards ? count - 1 - n : n];
      Pair pair(m, bodies, motion_of);
      NormalPart normal(m, pair);
      for (std::uint32_t k = m.first; k < m.first + m.count; ++k) {
        ContactConstraint<S>& c = constraints.contacts[island.contacts[k]];
        const Point& p = points_[k];
        if (c.parts) continue;
        const S left = c.gap * per_step + normal.velocity(p.row);
        const S wanted = max(c.least_placed, c.placed - left * p.inverse_response);
        const S change = wanted - c.placed;
        c.placed = wanted;
        if (change == S(0)) continue;
        normal.push(p.row, change);
        largest = max(largest, abs(change) * p.response);
      }
      normal.finish();
      pair.store(m, bodies, motion_of);
    }
    return largest;
  }

  /// Writes the impulses back to the constraints: friction is spread over the points in proportion
  /// to their normal impulses, so that its force and its torsion stay what they are.
  void store(const Island& island, Constraints<S>& constraints) const {
    for (const Manifold& m : manifolds_) {
      S sum = S(0);
      Vec3<S> center = Vec3<S>::Zero();
      for (std::uint32_t k = m.first; k < m.first + m.count; ++k) {
        sum += points_[k].impulse;
        center += points_[k].impulse * constraints.contacts[island.contacts[k]].arm_a;
      }
      if (!(sum > S(0))) {
        for (std::uint32_t k = m.first; k < m.first + m.count; ++k) {
          constraints.contacts[island.contacts[k]].impulse = {};
        }
        continue;
      }
      center /= sum;
      S moment = S(0);
      S farthest2 = S(0);
      for (std::uint32_t k = m.first; k < m.first + m.count; ++k) {
        const S r2 = (constraints.contacts[island.contacts[k]].arm_a - center).squaredNorm();
        moment += points_[k].impulse * r2;
        farthest2 = std::max(farthest2, r2);
      }
      // No point may carry more than its own friction, whatever torsion was found for others.
      using std::abs;
      using std::copysign;
      using std::min;
      using std::sqrt;
      const S twist =
          moment > S(0)
              ? copysign(min(abs(m.torsion / moment), m.friction / sqrt(farthest2)), m.torsion)
              : S(0);
      for (std::uint32_t k = m.first; k < m.first + m.count; ++k) {
        ContactConstraint<S>& c = constraints.contacts[island.contacts[k]];
        const S share = points_[k].impulse / sum;
        const Vec3<S> couple = (twist * points_[k].impulse) * c.axes[0].cross(c.arm_a - center);
        c.impulse = {points_[k].impulse, share * m.friction_impulse[0] + couple.dot(c.axes[1]),
                     share * m.friction_impulse[1] + couple.dot(c.axes[2])};
      }
    }
  }

 private:
  // Three numbers and a zero: what two or four lanes of a vector unit take at once.
  using Lanes = Eigen::Matrix<S, 4, 1, Eigen::DontAlign>;

  /// A direction, and what a unit impulse along it does to the two velocities.
  struct Direction {
    Lanes axis;
    Lanes move_a, move_b;
  };
  /// The same about the centres of mass: r x d of each body, and the turn that it makes.
  struct Row {
    Lanes arm_a, arm_b;
    Lanes turn_a, turn_b;
  };
  struct Point {
    Row row;
    S response = S(0);
    S inverse_response = S(0);
    S target = S(0);
    S impulse = S(0);
    S radius = S(0);  // Distance from the centre of pressure: the arm of torsion.
  };
  struct Manifold {
    std::uint32_t a = 0;
    std::uint32_t b = 0;
    std::uint32_t first = 0;
    std::uint32_t count = 0;
    Direction normal, t1, t2;
    Row row1, row2;        // Of the tangents, at the centre of pressure.
    Lanes turn_a, turn_b;  // What a unit of torsion does.
    Vec3<S> center;        // The centre of pressure, from a's centre of mass.
    S friction = S(0);
    S radius = S(0);  // The largest of its points.
    ContactResponse<S> response;
    S linear_response = S(0);  // To an impulse along the normal, of the centres of mass.
    S torsion_response = S(0);
    S inverse_torsion_response = S(0);
    std::array<S, 2> friction_impulse{};
    S torsion = S(0);
  };

  [[nodiscard]] static Lanes lanes(const Vec3<S>& v) { return {v.x(), v.y(), v.z(), S(0)}; }

  /// Velocities of a manifold's two bodies, held while its rows are solved.
  struct Pair {
    template <typename Of>
    Pair(const Manifold& m, std::span<SolverBody<S>> bodies, Of&& of)
        : linear_a(lanes(of(bodies[m.a]).linear)),
          linear_b(lanes(of(bodies[m.b]).linear)),
          angular_a(lanes(of(bodies[m.a]).angular)),
          angular_b(lanes(of(bodies[m.b]).angular)) {}
    template <typename Of>
    void store(const Manifold& m, std::span<SolverBody<S>> bodies, Of&& of) const {
      of(bodies[m.a]) = {linear_a.template head<3>(), angular_a.template head<3>()};
      of(bodies[m.b]) = {linear_b.template head<3>(), angular_b.template head<3>()};
    }
    [[nodiscard]] S velocity(const Direction& d, const Row& row) const {
      const Lanes sum = d.axis.cwiseProduct(linear_b - linear_a) +
                        row.arm_b.cwiseProduct(angular_b) - row.arm_a.cwiseProduct(angular_a);
      return (sum[0] + sum[1]) + sum[2];
    }
    [[nodiscard]] S spin(const Direction& d) const { return d.axis.dot(angular_b - angular_a); }
    void push(const Direction& d, const Row& row, S x) {
      linear_a -= x * d.move_a;
      linear_b += x * d.move_b;
      angular_a -= x * row.turn_a;
      angular_b += x * row.turn_b;
    }
    void twist(const Manifold& m, S x) {
      angular_a -= x * m.turn_a;
      angular_b += x * m.turn_b;
    }
    Lanes linear_a, linear_b, angular_a, angular_b;
  };

  /// The normal impulses of a manifold's points, which have one direction: what they do to linear
  /// velocities is one number while they are solved.
  struct NormalPart {
    NormalPart(const Manifold& m, Pair& bodies)
        : manifold(m), pair(bodies), linear(m.normal.axis.dot(bodies.linear_b - bodies.linear_a)) {}
    [[nodiscard]] S velocity(const Row& row) const {
      const Lanes sum =
          row.arm_b.cwiseProduct(pair.angular_b) - row.arm_a.cwiseProduct(pair.angular_a);
      return linear + ((sum[0] + sum[1]) + sum[2]);
    }
    void push(const Row& row, S x) {
      linear += x * manifold.linear_response;
      total += x;
      pair.angular_a -= x * row.turn_a;
      pair.angular_b += x * row.turn_b;
    }
    void finish() {
      pair.linear_a -= total * manifold.normal.move_a;
      pair.linear_b += total * manifold.normal.move_b;
    }
    const Manifold& manifold;
    Pair& pair;
    S linear;
    S total = S(0);
  };

  [[nodiscard]] static Direction direction(const Vec3<S>& d, const SolverBody<S>& a,
                                           const SolverBody<S>& b) {
    return {lanes(d), lanes(a.inverse_mass.cwiseProduct(d)), lanes(b.inverse_mass.cwiseProduct(d))};
  }
  [[nodiscard]] static Row row(const Vec3<S>& d, const Vec3<S>& arm_a, const Vec3<S>& arm_b,
                               const SolverBody<S>& a, const SolverBody<S>& b) {
    const Vec3<S> torque_a = arm_a.cross(d);
    const Vec3<S> torque_b = arm_b.cross(d);
    return {lanes(torque_a), lanes(torque_b), lanes(product<S>(a.inverse_inertia, torque_a)),
            lanes(product<S>(b.inverse_inertia, torque_b))};
  }
  /// Velocity along one direction for a unit impulse along another.
  [[nodiscard]] static S response(const Direction& d, const Row& at, const Direction& e,
                                  const Row& other) {
    return d.axis.dot(e.move_a + e.move_b) + at.arm_a.dot(other.turn_a) +
           at.arm_b.dot(other.turn_b);
  }

  void add_manifold(std::span<const std::uint32_t> contacts, const Constraints<S>& constraints,
                    std::span<const SolverBody<S>> bodies) {
    using std::sqrt;
    const ContactConstraint<S>& one = constraints.contacts[contacts[0]];
    const SolverBody<S>& a = bodies[one.body_a];
    const SolverBody<S>& b = bodies[one.body_b];
    Manifold& m = manifolds_.emplace_back();
    m.a = one.body_a;
    m.b = one.body_b;
    m.first = static_cast<std::uint32_t>(points_.size());
    m.count = static_cast<std::uint32_t>(contacts.size());
    m.normal = direction(one.axes[0], a, b);
    m.t1 = direction(one.axes[1], a, b);
    m.t2 = direction(one.axes[2], a, b);
    m.friction = one.friction;

    // The centre of pressure of the last step; of points that carried nothing, their middle.
    S sum = S(0);
    for (const std::uint32_t i : contacts) sum += constraints.contacts[i].impulse[0];
    const S even = S(1) / S(contacts.size());
    m.center.setZero();
    Vec3<S> center_b = Vec3<S>::Zero();
    for (const std::uint32_t i : contacts) {
      const ContactConstraint<S>& c = constraints.contacts[i];
      const S weight = sum > S(0) ? c.impulse[0] / sum : even;
      m.center += weight * c.arm_a;
      center_b += weight * c.arm_b;
    }
    m.row1 = row(one.axes[1], m.center, center_b, a, b);
    m.row2 = row(one.axes[2], m.center, center_b, a, b);
    m.response.a = response(m.t1, m.row1, m.t1, m.row1);
    m.response.b = response(m.t1, m.row1, m.t2, m.row2);
    m.response.c = response(m.t2, m.row2, m.t2, m.row2);
    m.response.prepare();
    m.turn_a = lanes(product<S>(a.inverse_inertia, one.axes[0]));
    m.turn_b = lanes(product<S>(b.inverse_inertia, one.axes[0]));
    m.linear_response = m.normal.axis.dot(m.normal.move_a + m.normal.move_b);
    m.torsion_response = m.normal.axis.dot(m.turn_a + m.turn_b);
    m.inverse_torsion_response = m.torsion_response > S(0) ? S(1) / m.torsion_response : S(0);

    for (const std::uint32_t i : contacts) {
      const ContactConstraint<S>& c = constraints.contacts[i];
      Point& p = points_.emplace_back();
      p.row = row(c.axes[0], c.arm_a, c.arm_b, a, b);
      p.response = response(m.normal, p.row, m.normal, p.row);
      p.inverse_response = p.response > S(0) ? S(1) / p.response : S(0);
      p.target = c.target;
      p.impulse = c.impulse[0];
      const Vec3<S> r = c.arm_a - m.center;
      p.radius = r.norm();
      m.radius = std::max(m.radius, p.radius);
      m.friction_impulse[0] += c.impulse[1];
      m.friction_impulse[1] += c.impulse[2];
      const Vec3<S> friction = c.impulse[1] * c.axes[1] + c.impulse[2] * c.axes[2];
      m.torsion += c.axes[0].dot(r.cross(friction));
    }
  }

  S sweep(Manifold& m, std::span<SolverBody<S>> bodies) {
    using std::abs;
    using std::max;
    using std::min;
    Pair pair(m, bodies, velocity_of);
    NormalPart normal(m, pair);
    S largest = S(0);
    S sum = S(0);
    S moment = S(0);
    for (std::uint32_t k = m.first; k < m.first + m.count; ++k) {
      Point& p = points_[k];
      const S wanted =
          max(S(0), p.impulse + (p.target - normal.velocity(p.row)) * p.inverse_response);
      const S change = wanted - p.impulse;
      p.impulse = wanted;
      sum += wanted;
      moment += wanted * p.radius;
      normal.push(p.row, change);
      largest = max(largest, abs(change) * p.response);
    }
    normal.finish();
    if (sum > S(0) || m.friction_impulse[0] != S(0) || m.friction_impulse[1] != S(0)) {
      largest = max(largest, rub(m, m.friction * sum, m.friction * moment, pair));
    }
    pair.store(m, bodies, velocity_of);
    return largest;
  }

  /// Friction of a manifold: force and torsion together within an ellipsoid, whose axes are the
  /// force `most` alone and the torsion `most_torsion` alone.
  static S rub(Manifold& m, S most, S most_torsion, Pair& pair) {
    using std::abs;
    using std::max;
    using std::sqrt;
    const std::array<S, 2> before = m.friction_impulse;
    const S before_torsion = m.torsion;
    S torsion = m.torsion - pair.spin(m.normal) * m.inverse_torsion_response;
    detail::solve_friction(m.response, pair.velocity(m.t1, m.row1), pair.velocity(m.t2, m.row2),
                           most, m.friction_impulse[0], m.friction_impulse[1]);
    const S force = most > S(0) ? (m.friction_impulse[0] * m.friction_impulse[0] +
                                   m.friction_impulse[1] * m.friction_impulse[1]) /
                                      (most * most)
                                : S(0);
    const S turn = most_torsion > S(0) ? torsion / most_torsion : S(0);
    if (!(most_torsion > S(0))) torsion = S(0);
    const S size2 = force + turn * turn;
    if (size2 > S(1)) {
      const S shrink = S(1) / sqrt(size2);
      torsion *= shrink;
      m.friction_impulse[0] *= shrink;
      m.friction_impulse[1] *= shrink;
    }
    m.torsion = torsion;
    const S twist = torsion - before_torsion;
    const S x1 = m.friction_impulse[0] - before[0];
    const S x2 = m.friction_impulse[1] - before[1];
    pair.twist(m, twist);
    pair.push(m.t1, m.row1, x1);
    pair.push(m.t2, m.row2, x2);
    return max(max(abs(x1), abs(x2)) * m.response.largest,
               abs(twist) * m.torsion_response * m.radius);
  }

  std::vector<Manifold> manifolds_;
  std::vector<Point> points_;
};

}  // namespace bristle
