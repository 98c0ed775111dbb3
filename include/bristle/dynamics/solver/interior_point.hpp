/// @file
/// Interior-point method for the convex problem of an island. It converges from anywhere.
///
/// The problem is that of `ProximalSolver`: velocities v and impulses l in the convex set K with
///     M v = r + J^T l,   u = J v - b + s in the dual of K,   l . u = 0.
/// Newton's method solves l o u = m e in its place. l and u stay inside their cones, and m falls to
/// zero (interior_cone.hpp, interior_interval.hpp). The step is predicted for m = 0, which tells
/// how far m can fall and the terms of second order, and then corrected (Mehrotra 1992), with one
/// factorisation. Where there is a solution it takes ten to forty of them, whatever the masses are
/// and however many contacts are redundant. Of the impulses that solve the problem it finds those
/// in the middle (docs/decisions/0056-an-interior-point-is-the-harbour.md).
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/dynamics/solver/interior_cone.hpp>
#include <bristle/dynamics/solver/interior_interval.hpp>
#include <bristle/dynamics/solver/island_row.hpp>
#include <bristle/dynamics/solver/solver_constants.hpp>
#include <bristle/math/block_cholesky.hpp>

#include <algorithm>
#include <cstddef>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// A convex problem for `InteriorPoint`.
template <typename Real>
struct ConvexProblem {
  /// Rows with their opening speeds.
  std::span<const IslandRow<Real>> rows;
  /// Mt: masses, and terms linear in the velocities. r: the momentum without constraints.
  const BlockCholesky<Real>* matrix;
  std::span<const Real> rhs;
  /// [m/s] Speed of which the rows' velocities are: the size of the start.
  Real speed;
  /// [m/s] Distance from the law that counts as zero.
  Real tolerance = Real(0);
  /// [-] Most Newton steps that the caller pays for.
  int most_steps = 0;
};

/// The method with its scratch memory.
template <typename Real>
class InteriorPoint {
 public:
  using Row = IslandRow<Real>;

  /// Reserves memory for a problem, so that `solve` allocates nothing.
  void reserve(const ConvexProblem<Real>& problem) {
    cones_.reserve(problem.rows.size() / 3);
    intervals_.reserve(problem.rows.size());
    impulses_.reserve(problem.rows.size());
    v_.reserve(problem.rhs.size());
    gradient_.reserve(problem.rhs.size());
    step_.reserve(problem.rhs.size());
    hessian_.reserve(*problem.matrix);
  }

  /// Finds impulses inside their cones, and velocities.
  /// @return [-] Factorisations.
  int solve(const ConvexProblem<Real>& problem) {
    start(problem);
    int count = 0;
    while (count < problem.most_steps) {
      hessian_ = *problem.matrix;
      for_each_law(problem, [&](auto& law, std::span<const Row> rows) {
        law.linearise(rows, v_, Real(chosen::interior_yield) * rows[0].response);
        law.add_slope(rows, hessian_);
      });
      if (!hessian_.factor()) break;
      ++count;
      find_gradient(problem);
      find_step(problem, Real(0), false);
      const Real left = Real(1) - std::min(Real(1), reach(problem));
      // The barrier falls by the cube of what is left (Mehrotra 1992).
      find_step(problem, left * left * left * barrier(problem), true);
      const Real share = std::min(Real(1), Real(chosen::boundary_share) * reach(problem));
      bool is_inside = true;
      for_each_law(problem, [&](auto& law, std::span<const Row>) {
        law.advance(share);
        is_inside = is_inside && law.is_inside();
      });
      // Round-off decides where cones are that narrow, and numbers that are not finite are nowhere.
      if (!is_inside) break;
      for (std::size_t i = 0; i < v_.size(); ++i) v_[i] += share * step_[i];
      store(problem);
      // The step is linear in the momentum that the impulses do not explain, so its share remains.
      const Real unexplained = (Real(1) - share) * largest_gradient(problem);
      if (std::max(unexplained, distance(problem)) <= problem.tolerance) break;
    }
    return count;
  }

  [[nodiscard]] Real impulse(std::size_t row) const { return impulses_[row]; }
  [[nodiscard]] const DynamicArray<Real>& velocities() const { return v_; }

 private:
  /// Calls use(law, its rows) for all laws.
  template <typename Use>
  void for_each_law(const ConvexProblem<Real>& problem, const Use& use) {
    for (InteriorCone<Real>& law : cones_) use(law, problem.rows.subspan(law.row(), 3));
    for (InteriorInterval<Real>& law : intervals_) use(law, problem.rows.subspan(law.row(), 1));
  }

  /// Puts all impulses and velocities of rows onto the axes of their cones. The bodies may start
  /// from any velocities: where a step leads to does not depend on them.
  void start(const ConvexProblem<Real>& problem) {
    v_.assign(problem.rhs.size(), Real(0));
    gradient_.resize(v_.size());
    step_.resize(v_.size());
    cones_.clear();
    intervals_.clear();
    impulses_.assign(problem.rows.size(), Real(0));
    // All products of impulses and velocities start alike.
    Real mobility = Real(0);
    std::size_t count = 0;
    for (const Row& row : problem.rows) {
      if (!acts(row) || row.kind == RowKind::free) continue;
      mobility += Real(1) / row.response;
      ++count;
    }
    const Real barrier =
        problem.speed * problem.speed * mobility / Real(std::max<std::size_t>(1, count));
    for (std::size_t k = 0; k < problem.rows.size(); ++k) {
      const Row& row = problem.rows[k];
      if (!acts(row)) continue;
      if (row.kind == RowKind::cone && row.friction > Real(0)) {
        cones_.push_back({k, problem.rows.subspan(k, 3), barrier});
      } else {
        intervals_.push_back({k, problem.rows.subspan(k, 1), barrier});
      }
    }
    store(problem);
  }

  [[nodiscard]] static bool acts(const Row& row) {
    return row.kind != RowKind::tangent && row.response > Real(0);
  }

  void store(const ConvexProblem<Real>& problem) {
    for_each_law(problem, [&](auto& law, std::span<const Row>) {
      std::size_t k = law.row();
      for (const Real x : law.impulses()) impulses_[k++] = x;
    });
  }

  /// gradient := r + J^T l - M v.
  void find_gradient(const ConvexProblem<Real>& problem) {
    problem.matrix->multiply(v_.data(), gradient_.data());
    for (std::size_t i = 0; i < v_.size(); ++i) gradient_[i] = problem.rhs[i] - gradient_[i];
    for (std::size_t k = 0; k < impulses_.size(); ++k) {
      if (impulses_[k] != Real(0)) problem.rows[k].add_to(gradient_, impulses_[k]);
    }
  }

  /// [m/s, rad/s] Largest velocity that the gradient gives a body by itself.
  [[nodiscard]] Real largest_gradient(const ConvexProblem<Real>& problem) const {
    using std::abs;
    Real largest = Real(0);
    for (std::size_t i = 0; i < gradient_.size(); ++i) {
      largest = std::max(largest, abs(gradient_[i]) / problem.matrix->at(i, i));
    }
    return largest;
  }

  /// Finds the step of all unknowns towards a complementarity.
  void find_step(const ConvexProblem<Real>& problem, Real barrier, bool is_corrected) {
    step_ = gradient_;
    for_each_law(problem, [&](auto& law, std::span<const Row> rows) {
      std::size_t k = 0;
      for (const Real x : law.start_step(barrier, is_corrected)) rows[k++].add_to(step_, x);
    });
    hessian_.solve(step_.data());
    for_each_law(problem,
                 [&](auto& law, std::span<const Row> rows) { law.finish_step(rows, step_); });
  }

  /// Share of the step at which the first law reaches its boundary.
  [[nodiscard]] Real reach(const ConvexProblem<Real>& problem) {
    Real share = infinity<Real>;
    for_each_law(problem, [&](const auto& law, std::span<const Row>) {
      share = std::min(share, law.reach());
    });
    return share;
  }

  /// [J] Mean of the products of impulses and velocities.
  [[nodiscard]] Real barrier(const ConvexProblem<Real>& problem) {
    Real sum = Real(0);
    std::size_t count = 0;
    for_each_law(problem, [&](const auto& law, std::span<const Row>) {
      sum += law.complementarity();
      count += law.pairs();
    });
    return sum / Real(std::max<std::size_t>(1, count));
  }

  /// [m/s] Largest distance of a row from its law in the convex problem.
  [[nodiscard]] Real distance(const ConvexProblem<Real>& problem) const {
    return distance_from_convex_law<Real>(
        problem.rows, [this](std::size_t k) { return impulses_[k]; },
        [&](std::size_t k) { return problem.rows[k].times(v_) - problem.rows[k].target; });
  }

  BlockCholesky<Real> hessian_;
  DynamicArray<Real> v_, gradient_, step_, impulses_;
  DynamicArray<InteriorCone<Real>> cones_;
  DynamicArray<InteriorInterval<Real>> intervals_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
