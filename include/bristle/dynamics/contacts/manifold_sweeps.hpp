/// @file
/// Sweeps over contacts by manifold: the fast path of large islands.
///
/// All points of a manifold keep their own normal impulse but share one friction. That is two
/// tangents at the centre of pressure and a torsion about the normal. The normal impulses bound it.
/// Friction that differs within one patch is given up. Rigid bodies leave it undetermined anyway.
/// Manifolds without a common moving body are solved side by side. They are lanes
/// (`ManifoldKernel`). A sweep has the results of one after the other.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/error.hpp>
#include <bristle/dynamics/contacts/manifold_block.hpp>
#include <bristle/dynamics/contacts/manifold_kernel.hpp>
#include <bristle/dynamics/contacts/manifold_mobility.hpp>
#include <bristle/dynamics/contacts/manifold_order.hpp>
#include <bristle/dynamics/contacts/manifold_part.hpp>
#include <bristle/dynamics/contacts/sweep_extrapolation.hpp>
#include <bristle/dynamics/dynamics_constants.hpp>
#include <bristle/dynamics/solver/solver_types.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// Unknowns of sweeps: velocities from impulses, or displacements from position impulses.
enum class SweptProblem { velocities, positions };

/// The sweeps with their scratch memory. One object serves many islands in turn.
template <Scalar S>
class ManifoldSweeps {
 public:
  /// Sets up an island's manifolds. Contacts of one manifold follow each other.
  /// @param substeps  [-] Parts of the step, among which the impulses of the contacts are divided.
  void start(const Island& island, const Constraints<S>& constraints,
             std::span<const SolverBody<S>> bodies, S substeps);

  /// Returns whether most contacts are new. New ones have no warm start.
  [[nodiscard]] bool is_cold() const { return is_cold_; }
  /// Returns whether a contact has a bound: movers may crush the island (`limit_crushing`).
  [[nodiscard]] bool may_be_crushed() const { return may_be_crushed_; }

  /// Starts a substep; arms, axes and masses stay those of `start`. It sets the velocity targets of
  /// the contacts and keeps their impulses. It reads the velocities of free motion. Free motion is
  /// the mean of the velocities at both ends (`mean_free_velocity`). It ignores
  /// `SolverBody::mean_free`.
  void target(std::span<const SolverBody<S>> bodies, const SolveContext<S>& context) {
    const auto start = [](const SolverBody<S>& body) { return body.kept_start(); };
    const auto free = [](const SolverBody<S>& body) -> const Twist<S>& { return body.free; };
    read(bodies, start, starts_);
    load(bodies, free);
    for_each_block([&](Part part) { part.target(starts_, velocities_, context); });
  }

  /// Reads the bodies' velocities, or their displacements. The calls that follow use them.
  template <typename Of>
  void load(std::span<const SolverBody<S>> bodies, Of&& of) {
    read(bodies, of, velocities_);
  }
  /// Writes the velocities of movable bodies back.
  template <typename Of>
  void unload(std::span<SolverBody<S>> bodies, Of&& of) const {
    for (std::size_t k = 0; k < slots_.size(); ++k) {
      SolverBody<S>& body = bodies[slots_[k]];
      if (body.moves) of(body) = velocities_[k + 1];
    }
  }

  /// Adds the effect of all impulses to the velocities.
  void apply() {
    for (Block& block : blocks_) Kernel(block, points_).apply(velocities_);
  }
  /// One sweep over all contacts, there or back.
  /// @return [m/s] Largest velocity change.
  S sweep(bool backwards) {
    return sweep_blocks(backwards, [this](Kernel block) { return block.solve(velocities_); });
  }

  /// Starts to watch pairs of sweeps for `extrapolate`.
  void start_extrapolation(SweptProblem problem) {
    if (!may_extrapolate(problem)) return;
    extrapolation_.start(rows_of_bodies(), [&](auto&& use) { show_impulses(problem, use); });
  }
  /// Goes on as the last pair of sweeps did (`SweepExtrapolation`). At least one sweep has to
  /// follow. Islands in which anything may bounce are left as they are: impacts do not make energy
  /// the least. So are those with joints or sensors, whose rows would have to go on, too, and the
  /// velocities of what movers may crush: they do work on it, and its energy falls far before it is
  /// the least.
  /// @return True if there was something to gain.
  bool extrapolate(SweptProblem problem) {
    return may_extrapolate(problem) &&
           extrapolation_.move_on(
               rows_of_bodies(), [&](auto&& use) { show_residuals(problem, use); },
               [&](auto&& use) { show_impulses(problem, use); });
  }

  /// Ends the sweeps over velocities.
  void spread_friction() {
    for_each_block([](Part part) { part.spread_friction(); });
  }

  /// Starts the position problem. Reads the bodies' displacements and adds those of bounces. Where
  /// surfaces slide fast, it adds those of what positions needed beyond velocities in the last
  /// substep. Elsewhere that mostly closed overlaps, which are closed now.
  void start_positions(std::span<const SolverBody<S>> bodies, const SolveContext<S>& context) {
    if (restitution_) load(bodies, velocity_of);
    const VelocityTable<S>* const velocities = restitution_ ? &velocities_ : nullptr;
    for_each_block([&](Part part) { part.start_positions(velocities, context); });
    load(bodies, motion_of);
    if (context.slides) for_each_block([&](Part part) { part.start_from_excess(velocities_); });
    if (!restitution_) return;
    for_each_block([&](Part part) { part.move_by_restitution(velocities_, context.integrator); });
  }
  /// One sweep of the position problem.
  S place(bool backwards) {
    return sweep_blocks(backwards, [this](Kernel block) { return block.place(velocities_); });
  }

  /// Ends the position problem. Writes what it needed beyond velocities to the constraints.
  void finish_positions(const Island& island, Constraints<S>& constraints) {
    for_each_block([](Part part) { part.keep_excess(); });
    for_each_contact(island, constraints,
                     [substeps = substeps_](ContactConstraint<S>& c, const Points&,
                                            const Contacts& contacts, std::size_t lane) {
                       const S excess = substeps * contacts.position_excess[lane];
                       c.position_excess = has_finite_square(excess) ? excess : S(0);
                     });
  }

  /// Ends a substep that another one follows.
  void move_on(std::span<const SolverBody<S>> bodies, S dt) {
    load(bodies, motion_of);
    for_each_block([&](Part part) { part.move_on(velocities_, dt); });
  }

  /// Clears all impulses.
  void forget() {
    for (Points& p : points_) p.impulse = {};
    for (Contacts& c : contacts_) c.friction1 = c.friction2 = {};
  }

  /// Writes the impulses at the start of a substep to the constraints.
  void write_impulses(const Island& island, Constraints<S>& constraints) const;
  /// Writes the results of contacts to the constraints. These are the impulses of all substeps, and
  /// `is_impact` of the last one.
  void write_back(const Island& island, Constraints<S>& constraints) const;

 private:
  using Kernel = ManifoldKernel<S>;
  using Part = ManifoldPart<S>;
  using Block = ManifoldBlock<S>;
  using Points = ManifoldPoints<S>;
  using Contacts = ManifoldContacts<S>;

  [[nodiscard]] bool may_extrapolate(SweptProblem problem) const {
    return may_extrapolate_ && !(may_be_crushed_ && problem == SweptProblem::velocities);
  }

  template <typename Turn>
  S sweep_blocks(bool backwards, Turn&& turn) {
    Pack<S> largest = S(0);
    const std::size_t count = blocks_.size();
    for (std::size_t k = 0; k < count; ++k) {
      largest = max(turn(Kernel(blocks_[backwards ? count - 1 - k : k], points_)), largest);
    }
    return max_of_lanes(largest);
  }

  template <typename Use>
  void for_each_block(Use&& use) {
    for (Block& block : blocks_) use(Part(block, points_, contacts_));
  }
  /// Velocities of all bodies of the island's contacts.
  [[nodiscard]] std::span<S> rows_of_bodies() { return velocities_.rows(1, slots_.size()); }
  /// Shows the impulses of a problem, and what their velocities lack, to `SweepExtrapolation`.
  template <typename Use>
  void show_impulses(SweptProblem problem, const Use& use);
  template <typename Use>
  void show_residuals(SweptProblem problem, const Use& use);
  /// Reads velocities into a table.
  template <typename Of>
  void read(std::span<const SolverBody<S>> bodies, Of&& of, VelocityTable<S>& table) const {
    table.resize(slots_.size() + 1);
    table.set(0, {});  // Unused lanes read what immovable bodies have left there.
    for (std::size_t k = 0; k < slots_.size(); ++k) table.set(k + 1, of(bodies[slots_[k]]));
  }

  /// Calls use(constraint, points, contacts, lane) for each contact.
  template <typename Use>
  void for_each_contact(const Island& island, Constraints<S>& constraints, Use&& use) const;
  void find_manifolds(const Island& island, const Constraints<S>& constraints,
                      std::span<const SolverBody<S>> bodies);
  void add_manifold(const ManifoldSpan& manifold, const Island& island,
                    const Constraints<S>& constraints, std::span<const SolverBody<S>> bodies);
  void add_side(typename Block::Side& side, std::size_t lane, std::uint32_t slot,
                const SolverBody<S>& body, const Vec3<S>& arm);

  DynamicArray<ManifoldSpan> manifolds_;
  ManifoldOrder order_;
  DynamicArray<Block> blocks_;
  DynamicArray<Points> points_;
  DynamicArray<Contacts> contacts_;  // As many as `points_`.

  // Bodies have places in the table from 1 on. Immovable bodies are written to place 0.
  DynamicArray<std::uint32_t> slots_;  // By place less 1.
  DynamicArray<std::uint32_t> place_;  // By slot; 0 where it has none.
  VelocityTable<S> velocities_, starts_;
  SweepExtrapolation<S> extrapolation_;
  S substeps_ = S(1);
  bool restitution_ = false;
  bool may_extrapolate_ = false;
  bool is_cold_ = false;
  bool may_be_crushed_ = false;
};

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
void ManifoldSweeps<S>::start(const Island& island, const Constraints<S>& constraints,
                              std::span<const SolverBody<S>> bodies, S substeps) {
  substeps_ = substeps;
  for (const std::uint32_t slot : slots_) place_[slot] = 0;
  slots_.clear();
  place_.resize(std::max(place_.size(), bodies.size()), 0);
  blocks_.clear();
  points_.clear();
  contacts_.clear();
  find_manifolds(island, constraints, bodies);
  order_.build(manifolds_, bodies.size());
  std::uint32_t round = 0;
  for (const ManifoldOrder::Place& place : order_.places()) {
    if (blocks_.empty() || blocks_.back().used == lanes<S> || place.round != round) {
      Block& block = blocks_.emplace_back();
      block.first_point = static_cast<std::uint32_t>(points_.size());
      block.inverse_determinant.fill(S(1));
      // Its first manifold has the most points.
      block.points = place.count;
      points_.resize(points_.size() + place.count);
      contacts_.resize(points_.size());
      round = place.round;
    }
    add_manifold(manifolds_[place.manifold], island, constraints, bodies);
  }
  may_extrapolate_ = !restitution_ && island.blocks.empty() && island.soft.empty();
  if (may_extrapolate_) extrapolation_.read_masses(slots_, bodies);
}

template <Scalar S>
void ManifoldSweeps<S>::find_manifolds(const Island& island, const Constraints<S>& constraints,
                                       std::span<const SolverBody<S>> bodies) {
  manifolds_.clear();
  restitution_ = false;
  may_be_crushed_ = false;
  std::size_t fresh = 0;
  for (std::uint32_t k = 0; k < island.contacts.size(); ++k) {
    const std::uint32_t i = island.contacts[k];
    const ContactConstraint<S>& c = constraints.contacts[i];
    restitution_ = restitution_ || c.restitution > S(0);
    may_be_crushed_ = may_be_crushed_ || c.most_impulse < infinity<S>;
    fresh += c.is_fresh ? 1u : 0u;
    // A contact that may bounce is a manifold of its own. The torsion of a manifold is bounded by
    // the distances of its points. One that bounces on a single point has no torsion. Its
    // velocities would then not match the impulses that are kept. With lossless bounces that error
    // grows without bound.
    const bool is_next = k > 0 && island.contacts[k - 1] + 1 == i && !(c.restitution > S(0));
    if (is_next && are_of_one_manifold(constraints.contacts[i - 1], c)) {
      ++manifolds_.back().count;
    } else {
      manifolds_.push_back(
          {k, 1, c.body_a, c.body_b, bodies[c.body_a].moves, bodies[c.body_b].moves});
    }
  }
  is_cold_ = static_cast<double>(fresh) >
             chosen::cold_contact_share * static_cast<double>(island.contacts.size());
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
  block.most_impulse[lane] = one.most_impulse;
  block.drift1[lane] = one.drift[0];
  block.drift2[lane] = one.drift[1];

  // The centre of pressure of the last step. It is the mean of the points if they carried no load.
  S sum = S(0);
  for (std::uint32_t k = 0; k < manifold.count; ++k) sum += contact(k).impulse[0];
  const S even = S(1) / S(manifold.count);
  Vec3<S> arm_a = zero<Vec3<S>>();
  Vec3<S> arm_b = zero<Vec3<S>>();
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
  if (a.follows_joints || b.follows_joints) block.follow_joints |= 1u << lane;
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
    const ContactConstraint<S>& c = contact(k);
    Contacts& state = contacts_[block.first_point + k];
    state.gap[lane] = c.gap;
    state.position_excess[lane] = c.position_excess / substeps_;
    state.restitution[lane] = c.restitution;
    state.friction1[lane] = c.impulse[1] / substeps_;
    state.friction2[lane] = c.impulse[2] / substeps_;
    Points& p = points_[block.first_point + k];
    p.impulse[lane] = c.impulse[0] / substeps_;
    S e1 = S(0);
    S e2 = S(0);
    // A single point is the centre of pressure. It has no lever about it.
    if (manifold.count > 1) {
      const Vec3<S> from_center = c.arm_a - arm_a;
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
template <typename Use>
void ManifoldSweeps<S>::show_impulses(SweptProblem problem, const Use& use) {
  for (Block& block : blocks_) {
    const auto points = std::span(points_).subspan(block.first_point, block.points);
    if (problem == SweptProblem::positions) {
      for (Points& p : points) use(p.position_impulse);
      continue;
    }
    for (Points& p : points) use(p.impulse);
    for (auto* x : {&block.friction_impulse1, &block.friction_impulse2, &block.torsion}) use(*x);
  }
}

template <Scalar S>
template <typename Use>
void ManifoldSweeps<S>::show_residuals(SweptProblem problem, const Use& use) {
  for (Block& block : blocks_) {
    const Kernel kernel(block, points_);
    if (problem == SweptProblem::positions) {
      kernel.show_position_residuals(velocities_, use);
    } else {
      kernel.show_residuals(velocities_, use);
    }
  }
}

template <Scalar S>
template <typename Use>
void ManifoldSweeps<S>::for_each_contact(const Island& island, Constraints<S>& constraints,
                                         Use&& use) const {
  for (const Block& block : blocks_) {
    for (std::size_t lane = 0; lane < block.used; ++lane) {
      for (std::uint32_t k = 0; k < block.contacts[lane]; ++k) {
        const std::uint32_t contact = island.contacts[block.first_contact[lane] + k];
        const std::uint32_t point = block.first_point + k;
        use(constraints.contacts[contact], points_[point], contacts_[point], lane);
      }
    }
  }
}

template <Scalar S>
void ManifoldSweeps<S>::write_impulses(const Island& island, Constraints<S>& constraints) const {
  for_each_contact(
      island, constraints,
      [](ContactConstraint<S>& c, const Points& point, const Contacts& contacts, std::size_t lane) {
        c.impulse = {point.impulse[lane], contacts.friction1[lane], contacts.friction2[lane]};
      });
}

template <Scalar S>
void ManifoldSweeps<S>::write_back(const Island& island, Constraints<S>& constraints) const {
  for_each_contact(
      island, constraints,
      [](ContactConstraint<S>& c, const Points&, const Contacts& contacts, std::size_t lane) {
        for (std::size_t i = 0; i < 3; ++i) c.impulse[i] = contacts.total[i][lane];
        c.is_impact = (contacts.impacts >> lane & 1u) != 0;
      });
}

}  // namespace bristle::inline BRISTLE_ABI::detail
