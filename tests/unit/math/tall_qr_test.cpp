// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/math/tall_qr.hpp>

#include <doctest/doctest.h>

#include <random>
#include <vector>

using namespace bristle;

using namespace bristle::detail;

namespace {

/// Rows of rank `rank`: combinations of that many random ones.
std::vector<Row6<double>> rows_of_rank(std::size_t count, std::size_t rank) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Row6<double>> base(rank);
  for (auto& row : base) {
    for (double& x : row) x = uniform(random);
  }
  std::vector<Row6<double>> rows(count, Row6<double>{});
  for (auto& row : rows) {
    for (const auto& one : base) {
      const double share = uniform(random);
      for (std::size_t j = 0; j < 6; ++j) row[j] += share * one[j];
    }
  }
  return rows;
}

}  // namespace

TEST_CASE("reduce_rows: rows are an orthogonal matrix times the triangle, at any rank") {
  for (const std::size_t rank : {0u, 1u, 3u, 5u, 6u}) {
    const auto before = rows_of_rank(40, rank);
    auto rows = before;
    const TallQr<double> qr = reduce_rows<double>(rows);
    // Errors of a reflection are a few round-offs of the longest column.
    const double tolerance = 40 * Tolerance<double>::round_off();
    std::vector<double> column(before.size());
    for (std::size_t j = 0; j < 6; ++j) {
      for (std::size_t i = 0; i < before.size(); ++i) column[i] = before[i][j];
      to_triangle<double>(qr, rows, column);
      for (std::size_t i = 0; i < before.size(); ++i) {
        const double expected = i < 6 ? qr.triangle[i][j] : 0.0;
        CHECK(std::abs(column[i] - expected) <= tolerance);
      }
      // And back.
      for (std::size_t i = 6; i < before.size(); ++i) column[i] = 0.0;
      from_triangle<double>(qr, rows, column);
      for (std::size_t i = 0; i < before.size(); ++i) {
        CHECK(std::abs(column[i] - before[i][j]) <= tolerance);
      }
    }
    for (std::size_t i = 0; i < 6; ++i) {
      for (std::size_t j = 0; j < i; ++j) CHECK(qr.triangle[i][j] == 0.0);
    }
  }
}
