/// @file
/// Newton's method on Coulomb's law itself, for islands with sliding contacts.
///
/// The unknowns are the velocities v of the bodies and the impulses l of all rows. On the branch of
/// a row (coulomb_branch.hpp) its law is linear, dl = q + D J dv, so that
///     [Mt - J^T D J] dv = r - Mt v + J^T (l + q).
/// The friction bound moves with the normal impulse. That makes the matrix nonsymmetric and
/// convergence fast. With a bound that lags a pass behind, convergence is slow: pushed blocks then
/// converge only by a factor of about mu^2 a pass.
///
/// Newton's method does not converge from far away. It starts at the end of the last step. It moves
/// the centre. It reduces eps once the problem with eps is solved, and raises it where a step leads
/// farther away than one before. Candidates are impulses within their bounds, with their
/// velocities. The best that add no energy are kept.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/no_index.hpp>
#include <bristle/dynamics/solver/coulomb_branch.hpp>
#include <bristle/dynamics/solver/island_row.hpp>
#include <bristle/dynamics/solver/solver_constants.hpp>
#include <bristle/math/block_cholesky.hpp>
#include <bristle/math/block_lu.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// An island for `CoulombNewton`.
template <typename Real>
struct CoulombProblem {
  /// Rows with their warm start.
  std::span<const IslandRow<Real>> rows;
  /// Mt: masses, and terms linear in the velocities. r: the momentum without constraints.
  const BlockCholesky<Real>* matrix;
  std::span<const Real> rhs;
  /// True if Mt is M. Then bodies act on each other through the rows alone.
  bool is_uncoupled;
  /// True if no surfaces slide that carry load. The law is linear until a row switches its branch.
  /// Surfaces may begin to slide, open or close, and joints may reach their limits.
  bool is_held;
  /// True if the impulses are near a solution of this step. Those of the last step may not be.
  bool is_near;
  /// [m/s, rad/s] Velocities at the start of the step, and after it without constraints.
  const DynamicArray<Real>*start, *free;
  /// [m/s] Residual that counts as zero.
  Real tolerance;
  /// [m/s] Velocity change by forces and motors in the step.
  Real speed_change;
  /// [-] Most Newton steps that the caller pays for.
  int most_steps;

  /// [m/s] Residual that is worth no more work. It is a share of the slip or of the velocity change
  /// by forces in the step, whichever is less. Resting contacts always go down to
  /// `tolerance`. Their errors would add up.
  [[nodiscard]] Real good_enough(Real slip) const {
    return std::max(tolerance, Real(chosen::good_enough_share) * std::min(speed_change, slip));
  }
};

/// Result of `CoulombNewton`.
template <typename Real>
struct CoulombResult {
  /// [m/s] Largest distance of a row from its law.
  Real residual = infinity<Real>;
  /// [m/s] Speed of the fastest sliding contact.
  Real slip = Real(0);
  /// The eps of the last factorisation.
  Real eps = Real(0);
  /// [-] Factorisations.
  int factorisations = 0;
  /// True if rows contradict each other: the problem is solved for every centre, and no centre
  /// leaves less.
  bool is_contradictory = false;
};

/// The algorithm with its scratch memory.
template <typename Real>
class CoulombNewton {
 public:
  using Row = IslandRow<Real>;

  /// Finds impulses and velocities that satisfy the law.
  CoulombResult<Real> solve(const CoulombProblem<Real>& problem) {
    CoulombResult<Real> result;
    const std::span<const Row> rows = problem.rows;
    start(problem);
    // The least eps solves a linear law by one factorisation.
    Real eps = Real(problem.is_held ? chosen::least_eps : chosen::newton_first_eps);
    evaluate(rows, v_, velocity_);
    // Impulses of the last step that are far from any solution give no hint.
    if (!problem.is_held && !problem.is_near &&
        measure(rows, eps).law > Real(chosen::far_start_ratio) * problem.speed_change) {
      eps = Real(chosen::newton_cold_eps);
      std::fill(centre_.begin(), centre_.end(), Real(0));
    }
    if (!factor_response(problem)) return result;
    // A state that stays as it was needs no factorisation.
    keep_if_better(problem, result);
    const Real nothing = Real(chosen::steady_share) * problem.tolerance;
    if (result.residual <= nothing && is_steady(problem, nothing)) return result;

    Real factored_eps = Real(-1);  // No factor yet.
    Real least_eps = Real(chosen::least_eps);
    Real nearest = infinity<Real>;  // Least distance of all steps from this centre.
    Real before = infinity<Real>;
    Real at_centre = infinity<Real>;
    Real last_left = infinity<Real>;
    int centres = 0;
    bool is_solved = false;
    for (int i = 0; i < std::min(problem.most_steps, chosen::most_newton_steps_of_law); ++i) {
      const bool has_switched = linearise(rows, eps);
      const bool is_fresh = has_switched || factored_eps != eps;
      if (is_solved && is_fresh) break;
      find_gradient(problem);
      if (is_fresh) {
        if (!factor(problem)) break;
        ++result.factorisations;
        factored_ = branches_;
        factored_eps = result.eps = eps;
      }
      solve_linear(step_);
      if (!advance(rows)) break;
      const Distances distances = measure(rows, eps);
      const Real left = distances.law;
      if (!is_solved || left < result.residual) result.slip = distances.slip;
      if (left <= problem.tolerance && left < result.residual) {
        result.residual = left;
        best_ = impulse_;
        move_into_bounds(rows, best_);
        best_v_ = v_;
        // One more step with the same factor costs little, and leaves round-off. An island at rest
        // then needs no Newton step in the next time step.
        if (is_solved) break;
        is_solved = true;
        centre_ = impulse_;
        continue;
      }
      if (is_solved) break;
      if (left < result.residual) keep_if_better(problem, result);
      // A good enough result is improved as long as that is cheap. A steady motion then needs no
      // Newton step in the next time step.
      if (result.residual <= problem.good_enough(result.slip) &&
          left > Real(chosen::cheap_gain_share) * last_left)
        break;
      last_left = left;

      const Real of_compliant = distances.compliant;
      if (of_compliant > Real(chosen::rejected_growth) * nearest &&
          eps < Real(chosen::largest_eps)) {
        // A step that leads away from the law was too long. A larger eps keeps the next step near
        // the centre. The centre moves to where the law was nearest.
        v_ = nearest_v_;
        impulse_ = centre_ = nearest_impulse_;
        evaluate(rows, v_, velocity_);
        eps = least_eps = Real(chosen::rejected_eps_growth) * eps;
        nearest = before = infinity<Real>;
        continue;
      }
      if (of_compliant < nearest) keep_nearest(of_compliant, nearest);
      // A factor that no longer helps is rebuilt.
      if (!is_fresh && of_compliant > Real(chosen::stale_factor_share) * before)
        factored_eps = Real(-1);
      before = of_compliant;
      const Real solved = Real(chosen::centre_solved_share);
      if (of_compliant > std::max(solved * problem.tolerance, solved * left)) continue;
      if (centres++ > 0 && left > Real(chosen::stalled_centre_share) * at_centre) {
        result.is_contradictory = !has_switched && !(eps > Real(chosen::least_eps));
        break;
      }
      // The factor is kept where it converges fast.
      if (left > Real(chosen::fast_centre_share) * at_centre) {
        eps = std::max(least_eps, Real(chosen::newton_eps_decrease) * eps);
      }
      at_centre = left;
      centre_ = impulse_;
      before = infinity<Real>;
      keep_nearest(left, nearest);
    }
    return result;
  }

  /// The impulses that were found. `velocities` are theirs [m/s, rad/s].
  [[nodiscard]] Real impulse(std::size_t row) const { return best_[row]; }
  /// x := H^-1 x with the matrix factored last, H = Mt - J^T D J.
  void solve_linear(DynamicArray<Real>& x) const {
    if (is_symmetric_) {
      cholesky_.solve(x.data());
    } else {
      lu_.solve(x.data());
    }
  }
  [[nodiscard]] const DynamicArray<Real>& velocities() const { return best_v_; }

 private:
  using State = CoulombState;
  using Branch = CoulombBranch<Real>;

  void start(const CoulombProblem<Real>& problem) {
    const std::size_t count = problem.rows.size();
    v_ = *problem.start;
    impulse_.assign(count, Real(0));
    best_.assign(count, Real(0));
    for (std::size_t k = 0; k < count; ++k) {
      best_[k] = problem.rows[k].lambda;
      if (problem.rows[k].response > Real(0)) impulse_[k] = best_[k];
    }
    best_v_ = v_;
    centre_ = impulse_;
    velocity_.resize(count);
    candidate_velocity_.resize(count);
    candidate_.resize(count);
    branches_.assign(count, Branch{});
    step_.resize(v_.size());
    free_velocity_.resize(count);
    // Reserves memory that only some solutions need. A warm step in which a contact begins or ends
    // to slide must not allocate.
    nearest_v_ = v_;
    nearest_impulse_ = impulse_;
    factored_ = branches_;
    cholesky_.reserve(*problem.matrix);
    lu_.reserve(problem.matrix->pattern());
    evaluate(problem.rows, *problem.free, free_velocity_);
  }

  static void evaluate(std::span<const Row> rows, const DynamicArray<Real>& v,
                       DynamicArray<Real>& out) {
    for (std::size_t k = 0; k < rows.size(); ++k) out[k] = rows[k].times(v) - rows[k].target;
  }

  /// Distances of the present iterate.
  struct Distances {
    Real law = Real(0);        // [m/s] Largest distance of a row from its law.
    Real compliant = Real(0);  // [m/s] The same with eps, by w~.
    Real slip = Real(0);       // [m/s] Speed of the fastest sliding contact.
  };
  [[nodiscard]] Distances measure(std::span<const Row> rows, Real eps) const {
    Distances found;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const Row& row = rows[k];
      if (row.kind == RowKind::tangent || !(row.response > Real(0))) continue;
      const Real* const l = &impulse_[k];
      const Real* const w = &velocity_[k];
      Real compliant_w[3];
      for (std::size_t part = 0; part < parts_of(row); ++part) {
        compliant_w[part] = compliant(row, k + part, eps);
      }
      found.law = std::max(found.law, distance_from_law(row, l, w));
      found.compliant = std::max(found.compliant, distance_from_law(row, l, compliant_w));
      if (branches_[k].state == State::slip) {
        found.slip = std::max(found.slip, planar_length(w[1], w[2]));
      }
    }
    return found;
  }

  /// Returns whether the best solution leaves the velocities as at the start of the step.
  [[nodiscard]] bool is_steady(const CoulombProblem<Real>& problem, Real nothing) const {
    using std::abs;
    for (std::size_t i = 0; i < best_v_.size(); ++i) {
      if (abs(best_v_[i] - (*problem.start)[i]) > nothing) return false;
    }
    return true;
  }

  void keep_nearest(Real distance, Real& nearest) {
    nearest = distance;
    nearest_v_ = v_;
    nearest_impulse_ = impulse_;
  }

  /// w~ of row k, whose kind and response are those of `row`.
  [[nodiscard]] Real compliant(const Row& row, std::size_t k, Real eps) const {
    return velocity_[k] + row.regularisation(eps) * (impulse_[k] - centre_[k]);
  }

  /// Finds the branch of each row.
  /// @return True if any branch has changed.
  bool linearise(std::span<const Row> rows, Real eps) {
    bool has_switched = false;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const Row& row = rows[k];
      if (row.kind == RowKind::tangent) continue;
      Branch& branch = branches_[k];
      const Branch last = branch;
      const Real w = compliant(row, k, eps);
      if (row.kind == RowKind::cone) {
        const std::array<Real, 3> velocities{w, compliant(row, k + 1, eps),
                                             compliant(row, k + 2, eps)};
        branch =
            branch_of_cone(row, {impulse_[k], impulse_[k + 1], impulse_[k + 2]}, velocities, eps);
      } else {
        branch = branch_of_single(row, impulse_[k], w, eps);
      }
      has_switched |= !branch.is_same_as(last);
    }
    return has_switched;
  }

  /// step := r - Mt v + J^T (l + constant).
  void find_gradient(const CoulombProblem<Real>& problem) {
    linear_.multiply(v_.data(), step_.data());
    for (std::size_t i = 0; i < step_.size(); ++i) step_[i] = problem.rhs[i] - step_[i];
    for_each_part(problem.rows, [&](std::size_t k, std::size_t part) {
      const Real x = impulse_[k + part] + branches_[k].constant[part];
      if (x != Real(0)) problem.rows[k + part].add_to(step_, x);
    });
  }

  /// Factors Mt - J^T D J. It is symmetric where nothing slides.
  [[nodiscard]] bool factor(const CoulombProblem<Real>& problem) {
    is_symmetric_ = std::none_of(branches_.begin(), branches_.end(),
                                 [](const Branch& b) { return b.state == State::slip; });
    if (!is_symmetric_) {
      assemble(problem);
      return lu_.factor();
    }
    cholesky_ = *problem.matrix;
    const std::span<const Row> rows = problem.rows;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const Branch& branch = branches_[k];
      if (rows[k].kind == RowKind::tangent || !branch.has_slope()) continue;
      add_square(cholesky_, -branch.normal, rows[k]);
      if (rows[k].kind != RowKind::cone) continue;
      add_square(cholesky_, -branch.xx, rows[k + 1]);
      add_square(cholesky_, -branch.yy, rows[k + 2]);
    }
    return cholesky_.factor();
  }

  /// Assembles the matrix with sliding contacts.
  void assemble(const CoulombProblem<Real>& problem) {
    lu_.assign(problem.matrix->pattern(), linear_);
    const std::span<const Row> rows = problem.rows;
    const Row* of_pair = nullptr;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const Row& row = rows[k];
      if (row.kind == RowKind::tangent || !branches_[k].has_slope()) continue;
      // Rows between the same two bodies follow each other. They are summed first.
      if (of_pair == nullptr || row.a != of_pair->a || row.b != of_pair->b) {
        if (of_pair != nullptr) add_pair(*of_pair);
        of_pair = &row;
        for (Block6<Real>& x : pair_) x.values.fill(Real(0));
      }
      add_to_pair(rows.subspan(k, parts_of(row)), branches_[k]);
    }
    if (of_pair != nullptr) add_pair(*of_pair);
  }

  /// Adds -J^T D J to the sums of the pair, with the rows J of one law. Blocks are aa, ab, ba, bb.
  void add_to_pair(std::span<const Row> rows, const Branch& branch) {
    const Real weights[3][3] = {{-branch.normal, Real(0), Real(0)},
                                {-branch.drag[0], -branch.xx, -branch.xy},
                                {-branch.drag[1], -branch.xy, -branch.yy}};
    const bool moves[2] = {rows[0].a != no_index, rows[0].b != no_index};
    Real left[2][18];                              // J^T of each body.
    Real right[2][3 * Block6<Real>::stride] = {};  // -D J of each body.
    for (std::size_t s = 0; s < 2; ++s) {
      if (!moves[s]) continue;
      for (std::size_t m = 0; m < rows.size(); ++m) {
        const std::array<Real, 6>& jacobian = s == 0 ? rows[m].jacobian_a : rows[m].jacobian_b;
        for (std::size_t i = 0; i < 6; ++i) left[s][3 * i + m] = jacobian[i];
        for (std::size_t n = m; n < rows.size(); ++n) {
          Real* const out = right[s] + Block6<Real>::stride * n;
          for (std::size_t i = 0; i < 6; ++i) out[i] += weights[n][m] * jacobian[i];
        }
      }
      if (rows.size() < 3) continue;
      for (std::size_t i = 0; i < 6; ++i) {
        right[s][Block6<Real>::stride + i] += weights[1][2] * left[s][3 * i + 2];
      }
    }
    for (std::size_t s = 0; s < 2; ++s) {
      for (std::size_t t = 0; t < 2; ++t) {
        if (!moves[s] || !moves[t]) continue;
        add_product<1>(left[s], 3, 1, right[t], rows.size(), pair_[2 * s + t].row(0));
      }
    }
  }

  void add_pair(const Row& of) {
    const std::uint32_t bodies[2] = {of.a, of.b};
    for (std::size_t s = 0; s < 2; ++s) {
      for (std::size_t t = 0; t < 2; ++t) {
        if (bodies[s] == no_index || bodies[t] == no_index) continue;
        lu_.add(bodies[s] / 6, bodies[t] / 6, pair_[2 * s + t]);
      }
    }
  }

  /// Applies the step. With a factor of an earlier iteration, the slopes of that iteration apply.
  /// @return False if the step is not finite. Nothing has changed then.
  bool advance(std::span<const Row> rows) {
    using std::abs;
    Real size = Real(0);
    for (const Real x : step_) size = std::max(size, abs(x));
    if (!(size < infinity<Real>)) return false;
    for (std::size_t i = 0; i < v_.size(); ++i) v_[i] += step_[i];
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const Row& row = rows[k];
      if (row.kind == RowKind::tangent || !(row.response > Real(0))) continue;
      const Branch& slope = factored_[k];
      const Real n = row.times(step_);
      velocity_[k] += n;
      impulse_[k] += branches_[k].constant[0] + slope.normal * n;
      if (row.kind != RowKind::cone) continue;
      const Real x = rows[k + 1].times(step_);
      const Real y = rows[k + 2].times(step_);
      velocity_[k + 1] += x;
      velocity_[k + 2] += y;
      impulse_[k + 1] += branches_[k].constant[1] + slope.drag[0] * n + slope.xx * x + slope.xy * y;
      impulse_[k + 2] += branches_[k].constant[2] + slope.drag[1] * n + slope.xy * x + slope.yy * y;
    }
    return true;
  }

  /// Keeps Mt and its factors. Where it does not couple bodies, its empty blocks are left out.
  bool factor_response(const CoulombProblem<Real>& problem) {
    if (problem.is_uncoupled) {
      diagonal_.clear();
      for (std::size_t i = 0; i < problem.matrix->blocks(); ++i) diagonal_.add_row({});
      linear_.assign(diagonal_, *problem.matrix);
    } else {
      linear_ = *problem.matrix;
    }
    response_ = linear_;
    return response_.factor();
  }

  static void move_into_bounds(std::span<const Row> rows, DynamicArray<Real>& impulse) {
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const Row& row = rows[k];
      if (row.kind == RowKind::tangent || !(row.response > Real(0))) continue;
      impulse[k] = row.clamped(impulse[k]);
      if (row.kind != RowKind::cone) continue;
      shrink(row.friction * impulse[k], impulse[k + 1], impulse[k + 2]);
    }
  }

  /// Keeps the impulses of the present iterate, moved into their bounds, if they are the best.
  /// Their velocities must be nearer to the law. They must add no energy, to the error that a
  /// solution may have anyway. Impulses that would are all scaled by the share that takes the most.
  void keep_if_better(const CoulombProblem<Real>& problem, CoulombResult<Real>& result) {
    candidate_ = impulse_;
    move_into_bounds(problem.rows, candidate_);
    Candidate candidate = try_candidate(problem, problem.good_enough(result.slip));
    if (candidate.work > Real(0)) {
      // The work of a share s is s slope + s^2 (work - slope).
      const Real share =
          std::max(Real(0), -candidate.slope / (Real(2) * (candidate.work - candidate.slope)));
      for (Real& x : candidate_) x *= share;
      candidate = try_candidate(problem, problem.good_enough(result.slip));
    }
    if (!(candidate.residual < result.residual)) return;
    result.residual = candidate.residual;
    best_ = candidate_;
    best_v_ = candidate_v_;
  }

  /// Effect of impulses on an island.
  struct Candidate {
    Real residual = Real(0);  // [m/s] Largest distance of a row from its law.
    Real work = Real(0);      // [J] Energy that they give.
    Real slope = Real(0);     // [J] The same for a small share of them, by that share.
  };
  /// Finds the velocities by `candidate_`. Rows change the bodies' energy by
  /// sum l . (w_free + w) / 2. These velocities are not relative to their targets.
  /// @param error  [m/s] Velocity that may be wrong.
  [[nodiscard]] Candidate try_candidate(const CoulombProblem<Real>& problem, Real error) {
    using std::abs;
    const std::span<const Row> rows = problem.rows;
    candidate_v_.assign(problem.rhs.begin(), problem.rhs.end());
    for_each_part(rows, [&](std::size_t k, std::size_t part) {
      const Real x = candidate_[k + part];
      if (x != Real(0)) rows[k + part].add_to(candidate_v_, x);
    });
    response_.solve(candidate_v_.data());
    evaluate(rows, candidate_v_, candidate_velocity_);
    Candidate found;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const Row& row = rows[k];
      if (row.kind != RowKind::tangent && row.response > Real(0)) {
        found.residual = std::max(found.residual,
                                  distance_from_law(row, &candidate_[k], &candidate_velocity_[k]));
      }
      if (row.kind == RowKind::bounded) continue;
      const Real start =
          candidate_[k] * (free_velocity_[k] + row.bias) - abs(candidate_[k]) * error;
      found.slope += start;
      found.work += start + candidate_[k] * (candidate_velocity_[k] - free_velocity_[k]) / Real(2);
    }
    return found;
  }

  /// [-] Rows of a law: three of a cone, else one.
  [[nodiscard]] static std::size_t parts_of(const Row& row) {
    return row.kind == RowKind::cone ? 3 : 1;
  }

  /// Calls use(number of the branch, part) for all rows that can act. Parts of a cone are its three
  /// rows.
  template <typename Use>
  static void for_each_part(std::span<const Row> rows, Use&& use) {
    for (std::size_t k = 0; k < rows.size(); ++k) {
      if (rows[k].kind == RowKind::tangent || !(rows[k].response > Real(0))) continue;
      for (std::size_t part = 0; part < parts_of(rows[k]); ++part) use(k, part);
    }
  }

  BlockLu<Real> lu_;
  BlockCholesky<Real> cholesky_;
  bool is_symmetric_ = false;              // True if `cholesky_` was factored last.
  BlockPattern diagonal_;                  // Of Mt, where it does not couple bodies.
  BlockCholesky<Real> linear_, response_;  // Mt, and its factors.
  DynamicArray<Branch> branches_, factored_;
  std::array<Block6<Real>, 4> pair_{};
  DynamicArray<Real> v_, step_, nearest_v_, candidate_v_, best_v_;
  DynamicArray<Real> impulse_, centre_, nearest_impulse_, candidate_, best_;
  DynamicArray<Real> velocity_, candidate_velocity_, free_velocity_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
