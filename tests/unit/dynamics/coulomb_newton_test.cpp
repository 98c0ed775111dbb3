// Newton's method on Coulomb's law, on bodies whose answers are known in closed form.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/ball_rows.hpp"
#include "support/random.hpp"
#include "support/relative.hpp"

#include <bristle/dynamics/solver/coulomb_newton.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>

using namespace bristle;

using namespace bristle::detail;

namespace {

using LawRow = IslandRow<double>;

constexpr double tolerance = 1e-12;
constexpr double error = 1e-11;

/// Balls and rows, solved by Newton's method.
struct Balls : test::BallRows {
  using test::BallRows::BallRows;

  // Where surfaces slide an error of 1e-3 of this ends the iteration.
  double speed_change = 1e-8;
  bool is_held = false;
  bool is_near = false;
  int most_steps = 30;
  CoulombNewton<double> newton{};

  CoulombResult<double> solve() {
    assemble();
    return newton.solve({.rows = rows,
                         .matrix = &matrix,
                         .rhs = rhs,
                         .is_uncoupled = true,
                         .is_held = is_held,
                         .is_near = is_near,
                         .start = &start,
                         .free = &free,
                         .tolerance = tolerance,
                         .speed_change = speed_change,
                         .most_steps = most_steps});
  }
  [[nodiscard]] double velocity(std::size_t i) const { return newton.velocities()[i]; }
};

}  // namespace

TEST_CASE("CoulombNewton: a ball on the ground slides on, sticks, or lifts off") {
  const double m = 2;
  const double mu = 0.5;
  SUBCASE("what slides is slowed down against its way") {
    Balls ball({m});
    ball.add_contact(2, mu, 0);
    ball.start = ball.free = {3, 4, -1, 0, 0, 0};
    CHECK(ball.solve().residual <= error);
    // The ground takes 1 m/s, so friction takes mu times that off the 5 m/s.
    CHECK(ball.velocity(0) == test::relative(3 * 0.9).epsilon(1e-10));
    CHECK(ball.velocity(1) == test::relative(4 * 0.9).epsilon(1e-10));
    CHECK(std::abs(ball.velocity(2)) < tolerance);
    CHECK(ball.newton.impulse(0) == test::relative(m * 1).epsilon(1e-10));
    CHECK(ball.newton.impulse(1) == test::relative(-mu * m * 0.6).epsilon(1e-10));
    CHECK(ball.newton.impulse(2) == test::relative(-mu * m * 0.8).epsilon(1e-10));
  }
  SUBCASE("what friction can stop sticks") {
    Balls ball({m});
    ball.add_contact(2, mu, 0);
    ball.start = ball.free = {0.3, -0.39, -1, 0, 0, 0};
    CHECK(ball.solve().residual <= error);
    for (std::size_t i = 0; i < 3; ++i) CHECK(std::abs(ball.velocity(i)) < tolerance);
    CHECK(ball.newton.impulse(1) == test::relative(-m * 0.3).epsilon(1e-10));
  }
  SUBCASE("what leaves is left alone, whatever impulse was there") {
    Balls ball({m});
    ball.add_contact(2, mu, 0);
    ball.rows[0].lambda = 7;
    ball.start = ball.free = {3, 4, 1, 0, 0, 0};
    CHECK(ball.solve().residual <= error);
    for (std::size_t i = 0; i < 3; ++i)
      CHECK(std::abs(ball.velocity(i) - ball.free[i]) < tolerance);
    CHECK(ball.newton.impulse(0) == 0);
  }
}

TEST_CASE(
    "CoulombNewton: what is crushed is pressed by the bound of a contact, and slows down by it") {
  // A ball between the ground and a plate that comes down at 0.1 m/s. Both pressed before.
  const double m = 2;
  const double mu = 0.5;
  const double most = 7;
  Balls ball({m});
  ball.add_contact(2, mu, 0);
  ball.add_contact(2, mu, 0, detail::no_index, -1);
  ball.rows[3].target = 0.1;
  ball.rows[3].upper = most;
  ball.rows[0].lambda = ball.rows[3].lambda = most;
  ball.speed_change = 1;
  SUBCASE("where the ground holds it") {
    ball.start = ball.free = {10, 0, -1, 0, 0, 0};
    CHECK(ball.solve().residual <= error);
    CHECK(ball.newton.impulse(0) == test::relative(most + m * 1).epsilon(1e-10));
    CHECK(ball.newton.impulse(3) == test::relative(most).epsilon(1e-10));
    CHECK(std::abs(ball.velocity(2)) < tolerance);
    CHECK(ball.velocity(0) == test::relative(10 - mu * (2 * most + m) / m).epsilon(1e-10));
  }
  SUBCASE("where friction holds it, too") {
    ball.start = ball.free = {1, 0, -1, 0, 0, 0};
    CHECK(ball.solve().residual <= error);
    for (std::size_t i = 0; i < 3; ++i) CHECK(std::abs(ball.velocity(i)) < tolerance);
  }
  SUBCASE("where both contacts have it") {
    ball.rows[0].upper = most;
    ball.start = ball.free = {10, 0, -0.05, 0, 0, 0};
    CHECK(ball.solve().residual <= error);
    CHECK(ball.velocity(2) == test::relative(-0.05).epsilon(1e-10));
    CHECK(ball.velocity(0) == test::relative(10 - mu * 2 * most / m).epsilon(1e-10));
  }
}

TEST_CASE("CoulombNewton: impulses that are said to be near are not forgotten") {
  // A ball that is caught in a corner at 10 m/s, of which 0.3 m/s are left to find. Forces change
  // velocities by far less.
  int steps[2];
  for (const bool is_near : {false, true}) {
    Balls ball({2});
    for (const std::size_t axis : {0u, 1u, 2u}) {
      ball.add_contact(axis, 0.3, 0);
      ball.rows[3 * axis].lambda = 2 * 9.7 / std::sqrt(3.0);
    }
    const double v = -10 / std::sqrt(3.0);
    ball.start = ball.free = {v, v, 0.99 * v, 0, 0, 0};
    ball.is_near = is_near;
    const CoulombResult<double> found = ball.solve();
    CHECK(found.residual <= error);
    steps[is_near] = found.factorisations;
  }
  CHECK(steps[true] < steps[false]);
}

TEST_CASE("CoulombNewton: rows that no velocities obey are told from those that are hard to find") {
  Balls ball({1, 1});
  for (const double target : {1e-4, -1e-4}) {
    ball.rows.push_back(ball.along(0, 1, 0));
    ball.rows.back().target = target;
    ball.rows.back().lambda = 0.1;
  }
  ball.is_held = true;
  SUBCASE("they contradict each other") {
    const CoulombResult<double> found = ball.solve();
    CHECK(found.is_contradictory);
    CHECK(found.residual == test::relative(1e-4).epsilon(1e-3));
    CHECK(std::abs(ball.velocity(6) - ball.velocity(0)) < 1e-9);
  }
  SUBCASE("one of them gives way") {
    ball.rows[1].kind = RowKind::bounded;
    ball.rows[1].upper = 1;
    ball.rows[1].lower = -1;
    const CoulombResult<double> found = ball.solve();
    CHECK_FALSE(found.is_contradictory);
    CHECK(found.residual <= error);
  }
}

// A motor pushes balls on rough ground against each other, and lets go of a fifth of all impulses
// that the last step found.
TEST_CASE("CoulombNewton: a pushed row moves as one, or as fast as the motor's force lets it") {
  const std::size_t n = 5;
  const double mu = 0.3;
  const double weight = 0.5;  // [m/s] Of gravity in the step.
  DynamicArray<double> masses;
  for (std::size_t i = 0; i < n; ++i) masses.push_back(1.0 + 0.5 * static_cast<double>(i));
  double total = 0;
  for (const double m : masses) total += m;
  // Over the friction of all.
  for (const double force : {100.0, 1.5}) {
    CAPTURE(force);
    const double speed = std::min(1.0, (force - 1) * mu * weight);
    const double kept = 0.8;
    Balls row(masses);
    double pushed = total;  // From here on.
    for (std::uint32_t i = 0; i < n; ++i) {
      row.free[6 * i + 2] = -weight;
      row.add_contact(2, mu, i);
      row.rows[row.rows.size() - 3].lambda = kept * masses[i] * weight;
      row.rows[row.rows.size() - 2].lambda = -kept * mu * masses[i] * weight;
      if (i > 0) {
        row.add_contact(0, 0.0, i, i - 1);
        row.rows[row.rows.size() - 3].lambda = kept * pushed * (speed + mu * weight);
      }
      pushed -= masses[i];
    }
    LawRow motor = row.along(0, 0);
    motor.kind = RowKind::bounded;
    motor.target = 1;
    motor.upper = force * total * mu * weight;
    motor.lambda = kept * total * (speed + mu * weight);
    row.rows.push_back(motor);
    for (std::size_t i = 0; i < n; ++i) row.start[6 * i] = speed;
    CHECK(row.solve().residual <= error);
    for (std::size_t i = 0; i < n; ++i) {
      CHECK(row.velocity(6 * i) == test::relative(speed).epsilon(1e-8));
      CHECK(std::abs(row.velocity(6 * i + 2)) < 1e-8);
    }
  }
}

// A long chain has little resistance to a wave of its own length, a thousandth of that of a joint.
// A softer regularisation of its joints takes another factorisation.
TEST_CASE("CoulombNewton: joints of a long chain hold at once") {
  constexpr std::uint32_t n = 40;
  Balls chain(DynamicArray<double>(n, 1.0));
  chain.speed_change = 1;
  // The last one is pulled, and friction holds the first.
  chain.add_contact(2, 10, 0);
  for (std::uint32_t i = 1; i < n; ++i) chain.rows.push_back(chain.along(0, i, i - 1));
  chain.free[2] = -1;
  chain.free[6 * (n - 1)] = 1;
  const CoulombResult<double> answer = chain.solve();
  CHECK(answer.residual <= error);
  CHECK(answer.factorisations <= 3);
  CHECK(chain.newton.impulse(1) == test::relative(-1).epsilon(1e-8));
  for (std::size_t i = 0; i < n; ++i) CHECK(std::abs(chain.velocity(6 * i)) < 1e-8);
}

// Balls on each other hold by friction alone. As long as nothing slips the law is linear, and one
// factorisation solves it whatever pulls at them.
TEST_CASE("CoulombNewton: what holds takes one factorisation, and what begins to slip is found") {
  constexpr std::uint32_t n = 12;
  Balls stack(DynamicArray<double>(n, 1.0));
  stack.speed_change = 1;
  stack.is_held = true;
  for (std::uint32_t i = 0; i < n; ++i) {
    stack.add_contact(2, 0.5, i, i == 0 ? detail::no_index : i - 1);
    stack.free[6 * i + 2] = -1;
    // The weight of those above.
    stack.rows[3 * i].lambda = n - i;
  }
  for (const double pull : {0.1, 0.4}) {
    CAPTURE(pull);
    for (std::uint32_t i = 0; i < n; ++i) stack.free[6 * i] = pull;
    const CoulombResult<double> answer = stack.solve();
    CHECK(answer.residual <= error);
    CHECK(answer.factorisations == 1);
    for (std::size_t i = 0; i < n; ++i) {
      CHECK(std::abs(stack.velocity(6 * i)) < 1e-9);
      CHECK(stack.newton.impulse(3 * i + 1) ==
            test::relative(-pull * static_cast<double>(n - i)).epsilon(1e-8));
    }
  }
  // More than friction holds: all slide on as one, and each has what the ground lets through.
  for (const double pull : {0.51, 0.7}) {
    CAPTURE(pull);
    for (std::uint32_t i = 0; i < n; ++i) stack.free[6 * i] = pull;
    const CoulombResult<double> answer = stack.solve();
    CHECK(answer.residual <= error);
    CHECK(answer.factorisations <= 3);
    for (std::size_t i = 0; i < n; ++i) {
      CHECK(stack.velocity(6 * i) == test::relative(pull - 0.5).epsilon(1e-6));
    }
  }
}

// Whatever jams, and however few steps there are, the answer does not add to the energy, and stays
// within its bounds.
TEST_CASE("CoulombNewton: answers take energy, solved or not") {
  for (const int most_steps : {1, 3, 30}) {
    CAPTURE(most_steps);
    test::Random random(3);
    int solved = 0;
    const int rounds = 200;
    for (int round = 0; round < rounds; ++round) {
      CAPTURE(round);
      const std::size_t n = 6;
      DynamicArray<double> masses(n);
      for (double& m : masses) m = std::pow(10.0, random.uniform(-1.0, 1.0));
      Balls heap(masses);
      heap.speed_change = 0.04;
      heap.most_steps = most_steps;
      for (double& x : heap.free) x = random.uniform(-1.0, 1.0);
      heap.start = heap.free;
      for (std::uint32_t i = 0; i < n; ++i) {
        heap.add_contact(2, 0.6, i);
        for (std::uint32_t j = 0; j < i; ++j) {
          if (random.uniform(0.0, 1.0) < 0.5) heap.add_contact(j % 2, 0.6, i, j);
        }
      }
      heap.add_contact(0, 0.6, 0);
      heap.add_contact(0, 0.6, n - 1, detail::no_index, -1);
      // Impulses of the last step may have nothing to do with this one.
      if (round % 2 != 0) {
        for (std::size_t k = 0; k < heap.rows.size(); k += 3) {
          heap.rows[k].lambda = random.uniform(0.0, 5.0);
        }
      }
      const CoulombResult<double> answer = heap.solve();
      // An impulse that adds energy is scaled until it takes some.
      REQUIRE(answer.residual < infinity<double>);
      solved += answer.residual <= 1e-3 * heap.speed_change ? 1 : 0;
      double before = 0;
      double after = 0;
      double slack = 0;
      for (std::size_t i = 0; i < heap.free.size(); ++i) {
        before += heap.mass[i / 6] * heap.free[i] * heap.free[i] / 2;
        after += heap.mass[i / 6] * heap.velocity(i) * heap.velocity(i) / 2;
      }
      for (std::size_t k = 0; k < heap.rows.size(); k += 3) {
        const double normal = heap.newton.impulse(k);
        const double friction = std::hypot(heap.newton.impulse(k + 1), heap.newton.impulse(k + 2));
        CHECK(normal >= 0);
        CHECK(friction <= 0.6 * normal * (1 + 1e-12));
        // An error of a thousandth of what forces do is allowed to do work.
        slack += 1e-3 * heap.speed_change * (normal + 2 * friction);
      }
      // Without impulses the velocities are those of free motion, to round-off.
      CHECK(after <= before * (1 + 1e-14) + slack);
    }
    // Most are, from no impulses at all.
    if (most_steps == 30) CHECK(solved > rounds / 2);
  }
}
