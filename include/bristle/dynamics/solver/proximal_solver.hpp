/// @file
/// The solver of small stiff islands: stacks of unlike masses, grips, mechanisms, patches of
/// sensors, all in one system.
///
/// Unknown are the velocities v of the bodies. Soft blocks are linear in v and belong to the matrix
/// Mt = M + sum G^T A6 G. Every other constraint i has a multiplier and a projection P_i onto what
/// its impulse may be (any value, an interval, Coulomb's cone), and the proximal-point method
///     lambda+ = P(lambda - (J v - b + s) / R),   Mt v = r + J^T lambda+
/// is iterated with R = eps K, K the response of each constraint by itself. For given lambda the
/// two equations are the gradient of a convex function of v, which Newton's method with an exact
/// line search minimises from anywhere; its Hessian Mt + J^T D J is sparse like the island and is
/// factored within its envelope. Redundant constraints share their load evenly, since nothing is
/// ever divided by their (singular) response.
///
/// The projection on a cone makes sliding surfaces part at mu |v_t|; s = mu |v_t| of the iteration
/// before takes that out again (De Saxce and Feng 1998; Acary, Cadoux, Lemarechal and Malick 2011).
/// docs/solver.md derives this, and tells what friction disks of fixed radius did instead.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/solver/coulomb_newton.hpp>
#include <bristle/dynamics/solver/derivative_watch.hpp>
#include <bristle/dynamics/solver/island_rows.hpp>
#include <bristle/dynamics/solver/solver_types.hpp>

#include <algorithm>
#include <type_traits>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// Scratch memory and the algorithm. One object serves many islands, one after the other. Islands
/// of floats are solved in double: eps^-1 leaves float no digits.
template <Scalar S>
class ProximalSolver {
 public:
  using Real = std::conditional_t<std::is_same_v<S, float>, double, S>;

  /// Finds the impulses of all constraints and the motion of the soft blocks, starting from the
  /// impulses there are.
  ///
  /// @return [m/s] What is left to solve, in the worst constraint; infinite when the matrix is not
  ///         positive definite (input that is not finite), and nothing was changed then.
  Real solve(const Island& island, Constraints<S>& constraints, std::span<SolverBody<S>> bodies,
             const SolveContext<S>& context, SolveReport<S>& report) {
    rows_.number(island, constraints, bodies);
    rows_.add_velocity_rows(island, constraints, bodies);
    make_matrix(island, constraints, bodies);
    drop_locked_rows();
    // Where all is linear one step from zero is exact; from anywhere else it would leave what
    // rounding makes of stiff blocks there.
    detail::refill(v_, rows_.unknowns(), Real(0));
    if (rows_.can_switch()) {
      for (const std::uint32_t slot : island.bodies) rows_.put(slot, bodies[slot].twist, v_);
    }
    is_stiff_ = rows_.can_switch() && !island.soft.empty();
    // What slips is taken to slip on as it did when the step began. From slip that the impulses to
    // come will stop, the iteration can end where a grip slides that could hold.
    detail::refill(step_, rows_.unknowns(), Real(0));
    for (const std::uint32_t slot : island.bodies) rows_.put(slot, bodies[slot].start, step_);
    rows_.evaluate(step_);
    rows_.set_shifts();
    // Well below what counts, so that a sweep over the result finds nothing to do.
    const Real tolerance = Real(0.1) * Real(context.velocity_tolerance);
    enough_ = Real(context.velocity_tolerance);
    if constexpr (derivatives_of<S> == 0) {
      if (rows_.can_switch() && rows_.has_impulses()) {
        const Real left = follow(island, constraints, bodies, context, report);
        if (left < infinity<Real>) return left;
      }
    }
    const Real left = iterate(tolerance, context.settings, report);
    if (!(left < infinity<Real>)) return left;
    rows_.store_impulses(island, constraints);
    if (left <= tolerance && island.blocks.empty() && island.soft.empty() &&
        !rows_.has_sliding(eps_, tolerance)) {
      find_passing(island, constraints, bodies,
                   [this](std::vector<Real>& x) { hessian_.solve(x.data()); });
    }
    store_soft(island, constraints, bodies);
    return left;
  }

  /// Solves the position problem (`SequentialSolver::sweep_positions`) of the same island: finds
  /// the placed impulses, and the motion that they give.
  /// @return [m/s] As above, for displacements divided by the step.
  Real place(const Island& island, Constraints<S>& constraints, std::span<SolverBody<S>> bodies,
             const SolveContext<S>& context, SolveReport<S>& report) {
    rows_.number(island, constraints, bodies);
    rows_.add_position_rows(island, constraints, bodies, context.dt);
    make_mass(island, bodies);
    drop_locked_rows();
    is_stiff_ = false;
    // The motion without any placed impulse: the present one with them taken out again.
    v_.resize(rows_.unknowns());
    for (const std::uint32_t slot : island.bodies) rows_.put(slot, bodies[slot].motion, v_);
    rows_.remove_impulses(v_, rhs_, matrix_);
    const Real left =
        iterate(Real(context.position_tolerance / context.dt), context.settings, report);
    if (!(left < infinity<Real>)) return left;
    rows_.store_placed(island, constraints);
    for (const std::uint32_t slot : island.bodies) {
      bodies[slot].motion = rows_.twist(slot, v_, bodies);
    }
    return left;
  }

  /// [m/s] What may be left to solve for the last `solve` to count as done: more where surfaces
  /// slide than where they rest.
  [[nodiscard]] Real enough() const { return enough_; }

 private:
  Real follow(const Island& island, Constraints<S>& constraints, std::span<SolverBody<S>> bodies,
              const SolveContext<S>& context, SolveReport<S>& report);
  void store_soft(const Island& island, Constraints<S>& constraints,
                  std::span<SolverBody<S>> bodies);
  /// Whether all of Newton's steps on the convex problem take more than ten of the largest
  /// factorisations.
  [[nodiscard]] static bool is_convex_costly(const SolveContext<S>& context) {
    const auto steps = static_cast<std::uint64_t>(context.settings.max_newton_steps);
    return context.factor_work / 10 > context.settings.max_direct_work / steps;
  }
  void make_mass(const Island& island, std::span<const SolverBody<S>> bodies);
  void make_matrix(const Island& island, const Constraints<S>& constraints,
                   std::span<const SolverBody<S>> bodies);
  void add_soft(const SoftBlock<S>& soft, std::span<const SolverBody<S>> bodies);
  void drop_locked_rows();
  template <typename SolveLinear>
  void find_passing(const Island& island, Constraints<S>& constraints,
                    std::span<const SolverBody<S>> bodies, const SolveLinear& solve_linear);
  Real iterate(Real tolerance, const SolverDef<S>& settings, SolveReport<S>& report);
  bool minimise(Real eps, Real tolerance, int& steps, int most_steps);
  [[nodiscard]] Real mismatch() const;
  [[nodiscard]] bool have_derivatives_settled(const SolverDef<S>& settings);
  void find_gradient(Real eps);
  Real search_line(Real eps);

  IslandRows<S, Real> rows_;
  CoulombNewton<Real> newton_;
  Real enough_ = Real(0);
  EnvelopeMatrix<Real> matrix_;   // Mt.
  EnvelopeMatrix<Real> hessian_;  // Mt + J^T D J, then its factor.
  Real eps_ = Real(1);            // With which it was factored.
  bool is_stiff_ = false;         // Whether one step of Newton's leaves more than round-off.
  std::vector<Real> rhs_;         // r.
  std::vector<Real> masses_;      // Diagonal of M.
  DerivativeWatch<Real> watch_;
  std::vector<Real> v_, settled_, gradient_, step_, product_;
};

// Implementation -----------------------------------------------------------------------------------

/// Solves with Coulomb's law as it is, from the answer of the last step.
/// @return [m/s] What is left. Infinite where nothing was found that is good enough: the impulses
///         are as before.
template <Scalar S>
auto ProximalSolver<S>::follow(const Island& island, Constraints<S>& constraints,
                               std::span<SolverBody<S>> bodies, const SolveContext<S>& context,
                               SolveReport<S>& report) -> Real {
  const auto change = Real(context.driven_change);
  product_.resize(rows_.unknowns());
  for (const std::uint32_t slot : island.bodies) rows_.put(slot, bodies[slot].free, product_);
  // Contacts alone are swept first in the next step, which ends it where little is left. With
  // joints no sweep will do, and their rows need not agree to more than that.
  const bool is_swept_first = island.blocks.empty() && island.soft.empty();
  const CoulombProblem<Real> problem{
      .rows = rows_.rows(),
      .matrix = &matrix_,
      .rhs = rhs_,
      .is_uncoupled = island.soft.empty(),
      .start = &step_,
      .free = &product_,
      .tolerance = Real(is_swept_first ? 0.01 : 0.1) * Real(context.velocity_tolerance),
      .speed_change = change};
  const CoulombAnswer<Real> answer = newton_.solve(problem);
  report.factorisations += answer.factorisations;
  enough_ = std::max(enough_, problem.good_enough(answer.slip));
  // Many jammed bodies that are hit have no answer that is found in bounded time. Any that takes
  // energy and stops half of the impact will do for this step: the next begins near its own.
  const bool is_impact = answer.change > change && is_convex_costly(context);
  if (!(answer.residual <= (is_impact ? Real(0.5) * answer.change : enough_))) {
    return infinity<Real>;
  }
  enough_ = std::max(enough_, answer.residual);
  for (std::size_t k = 0; k < rows_.rows().size(); ++k) rows_.rows()[k].lambda = newton_.impulse(k);
  v_ = newton_.velocities();
  rows_.store_impulses(island, constraints);
  const auto tolerance = Real(context.velocity_tolerance);
  if (answer.factorisations > 0 && answer.residual <= tolerance && answer.slip <= tolerance &&
      is_swept_first) {
    eps_ = answer.eps;
    rows_.evaluate(v_);
    rows_.set_sides(eps_);
    find_passing(island, constraints, bodies,
                 [this](std::vector<Real>& x) { newton_.solve_linear(x); });
  }
  store_soft(island, constraints, bodies);
  return answer.residual;
}

/// Writes the motions of the soft blocks, and the impulses that belong to them.
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
  matrix_.reset(rows_.envelope());
  detail::refill(rhs_, rows_.unknowns(), Real(0));
  for (const std::uint32_t slot : island.bodies) {
    const SolverBody<S>& body = bodies[slot];
    const std::size_t u = rows_.unknown(slot);
    for (std::size_t i = 0; i < 3; ++i) {
      const auto e = static_cast<Eigen::Index>(i);
      matrix_.at(u + i, u + i) = body.is_locked(e) ? Real(1) : Real(body.mass);
      matrix_.at(u + 3 + i, u + 3 + i) = body.is_locked(e + 3) ? Real(1) : Real(body.inertia(e, e));
      for (std::size_t j = 0; j < i; ++j) {
        const auto f = static_cast<Eigen::Index>(j);
        const bool is_free = !body.is_locked(e + 3) && !body.is_locked(f + 3);
        matrix_.at(u + 3 + i, u + 3 + j) = is_free ? Real(body.inertia(e, f)) : Real(0);
      }
    }
  }
  masses_.resize(rows_.unknowns());
  for (std::size_t i = 0; i < masses_.size(); ++i) masses_[i] = matrix_.at(i, i);
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
  // Columns of axes on which nothing moves the body are left out.
  const auto motion_of_body = [&](std::uint32_t slot, const Vec3<S>& arm, Real sign) {
    Matrix G = sign * shift_matrix<Real>(arm.template cast<Real>());
    for (Eigen::Index axis = 0; axis < 6; ++axis) {
      if (rows_.unknown(slot) != rows_.none && bodies[slot].is_locked(axis)) G.col(axis).setZero();
    }
    return G;
  };
  const std::uint32_t slots[2] = {soft.body_a, soft.body_b};
  const Matrix G[2] = {motion_of_body(slots[0], soft.arm_a, Real(1)),
                       motion_of_body(slots[1], soft.arm_b, Real(-1))};
  const Matrix A = soft.matrix.template cast<Real>();
  // Bodies that forces do not move contribute their known motion to the constant part.
  Vector constant = soft.offset.template cast<Real>();
  for (int k = 0; k < 2; ++k) {
    if (rows_.unknown(slots[k]) != rows_.none) continue;
    Vector known;
    known << bodies[slots[k]].free.linear.template cast<Real>(),
        bodies[slots[k]].free.angular.template cast<Real>();
    constant += A * (G[k] * known);
  }
  for (int k = 0; k < 2; ++k) {
    const std::size_t row = rows_.unknown(slots[k]);
    if (row == rows_.none) continue;
    const Matrix left = G[k].transpose() * A;
    const Vector load = G[k].transpose() * constant;
    for (std::size_t i = 0; i < 6; ++i) rhs_[row + i] -= load[static_cast<Eigen::Index>(i)];
    for (int l = 0; l < 2; ++l) {
      const std::size_t column = rows_.unknown(slots[l]);
      if (column == rows_.none || column > row) continue;  // Lower triangle only.
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

/// Leaves out rows along which joints leave no mobility: a finger on a slide, pushed across it,
/// could only be met by tearing it off its slide
/// (docs/decisions/0009-locked-contact-directions.md). What is left of a row's response is that of
/// the matrix with all joints held by springs of 1e-9.
template <Scalar S>
void ProximalSolver<S>::drop_locked_rows() {
  if (!rows_.has_joints_beside_others()) return;
  hessian_ = matrix_;
  rows_.add_joints(Real(1e-9), hessian_);
  if (!hessian_.factor()) return;
  rows_.drop_locked(hessian_, Real(1e-6), product_);
}

/// Finds what of the contacts' impulses the next step will not need: what they would be less if
/// this one had started with the velocities v that it ends with. The difference is linear as long
/// as no contact changes its state or slides, where the opening speed would change too, and the
/// factor of the last step of Newton's gives it:
///     H dv = M (v - v0),   dlambda = D J dv.
/// Without it a step that stops what the last one left of motion would push it the other way in the
/// next, and heavy bodies on light ones would never come to rest.
template <Scalar S>
template <typename SolveLinear>
void ProximalSolver<S>::find_passing(const Island& island, Constraints<S>& constraints,
                                     std::span<const SolverBody<S>> bodies,
                                     const SolveLinear& solve_linear) {
  product_.resize(v_.size());
  step_.resize(v_.size());
  for (const std::uint32_t slot : island.bodies) rows_.put(slot, bodies[slot].start, product_);
  for (std::size_t i = 0; i < v_.size(); ++i) product_[i] = v_[i] - product_[i];
  matrix_.multiply(product_.data(), step_.data());
  solve_linear(step_);
  rows_.evaluate_step(step_);
  rows_.store_passing(eps_, island, constraints, product_);
}

/// The outer loop: multipliers, opening speeds, eps.
template <Scalar S>
auto ProximalSolver<S>::iterate(Real tolerance, const SolverDef<S>& settings,
                                SolveReport<S>& report) -> Real {
  // Smaller eps is a stiffer penalty: fewer outer iterations, but many Newton steps for one that
  // starts from far away. Where nothing can switch the smallest is right at once.
  const Real smallest = Real(1e-6);
  Real eps = rows_.can_switch() ? Real(1e-3) : smallest;
  Real left = infinity<Real>;
  Real inner = Real(0);
  int steps = 0;
  watch_.start();
  rows_.evaluate(v_);
  for (int outer = 0; steps < settings.max_newton_steps; ++outer) {
    if (outer > 0) rows_.set_shifts();
    if (!minimise(eps, std::max(Real(0.1) * tolerance, inner), steps, settings.max_newton_steps)) {
      // The impulses of an iteration that was cut short belong to no velocities: those of the one
      // before do.
      v_ = settled_;
      break;
    }
    settled_ = v_;
    eps_ = eps;
    rows_.accept(eps);
    const Real before = left;
    left = rows_.residual();
    if (left <= tolerance && have_derivatives_settled(settings)) break;
    // Slip that keeps turning leaves a residual that no longer falls.
    if (outer >= 10 && left > Real(0.9) * before) break;
    eps = std::max(smallest, eps / Real(10));
    inner = Real(0.01) * left;  // Exact minima of a function that is about to change are no use.
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

/// The inner loop: Newton with line search, until the impulses that belong to the velocities move
/// the bodies by these velocities. Steps that are small are not enough: stiffnesses of 1e6 make
/// much of what is left, and velocities are made of the impulses in the end.
/// @return Whether that was reached.
template <Scalar S>
bool ProximalSolver<S>::minimise(Real eps, Real tolerance, int& steps, int most_steps) {
  using std::abs;
  find_gradient(eps);
  Real left = infinity<Real>;
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
    // Where a whole step switches nothing, the function was the parabola that Newton minimises.
    const bool is_whole = search_line(eps) == Real(1);
    if (is_whole && !is_stiff_ && rows_.is_linear(eps)) return true;
    find_gradient(eps);
    // Where steps are small and no longer help, what is left is the rounding of large impulses.
    const Real before = left;
    left = mismatch();
    if (left <= tolerance || (size <= tolerance && left > before / Real(2))) return true;
  }
  return false;
}

/// [m/s, rad/s] By how much the velocities differ from what the impulses make of them.
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

/// Moves v along the step to the minimum of the convex function on that line: the root of its
/// derivative, which grows along the line, by the Illinois method.
/// @return The part of the step that was taken.
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
  const Real small = Real(0.01) * abs(at_low);
  Real s = high;
  if (at_high > small && at_low < Real(0)) {
    int side = 0;
    for (int i = 0; i < 20; ++i) {
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

}  // namespace bristle::inline BRISTLE_ABI
