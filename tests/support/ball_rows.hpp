/// @file
/// Balls and rows between them, for tests of what solves an island.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "support/block_patterns.hpp"

#include <bristle/core/dynamic_array.hpp>
#include <bristle/dynamics/solver/island_row.hpp>
#include <bristle/math/block_cholesky.hpp>

#include <cstddef>
#include <cstdint>
#include <utility>

namespace bristle::test {

/// Balls of mass and moment of inertia m that move freely but for the rows that are added.
struct BallRows {
  using Row = detail::IslandRow<double>;

  detail::DynamicArray<double> mass;
  detail::DynamicArray<Row> rows{};
  /// [m/s, rad/s] Velocities of all balls at the start of a step, and without rows at its end.
  detail::DynamicArray<double> start, free;
  /// The system of `assemble`, with a block for each two balls.
  detail::DynamicArray<double> rhs{};
  detail::BlockPattern pattern{};
  detail::BlockCholesky<double> matrix{};

  explicit BallRows(detail::DynamicArray<double> masses)
      : mass(std::move(masses)), start(6 * mass.size(), 0.0), free(start) {}

  /// A unit row along an axis of ball b, less that of ball a unless that is `detail::no_index`.
  Row along(std::size_t axis, std::uint32_t b, std::uint32_t a = detail::no_index) const {
    Row row;
    row.b = 6 * b;
    row.jacobian_b[axis] = 1;
    row.response = 1 / mass[b];
    if (a != detail::no_index) {
      row.a = 6 * a;
      row.jacobian_a[axis] = -1;
      row.response += 1 / mass[a];
    }
    return row;
  }
  void add_contact(std::size_t normal, double friction, std::uint32_t b,
                   std::uint32_t a = detail::no_index, double sign = 1) {
    for (std::size_t part = 0; part < 3; ++part) {
      Row row = along((normal + part) % 3, b, a);
      row.kind = part == 0 ? detail::RowKind::cone : detail::RowKind::tangent;
      row.friction = friction;
      if (part == 0) {
        row.jacobian_a[normal] *= sign;
        row.jacobian_b[normal] *= sign;
      }
      rows.push_back(row);
    }
  }
  /// Fills the matrix of masses, and the momentum of free motion.
  void assemble() {
    const std::size_t n = 6 * mass.size();
    pattern = full_pattern(mass.size());
    matrix.reset(pattern);
    rhs.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      matrix.at(i, i) = mass[i / 6];
      rhs[i] = mass[i / 6] * free[i];
    }
  }
};

}  // namespace bristle::test
