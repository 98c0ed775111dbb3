/// @file
/// Solver of small stiff islands. Stacks of unlike masses, grips, mechanisms and patches of sensors
/// are all in one system.
///
/// Coulomb's law is solved by `CoulombNewton`, with `InteriorPoint` as its fallback. The algorithm
/// below is for displacements and for scalars with derivatives. It is also the fallback for what is
/// crushed, and for islands so small that sixty Newton steps are cheap.
///
/// The unknowns are the velocities v of the bodies. Soft blocks are linear in v and belong to the
/// matrix Mt = M + sum G^T A6 G. Every other constraint i has a multiplier. A projection P_i maps
/// it onto the allowed impulses (any value, an interval, Coulomb's cone). The proximal-point method
///     lambda+ = P(lambda - (J v - b + s) / R),   Mt v = r + J^T lambda+
/// is iterated with R = eps K. Here K is the response of each constraint by itself. For a given
/// lambda the two equations are the gradient of a convex function of v. Newton's method with an
/// exact line search minimises it from anywhere. Its Hessian Mt + J^T D J is as sparse as the
/// island (`IslandOrder`). Redundant constraints share their load evenly.
/// Nothing is ever divided by their (singular) response.
///
/// The projection on a cone makes sliding surfaces separate at mu |v_t|. The shift s = mu |v_t| of
/// the last solved problem cancels that (De Saxce and Feng 1998; Acary, Cadoux, Lemarechal and
/// Malick 2011). docs/solver.md derives this, and compares it with friction disks of fixed radius.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/error.hpp>
#include <bristle/core/no_index.hpp>
#include <bristle/dynamics/solver/coulomb_newton.hpp>
#include <bristle/dynamics/solver/derivative_watch.hpp>
#include <bristle/dynamics/solver/interior_point.hpp>
#include <bristle/dynamics/solver/island_rows.hpp>
#include <bristle/dynamics/solver/method_choice.hpp>
#include <bristle/dynamics/solver/solver_constants.hpp>
#include <bristle/dynamics/solver/solver_types.hpp>
#include <bristle/math/spatial.hpp>

#include <algorithm>
#include <type_traits>

namespace bristle::inline BRISTLE_ABI::detail {

/// The algorithm with its scratch memory. One object serves many islands in turn. Islands of floats
/// are solved in double. In float eps^-1 leaves no digits.
template <Scalar S>
class ProximalSolver {
 public:
  using Real = std::conditional_t<std::is_same_v<S, float>, double, S>;

  /// Finds the impulses of all constraints and the motion of the soft blocks. Starts from the
  /// present impulses.
  ///
  /// @return [m/s] Residual of the worst constraint. It is infinite if the matrix is not positive
  ///         definite (input that is not finite). Nothing was changed then.
  Real solve(const Island& island, Constraints<S>& constraints, std::span<SolverBody<S>> bodies,
             const SolveContext<S>& context, SolveReport<S>& report) {
    rows_.number(island, constraints, bodies);
    rows_.add_velocity_rows(island, constraints, bodies);
    make_matrix(island, constraints, bodies);
    drop_locked_rows(island, constraints, bodies);
    // If all is linear, one step from zero is exact. From anywhere else it would leave the
    // round-off of stiff blocks.
    v_.assign(rows_.unknowns(), Real(0));
    if (rows_.can_switch()) {
      for (const std::uint32_t slot : island.bodies) rows_.put(slot, bodies[slot].twist, v_);
    }
    is_stiff_ = rows_.can_switch() && !island.soft.empty();
    // Slipping contacts are assumed to slip on as at the start of the step. Another guess could be
    // slip that the coming impulses stop. The iteration could then end with a grip that slides
    // although it could hold.
    step_.assign(rows_.unknowns(), Real(0));
    for (const std::uint32_t slot : island.bodies) rows_.put(slot, bodies[slot].start, step_);
    rows_.evaluate(step_);
    rows_.set_shifts();
    // Well below the tolerance. A sweep over the result then finds nothing to do.
    const Real tolerance =
        Real(chosen::direct_tolerance_share) * Real(context.velocity_tolerance);
    enough_ = Real(context.velocity_tolerance);
    // Derivatives have to settle, too, which the iteration waits for.
    if constexpr (derivatives_of<S> == 0) {
      if (rows_.can_switch() && (rows_.has_impulses() || !context.is_cheap())) {
        const Real left = solve_law(island, constraints, bodies, context, report);
        if (left < infinity<Real>) return left;
      }
    }
    const Real left =
        iterate(enough_ > Real(context.velocity_tolerance) ? enough_ : tolerance, context, report);
    if (!(left < infinity<Real>)) return left;
    rows_.store_impulses(island, constraints);
    if (left <= tolerance && island.blocks.empty() && island.soft.empty() &&
        !rows_.has_sliding(eps_, tolerance)) {
      find_transient_impulses(island, constraints, bodies,
                              [this](DynamicArray<Real>& x) { hessian_.solve(x.data()); });
    }
    store_soft(island, constraints, bodies);
    return left;
  }

  /// Solves the position problem (`SequentialSolver::sweep_positions`) of the same island. Finds
  /// the position impulses and their motion.
  /// @return [m/s] Like `solve`, for displacements divided by the step.
  Real place(const Island& island, Constraints<S>& constraints, std::span<SolverBody<S>> bodies,
             const SolveContext<S>& context, SolveReport<S>& report) {
    rows_.number(island, constraints, bodies);
    rows_.add_position_rows(island, constraints, bodies, context.dt);
    make_mass(island, bodies);
    drop_locked_rows(island, constraints, bodies);
    is_stiff_ = false;
    // Motion without position impulses: the present motion less their effect.
    v_.resize(rows_.unknowns());
    for (const std::uint32_t slot : island.bodies) rows_.put(slot, bodies[slot].motion, v_);
    rows_.remove_impulses(v_, rhs_, matrix_);
    const Real left = iterate(Real(context.position_tolerance / context.dt), context, report);
    if (!(left < infinity<Real>)) return left;
    rows_.store_position_impulses(island, constraints);
    for (const std::uint32_t slot : island.bodies) {
      bodies[slot].motion = rows_.twist(slot, v_, bodies);
    }
    return left;
  }

  /// [m/s] Residual at which the last `solve` counts as done. It is larger where surfaces slide
  /// than where they rest.
  [[nodiscard]] Real enough() const { return enough_; }

 private:
  Real solve_law(const Island& island, Constraints<S>& constraints, std::span<SolverBody<S>> bodies,
                 const SolveContext<S>& context, SolveReport<S>& report);
  [[nodiscard]] ConvexProblem<Real> convex_problem(const CoulombProblem<Real>& problem);
  void take(const CoulombResult<Real>& found);
  CoulombResult<Real> solve_from_inside(CoulombProblem<Real> problem,
                                        const CoulombResult<Real>& found,
                                        const SolveContext<S>& context, SolveReport<S>& report);
  void store_soft(const Island& island, Constraints<S>& constraints,
                  std::span<SolverBody<S>> bodies);
  void make_mass(const Island& island, std::span<const SolverBody<S>> bodies);
  void make_matrix(const Island& island, const Constraints<S>& constraints,
                   std::span<const SolverBody<S>> bodies);
  void add_soft(const SoftBlock<S>& soft, std::span<const SolverBody<S>> bodies);
  void drop_locked_rows(const Island& island, const Constraints<S>& constraints,
                        std::span<const SolverBody<S>> bodies);
  template <typename SolveLinear>
  void find_transient_impulses(const Island& island, Constraints<S>& constraints,
                               std::span<const SolverBody<S>> bodies,
                               const SolveLinear& solve_linear);
  Real iterate(Real tolerance, const SolveContext<S>& context, SolveReport<S>& report);
  bool minimise(Real eps, Real tolerance, int& steps, int most_steps);
  [[nodiscard]] Real mismatch() const;
  [[nodiscard]] bool have_derivatives_settled(const SolverDef<S>& settings);
  void find_gradient(Real eps);
  Real search_line(Real eps);

  IslandRows<S, Real> rows_;
  CoulombNewton<Real> newton_;
  InteriorPoint<Real> interior_;
  DynamicArray<Real> found_;  // Impulses from the warm start.
  Real enough_ = Real(0);
  BlockCholesky<Real> matrix_;   // Mt.
  BlockCholesky<Real> hessian_;  // Mt + J^T D J, then its factor.
  Real eps_ = Real(1);           // The eps of `hessian_`.
  bool is_stiff_ = false;        // True if one Newton step leaves more than round-off.
  DynamicArray<Real> rhs_;       // r.
  DynamicArray<Real> masses_;    // Diagonal of M.
  Real mismatch_ = Real(0);      // Of the last `minimise`.
  DerivativeWatch<Real> watch_;
  DynamicArray<Real> v_, settled_, gradient_, step_, product_;
};

// Implementation ----------------------------------------------------------------------------------

/// Solves with Coulomb's law itself: from the solution of the last step if there is one, and from
/// that of the convex problem where it leads nowhere.
/// @return [m/s] Residual. Infinite if the proximal iteration is to solve it.
template <Scalar S>
auto ProximalSolver<S>::solve_law(const Island& island, Constraints<S>& constraints,
                                  std::span<SolverBody<S>> bodies, const SolveContext<S>& context,
                                  SolveReport<S>& report) -> Real {
  product_.resize(rows_.unknowns());
  for (const std::uint32_t slot : island.bodies) rows_.put(slot, bodies[slot].free, product_);
  // Contacts alone are swept first in the next step. A small residual here ends it after one sweep.
  // With joints sweeps do not help. A larger residual is then enough.
  const bool is_swept_first = !has_joints(island, constraints) && island.soft.empty();
  const bool is_fresh = !rows_.has_impulses();
  CoulombProblem<Real> problem{
      .rows = rows_.rows(),
      .matrix = &matrix_,
      .rhs = rhs_,
      .is_uncoupled = island.soft.empty(),
      .is_held = is_held<S>(island, constraints, bodies, context),
      .is_near = false,
      .start = &step_,
      .free = &product_,
      .tolerance = Real(is_swept_first ? chosen::swept_first_tolerance_share
                                       : chosen::direct_tolerance_share) *
                   Real(context.velocity_tolerance),
      .speed_change = Real(context.driven_change),
      .most_steps =
          std::min(context.most_newton_steps(report),
                   is_fresh ? chosen::most_landing_steps : context.settings.max_newton_steps)};
  // A warm step in which a grip begins to slip must not allocate.
  if (!context.is_cheap()) {
    interior_.reserve(convex_problem(problem));
    found_.reserve(rows_.rows().size());
  }
  CoulombResult<Real> found = newton_.solve(problem);
  report.factorisations += found.factorisations;
  enough_ = std::max(enough_, problem.good_enough(found.slip));
  const bool is_short = found.residual > enough_ && !found.is_contradictory;
  const bool is_crushed =
      is_short && rows_.is_crushed([this](std::size_t k) { return newton_.impulse(k); });
  // The next method is the proximal iteration, whose opening speeds follow the slip, where the
  // budget pays for it. Crushed bodies have no other: `InteriorPoint` does not know cones that end.
  const bool is_paid = is_crushed ? context.cost_share() <= 1 : context.is_cheap();
  // Where surfaces slide fast and nothing is crushed, neither fallback is worth its cost. In two of
  // three cases it ends farther from the law (docs/measurements/0042-a-budget-for-an-island.md).
  const Real fast = std::max(problem.speed_change, Real(context.velocity_tolerance));
  const bool slides = !is_fresh && found.slip > fast;
  const bool is_unsolved = is_short && ((is_crushed && is_paid) || !slides);
  if (is_unsolved && is_paid) return infinity<Real>;
  const bool has_interior = is_unsolved && !is_crushed;
  take(found);
  if (has_interior) found = solve_from_inside(problem, found, context, report);
  if (!(found.residual < infinity<Real>)) return infinity<Real>;
  rows_.store_impulses(island, constraints);
  const auto tolerance = Real(context.velocity_tolerance);
  if (found.factorisations > 0 && found.residual <= tolerance && found.slip <= tolerance &&
      island.blocks.empty() && island.soft.empty()) {
    eps_ = found.eps;
    rows_.evaluate(v_);
    rows_.set_sides(eps_);
    find_transient_impulses(island, constraints, bodies,
                            [this](DynamicArray<Real>& x) { newton_.solve_linear(x); });
  }
  store_soft(island, constraints, bodies);
  return found.residual;
}

/// The convex problem with the slip at the start of the step.
template <Scalar S>
auto ProximalSolver<S>::convex_problem(const CoulombProblem<Real>& problem) -> ConvexProblem<Real> {
  return {.rows = rows_.rows(),
          .matrix = problem.matrix,
          .rhs = problem.rhs,
          .speed = problem.speed_change};
}

/// Takes what Newton's method found, if it did.
template <Scalar S>
void ProximalSolver<S>::take(const CoulombResult<Real>& found) {
  if (!(found.residual < infinity<Real>)) return;
  for (std::size_t k = 0; k < rows_.rows().size(); ++k) rows_.rows()[k].lambda = newton_.impulse(k);
  v_ = newton_.velocities();
}

/// Solves the convex problem from inside its cones, and the law from there.
/// @param found  The result from the warm start, which has been taken.
/// @return The better of both results.
template <Scalar S>
auto ProximalSolver<S>::solve_from_inside(CoulombProblem<Real> problem,
                                          const CoulombResult<Real>& found,
                                          const SolveContext<S>& context, SolveReport<S>& report)
    -> CoulombResult<Real> {
  using std::abs;
  const std::span<IslandRow<Real>> rows = rows_.rows();
  found_.resize(rows.size());
  for (std::size_t k = 0; k < rows.size(); ++k) found_[k] = rows[k].lambda;
  ConvexProblem<Real> convex = convex_problem(problem);
  rows_.evaluate(*problem.free);
  for (const IslandRow<Real>& row : rows) {
    if (!(row.response > Real(0)) || row.kind == RowKind::free) continue;
    convex.speed = std::max(convex.speed, abs(row.velocity));
  }
  // Newton's method does the rest. The nearer to the solution, the nearer to the edges of cones.
  convex.tolerance =
      std::max(enough_, Real(chosen::interior_solved_share) * problem.speed_change);
  convex.most_steps = context.most_interior_steps(report);
  report.factorisations += interior_.solve(convex);
  for (std::size_t k = 0; k < rows.size(); ++k) rows[k].lambda = interior_.impulse(k);
  problem.start = &interior_.velocities();
  problem.is_held = false;
  problem.is_near = true;
  problem.most_steps = context.most_newton_steps(report);
  const CoulombResult<Real> better = newton_.solve(problem);
  report.factorisations += better.factorisations;
  if (!(better.residual < found.residual)) {
    for (std::size_t k = 0; k < rows.size(); ++k) rows[k].lambda = found_[k];
    return found;
  }
  enough_ = std::max(enough_, problem.good_enough(better.slip));
  take(better);
  return better;
}

/// Writes the motions of the soft blocks, and their impulses.
template <Scalar S>
void ProximalSolver<S>::store_soft(const Island& island, Constraints<S>& constraints,
                                   std::span<SolverBody<S>> bodies) {
  for (const std::uint32_t s : island.soft) {
    SoftBlock<S>& soft = constraints.soft[s];
    soft.motion = relative_motion(soft, rows_.twist(soft.body_a, v_, bodies),
                                  rows_.twist(soft.body_b, v_, bodies));
    soft.impulse = soft.offset + soft.matrix * soft.motion;
  }
}

template <Scalar S>
void ProximalSolver<S>::make_mass(const Island& island, std::span<const SolverBody<S>> bodies) {
  matrix_.reset(rows_.pattern());
  rhs_.assign(rows_.unknowns(), Real(0));
  masses_.resize(rows_.unknowns());
  for (const std::uint32_t slot : island.bodies) {
    const SolverBody<S>& body = bodies[slot];
    const std::size_t u = rows_.unknown(slot);
    Real* const block = matrix_.block(matrix_.pattern().diagonal(u / 6));
    const auto at = [&](std::size_t i, std::size_t j) -> Real& {
      return block[Block6<Real>::stride * j + i];
    };
    for (std::size_t i = 0; i < 3; ++i) {
      const auto e = static_cast<Eigen::Index>(i);
      at(i, i) = body.is_locked(e) ? Real(1) : Real(body.mass);
      at(3 + i, 3 + i) = body.is_locked(e + 3) ? Real(1) : Real(body.inertia(e, e));
      for (std::size_t j = 0; j < i; ++j) {
        const auto f = static_cast<Eigen::Index>(j);
        const bool is_free = !body.is_locked(e + 3) && !body.is_locked(f + 3);
        at(3 + i, 3 + j) = is_free ? Real(body.inertia(e, f)) : Real(0);
      }
    }
    for (std::size_t i = 0; i < 6; ++i) masses_[u + i] = at(i, i);
  }
}

template <Scalar S>
void ProximalSolver<S>::make_matrix(const Island& island, const Constraints<S>& constraints,
                                    std::span<const SolverBody<S>> bodies) {
  make_mass(island, bodies);
  v_.resize(rows_.unknowns());
  for (const std::uint32_t slot : island.bodies) rows_.put(slot, bodies[slot].free, v_);
  matrix_.multiply(v_.data(), rhs_.data());
  for (const std::uint32_t s : island.soft) add_soft(constraints.soft[s], bodies);
}

template <Scalar S>
void ProximalSolver<S>::add_soft(const SoftBlock<S>& soft, std::span<const SolverBody<S>> bodies) {
  using Matrix = Eigen::Matrix<Real, 6, 6, Eigen::DontAlign>;
  using Vector = Eigen::Matrix<Real, 6, 1, Eigen::DontAlign>;
  // G maps the twist of a body to the block's motion: V_c = v - arm x w for A, its negative for B.
  // Columns of locked axes are left out.
  const auto motion_of_body = [&](std::uint32_t slot, const Vec3<S>& arm, Real sign) {
    Matrix G = sign * shift_matrix<Real>(arm.template cast<Real>());
    for (Eigen::Index axis = 0; axis < 6; ++axis) {
      if (rows_.unknown(slot) != no_index && bodies[slot].is_locked(axis)) {
        set_column(G, axis, zero<Vec6<Real>>());
      }
    }
    return G;
  };
  const std::uint32_t slots[2] = {soft.body_a, soft.body_b};
  const Matrix G[2] = {motion_of_body(slots[0], soft.arm_a, Real(1)),
                       motion_of_body(slots[1], soft.arm_b, Real(-1))};
  const Matrix A = soft.matrix.template cast<Real>();
  // Immovable bodies contribute their known motion to the constant part.
  Vector constant = soft.offset.template cast<Real>();
  for (int k = 0; k < 2; ++k) {
    if (rows_.unknown(slots[k]) != no_index) continue;
    const Vector known = stacked(bodies[slots[k]].free).template cast<Real>();
    constant += A * (G[k] * known);
  }
  for (int k = 0; k < 2; ++k) {
    const std::size_t row = rows_.unknown(slots[k]);
    if (row == no_index) continue;
    const Matrix left = G[k].transpose() * A;
    const Vector load = G[k].transpose() * constant;
    for (std::size_t i = 0; i < 6; ++i) rhs_[row + i] -= load[static_cast<Eigen::Index>(i)];
    for (int l = 0; l < 2; ++l) {
      const std::size_t column = rows_.unknown(slots[l]);
      if (column == no_index || column > row) continue;  // Lower triangle only.
      const Matrix product = left * G[l];
      for (std::size_t i = 0; i < 6; ++i) {
        for (std::size_t j = 0; j < (row == column ? i + 1 : 6); ++j) {
          matrix_.at(row + i, column + j) +=
              product(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
        }
      }
    }
  }
}

/// Drops rows along which joints leave no mobility. A finger on a slide may be pushed across it. It
/// could only yield by being torn off (docs/decisions/0009-locked-contact-directions.md). The
/// remaining response of a row is that of the matrix with all joints held by stiff springs.
template <Scalar S>
void ProximalSolver<S>::drop_locked_rows(const Island& island, const Constraints<S>& constraints,
                                         std::span<const SolverBody<S>> bodies) {
  if (!rows_.find_lockable(island, constraints, bodies)) return;
  hessian_ = matrix_;
  rows_.add_joints(Real(chosen::joint_spring_softness), hessian_);
  if (!hessian_.factor()) return;
  rows_.drop_locked(hessian_, Real(chosen::locked_response_share), product_);
}

/// Finds the transient impulses of contacts, which the next step does not need. Impulses would be
/// smaller by them if this step had started with its final velocities v. The difference is linear
/// as long as no contact changes its state. No contact may slide either, since the opening speed
/// would change too. The factor of the last Newton step gives it:
///     H dv = M (v - v0),   dlambda = D J dv.
/// Without them, a step that stops a motion would reverse it in the next one. Heavy bodies on light
/// ones would never come to rest.
template <Scalar S>
template <typename SolveLinear>
void ProximalSolver<S>::find_transient_impulses(const Island& island, Constraints<S>& constraints,
                                                std::span<const SolverBody<S>> bodies,
                                                const SolveLinear& solve_linear) {
  product_.resize(v_.size());
  step_.resize(v_.size());
  for (const std::uint32_t slot : island.bodies) rows_.put(slot, bodies[slot].start, product_);
  for (std::size_t i = 0; i < v_.size(); ++i) product_[i] = v_[i] - product_[i];
  matrix_.multiply(product_.data(), step_.data());
  solve_linear(step_);
  rows_.evaluate_step(step_);
  rows_.store_transient_impulses(eps_, island, constraints, product_);
}

/// The outer loop: updates multipliers and eps, and opening speeds once their problem is solved.
template <Scalar S>
auto ProximalSolver<S>::iterate(Real tolerance, const SolveContext<S>& context,
                                SolveReport<S>& report) -> Real {
  // A smaller eps is a stiffer penalty. It needs fewer outer iterations, but many Newton steps if
  // one starts from far away. Where no row can switch, the smallest eps is right at once.
  const Real smallest = Real(chosen::least_eps);
  Real eps = rows_.can_switch() ? Real(chosen::proximal_first_eps) : smallest;
  Real left = infinity<Real>;
  Real inner = Real(0);
  const int most_steps = context.most_newton_steps(report);
  int steps = 0;
  watch_.start();
  rows_.evaluate(v_);
  for (int outer = 0; steps < most_steps; ++outer) {
    // Shifts follow the slip of a solved convex problem. Before, all that is loaded creeps by eps.
    // Shifts by that creep would unload what sticks, and what could hold would begin to slide.
    const Real solved = Real(chosen::convex_solved_share) * left;
    if (outer > 0 && rows_.convex_residual() <= solved) rows_.set_shifts();
    if (!minimise(eps, std::max(Real(chosen::inner_tolerance_share) * tolerance, inner), steps,
                  most_steps)) {
      // The impulses of an iteration that was cut short match no velocities. Those of the iteration
      // before do.
      v_ = settled_;
      break;
    }
    settled_ = v_;
    eps_ = eps;
    rows_.accept(eps);
    const Real before = left;
    left = std::max(rows_.residual(), mismatch_);
    if (left <= tolerance && have_derivatives_settled(context.settings)) break;
    // Slip that keeps turning leaves a residual that no longer falls.
    const bool is_stalled = left > Real(chosen::stalled_residual_share) * before;
    if (outer >= chosen::least_outer_iterations && is_stalled) break;
    eps = std::max(smallest, eps / Real(chosen::proximal_eps_divisor));
    // Exact minima of a changing function are no use.
    inner = Real(chosen::inner_residual_share) * left;
  }
  report.factorisations += steps;
  return left;
}

template <Scalar S>
bool ProximalSolver<S>::have_derivatives_settled(const SolverDef<S>& settings) {
  return watch_.have_settled(Real(settings.tolerance), [&](auto& watch) {
    for (const Real& x : v_) watch.velocity(x);
    rows_.for_each_load([&](const Real& x, const Real& response) { watch.impulse(x, response); });
  });
}

/// The inner loop: Newton's method with line search, until the impulses of the velocities give
/// these velocities, or come no nearer to them. `mismatch_` says what is left. The velocities are
/// made from the impulses in the end.
/// @return True if it came to an end.
template <Scalar S>
bool ProximalSolver<S>::minimise(Real eps, Real tolerance, int& steps, int most_steps) {
  using std::abs;
  find_gradient(eps);
  mismatch_ = infinity<Real>;
  Real nearest = infinity<Real>;
  int idle = 0;
  while (steps < most_steps) {
    hessian_ = matrix_;
    rows_.add_hessian(eps, hessian_);
    if (!hessian_.factor()) return false;
    ++steps;
    step_.resize(gradient_.size());
    for (std::size_t i = 0; i < step_.size(); ++i) step_[i] = -gradient_[i];
    hessian_.solve(step_.data());
    Real size = Real(0);
    for (const Real x : step_) size = std::max(size, abs(x));
    if (!(size < infinity<Real>)) return false;
    // If a whole step switches nothing, the function was the parabola that Newton minimises.
    const bool is_whole = search_line(eps) == Real(1);
    if (is_whole && !is_stiff_ && rows_.is_linear(eps)) {
      mismatch_ = Real(0);
      return true;
    }
    find_gradient(eps);
    // Impulses are velocities divided by eps. So small steps still bring them nearer, and several
    // that do not leave round-off.
    mismatch_ = mismatch();
    const bool is_idle =
        size <= tolerance && mismatch_ > Real(chosen::idle_mismatch_share) * nearest;
    idle = is_idle ? idle + 1 : 0;
    nearest = std::min(nearest, mismatch_);
    if (mismatch_ <= tolerance || idle >= chosen::most_idle_steps) return true;
  }
  return false;
}

/// [m/s, rad/s] Difference between the velocities and those by the impulses.
template <Scalar S>
auto ProximalSolver<S>::mismatch() const -> Real {
  using std::abs;
  Real largest = Real(0);
  for (std::size_t i = 0; i < gradient_.size(); ++i) {
    largest = std::max(largest, abs(gradient_[i]) / masses_[i]);
  }
  return largest;
}

/// gradient := Mt v - r - J^T lambda+.
template <Scalar S>
void ProximalSolver<S>::find_gradient(Real eps) {
  gradient_.resize(v_.size());
  matrix_.multiply(v_.data(), gradient_.data());
  for (std::size_t i = 0; i < v_.size(); ++i) gradient_[i] -= rhs_[i];
  rows_.subtract_impulses(eps, gradient_);
}

/// Moves v along the step to the minimum of the convex function on that line. The derivative grows
/// along the line. The Illinois method finds its root.
/// @return Share of the step that was taken.
template <Scalar S>
auto ProximalSolver<S>::search_line(Real eps) -> Real {
  using std::abs;
  rows_.evaluate_step(step_);
  product_.resize(v_.size());
  matrix_.multiply(step_.data(), product_.data());
  Real constant = Real(0);
  Real slope = Real(0);
  for (std::size_t i = 0; i < v_.size(); ++i) {
    constant += product_[i] * v_[i] - step_[i] * rhs_[i];
    slope += product_[i] * step_[i];
  }
  const auto derivative = [&](Real s) { return constant + s * slope - rows_.work(eps, s); };
  Real low = Real(0);
  Real at_low = derivative(low);
  Real high = Real(1);
  Real at_high = derivative(high);
  const Real small = Real(chosen::line_search_share) * abs(at_low);
  Real s = high;
  if (at_high > small && at_low < Real(0)) {
    int side = 0;
    for (int i = 0; i < chosen::most_line_search_steps; ++i) {
      s = (low * at_high - high * at_low) / (at_high - at_low);
      const Real at_s = derivative(s);
      if (abs(at_s) <= small) break;
      if (at_s > Real(0)) {
        high = s;
        at_high = at_s;
        if (side == 1) at_low /= Real(2);
        side = 1;
      } else {
        low = s;
        at_low = at_s;
        if (side == -1) at_high /= Real(2);
        side = -1;
      }
    }
  }
  for (std::size_t i = 0; i < v_.size(); ++i) v_[i] += s * step_[i];
  rows_.move(s);
  return s;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
