/// @file
/// Extrapolated sweeps: conjugate gradients where all contacts hold, and nothing where they slide.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/contact_island.hpp"
#include "support/relative.hpp"

#include <bristle/dynamics/contacts/manifold_sweeps.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

using namespace bristle;

using namespace bristle::detail;

namespace {

/// Bodies on each other on a floor that drives on. Every contact presses, and none slides: the
/// problem is linear.
template <typename S>
test::ContactIsland<S> held_column(test::Random& random, std::uint32_t count) {
  test::ContactIsland<S> column = test::random_pile<S>(random, count, 3, S(1000), S(3));
  SolverBody<S>& floor = column.bodies[0];
  floor.start = floor.free = floor.twist = {{S(0.3), S(-0.2), S(0.1)}, {S(0), S(0.1), S(0.2)}};
  for (ContactConstraint<S>& c : column.constraints.contacts) {
    // The points of a manifold are in one plane, so that it matters to none which of them rub.
    const Vec3<S> height = c.arm_a.dot(c.axes[0]) * c.axes[0];
    c.arm_a -= height;
    c.arm_b += c.arm_b.dot(c.axes[0]) * -c.axes[0];
    c.impulse = {S(1000), S(0), S(0)};
    c.gap = S(-1e-4);
  }
  for (SolverBody<S>& body : column.bodies) {
    if (body.moves) body.start = body.free;
  }
  return column;
}

template <typename S>
SolveContext<S> step_context() {
  SolveContext<S> c;
  c.dt = S(1) / S(240);
  c.speed_change = S(1000);  // So that nothing is an impact.
  c.is_swept = true;
  return c;
}

template <typename S>
S turn(ManifoldSweeps<S>& sweeps, SweptProblem problem, bool backwards) {
  return problem == SweptProblem::velocities ? sweeps.sweep(backwards) : sweeps.place(backwards);
}

/// Residual after pairs of sweeps, and how often they were extrapolated.
template <typename S>
struct Run {
  S residual = S(0);
  int extrapolated = 0;
};
template <typename S>
Run<S> run_pairs(ManifoldSweeps<S>& sweeps, SweptProblem problem, int pairs, bool extrapolates) {
  Run<S> run;
  sweeps.start_extrapolation(problem);
  for (int n = 0; n < pairs; ++n) {
    turn(sweeps, problem, false);
    run.residual = turn(sweeps, problem, true);
    if (extrapolates && n + 1 < pairs && sweeps.extrapolate(problem)) ++run.extrapolated;
  }
  return run;
}

}  // namespace

// Conjugate gradients end after as many pairs as the problem has unknowns: the motions of three
// bodies, 18. Twice as many leave room for rounding. Measured: up to 5e-7 of what sweeps alone
// leave, and 3e-5 with directions that are not conjugate.
TEST_CASE("SweepExtrapolation: what holds is solved in as many pairs as bodies have freedoms") {
  for (const SweptProblem problem : {SweptProblem::velocities, SweptProblem::positions}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      CAPTURE(seed);
      const auto solve = [&](bool extrapolates) {
        test::Random random(seed);
        auto column = held_column<double>(random, 3);
        ManifoldSweeps<double> sweeps;
        sweeps.start(column.island(), column.constraints, column.bodies, 1.0);
        sweeps.target(column.bodies, step_context<double>());
        if (problem == SweptProblem::positions) {
          sweeps.start_positions(column.bodies, step_context<double>());
        }
        if (problem == SweptProblem::velocities) sweeps.apply();
        return run_pairs(sweeps, problem, 36, extrapolates);
      };
      const Run<double> fast = solve(true);
      const Run<double> slow = solve(false);
      CHECK(fast.residual <= 5e-6 * slow.residual);
      CHECK(fast.extrapolated > 0);
    }
  }
}

// A body of 1 kg at 0.05 m/s that an impulse of 1 N s has made 0.01 m/s faster, as others press
// back. What its contact lacks is the slope of the energy along that impulse.
TEST_CASE("SweepExtrapolation: goes no step that takes more energy than bodies have") {
  const auto goes_on = [](double lack) {
    std::vector<SolverBody<double>> bodies(1);
    bodies[0].mass = 1;
    const std::array<std::uint32_t, 1> slots{0};
    std::array<double, VelocityTable<double>::stride> velocities{0.04};
    SweepExtrapolation<double>::Row impulses{};
    const auto show_impulses = [&](auto&& use) { use(impulses); };
    SweepExtrapolation<double> extrapolation;
    extrapolation.read_masses(slots, bodies);
    extrapolation.start(velocities, show_impulses);
    velocities[0] = 0.05;
    impulses[0] = 1;
    SweepExtrapolation<double>::Row lacks{};
    lacks[0] = lack;
    const auto show_residuals = [&](auto&& use) {
      use(impulses, Pack<double>::load(lacks.data()));
    };
    const bool result = extrapolation.move_on(velocities, show_residuals, show_impulses);
    // The least energy is where the slope is zero: lack / 0.01^2 times the change away.
    CHECK(velocities[0] == test::relative(result ? 0.05 - 0.01 * lack / 1e-4 : 0.05));
    return result;
  };
  // The step takes lack^2 / (2 * 0.01^2): of the 1.25 mJ of the body 0.2, 1.2, 1.3 and all there
  // is.
  CHECK(goes_on(-2e-4));
  CHECK(goes_on(-4.9e-4));
  CHECK_FALSE(goes_on(-5.1e-4));
  CHECK_FALSE(goes_on(-1));
}

// The velocities go along with the impulses: taken anew from these, they are the same. Some ten
// points push a body, of 1000 N s, with ten roundings each.
TEST_CASE_TEMPLATE("SweepExtrapolation: velocities stay those of the impulses", S, double, float) {
  test::Random random(5);
  auto column = held_column<S>(random, 12);
  auto one_by_one = column;
  const Island island = column.island();
  ManifoldSweeps<S> sweeps;
  sweeps.start(island, column.constraints, column.bodies, S(1));
  sweeps.target(column.bodies, step_context<S>());
  sweeps.apply();
  sweeps.start_extrapolation(SweptProblem::velocities);
  int extrapolated = 0;
  for (int pair = 0; pair < 6; ++pair) {
    sweeps.sweep(false);
    sweeps.sweep(true);
    extrapolated += sweeps.extrapolate(SweptProblem::velocities) ? 1 : 0;
  }
  CHECK(extrapolated > 2);
  sweeps.unload(column.bodies, velocity_of);
  sweeps.spread_friction();
  sweeps.write_back(island, one_by_one.constraints);
  apply_impulses(island, one_by_one.constraints, std::span(one_by_one.bodies));
  S largest = S(0);
  for (std::size_t i = 0; i < column.bodies.size(); ++i) {
    const Twist<S> error = column.bodies[i].twist - one_by_one.bodies[i].twist;
    largest = std::max({largest, error.linear.norm(), error.angular.norm()});
  }
  CHECK(largest < S(1000) * S(100) * std::numeric_limits<S>::epsilon());
}
