// The interior-point method, on bodies whose answers are known in closed form, and on random ones.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/ball_rows.hpp"
#include "support/random.hpp"
#include "support/relative.hpp"

#include <bristle/dynamics/solver/interior_point.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

using namespace bristle;
using namespace bristle::detail;

namespace {

/// Balls and rows, solved from inside their cones.
struct ConvexBalls : test::BallRows {
  using test::BallRows::BallRows;

  double speed = 1;
  int most_steps = 60;
  InteriorPoint<double> method{};

  /// @return [-] Factorisations.
  int solve() {
    assemble();
    return method.solve({.rows = rows,
                         .matrix = &matrix,
                         .rhs = rhs,
                         .speed = speed,
                         .tolerance = 1e-11,
                         .most_steps = most_steps});
  }
  [[nodiscard]] double velocity(std::size_t i) const { return method.velocities()[i]; }
  /// [m/s] Velocity of a row that its impulses leave, by the momentum of the balls.
  [[nodiscard]] double left(std::size_t row) const {
    DynamicArray<double> v(rhs.begin(), rhs.end());
    for (std::size_t k = 0; k < rows.size(); ++k) rows[k].add_to(v, method.impulse(k));
    for (std::size_t i = 0; i < v.size(); ++i) v[i] /= mass[i / 6];
    return rows[row].times(v) - rows[row].target;
  }
};

}  // namespace

TEST_CASE("InteriorPoint: a ball on the ground sticks, slides or leaves by the convex law") {
  const double m = 2;
  const double mu = 0.5;
  ConvexBalls ball({m});
  ball.add_contact(2, mu, 0);
  SUBCASE("what friction can stop sticks") {
    ball.free = {0.3, -0.39, -1, 0, 0, 0};
    ball.solve();
    for (std::size_t i = 0; i < 3; ++i) CHECK(std::abs(ball.velocity(i)) < 1e-9);
    CHECK(ball.method.impulse(0) == test::relative(m * 1).epsilon(1e-9));
    CHECK(ball.method.impulse(1) == test::relative(-m * 0.3).epsilon(1e-8));
    CHECK(ball.method.impulse(2) == test::relative(m * 0.39).epsilon(1e-8));
  }
  SUBCASE("what slides leaves along the edge of the dual cone, v_n = mu v_t") {
    ball.free = {3, 4, -1, 0, 0, 0};
    ball.solve();
    // The nearest velocity on that edge: (5, -1) . (1, mu) / (1 + mu^2) of (1, mu).
    const double along = (5 - mu) / (1 + mu * mu);
    CHECK(ball.velocity(0) == test::relative(0.6 * along).epsilon(1e-9));
    CHECK(ball.velocity(1) == test::relative(0.8 * along).epsilon(1e-9));
    CHECK(ball.velocity(2) == test::relative(mu * along).epsilon(1e-9));
  }
  SUBCASE("an opening speed of mu times the slip makes that Coulomb's law") {
    ball.free = {3, 4, -1, 0, 0, 0};
    ball.rows[0].shift = mu * (5 - mu);
    ball.solve();
    CHECK(ball.velocity(0) == test::relative(3 * 0.9).epsilon(1e-9));
    CHECK(ball.velocity(1) == test::relative(4 * 0.9).epsilon(1e-9));
    CHECK(std::abs(ball.velocity(2)) < 1e-9);
  }
  SUBCASE("what leaves keeps its velocity") {
    ball.free = {3, 4, 4, 0, 0, 0};
    ball.solve();
    for (std::size_t i = 0; i < 3; ++i) {
      CHECK(ball.velocity(i) == test::relative(ball.free[i]).epsilon(1e-9));
    }
  }
}

TEST_CASE("InteriorPoint: rows without cones keep to their bounds") {
  const double m = 2;
  const double fast = 3;
  ConvexBalls ball({m});
  ball.free = {fast, fast, fast, fast, fast, fast};
  const double infinite = std::numeric_limits<double>::infinity();
  const auto add = [&](std::size_t axis, RowKind kind, double lower,
                       double upper) -> test::BallRows::Row& {
    ball.rows.push_back(ball.along(axis, 0));
    test::BallRows::Row& row = ball.rows.back();
    row.kind = kind;
    row.lower = lower;
    row.upper = upper;
    return row;
  };
  add(0, RowKind::free, 0, 0).target = 1;               // A joint.
  add(1, RowKind::bounded, -4, 4);                      // A motor that is too weak.
  add(2, RowKind::bounded, -40, 40);                    // One that is not.
  add(3, RowKind::bounded, 0, infinite);                // A limit that is left.
  add(4, RowKind::bounded, -1.5, -1.5);                 // A motor that has one force.
  add(5, RowKind::bounded, -40, 40).compliance = 0.25;  // A damper: w + 0.25 l = 0.
  ball.solve();
  CHECK(ball.velocity(0) == test::relative(1).epsilon(1e-9));
  CHECK(ball.velocity(1) == test::relative(fast - 4 / m).epsilon(1e-9));
  CHECK(std::abs(ball.velocity(2)) < 1e-9);
  CHECK(ball.velocity(3) == test::relative(fast).epsilon(1e-9));
  CHECK(ball.velocity(4) == test::relative(fast - 1.5 / m).epsilon(1e-9));
  // m (w - fast) = l = -4 w.
  CHECK(ball.velocity(5) == test::relative(m * fast / (m + 4)).epsilon(1e-9));
}

TEST_CASE("InteriorPoint: a contact without friction pushes along its normal alone") {
  ConvexBalls ball({2});
  ball.add_contact(2, 0, 0);
  ball.free = {3, 4, -1, 0, 0, 0};
  ball.solve();
  CHECK(ball.velocity(0) == test::relative(3).epsilon(1e-12));
  CHECK(ball.velocity(1) == test::relative(4).epsilon(1e-12));
  CHECK(std::abs(ball.velocity(2)) < 1e-9);
}

TEST_CASE("InteriorPoint: redundant contacts share their load evenly") {
  const std::size_t n = 7;
  ConvexBalls ball({2});
  for (std::size_t k = 0; k < n; ++k) ball.add_contact(2, 0.5, 0);
  ball.free = {0.2, 0, -1, 0, 0, 0};
  ball.solve();
  for (std::size_t k = 0; k < n; ++k) {
    CHECK(ball.method.impulse(3 * k) == test::relative(2.0 / n).epsilon(1e-6));
    CHECK(ball.method.impulse(3 * k + 1) == test::relative(-0.4 / n).epsilon(1e-5));
  }
}

// A row of balls is pressed against a wall, and gravity pulls across. Every contact has the load of
// the press, and the friction of all balls behind it. Sequential impulses take some n^2 sweeps
// times the ratio of masses here.
TEST_CASE("InteriorPoint: unlike masses between two plates take no more steps") {
  const double press = 30;
  const double g = 0.01;
  for (const double ratio : {1.0, 1e2, 1e4}) {
    CAPTURE(ratio);
    const std::uint32_t n = 8;
    DynamicArray<double> masses;
    double weight = 0;
    for (std::uint32_t i = 0; i < n; ++i) {
      masses.push_back(i % 2 == 0 ? 1 : 1 / ratio);
      weight += masses.back() * g;
    }
    ConvexBalls row(masses);
    for (std::uint32_t i = 0; i < n; ++i) {
      // The normal of the first is that of the wall, then from ball to ball.
      row.add_contact(0, 0.5, i, i == 0 ? detail::no_index : i - 1);
      row.free[6 * i + 2] = -g;
    }
    row.free[6 * (n - 1)] = -press / row.mass[n - 1];
    row.speed = press / row.mass[n - 1];
    CHECK(row.solve() <= 25);
    double behind = weight;
    for (std::uint32_t i = 0; i < n; ++i) {
      CHECK(row.method.impulse(3 * i) == test::relative(press).epsilon(1e-8));
      CHECK(std::abs(row.method.impulse(3 * i + 2) - behind) < 1e-9 * press);
      behind -= row.mass[i] * g;
    }
  }
}

TEST_CASE("InteriorPoint: random heaps satisfy the law, with the velocities of their impulses") {
  test::Random random(20);
  int most = 0;
  for (int problem = 0; problem < 200; ++problem) {
    CAPTURE(problem);
    const auto n = static_cast<std::uint32_t>(1 + random.index(6));
    DynamicArray<double> masses;
    for (std::uint32_t i = 0; i < n; ++i) {
      masses.push_back(std::pow(10.0, random.uniform(-1.0, 1.0)));
    }
    ConvexBalls heap(masses);
    for (double& v : heap.free) v = random.uniform(-1.0, 1.0);
    const std::size_t contacts = 1 + random.index(3 * n);
    for (std::size_t k = 0; k < contacts; ++k) {
      const auto b = static_cast<std::uint32_t>(random.index(n));
      const auto a = static_cast<std::uint32_t>(random.index(n));
      heap.add_contact(random.index(3), random.uniform(0.05, 1.5), b, a == b ? detail::no_index : a,
                       random.uniform(-1.0, 1.0) < 0 ? -1 : 1);
    }
    most = std::max(most, heap.solve());
    for (std::size_t k = 0; k < heap.rows.size(); k += 3) {
      const double l[3] = {heap.method.impulse(k), heap.method.impulse(k + 1),
                           heap.method.impulse(k + 2)};
      const double w[3] = {heap.left(k), heap.left(k + 1), heap.left(k + 2)};
      // Where neither impulse nor velocity carries anything, both are the root of their product, of
      // which 1e-16 is round-off. Responses of up to 20 multiply that.
      CHECK(distance_from_cone(heap.rows[k], l, w) < 1e-6);
    }
  }
  CHECK(most <= 40);
}

TEST_CASE("InteriorPoint: it stops where the caller does, and where numbers are not finite") {
  ConvexBalls ball({2});
  ball.add_contact(2, 0.5, 0);
  ball.free = {3, 4, -1, 0, 0, 0};
  ball.most_steps = 3;
  CHECK(ball.solve() == 3);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  SUBCASE("in a row") {
    ball.rows[0].jacobian_b[2] = nan;
    CHECK(ball.solve() == 0);
  }
  SUBCASE("in the momentum") {
    ball.most_steps = 30;
    ball.free[0] = nan;
    CHECK(ball.solve() == 1);
  }
  for (std::size_t k = 0; k < 3; ++k) CHECK(std::isfinite(ball.method.impulse(k)));
  for (std::size_t i = 0; i < 3; ++i) CHECK(std::isfinite(ball.method.velocities()[i]));
}
