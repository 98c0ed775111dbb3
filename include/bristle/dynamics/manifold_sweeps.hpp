/// @file
/// Sweeps over contacts by manifold: the fast path of large islands.
///
/// All points of a manifold keep their own normal impulse but share one friction: two tangents at
/// the centre of pressure and a torsion about the normal, bounded by what the normal impulses
/// allow. What it gives up is friction that differs from point to point within one patch, which
/// rigid bodies leave undetermined anyway. Manifolds without a moving body in common are solved
/// side by side, in lanes (`ManifoldBlock`), with the results of one after the other.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/contact_aim.hpp>
#include <bristle/dynamics/manifold_block.hpp>
#include <bristle/dynamics/manifold_mobility.hpp>
#include <bristle/dynamics/manifold_order.hpp>
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
  /// contacts and takes over the impulses they have. Free motion is the mean of the velocities at
  /// both ends (`mean_free_motion`), whatever `SolverBody::free_motion` says.
  void aim(const Island& island, Constraints<S>& constraints, std::span<const SolverBody<S>> bodies,
           const SolveContext<S>& context);

  /// Reads the bodies' velocities, or their displacements. All that follows works on what was read.
  template <typename Of>
  void load(std::span<const SolverBody<S>> bodies, Of&& of) {
    velocities_.resize(slots_.size() + 1);
    for (std::size_t k = 0; k < slots_.size(); ++k) velocities_.set(k + 1, of(bodies[slots_[k]]));
  }
  /// Writes back those of the bodies that are moved.
  template <typename Of>
  void unload(std::span<SolverBody<S>> bodies, Of&& of) const {
    for (std::size_t k = 0; k < slots_.size(); ++k) {
      SolverBody<S>& body = bodies[slots_[k]];
      if (body.moves) of(body) = velocities_[k + 1];
    }
  }

  /// Adds what all impulses do to the velocities.
  void apply() {
    for (Block& block : blocks_) Kernel(block, points_).apply(velocities_);
  }
  /// One sweep over all contacts, there or back.
  /// @return [m/s] Largest velocity change.
  S sweep(bool backwards) {
    return for_each_block(backwards, [this](Kernel block) { return block.solve(velocities_); });
  }

  /// Shares of the impulses by default and for bounces (`place_contact`), which `store` must have
  /// written back.
  void place_contacts(const Island& island, Constraints<S>& constraints,
                      std::span<const SolverBody<S>> bodies, Integrator integrator) {
    if (!bounces_) {
      for (const std::uint32_t i : island.contacts) {
        place_contact(constraints.contacts[i], S(0), integrator);
      }
      return;
    }
    for_each_speed(island, constraints, bodies, velocity_of,
                   [&](ContactConstraint<S>& c, S speed) { place_contact(c, speed, integrator); });
  }

  /// Whether any contact may bounce.
  [[nodiscard]] bool bounces() const { return bounces_; }

  /// Ends a part of the step that another one follows: gaps follow its motion, and impacts leave
  /// nothing to the next part, as they say nothing about the load that follows.
  void move_on(const Island& island, Constraints<S>& constraints,
               std::span<const SolverBody<S>> bodies, S dt) {
    for_each_speed(island, constraints, bodies, motion_of, [&](ContactConstraint<S>& c, S speed) {
      c.gap += dt * speed;
      if (c.is_impact) c.impulse = {};
    });
  }

  /// Takes over the shares of the impulses that the contacts have, for sweeps of the position
  /// problem. The contacts never learn what becomes of them: only the displacements count.
  void start_placing(const Island& island, const Constraints<S>& constraints, S dt);
  /// One sweep of the position problem.
  S place(bool backwards) {
    return for_each_block(backwards, [this](Kernel block) { return block.place(velocities_); });
  }

  /// Writes the impulses back to the constraints: friction is spread over the points in proportion
  /// to their normal impulses, so that its force and its torsion stay what they are.
  /// @param totals  [N s] By contact of the island: are added to.
  void store(const Island& island, Constraints<S>& constraints,
             std::span<std::array<S, 3>> totals) const;

 private:
  using Kernel = ManifoldKernel<S>;
  using Block = ManifoldBlock<S>;
  using Points = ManifoldPoints<S>;
  using Row = typename Block::Row;

  template <typename Turn>
  S for_each_block(bool backwards, Turn&& turn) {
    Pack<S> largest = S(0);
    const std::size_t count = blocks_.size();
    for (std::size_t k = 0; k < count; ++k) {
      largest = max(turn(Kernel(blocks_[backwards ? count - 1 - k : k], points_)), largest);
    }
    return max_of_lanes(largest);
  }

  /// Calls use(contact of the island, rows of its point, lane) for all points of a block, or of
  /// all.
  template <typename Use>
  static void for_each_point(const Block& block, Use&& use) {
    for (std::size_t lane = 0; lane < block.used; ++lane) {
      for (std::uint32_t k = 0; k < block.contacts[lane]; ++k) {
        use(block.first_contact[lane] + k, block.first_point + k, lane);
      }
    }
  }
  template <typename Use>
  void for_each_point(Use&& use) const {
    for (const Block& block : blocks_) for_each_point(block, use);
  }
  /// Normal velocities at all points.
  template <typename Of>
  void find_speeds(std::span<const SolverBody<S>> bodies, Of&& of, std::vector<Row>& speeds) {
    load(bodies, of);
    speeds.resize(points_.size());
    for (Block& block : blocks_) Kernel(block, points_).write_speeds(velocities_, speeds);
  }
  /// Calls use(contact, normal velocity) for all contacts.
  template <typename Of, typename Use>
  void for_each_speed(const Island& island, Constraints<S>& constraints,
                      std::span<const SolverBody<S>> bodies, Of&& of, Use&& use) {
    find_speeds(bodies, of, speeds_);
    for_each_point([&](std::uint32_t contact, std::uint32_t point, std::size_t lane) {
      use(constraints.contacts[island.contacts[contact]], speeds_[point][lane]);
    });
  }

  void find_manifolds(const Island& island, const Constraints<S>& constraints,
                      std::span<const SolverBody<S>> bodies);
  void add_manifold(const ManifoldSpan& manifold, const Island& island,
                    const Constraints<S>& constraints, std::span<const SolverBody<S>> bodies);
  void add_side(typename Block::Side& side, std::size_t lane, std::uint32_t slot,
                const SolverBody<S>& body, const Vec3<S>& arm);
  void store(const Block& block, std::size_t lane, const Island& island,
             Constraints<S>& constraints, std::span<std::array<S, 3>> totals) const;

  std::vector<ManifoldSpan> manifolds_;
  ManifoldOrder order_;
  std::vector<Block> blocks_;
  std::vector<Points> points_;

  // Bodies have places in the table from 1 on. What nothing moves is written to place 0.
  std::vector<std::uint32_t> slots_;  // By place less 1.
  std::vector<std::uint32_t> place_;  // By slot; 0 where it has none.
  VelocityTable<S> velocities_;
  bool bounces_ = false;
  std::vector<Row> speeds_, free_speeds_;
};

// Implementation -----------------------------------------------------------------------------------

template <Scalar S>
void ManifoldSweeps<S>::start(const Island& island, const Constraints<S>& constraints,
                              std::span<const SolverBody<S>> bodies) {
  for (const std::uint32_t slot : slots_) place_[slot] = 0;
  slots_.clear();
  place_.resize(std::max(place_.size(), bodies.size()), 0);
  blocks_.clear();
  points_.clear();
  find_manifolds(island, constraints, bodies);
  order_.build(manifolds_, bodies.size());
  std::uint32_t round = 0;
  for (const ManifoldOrder::Place& place : order_.places()) {
    if (blocks_.empty() || blocks_.back().used == lanes<S> || place.round != round) {
      Block& block = blocks_.emplace_back();
      block.first_point = static_cast<std::uint32_t>(points_.size());
      block.inverse_determinant.fill(S(1));
      // Its first manifold has the most.
      block.points = place.count;
      points_.resize(points_.size() + place.count);
      round = place.round;
    }
    add_manifold(manifolds_[place.manifold], island, constraints, bodies);
  }
}

template <Scalar S>
void ManifoldSweeps<S>::find_manifolds(const Island& island, const Constraints<S>& constraints,
                                       std::span<const SolverBody<S>> bodies) {
  manifolds_.clear();
  bounces_ = false;
  for (std::uint32_t k = 0; k < island.contacts.size(); ++k) {
    const std::uint32_t i = island.contacts[k];
    const ContactConstraint<S>& c = constraints.contacts[i];
    bounces_ = bounces_ || c.restitution > S(0);
    if (k > 0 && island.contacts[k - 1] + 1 == i &&
        are_of_one_manifold(constraints.contacts[i - 1], c)) {
      ++manifolds_.back().count;
    } else {
      manifolds_.push_back(
          {k, 1, c.body_a, c.body_b, bodies[c.body_a].moves, bodies[c.body_b].moves});
    }
  }
}

template <Scalar S>
void ManifoldSweeps<S>::add_side(typename Block::Side& side, std::size_t lane, std::uint32_t slot,
                                 const SolverBody<S>& body, const Vec3<S>& arm) {
  if (place_[slot] == 0) {
    slots_.push_back(slot);
    place_[slot] = static_cast<std::uint32_t>(slots_.size());
  }
  side.from[lane] = VelocityTable<S>::stride * place_[slot];
  side.to[lane] = body.moves ? side.from[lane] : 0;
  side.arm.set(lane, arm);
  if (!body.moves) return;
  side.inverse_mass.set(lane, body.inverse_mass);
  const Mat3<S>& I = body.inverse_inertia;
  const S upper[] = {I(0, 0), I(0, 1), I(0, 2), I(1, 1), I(1, 2), I(2, 2)};
  for (std::size_t i = 0; i < 6; ++i) side.inverse_inertia[i][lane] = upper[i];
  side.is_isotropic = side.is_isotropic && body.is_isotropic;
}

template <Scalar S>
void ManifoldSweeps<S>::add_manifold(const ManifoldSpan& manifold, const Island& island,
                                     const Constraints<S>& constraints,
                                     std::span<const SolverBody<S>> bodies) {
  using std::max;
  using std::sqrt;
  Block& block = blocks_.back();
  const std::size_t lane = block.used++;
  const auto contact = [&](std::uint32_t k) -> const ContactConstraint<S>& {
    return constraints.contacts[island.contacts[manifold.first + k]];
  };
  const ContactConstraint<S>& one = contact(0);
  block.first_contact[lane] = manifold.first;
  block.contacts[lane] = manifold.count;
  block.friction[lane] = one.friction;

  // The centre of pressure of the last step; of points that carried nothing, their middle.
  S sum = S(0);
  for (std::uint32_t k = 0; k < manifold.count; ++k) sum += contact(k).impulse[0];
  const S even = S(1) / S(manifold.count);
  Vec3<S> arm_a = Vec3<S>::Zero();
  Vec3<S> arm_b = Vec3<S>::Zero();
  for (std::uint32_t k = 0; k < manifold.count; ++k) {
    const ContactConstraint<S>& c = contact(k);
    const S weight = sum > S(0) ? c.impulse[0] / sum : even;
    arm_a += weight * c.arm_a;
    arm_b += weight * c.arm_b;
  }
  const SolverBody<S>& a = bodies[manifold.body_a];
  const SolverBody<S>& b = bodies[manifold.body_b];
  add_side(block.a, lane, manifold.body_a, a, arm_a);
  add_side(block.b, lane, manifold.body_b, b, arm_b);
  block.follows_joints[lane] = a.follows_joints || b.follows_joints;
  block.normal.set(lane, one.axes[0]);
  block.tangent1.set(lane, one.axes[1]);
  block.tangent2.set(lane, one.axes[2]);

  ManifoldMobility<S> w(one, a, b, arm_a, arm_b);
  ContactResponse<S>& K = w.linear;
  K.prepare();
  block.response_a[lane] = K.a;
  block.response_b[lane] = K.b;
  block.response_c[lane] = K.c;
  block.inverse_determinant[lane] = K.inverse_determinant;
  block.largest_response[lane] = K.largest;
  block.inverse_largest[lane] = K.inverse_largest;
  const S spin = w.angular(0, 0);
  block.torsion_response[lane] = spin;
  block.inverse_torsion_response[lane] = spin > S(0) ? S(1) / spin : S(0);
  const S across[3][3] = {{K.n1, w.turn(1, 1), w.turn(2, 1)},
                          {K.n2, w.turn(1, 2), w.turn(2, 2)},
                          {w.turn(0, 0), w.angular(0, 1), w.angular(0, 2)}};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) block.across[i][j][lane] = across[i][j];
  }

  for (std::uint32_t k = 0; k < manifold.count; ++k) {
    Points& p = points_[block.first_point + k];
    S e1 = S(0);
    S e2 = S(0);
    // A single point is the centre of pressure, and has no lever about it.
    if (manifold.count > 1) {
      const Vec3<S> from_center = contact(k).arm_a - arm_a;
      e1 = from_center.dot(one.axes[2]);
      e2 = -from_center.dot(one.axes[1]);
      p.radius[lane] = sqrt(e1 * e1 + e2 * e2);
      block.radius[lane] = max(block.radius[lane], p.radius[lane]);
    }
    p.e1[lane] = e1;
    p.e2[lane] = e2;
    const S turn1 = w.turn(1, 0) + e1 * w.angular(1, 1) + e2 * w.angular(1, 2);
    const S turn2 = w.turn(2, 0) + e1 * w.angular(2, 1) + e2 * w.angular(2, 2);
    const S linear = K.nn + e1 * w.turn(1, 0) + e2 * w.turn(2, 0);
    const S response = linear + e1 * turn1 + e2 * turn2;
    for (std::uint32_t i = k - k % point_group; i < k; ++i) {
      const Points& o = points_[block.first_point + i];
      p.coupling[i % point_group][lane] = o.linear[lane] + e1 * o.turn1[lane] + e2 * o.turn2[lane];
    }
    p.turn1[lane] = turn1;
    p.turn2[lane] = turn2;
    p.linear[lane] = linear;
    p.response[lane] = response;
    p.inverse_response[lane] = response > S(0) ? S(1) / response : S(0);
  }
}

template <Scalar S>
void ManifoldSweeps<S>::aim(const Island& island, Constraints<S>& constraints,
                            std::span<const SolverBody<S>> bodies, const SolveContext<S>& context) {
  const auto start = [](const SolverBody<S>& body) -> const Twist<S>& { return body.start; };
  const auto free = [](const SolverBody<S>& body) -> const Twist<S>& { return body.free; };
  find_speeds(bodies, start, speeds_);
  find_speeds(bodies, free, free_speeds_);
  for (Block& block : blocks_) {
    block.friction_impulse1 = block.friction_impulse2 = block.torsion = {};
    for_each_point(block, [&](std::uint32_t contact, std::uint32_t point, std::size_t lane) {
      ContactConstraint<S>& c = constraints.contacts[island.contacts[contact]];
      const S start_speed = speeds_[point][lane];
      const S free_speed = free_speeds_[point][lane];
      aim_contact<S>(c,
                     {start_speed, free_speed,
                      mean_free_motion<S>(start_speed, free_speed, context.integrator)},
                     block.follows_joints[lane], context);
      Points& p = points_[point];
      p.target[lane] = c.target;
      p.impulse[lane] = c.impulse[0];
      block.friction_impulse1[lane] += c.impulse[1];
      block.friction_impulse2[lane] += c.impulse[2];
      block.torsion[lane] -= p.e1[lane] * c.impulse[1] + p.e2[lane] * c.impulse[2];
    });
  }
}

template <Scalar S>
void ManifoldSweeps<S>::start_placing(const Island& island, const Constraints<S>& constraints,
                                      S dt) {
  const S per_step = S(1) / dt;
  for_each_point([&](std::uint32_t contact, std::uint32_t point, std::size_t lane) {
    const ContactConstraint<S>& c = constraints.contacts[island.contacts[contact]];
    Points& p = points_[point];
    p.placing_target[lane] = -c.gap * per_step;
    p.placed[lane] = c.placed;
    p.least_placed[lane] = c.parts ? c.placed : c.least_placed;
    p.inverse_placing[lane] = c.parts ? S(0) : p.inverse_response[lane];
  });
}

template <Scalar S>
void ManifoldSweeps<S>::store(const Island& island, Constraints<S>& constraints,
                              std::span<std::array<S, 3>> totals) const {
  for (const Block& block : blocks_) {
    for (std::size_t lane = 0; lane < block.used; ++lane) {
      store(block, lane, island, constraints, totals);
    }
  }
}
template <Scalar S>
void ManifoldSweeps<S>::store(const Block& block, std::size_t lane, const Island& island,
                              Constraints<S>& constraints,
                              std::span<std::array<S, 3>> totals) const {
  using std::abs;
  using std::copysign;
  using std::max;
  using std::min;
  using std::sqrt;
  const auto points = std::span(points_).subspan(block.first_point, block.contacts[lane]);
  const S friction1 = block.friction_impulse1[lane];
  const S friction2 = block.friction_impulse2[lane];
  S sum = S(0);
  S e1 = S(0);
  S e2 = S(0);
  for (const Points& p : points) {
    sum += p.impulse[lane];
    e1 += p.impulse[lane] * p.e1[lane];
    e2 += p.impulse[lane] * p.e2[lane];
  }
  const S per_load = sum > S(0) ? S(1) / sum : S(0);
  e1 *= per_load;
  e2 *= per_load;
  // The force now acts at the centre of these impulses; what it did about the former one becomes
  // torsion.
  const S torsion = block.torsion[lane] + e1 * friction1 + e2 * friction2;
  S moment = S(0);
  S farthest2 = S(0);
  for (const Points& p : points) {
    const S r1 = p.e1[lane] - e1;
    const S r2 = p.e2[lane] - e2;
    moment += p.impulse[lane] * (r1 * r1 + r2 * r2);
    farthest2 = max(farthest2, r1 * r1 + r2 * r2);
  }
  // No point may carry more than its own friction, whatever torsion was found for others.
  const S twist =
      moment > S(0)
          ? copysign(min(abs(torsion / moment), block.friction[lane] / sqrt(farthest2)), torsion)
          : S(0);
  for (std::uint32_t k = 0; k < points.size(); ++k) {
    const Points& p = points[k];
    const S load = p.impulse[lane];
    const S share = load * per_load;
    const S turn = twist * load;
    const std::size_t contact = block.first_contact[lane] + k;
    const std::array<S, 3> impulse = {load, share * friction1 - turn * (p.e1[lane] - e1),
                                      share * friction2 - turn * (p.e2[lane] - e2)};
    constraints.contacts[island.contacts[contact]].impulse = impulse;
    for (std::size_t i = 0; i < 3; ++i) totals[contact][i] += impulse[i];
  }
}

}  // namespace bristle
