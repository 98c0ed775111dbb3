/// @file
/// The solver of small stiff islands: grips, mechanisms, anything with sensors or joints.
///
/// Soft blocks are linear in the velocities, so they go into the island's mass matrix,
/// (M + sum G^T A6 G) v = M v_free - sum G^T p6, which stays symmetric positive definite for any
/// step, stiffness and mass ratio and is factored once. Joints are eliminated exactly by their
/// Schur complement. What remains, contacts and bounded rows, is a dense problem of few rows that
/// is swept until it stands still. Nothing is approximate but that last residual.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/solver_types.hpp>

#include <algorithm>
#include <vector>

namespace bristle {

/// Scratch memory and the algorithm. One object serves many islands, one after the other.
template <Scalar S>
class DirectSolver {
 public:
  /// Whether the island is small enough and has anything that is worth a factorisation.
  [[nodiscard]] static bool applies_to(const Island& island, const Constraints<S>& constraints,
                                       const SolverDef<S>& settings) {
    if (island.bodies.size() > settings.max_direct_bodies) return false;
    bool has_joint = false;
    std::size_t rows = 0;
    for (const std::uint32_t i : island.blocks) {
      has_joint = has_joint || constraints.blocks[i].kind != BlockKind::contact;
      rows += constraints.blocks[i].count;
    }
    return (has_joint || !island.soft.empty()) && rows <= settings.max_direct_rows;
  }

  /// Finds the velocities at the end of the step and the motion of the soft blocks.
  /// @return False when the matrix is not positive definite (not finite input); nothing was
  /// changed.
  [[nodiscard]] bool solve(const Island& island, Constraints<S>& constraints,
                           std::span<SolverBody<S>> bodies, const SolveContext<S>& context,
                           SolveReport<S>& report) {
    if (!factor_mass(island, constraints, bodies)) return false;
    ++report.factorisations;
    number_rows(island, constraints);
    project_rows(island, constraints, bodies);
    if (!reduce()) return false;

    // Velocities the contacts meet once the joints hold.
    start_from_impulses(constraints);
    S residual = S(0);
    int sweeps = 0;
    while (!unilateral_.empty() && sweeps < context.settings.max_sweeps) {
      residual = sweep(constraints, sweeps % 2 != 0);
      ++sweeps;
      if (residual <= context.velocity_tolerance) break;
    }
    report.sweeps += std::max(sweeps, 1);
    report.residual = std::max(report.residual, residual);
    finish_velocities(island, constraints, bodies);
    return true;
  }

  /// Finds displacements that close the position errors left after the step, in the metric of the
  /// matrix factored by the `solve` before it.
  int correct_positions(const Island& island, Constraints<S>& constraints,
                        std::span<SolverBody<S>> bodies, const SolveContext<S>& context);

 private:
  // Row numbers here run over the island: joints (equality rows) first, then the rest.
  struct UnilateralBlock {
    std::uint32_t block;
    std::uint32_t first;
  };

  [[nodiscard]] S* projected(std::size_t row) { return projected_.data() + row * unknowns_; }

  bool factor_mass(const Island& island, Constraints<S>& constraints,
                   std::span<SolverBody<S>> bodies);
  void add_soft(const SoftBlock<S>& soft, std::span<const SolverBody<S>> bodies);
  void hold_locked(const SolverBody<S>& body, std::uint32_t unknown);
  void number_rows(const Island& island, const Constraints<S>& constraints);
  void project_rows(const Island& island, Constraints<S>& constraints,
                    std::span<const SolverBody<S>> bodies);
  bool reduce();
  void start_from_impulses(Constraints<S>& constraints);
  S sweep(Constraints<S>& constraints, bool backwards);
  void recover_equality(const std::vector<S>& free_velocity, const std::vector<S>& impulses,
                        std::vector<S>& equality);
  void finish_velocities(const Island& island, Constraints<S>& constraints,
                         std::span<SolverBody<S>> bodies);

  std::size_t unknowns_ = 0;
  std::size_t equalities_ = 0;
  std::vector<std::uint32_t> unknown_of_;  // First unknown of each body slot, or none.
  std::vector<S> mass_;                    // Factor of the island's matrix.
  std::vector<S> velocity_;                // L^-1 r, then velocities.
  std::vector<std::uint32_t> row_of_;      // Row in `Constraints` of each row here.
  std::vector<UnilateralBlock> unilateral_;
  std::vector<S> projected_;        // Row i: L^-1 J_i^T.
  std::vector<S> response_;         // J Mt^-1 J^T of all rows.
  std::vector<S> reduced_;          // The same of the rest, with the joints holding.
  std::vector<S> coupling_;         // Row i of the rest: factor of W_ee applied to W_ei.
  std::vector<S> equality_factor_;  // Cholesky factor of W_ee.
  std::vector<S> free_row_velocity_;
  std::vector<S> row_velocity_;
  std::vector<S> impulses_;
  std::vector<S> equality_;
  std::vector<BlockResponse<S>> block_responses_;
};

// Implementation -----------------------------------------------------------------------------------

namespace detail {
inline constexpr std::uint32_t no_unknown = 0xffffffffu;

template <Scalar S>
[[nodiscard]] S dot(const S* a, const S* b, std::size_t n) {
  S sum = S(0);
  for (std::size_t i = 0; i < n; ++i) sum += a[i] * b[i];
  return sum;
}
}  // namespace detail

template <Scalar S>
bool DirectSolver<S>::factor_mass(const Island& island, Constraints<S>& constraints,
                                  std::span<SolverBody<S>> bodies) {
  if (unknown_of_.size() < bodies.size()) unknown_of_.resize(bodies.size(), detail::no_unknown);
  std::fill(unknown_of_.begin(), unknown_of_.end(), detail::no_unknown);
  unknowns_ = 6 * island.bodies.size();
  mass_.assign(unknowns_ * unknowns_, S(0));
  velocity_.assign(unknowns_, S(0));
  std::uint32_t next = 0;
  for (const std::uint32_t slot : island.bodies) {
    const SolverBody<S>& body = bodies[slot];
    unknown_of_[slot] = next;
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Index e = static_cast<Eigen::Index>(i);
      mass_[(next + i) * unknowns_ + next + i] = body.mass;
      velocity_[next + i] = body.mass * body.free.linear[e];
      for (std::size_t j = 0; j < 3; ++j) {
        mass_[(next + 3 + i) * unknowns_ + next + 3 + j] =
            body.inertia(e, static_cast<Eigen::Index>(j));
      }
      velocity_[next + 3 + i] = body.inertia.row(e).dot(body.free.angular);
    }
    next += 6;
  }
  for (const std::uint32_t s : island.soft) add_soft(constraints.soft[s], bodies);
  for (const std::uint32_t slot : island.bodies) hold_locked(bodies[slot], unknown_of_[slot]);
  if (!factor_cholesky(mass_.data(), unknowns_)) return false;
  solve_lower(mass_.data(), unknowns_, velocity_.data());
  return true;
}

template <Scalar S>
void DirectSolver<S>::add_soft(const SoftBlock<S>& soft, std::span<const SolverBody<S>> bodies) {
  // G maps the twist of a body to the block's motion: V_c = v - arm x w for A, its negative for B.
  const auto motion_of = [](const Vec3<S>& arm, S sign) {
    Mat6<S> G = sign * Mat6<S>::Identity();
    G.template topRightCorner<3, 3>() = -sign * skew(arm);
    return G;
  };
  const std::uint32_t slots[2] = {soft.body_a, soft.body_b};
  const Mat6<S> G[2] = {motion_of(soft.arm_a, S(1)), motion_of(soft.arm_b, S(-1))};
  // Bodies that forces do not move contribute their known motion to the constant part.
  Vec6<S> constant = soft.offset;
  for (int k = 0; k < 2; ++k) {
    if (unknown_of_[slots[k]] != detail::no_unknown) continue;
    Vec6<S> known;
    known << bodies[slots[k]].free.linear, bodies[slots[k]].free.angular;
    constant += soft.matrix * (G[k] * known);
  }
  for (int k = 0; k < 2; ++k) {
    const std::uint32_t row = unknown_of_[slots[k]];
    if (row == detail::no_unknown) continue;
    const Mat6<S> left = G[k].transpose() * soft.matrix;
    const Vec6<S> load = G[k].transpose() * constant;
    for (std::size_t i = 0; i < 6; ++i) {
      velocity_[row + i] -= load[static_cast<Eigen::Index>(i)];
    }
    for (int l = 0; l < 2; ++l) {
      const std::uint32_t column = unknown_of_[slots[l]];
      if (column == detail::no_unknown || column > row) continue;  // Lower triangle only.
      const Mat6<S> product = left * G[l];
      for (std::size_t i = 0; i < 6; ++i) {
        for (std::size_t j = 0; j < 6; ++j) {
          mass_[(row + i) * unknowns_ + column + j] +=
              product(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
        }
      }
    }
  }
}

/// Takes the axes on which nothing moves a body out of the system.
template <Scalar S>
void DirectSolver<S>::hold_locked(const SolverBody<S>& body, std::uint32_t unknown) {
  for (Eigen::Index axis = 0; axis < 6; ++axis) {
    if (!body.is_locked(axis)) continue;
    const std::size_t i = unknown + static_cast<std::size_t>(axis);
    for (std::size_t k = 0; k < unknowns_; ++k) {
      mass_[i * unknowns_ + k] = mass_[k * unknowns_ + i] = S(0);
    }
    mass_[i * unknowns_ + i] = S(1);
    velocity_[i] = S(0);
  }
}

template <Scalar S>
void DirectSolver<S>::number_rows(const Island& island, const Constraints<S>& constraints) {
  row_of_.clear();
  unilateral_.clear();
  for (const std::uint32_t i : island.blocks) {
    const ConstraintBlock<S>& block = constraints.blocks[i];
    if (block.kind != BlockKind::equality) continue;
    for (std::uint32_t r = 0; r < block.count; ++r) row_of_.push_back(block.first + r);
  }
  equalities_ = row_of_.size();
  for (const std::uint32_t i : island.blocks) {
    const ConstraintBlock<S>& block = constraints.blocks[i];
    if (block.kind == BlockKind::equality) continue;
    unilateral_.push_back({i, static_cast<std::uint32_t>(row_of_.size())});
    for (std::uint32_t r = 0; r < block.count; ++r) row_of_.push_back(block.first + r);
  }
}

template <Scalar S>
void DirectSolver<S>::project_rows(const Island& island, Constraints<S>& constraints,
                                   std::span<const SolverBody<S>> bodies) {
  const std::size_t rows = row_of_.size();
  projected_.assign(rows * unknowns_, S(0));
  free_row_velocity_.assign(rows, S(0));
  std::size_t r = 0;
  const auto fill = [&](const ConstraintBlock<S>& block) {
    for (std::uint32_t i = 0; i < block.count; ++i, ++r) {
      const ConstraintRow<S>& row = constraints.rows[block.first + i];
      S* p = projected(r);
      std::size_t first = unknowns_;
      const auto put = [&](std::uint32_t slot, S sign, const Vec3<S>& angular) {
        const std::uint32_t u = unknown_of_[slot];
        if (u == detail::no_unknown) {
          // The known motion of the other bodies enters the row's free velocity.
          free_row_velocity_[r] += sign * (row.direction.dot(bodies[slot].free.linear) +
                                           angular.dot(bodies[slot].free.angular));
          return;
        }
        first = std::min<std::size_t>(first, u);
        for (std::size_t k = 0; k < 3; ++k) {
          const auto axis = static_cast<Eigen::Index>(k);
          if (!bodies[slot].is_locked(axis)) p[u + k] += sign * row.direction[axis];
          if (!bodies[slot].is_locked(axis + 3)) p[u + 3 + k] += sign * angular[axis];
        }
      };
      put(block.body_a, S(-1), row.angular_a);
      put(block.body_b, S(1), row.angular_b);
      solve_lower(mass_.data(), unknowns_, p, first);
      free_row_velocity_[r] += detail::dot(p, velocity_.data(), unknowns_);
    }
  };
  for (const std::uint32_t i : island.blocks) {
    if (constraints.blocks[i].kind == BlockKind::equality) fill(constraints.blocks[i]);
  }
  for (const UnilateralBlock& u : unilateral_) fill(constraints.blocks[u.block]);

  response_.resize(rows * rows);
  for (std::size_t i = 0; i < rows; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      response_[i * rows + j] = response_[j * rows + i] =
          detail::dot(projected(i), projected(j), unknowns_);
    }
  }
  // Joints aim at their targets: from here on row velocities are relative to them.
  for (std::size_t i = 0; i < equalities_; ++i) {
    free_row_velocity_[i] -= constraints.rows[row_of_[i]].target;
  }
}

template <Scalar S>
bool DirectSolver<S>::reduce() {
  const std::size_t rows = row_of_.size();
  const std::size_t rest = rows - equalities_;
  equality_factor_.resize(equalities_ * equalities_);
  for (std::size_t i = 0; i < equalities_; ++i) {
    for (std::size_t j = 0; j < equalities_; ++j) {
      equality_factor_[i * equalities_ + j] = response_[i * rows + j];
    }
  }
  // Loops make joints redundant; the floor softens them just enough to share the load.
  if (!factor_cholesky(equality_factor_.data(), equalities_, no_mobility<S>)) {
    return false;
  }
  coupling_.resize(rest * equalities_);
  reduced_.resize(rest * rest);
  for (std::size_t i = 0; i < rest; ++i) {
    S* c = coupling_.data() + i * equalities_;
    for (std::size_t e = 0; e < equalities_; ++e) c[e] = response_[(equalities_ + i) * rows + e];
    solve_lower(equality_factor_.data(), equalities_, c);
  }
  for (std::size_t i = 0; i < rest; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      reduced_[i * rest + j] = reduced_[j * rest + i] =
          response_[(equalities_ + i) * rows + equalities_ + j] -
          detail::dot(coupling_.data() + i * equalities_, coupling_.data() + j * equalities_,
                      equalities_);
    }
  }
  // A row along which the joints leave no mobility (a finger on a slide, pushed across it) must not
  // divide by what rounding left there: nothing but the joints' carrier could give way.
  for (std::size_t i = 0; i < rest; ++i) {
    const S before = response_[(equalities_ + i) * rows + equalities_ + i];
    if (reduced_[i * rest + i] > no_mobility<S> * before) continue;
    for (std::size_t j = 0; j < rest; ++j) reduced_[i * rest + j] = reduced_[j * rest + i] = S(0);
  }
  return true;
}

template <Scalar S>
void DirectSolver<S>::start_from_impulses(Constraints<S>& constraints) {
  const std::size_t rest = row_of_.size() - equalities_;
  equality_.assign(free_row_velocity_.begin(),
                   free_row_velocity_.begin() + static_cast<std::ptrdiff_t>(equalities_));
  solve_lower(equality_factor_.data(), equalities_, equality_.data());
  row_velocity_.resize(rest);
  impulses_.resize(rest);
  for (std::size_t i = 0; i < rest; ++i) {
    ConstraintRow<S>& row = constraints.rows[row_of_[equalities_ + i]];
    if (reduced_[i * rest + i] == S(0))
      row.impulse = S(0);  // Left out: nothing would ever change it.
    impulses_[i] = row.impulse;
  }
  for (std::size_t i = 0; i < rest; ++i) {
    row_velocity_[i] =
        free_row_velocity_[equalities_ + i] -
        detail::dot(coupling_.data() + i * equalities_, equality_.data(), equalities_) +
        detail::dot(reduced_.data() + i * rest, impulses_.data(), rest);
  }
  block_responses_.resize(std::max(block_responses_.size(), unilateral_.size()));
  for (std::size_t k = 0; k < unilateral_.size(); ++k) {
    const std::size_t first = unilateral_[k].first - equalities_;
    const std::size_t count = constraints.blocks[unilateral_[k].block].count;
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t j = 0; j < count; ++j) {
        block_responses_[k].matrix[i * count + j] = reduced_[(first + i) * rest + first + j];
      }
    }
  }
}

template <Scalar S>
S DirectSolver<S>::sweep(Constraints<S>& constraints, bool backwards) {
  using std::abs;
  const std::size_t rest = row_of_.size() - equalities_;
  S residual = S(0);
  for (std::size_t n = 0; n < unilateral_.size(); ++n) {
    const std::size_t k = backwards ? unilateral_.size() - 1 - n : n;
    const ConstraintBlock<S>& block = constraints.blocks[unilateral_[k].block];
    const std::size_t first = unilateral_[k].first - equalities_;
    S change[ConstraintBlock<S>::max_rows];
    solve_block(block, block_responses_[k], &row_velocity_[first], &constraints.rows[block.first],
                change);
    for (std::size_t i = 0; i < block.count; ++i) {
      if (change[i] == S(0)) continue;
      const S* column = reduced_.data() + (first + i) * rest;
      for (std::size_t j = 0; j < rest; ++j) row_velocity_[j] += change[i] * column[j];
      residual = std::max(residual, abs(change[i]) * block_responses_[k](i, i, block.count));
    }
  }
  return residual;
}

/// equality := -W_ee^-1 (velocity_e + W_ei impulses), the joints' answer to the rest.
template <Scalar S>
void DirectSolver<S>::recover_equality(const std::vector<S>& free_velocity,
                                       const std::vector<S>& impulses, std::vector<S>& equality) {
  equality.assign(free_velocity.begin(),
                  free_velocity.begin() + static_cast<std::ptrdiff_t>(equalities_));
  solve_lower(equality_factor_.data(), equalities_, equality.data());
  for (std::size_t i = 0; i < impulses.size(); ++i) {
    const S* c = coupling_.data() + i * equalities_;
    for (std::size_t e = 0; e < equalities_; ++e) equality[e] += c[e] * impulses[i];
  }
  solve_upper(equality_factor_.data(), equalities_, equality.data());
  for (S& x : equality) x = -x;
}

template <Scalar S>
void DirectSolver<S>::finish_velocities(const Island& island, Constraints<S>& constraints,
                                        std::span<SolverBody<S>> bodies) {
  for (std::size_t i = 0; i < impulses_.size(); ++i) {
    impulses_[i] = constraints.rows[row_of_[equalities_ + i]].impulse;
  }
  recover_equality(free_row_velocity_, impulses_, equality_);
  for (std::size_t e = 0; e < equalities_; ++e) {
    constraints.rows[row_of_[e]].impulse = equality_[e];
  }
  for (std::size_t r = 0; r < row_of_.size(); ++r) {
    const S x = constraints.rows[row_of_[r]].impulse;
    if (x == S(0)) continue;
    const S* p = projected(r);
    for (std::size_t u = 0; u < unknowns_; ++u) velocity_[u] += x * p[u];
  }
  solve_upper(mass_.data(), unknowns_, velocity_.data());

  for (const std::uint32_t slot : island.bodies) {
    const std::uint32_t u = unknown_of_[slot];
    bodies[slot].twist = {{velocity_[u], velocity_[u + 1], velocity_[u + 2]},
                          {velocity_[u + 3], velocity_[u + 4], velocity_[u + 5]}};
  }
  for (const std::uint32_t s : island.soft) {
    SoftBlock<S>& soft = constraints.soft[s];
    soft.motion = relative_motion(soft, bodies[soft.body_a].twist, bodies[soft.body_b].twist);
    soft.impulse = soft.offset + soft.matrix * soft.motion;
  }
}

template <Scalar S>
int DirectSolver<S>::correct_positions(const Island& island, Constraints<S>& constraints,
                                       std::span<SolverBody<S>> bodies,
                                       const SolveContext<S>& context) {
  using std::abs;
  const std::size_t rows = row_of_.size();
  const std::size_t rest = rows - equalities_;
  // Velocity of each row that would close its error by the end of the step.
  const auto left_of = [&](std::size_t r, const ConstraintBlock<S>& block) {
    const ConstraintRow<S>& row = constraints.rows[row_of_[r]];
    return row.error / context.dt +
           row.velocity(bodies[block.body_a].twist, bodies[block.body_b].twist);
  };
  std::size_t r = 0;
  for (const std::uint32_t i : island.blocks) {
    const ConstraintBlock<S>& block = constraints.blocks[i];
    if (block.kind != BlockKind::equality) continue;
    for (std::uint32_t k = 0; k < block.count; ++k, ++r) free_row_velocity_[r] = left_of(r, block);
  }
  equality_.assign(free_row_velocity_.begin(),
                   free_row_velocity_.begin() + static_cast<std::ptrdiff_t>(equalities_));
  solve_lower(equality_factor_.data(), equalities_, equality_.data());
  impulses_.assign(rest, S(0));
  row_velocity_.assign(rest, S(0));
  for (const UnilateralBlock& u : unilateral_) {
    const ConstraintBlock<S>& block = constraints.blocks[u.block];
    if (corrected_rows(block) == 0) continue;
    const std::size_t i = u.first - equalities_;
    row_velocity_[i] = left_of(u.first, block);
    row_velocity_[i] -=
        detail::dot(coupling_.data() + i * equalities_, equality_.data(), equalities_);
  }

  int sweeps = 0;
  while (sweeps < context.settings.max_position_sweeps) {
    S residual = S(0);
    for (const UnilateralBlock& u : unilateral_) {
      if (corrected_rows(constraints.blocks[u.block]) == 0) continue;
      const std::size_t i = u.first - equalities_;
      const S response = reduced_[i * rest + i];
      const S wanted =
          std::max(S(0), impulses_[i] + detail::scalar_change(row_velocity_[i], response));
      const S change = wanted - impulses_[i];
      if (change == S(0)) continue;
      impulses_[i] = wanted;
      const S* column = reduced_.data() + i * rest;
      for (std::size_t j = 0; j < rest; ++j) row_velocity_[j] += change * column[j];
      residual = std::max(residual, abs(change) * response);
    }
    ++sweeps;
    if (residual <= context.velocity_tolerance) break;
  }

  recover_equality(free_row_velocity_, impulses_, equality_);
  velocity_.assign(unknowns_, S(0));
  for (std::size_t i = 0; i < rows; ++i) {
    const S x = i < equalities_ ? equality_[i] : impulses_[i - equalities_];
    if (x == S(0)) continue;
    const S* p = projected(i);
    for (std::size_t u = 0; u < unknowns_; ++u) velocity_[u] += x * p[u];
  }
  solve_upper(mass_.data(), unknowns_, velocity_.data());
  for (const std::uint32_t slot : island.bodies) {
    const std::uint32_t u = unknown_of_[slot];
    bodies[slot].correction = {{velocity_[u], velocity_[u + 1], velocity_[u + 2]},
                               {velocity_[u + 3], velocity_[u + 4], velocity_[u + 5]}};
  }
  return sweeps;
}

}  // namespace bristle
