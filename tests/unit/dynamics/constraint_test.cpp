// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/dynamics/solver/constraint.hpp>

#include <doctest/doctest.h>

using namespace bristle;

using namespace bristle::detail;

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
  const S velocity[3] = {-1, 1, 1};
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
