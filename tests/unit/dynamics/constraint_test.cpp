// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/dynamics/constraint.hpp>

#include <doctest/doctest.h>

#include <cmath>

using namespace bristle;

namespace {

/// A contact block whose rows respond with a diagonal matrix.
template <typename S>
BlockResponse<S> response(S normal, S t1, S t2, S coupling = S(0)) {
  BlockResponse<S> K;
  K.matrix = {normal, 0, 0, 0, t1, coupling, 0, coupling, t2};
  return K;
}

template <typename S>
struct Contact {
  ConstraintBlock<S> block{};
  ConstraintRow<S> rows[3]{};
  S change[3]{};
  explicit Contact(S friction) {
    block.kind = BlockKind::contact;
    block.count = 3;
    block.friction = friction;
  }
};

}  // namespace

TEST_CASE_TEMPLATE("solve_block: a contact stops approach and never pulls", S, float, double) {
  Contact<S> c(S(0));
  const BlockResponse<S> K = response<S>(2, 1, 1);
  const S approaching[3] = {-4, 0, 0};
  solve_block(c.block, K, approaching, c.rows, c.change);
  CHECK(c.rows[0].impulse == S(2));
  CHECK(c.change[0] == S(2));
  const S leaving[3] = {6, 0, 0};
  solve_block(c.block, K, leaving, c.rows, c.change);
  CHECK(c.rows[0].impulse == S(0));
  CHECK(c.change[0] == S(-2));
}

TEST_CASE_TEMPLATE("solve_block: friction stops what the disk allows, in every direction", S, float,
                   double) {
  for (const S angle : {S(0), S(0.5), S(0.8), S(2), S(4)}) {
    const S x = std::cos(angle);
    const S y = std::sin(angle);
    // Sticks: slip of 1 needs 1, mu N = 2.
    Contact<S> stick(S(0.5));
    const S slow[3] = {S(-4), x, y};
    solve_block(stick.block, response<S>(1, 1, 1), slow, stick.rows, stick.change);
    CHECK(std::abs(stick.rows[1].impulse + x) < S(4) * Tolerance<S>::round_off());
    CHECK(std::abs(stick.rows[2].impulse + y) < S(4) * Tolerance<S>::round_off());
    // Slides: exactly mu N against the slip.
    Contact<S> slide(S(0.5));
    const S fast[3] = {S(-4), 9 * x, 9 * y};
    solve_block(slide.block, response<S>(1, 1, 1), fast, slide.rows, slide.change);
    CHECK(std::abs(slide.rows[1].impulse + 2 * x) < S(8) * Tolerance<S>::round_off());
    CHECK(std::abs(slide.rows[2].impulse + 2 * y) < S(8) * Tolerance<S>::round_off());
  }
}

TEST_CASE("solve_block: where directions respond differently, friction still opposes the slip") {
  Contact<double> c(1);
  const BlockResponse<double> K = response<double>(1, 2, 0.5, 0.3);
  // Repeated with the velocities that follow, as a solver does.
  double velocity[3] = {-1, 5, 3};
  for (int i = 0; i < 500; ++i) {
    solve_block(c.block, K, velocity, c.rows, c.change);
    for (int r = 0; r < 3; ++r) {
      for (int k = 0; k < 3; ++k) {
        velocity[r] += K(static_cast<std::size_t>(r), static_cast<std::size_t>(k), 3) * c.change[k];
      }
    }
  }
  const double t1 = c.rows[1].impulse;
  const double t2 = c.rows[2].impulse;
  CHECK(std::hypot(t1, t2) == doctest::Approx(1).epsilon(1e-9));
  CHECK(std::abs(t1 * velocity[2] - t2 * velocity[1]) < 1e-9);
  CHECK(t1 * velocity[1] + t2 * velocity[2] < 0);
}

TEST_CASE_TEMPLATE("solve_block: a bounded row aims at its target within its bounds", S, float,
                   double) {
  ConstraintBlock<S> block;
  block.kind = BlockKind::bounded;
  block.count = 1;
  block.lower = S(-1);
  block.upper = S(3);
  BlockResponse<S> K;
  K.matrix[0] = S(2);
  for (const S target : {S(2), S(100), S(-100)}) {
    ConstraintRow<S> row;
    row.target = target;
    S change[1];
    const S velocity[1] = {0};
    solve_block(block, K, velocity, &row, change);
    CHECK(row.impulse == (target == S(2) ? S(1) : target > S(0) ? S(3) : S(-1)));
    CHECK(change[0] == row.impulse);
  }
}

TEST_CASE_TEMPLATE("solve_block: an equality block meets all its targets at once", S, float,
                   double) {
  ConstraintBlock<S> block;
  block.count = 2;
  BlockResponse<S> K;
  K.matrix = {2, 1, 1, 3};
  K.prepare(BlockKind::equality, 2);
  ConstraintRow<S> rows[2];
  rows[0].target = S(1);
  rows[1].target = S(-2);
  const S velocity[2] = {S(0.5), S(0)};
  S change[2];
  solve_block(block, K, velocity, rows, change);
  CHECK(std::abs(velocity[0] + 2 * change[0] + change[1] - S(1)) < Tolerance<S>::round_off());
  CHECK(std::abs(velocity[1] + change[0] + 3 * change[1] + S(2)) < Tolerance<S>::round_off());
}

TEST_CASE_TEMPLATE("solve_block: between two immovable bodies nothing happens", S, float, double) {
  Contact<S> c(S(0.5));
  const S velocity[3] = {-1, 1, 1};
  solve_block(c.block, response<S>(0, 0, 0), velocity, c.rows, c.change);
  for (const S change : c.change) CHECK(change == S(0));
  ConstraintBlock<S> joint;
  joint.count = 3;
  BlockResponse<S> K;
  K.prepare(BlockKind::equality, 3);
  ConstraintRow<S> rows[3];
  S change[3];
  solve_block(joint, K, velocity, rows, change);
  for (const S x : change) CHECK(x == S(0));
}

TEST_CASE_TEMPLATE("ConstraintRow: measures the velocity of B against A", S, float, double) {
  ConstraintRow<S> row;
  row.direction = {1, 0, 0};
  row.angular_a = {0, 0, 2};
  row.angular_b = {0, 0, 3};
  const Twist<S> a{{1, 0, 0}, {0, 0, 10}};
  const Twist<S> b{{5, 0, 0}, {0, 0, 100}};
  CHECK(row.velocity(a, b) == S(4 + 300 - 20));
}
