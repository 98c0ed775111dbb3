/// @file
/// The constraints of one island as rows over its unknown velocities, for `ProximalSolver`.
///
/// A row has a Jacobian J over the two bodies. It has a multiplier, and bounds for the multiplier.
/// Immovable bodies and locked axes have no unknowns. Their known velocity goes into the rows'
/// targets.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/no_index.hpp>
#include <bristle/dynamics/solver/crushing_limit.hpp>
#include <bristle/dynamics/solver/island_order.hpp>
#include <bristle/dynamics/solver/island_row.hpp>
#include <bristle/dynamics/solver/joint_locks.hpp>
#include <bristle/dynamics/solver/solver_types.hpp>
#include <bristle/math/block_cholesky.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// Rows of one island at a time. Keeps its memory.
/// @tparam Real  Scalar of the arithmetic.
template <Scalar S, typename Real>
class IslandRows {
 public:
  /// Starts an island: numbers its unknowns.
  void number(const Island& island, const Constraints<S>& constraints,
              std::span<const SolverBody<S>> bodies) {
    order_.build(island, constraints, bodies.size());
    unknowns_ = 6 * island.bodies.size();
    unknown_.resize(std::max(unknown_.size(), bodies.size()), no_index);
    for (const std::uint32_t slot : island.bodies) {
      unknown_[slot] = 6 * order_.number(slot);
    }
    for (const std::uint32_t slot : last_) {
      if (order_.number(slot) == no_index) unknown_[slot] = no_index;
    }
    last_.assign(island.bodies.begin(), island.bodies.end());
    order_.clear(island);
    rows_.clear();
    can_switch_ = false;
  }

  /// Adds one row for each velocity that a constraint acts on.
  void add_velocity_rows(const Island& island, const Constraints<S>& constraints,
                         std::span<const SolverBody<S>> bodies) {
    const auto velocity = [](const SolverBody<S>& b) -> const Twist<S>& { return b.free; };
    for (const std::uint32_t i : island.contacts) {
      const ContactConstraint<S>& c = constraints.contacts[i];
      for (std::size_t k = 0; k < 3; ++k) {
        Row& row = add(c, k, bodies, velocity);
        row.lambda = Real(c.impulse[k]);
        row.friction = Real(c.friction);
        row.kind = k == 0 ? Kind::cone : Kind::tangent;
        row.upper = Real(c.most_impulse);
        row.bias = Real(k == 0 ? c.target : c.bias[k]);
        row.target += row.bias;
      }
      // One response for all three, so that the cone stays circular.
      Row* last = &rows_.back();
      const Real response = std::max({last[0].response, last[-1].response, last[-2].response});
      last[0].response = last[-1].response = last[-2].response = response;
    }
    contact_rows_ = rows_.size();
    for (const std::uint32_t i : island.blocks) {
      const ConstraintBlock<S>& block = constraints.blocks[i];
      for (std::uint32_t r = block.first; r < block.first + block.count; ++r) {
        Row& row = add(block, constraints.rows[r], bodies, velocity);
        row.lambda = Real(constraints.rows[r].impulse);
        row.target += Real(constraints.rows[r].target);
        if (block.kind != BlockKind::equality) {
          row.kind = Kind::bounded;
          row.compliance = Real(constraints.rows[r].compliance);
          row.lower = Real(block.lower);
          row.upper = Real(block.upper);
        }
      }
    }
    find_switches();
  }

  /// Adds one row for each position that a constraint controls.
  void add_position_rows(const Island& island, const Constraints<S>& constraints,
                         std::span<const SolverBody<S>> bodies, S dt) {
    const auto motion = [](const SolverBody<S>& b) -> const Twist<S>& { return b.motion; };
    for (const std::uint32_t i : island.contacts) {
      const ContactConstraint<S>& c = constraints.contacts[i];
      Row& row = add(c, 0, bodies, motion);
      row.target -= Real(c.gap / dt);
      row.lambda = Real(c.position_impulse);
      row.lower = Real(c.least_position_impulse);
      row.upper = c.is_separating ? row.lambda : infinity<Real>;
      if (c.is_separating) row.lower = row.lambda;
      row.kind = Kind::bounded;
    }
    contact_rows_ = rows_.size();
    for (const std::uint32_t i : island.blocks) {
      const ConstraintBlock<S>& block = constraints.blocks[i];
      for (std::uint32_t r = block.first; r < block.first + corrected_rows(block); ++r) {
        Row& row = add(block, constraints.rows[r], bodies, motion);
        row.target -= Real(constraints.rows[r].error / dt);
        row.lambda = Real(constraints.rows[r].correction);
        if (block.kind == BlockKind::equality) continue;
        row.kind = Kind::bounded;
        row.lower = Real(0);
        row.upper = infinity<Real>;
      }
    }
    find_switches();
  }

  [[nodiscard]] std::size_t unknowns() const { return unknowns_; }
  /// First of a body's six unknowns, or `no_index`.
  [[nodiscard]] std::uint32_t unknown(std::uint32_t slot) const { return unknown_[slot]; }
  /// Blocks of the island's matrix and of its factors.
  [[nodiscard]] const BlockPattern& pattern() const { return order_.pattern(); }
  /// Returns whether any row may change its state. If none may, the problem is linear.
  [[nodiscard]] bool can_switch() const { return can_switch_; }

  /// Returns whether any multiplier has a warm start.
  [[nodiscard]] bool has_impulses() const {
    return std::any_of(rows_.begin(), rows_.end(),
                       [](const Row& row) { return row.lambda != Real(0); });
  }
  /// Returns whether something is crushed (`is_crushing`) by the impulses from which a solve
  /// starts, or by those that it gives.
  /// @param impulse_of  impulse_of(k) is the impulse that row k gets.
  template <typename ImpulseOf>
  [[nodiscard]] bool is_crushed(const ImpulseOf& impulse_of) const {
    for (std::size_t k = 0; k < rows_.size(); ++k) {
      const Row& row = rows_[k];
      if (row.kind != Kind::cone) continue;
      if (is_crushing<Real>(std::max(row.lambda, impulse_of(k)), row.upper)) return true;
    }
    return false;
  }
  [[nodiscard]] std::span<IslandRow<Real>> rows() { return rows_; }

  /// Writes a body's velocity to the unknowns.
  void put(std::uint32_t slot, const Twist<S>& twist, DynamicArray<Real>& v) const {
    for (std::size_t i = 0; i < 3; ++i) {
      v[unknown_[slot] + i] = Real(twist.linear[static_cast<Eigen::Index>(i)]);
      v[unknown_[slot] + 3 + i] = Real(twist.angular[static_cast<Eigen::Index>(i)]);
    }
  }
  /// Velocity of a body: from its unknowns, or its known one.
  [[nodiscard]] Twist<S> twist(std::uint32_t slot, const DynamicArray<Real>& v,
                               std::span<const SolverBody<S>> bodies) const {
    if (unknown_[slot] == no_index) return bodies[slot].free;
    const Real* u = v.data() + unknown_[slot];
    return {{S(u[0]), S(u[1]), S(u[2])}, {S(u[3]), S(u[4]), S(u[5])}};
  }

  /// Adds J^T J / (eps K) of the joints alone.
  void add_joints(Real eps, BlockCholesky<Real>& h) const {
    for (const Row& row : rows_) {
      if (row.kind != Kind::free || !(row.response > Real(0))) continue;
      add_square(h, Real(1) / (eps * row.response), row);
    }
  }
  /// Lists the rows that may need motions which joints lock.
  /// @return True if there are any.
  bool find_lockable(const Island& island, const Constraints<S>& constraints,
                     std::span<const SolverBody<S>> bodies);
  /// Drops those of the listed rows whose response in a factored matrix is at most `share` of their
  /// own response. A contact is dropped with its normal.
  void drop_locked(const BlockCholesky<Real>& factored, Real share, DynamicArray<Real>& scratch) {
    for (const std::size_t i : lockable_) {
      Row& row = rows_[i];
      scratch.assign(unknowns_, Real(0));
      row.add_to(scratch, Real(1));
      // An immovable body has the largest number.
      const std::uint32_t first = std::min(row.a, row.b) / 6;
      if (factored.responds_by(share * row.response, scratch.data(), first)) continue;
      row.response = Real(0);
      if (row.kind == Kind::cone) rows_[i + 1].response = rows_[i + 2].response = Real(0);
    }
  }

  /// Finds the velocities of all rows, relative to their targets, from those of the bodies.
  void evaluate(const DynamicArray<Real>& v) {
    for (Row& row : rows_) row.velocity = row.times(v) - row.target;
  }
  /// Finds the change of row velocities along a step of the bodies' velocities.
  void evaluate_step(const DynamicArray<Real>& step) {
    for (Row& row : rows_) row.change = row.times(step);
  }
  /// Advances row velocities by a share of that step.
  void move(Real s) {
    for (Row& row : rows_) {
      row.velocity += s * row.change;
      row.change = Real(0);
    }
  }

  /// Cancels the opening speed mu |v_t| of cones in sliding contacts.
  void set_shifts() {
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      if (rows_[i].kind != Kind::cone) continue;
      rows_[i].shift =
          rows_[i].friction * planar_length(rows_[i + 1].velocity, rows_[i + 2].velocity);
    }
  }

  /// g -= J^T lambda+.
  void subtract_impulses(Real eps, DynamicArray<Real>& g) const {
    for_each_impulse(eps, Real(0), [&](std::size_t i, Real x) {
      if (x != Real(0)) rows_[i].add_to(g, -x);
    });
  }
  /// lambda+ . J step, at a share s of the way along the step. It is the constraints' part of the
  /// derivative on the line.
  [[nodiscard]] Real work(Real eps, Real s) const {
    Real sum = Real(0);
    for_each_impulse(eps, s, [&](std::size_t i, Real x) { sum += x * rows_[i].change; });
    return sum;
  }
  /// Adds J^T D J, with the derivative D of -lambda+ by J v. Records on which side of their bounds
  /// the rows are.
  void add_hessian(Real eps, BlockCholesky<Real>& h);
  /// Records on which side of their bounds the rows are. Opening speeds do not count.
  void set_sides(Real eps) {
    for (Row& row : rows_) row.shift = Real(0);
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      if (rows_[i].kind != Kind::tangent) rows_[i].side = side_of(i, eps);
    }
  }
  /// Returns whether lambda+ is still the linear function of J v whose slope `add_hessian` took.
  [[nodiscard]] bool is_linear(Real eps) const {
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const Row& row = rows_[i];
      if (!(row.response > Real(0)) || row.kind == Kind::tangent) continue;
      if (row.side == Side::sliding || side_of(i, eps) != row.side) return false;
    }
    return true;
  }
  /// lambda := lambda+.
  void accept(Real eps) {
    for_each_impulse(eps, Real(0), [this](std::size_t i, Real x) { rows_[i].lambda = x; });
  }
  /// [m/s] `distance_from_law` of the present multipliers and velocities.
  [[nodiscard]] Real residual() const {
    return distance_from_law<Real>(
        rows_, [this](std::size_t i) { return rows_[i].lambda; },
        [this](std::size_t i) { return rows_[i].velocity; });
  }
  /// [m/s] The same with the laws of the convex problem: cones whose contacts open at their shifts.
  [[nodiscard]] Real convex_residual() const {
    return distance_from_convex_law<Real>(
        rows_, [this](std::size_t i) { return rows_[i].lambda; },
        [this](std::size_t i) { return rows_[i].velocity; });
  }

  /// Calls use(multiplier, response) for all rows.
  template <typename Use>
  void for_each_load(Use&& use) const {
    for (const Row& row : rows_) use(row.lambda, row.response);
  }

  /// r := Mt v - J^T lambda.
  void remove_impulses(const DynamicArray<Real>& v, DynamicArray<Real>& r,
                       const BlockCholesky<Real>& matrix) const {
    matrix.multiply(v.data(), r.data());
    for (const Row& row : rows_) row.add_to(r, -row.lambda);
  }

  /// Writes the multipliers to the constraints of the velocity rows. Friction stays within its
  /// disk.
  void store_impulses(const Island& island, Constraints<S>& constraints) const {
    std::size_t r = 0;
    for (const std::uint32_t i : island.contacts) {
      ContactConstraint<S>& c = constraints.contacts[i];
      Real x = rows_[r + 1].lambda;
      Real y = rows_[r + 2].lambda;
      shrink(rows_[r].friction * rows_[r].lambda, x, y);
      c.impulse = {S(rows_[r].lambda), S(x), S(y)};
      r += 3;
    }
    for (const std::uint32_t i : island.blocks) {
      const ConstraintBlock<S>& block = constraints.blocks[i];
      for (std::uint32_t k = 0; k < block.count; ++k) {
        constraints.rows[block.first + k].impulse = S(rows_[r++].lambda);
      }
    }
  }
  /// Returns whether a loaded contact slides with an opening speed mu |v_t| above `speed` [m/s].
  [[nodiscard]] bool has_sliding(Real eps, Real speed) const {
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const Row& row = rows_[i];
      if (row.kind != Kind::cone || !(row.shift > speed)) continue;
      if (side_of(i, eps) == Side::sliding) return true;
    }
    return false;
  }
  /// Writes the decrease of the contacts' multipliers along the whole step of the velocities. The
  /// step knows only loaded contacts. Where it closes another, the penalty may give it any impulse.
  /// A prediction above the largest impulse in the island is dropped.
  void store_transient_impulses(Real eps, const Island& island, Constraints<S>& constraints,
                                DynamicArray<Real>& scratch) const {
    scratch.resize(rows_.size());
    Real largest = Real(0);
    for_each_impulse(eps, Real(0), [&](std::size_t i, Real x) {
      scratch[i] = x;
      if (rows_[i].kind == Kind::cone) largest = std::max(largest, x);
    });
    bool is_likely = true;
    for_each_impulse(eps, Real(1), [&](std::size_t i, Real x) {
      const Row& row = rows_[i];
      if (row.kind == Kind::cone) is_likely = row.side != Side::at_bound || x <= largest;
      constraints.contacts[island.contacts[i / 3]].transient_impulse[i % 3] =
          is_likely ? S(scratch[i] - x) : S(0);
    });
  }
  /// Writes the multipliers of the position rows to the constraints.
  void store_position_impulses(const Island& island, Constraints<S>& constraints) const {
    std::size_t r = 0;
    for (const std::uint32_t i : island.contacts) {
      constraints.contacts[i].position_impulse = S(rows_[r++].lambda);
    }
    for (const std::uint32_t i : island.blocks) {
      const ConstraintBlock<S>& block = constraints.blocks[i];
      for (std::uint32_t k = 0; k < corrected_rows(block); ++k) {
        constraints.rows[block.first + k].correction = S(rows_[r++].lambda);
      }
    }
  }

 private:
  using Row = IslandRow<Real>;
  using Kind = RowKind;
  using Side = RowSide;

  [[nodiscard]] Side side_of(std::size_t i, Real eps) const {
    const Row& row = rows_[i];
    if (row.kind == Kind::free) return Side::inside;
    const Real x = row.proposed(eps, Real(0));
    if (row.kind != Kind::cone) {
      return x > row.lower && x < row.upper ? Side::inside : Side::at_bound;
    }
    const Real t =
        planar_length(rows_[i + 1].proposed(eps, Real(0)), rows_[i + 2].proposed(eps, Real(0)));
    if (x > row.upper && t <= row.friction * row.upper) return Side::at_end;
    if (x >= Real(0) && x <= row.upper && t <= row.friction * x) return Side::inside;
    return row.friction * t <= -x ? Side::at_bound : Side::sliding;
  }

  /// Calls use(number of the row, lambda+) for all rows. It is at a share s of the way along the
  /// step.
  template <typename Use>
  void for_each_impulse(Real eps, Real s, Use&& use) const {
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const Row& row = rows_[i];
      Real n = row.proposed(eps, s);
      if (row.kind != Kind::cone) {
        use(i, row.clamped(n));
        continue;
      }
      Real x = rows_[i + 1].proposed(eps, s);
      Real y = rows_[i + 2].proposed(eps, s);
      project_on_cone(row.friction, row.upper, n, x, y);
      use(i, n);
      use(i + 1, x);
      use(i + 2, y);
      i += 2;
    }
  }

  template <typename Velocity>
  Row& add(const ContactConstraint<S>& c, std::size_t axis, std::span<const SolverBody<S>> bodies,
           Velocity&& velocity) {
    const Vec3<S>& d = c.axes[axis];
    return add(c.body_a, c.body_b, d, c.arm_a.cross(d), c.arm_b.cross(d), bodies, velocity);
  }
  template <typename Velocity>
  Row& add(const ConstraintBlock<S>& block, const ConstraintRow<S>& row,
           std::span<const SolverBody<S>> bodies, Velocity&& velocity) {
    return add(block.body_a, block.body_b, row.direction, row.angular_a, row.angular_b, bodies,
               velocity);
  }
  /// Adds a row without bounds. Its target is rest relative to immovable bodies.
  template <typename Velocity>
  Row& add(std::uint32_t slot_a, std::uint32_t slot_b, const Vec3<S>& d, const Vec3<S>& angular_a,
           const Vec3<S>& angular_b, std::span<const SolverBody<S>> bodies, Velocity&& velocity) {
    Row row;
    row.a = fill(bodies[slot_a], slot_a, -d, -angular_a, velocity, row.jacobian_a, row);
    row.b = fill(bodies[slot_b], slot_b, d, angular_b, velocity, row.jacobian_b, row);
    rows_.push_back(row);
    return rows_.back();
  }
  template <typename Velocity>
  std::uint32_t fill(const SolverBody<S>& body, std::uint32_t slot, const Vec3<S>& linear,
                     const Vec3<S>& angular, Velocity&& velocity, std::array<Real, 6>& jacobian,
                     Row& row) const {
    if (unknown_[slot] == no_index) {
      const Twist<S>& known = velocity(body);
      row.target -= Real(linear.dot(known.linear) + angular.dot(known.angular));
      return no_index;
    }
    for (std::size_t i = 0; i < 3; ++i) {
      const auto axis = static_cast<Eigen::Index>(i);
      jacobian[i] = body.is_locked(axis) ? Real(0) : Real(linear[axis]);
      jacobian[i + 3] = body.is_locked(axis + 3) ? Real(0) : Real(angular[axis]);
    }
    row.response += Real(linear.dot(cwise_product(body.inverse_mass, linear)) +
                         angular.dot(body.inverse_inertia * angular));
    return unknown_[slot];
  }

  void find_switches() {
    can_switch_ = std::any_of(rows_.begin(), rows_.end(),
                              [](const Row& row) { return row.kind != Kind::free; });
  }

  IslandOrder order_;
  std::size_t unknowns_ = 0;
  DynamicArray<std::uint32_t> unknown_, last_;
  DynamicArray<Row> rows_;
  std::size_t contact_rows_ = 0;  // The first rows, up to those of joints.
  bool can_switch_ = false;
  JointLocks locks_;
  DynamicArray<std::size_t> lockable_;
};

// Implementation ----------------------------------------------------------------------------------

template <Scalar S, typename Real>
bool IslandRows<S, Real>::find_lockable(const Island& island, const Constraints<S>& constraints,
                                        std::span<const SolverBody<S>> bodies) {
  lockable_.clear();
  locks_.reset(island.bodies.size());
  const auto number = [this](std::uint32_t unknown) {
    return unknown == no_index ? locks_.ground() : unknown / 6;
  };
  bool has_joints = false;
  for (const std::uint32_t i : island.blocks) {
    const ConstraintBlock<S>& block = constraints.blocks[i];
    if (block.kind != BlockKind::equality) continue;
    has_joints = true;
    locks_.join(number(unknown_[block.body_a]), number(unknown_[block.body_b]));
  }
  if (!has_joints) return false;
  for (const std::uint32_t slot : island.bodies) {
    bool is_locked = false;
    for (Eigen::Index axis = 0; axis < 6; ++axis) {
      is_locked = is_locked || bodies[slot].is_locked(axis);
    }
    if (is_locked) locks_.hold(number(unknown_[slot]));
  }
  locks_.finish();
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Row& row = rows_[i];
    if (row.kind == Kind::free || row.kind == Kind::tangent) continue;
    const std::uint32_t a = number(row.a);
    const std::uint32_t b = number(row.b);
    if (i < contact_rows_ ? locks_.may_lock_contact(a, b) : locks_.may_lock_joint(a, b)) {
      lockable_.push_back(i);
    }
  }
  return !lockable_.empty();
}

template <Scalar S, typename Real>
void IslandRows<S, Real>::add_hessian(Real eps, BlockCholesky<Real>& h) {
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    Row& row = rows_[i];
    if (!(row.response > Real(0)) || row.kind == Kind::tangent) continue;
    const Real stiffness = Real(1) / row.softness(eps);
    row.side = side_of(i, eps);
    if (row.side == Side::at_bound) continue;
    if (row.kind != Kind::cone) {
      add_square(h, stiffness, row);
      continue;
    }
    const Row& first = rows_[i + 1];
    const Row& second = rows_[i + 2];
    if (row.side == Side::inside || row.side == Side::at_end) {
      if (row.side == Side::inside) add_square(h, stiffness, row);
      add_square(h, stiffness, first);
      add_square(h, stiffness, second);
      continue;
    }
    // Sliding is stiff along the edge of the cone. Across it only the direction of slip is soft.
    Real n = row.proposed(eps, Real(0));
    Real x = first.proposed(eps, Real(0));
    Real y = second.proposed(eps, Real(0));
    const Real t = planar_length(x, y);
    const Real mu = row.friction;
    const Real on_edge = std::min(Real((n + mu * t) / (Real(1) + mu * mu)), row.upper);
    const Real cosine = t > Real(0) ? x / t : Real(1);
    const Real sine = t > Real(0) ? y / t : Real(0);
    Row edge = row;
    Row across = row;
    for (std::size_t k = 0; k < 6; ++k) {
      edge.jacobian_a[k] += mu * (cosine * first.jacobian_a[k] + sine * second.jacobian_a[k]);
      edge.jacobian_b[k] += mu * (cosine * first.jacobian_b[k] + sine * second.jacobian_b[k]);
      across.jacobian_a[k] = cosine * second.jacobian_a[k] - sine * first.jacobian_a[k];
      across.jacobian_b[k] = cosine * second.jacobian_b[k] - sine * first.jacobian_b[k];
    }
    if (on_edge < row.upper) add_square(h, stiffness / (Real(1) + mu * mu), edge);
    if (t > Real(0)) add_square(h, stiffness * mu * on_edge / t, across);
  }
}

}  // namespace bristle::inline BRISTLE_ABI::detail
