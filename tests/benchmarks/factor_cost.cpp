// Cost of the matrices of islands: to order their bodies, to factor and to solve.
//
// Islands of contacts in several shapes: a chain, a chain whose bodies all touch one more, bodies
// that all touch one, a square of boxes side by side, and bodies that all touch each other. Median
// times, the blocks of the factor, its multiply-adds, and the largest error of a solution whose
// entries are one.
// SPDX-License-Identifier: BSD-3-Clause
#include "thread_clock.hpp"

#include <bristle/dynamics/solver/island_order.hpp>
#include <bristle/math/block_cholesky.hpp>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <utility>
#include <vector>

using namespace bristle;
using namespace bristle::detail;
using benchmarks::median_nanoseconds;

namespace {

using Links = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// Masses of one, and springs along all links, each of them stiffer than a mass by two.
void fill(BlockCholesky<double>& matrix, const IslandOrder& order, const Links& links) {
  matrix.reset(order.pattern());
  for (std::size_t i = 0; i < matrix.size(); ++i) matrix.at(i, i) = 1;
  for (const auto& [a, b] : links) {
    const std::size_t low = std::min(order.number(a), order.number(b));
    const std::size_t high = std::max(order.number(a), order.number(b));
    for (std::size_t i = 0; i < 6; ++i) {
      matrix.at(6 * low + i, 6 * low + i) += 2;
      matrix.at(6 * high + i, 6 * high + i) += 2;
      matrix.at(6 * high + i, 6 * low + i) -= 2;
    }
  }
}

void measure(const char* name, std::uint32_t count, const Links& links) {
  Constraints<double> constraints;
  std::vector<std::uint32_t> bodies(count);
  std::vector<std::uint32_t> contacts(links.size());
  for (std::uint32_t i = 0; i < count; ++i) bodies[i] = i;
  for (std::uint32_t i = 0; i < links.size(); ++i) {
    contacts[i] = i;
    ContactConstraint<double> contact;
    contact.body_a = links[i].first;
    contact.body_b = links[i].second;
    constraints.contacts.push_back(contact);
  }
  Island island;
  island.bodies = bodies;
  island.contacts = contacts;

  IslandOrder order;
  const double ordering = median_nanoseconds([&] {
    order.build(island, constraints, count);
    order.clear(island);
  });
  const std::uint64_t work =
      order.factor_work(island, constraints, count, std::numeric_limits<std::uint64_t>::max());
  order.build(island, constraints, count);

  BlockCholesky<double> matrix, factor;
  fill(matrix, order, links);
  const double copying = median_nanoseconds([&] { factor = matrix; });
  bool is_factored = true;
  const double factoring = median_nanoseconds([&] {
    factor = matrix;
    is_factored = factor.factor() && is_factored;
  });
  const std::vector<double> ones(matrix.size(), 1.0);
  std::vector<double> load(matrix.size(), 0.0);
  matrix.multiply(ones.data(), load.data());
  std::vector<double> x;
  const double solving = median_nanoseconds([&] {
    x = load;
    factor.solve(x.data());
  });
  double error = 0;
  for (const double entry : x) error = std::max(error, std::abs(entry - 1));
  if (!is_factored) error = std::numeric_limits<double>::infinity();
  std::printf("%-24s %6u %7zu %10llu %10.1f %10.1f %8.1f %9.1e\n", name, count,
              order.pattern().size(), static_cast<unsigned long long>(work), ordering / 1e3,
              (factoring - copying) / 1e3, solving / 1e3, error);
}

}  // namespace

int main() {
  std::printf("%-24s %6s %7s %10s %10s %10s %8s %9s\n", "island", "bodies", "blocks", "work",
              "order [us]", "factor", "solve", "error");
  const auto chain_of = [](std::uint32_t count) {
    Links links;
    for (std::uint32_t i = 1; i < count; ++i) links.emplace_back(i - 1, i);
    return links;
  };
  const auto star_of = [](std::uint32_t count) {
    Links links;
    for (std::uint32_t i = 1; i < count; ++i) links.emplace_back(0, i);
    return links;
  };
  measure("chain", 100, chain_of(100));
  Links wheel = chain_of(13);
  for (std::uint32_t i = 2; i < 13; ++i) wheel.emplace_back(0, i);
  measure("chain that touches one", 13, wheel);
  measure("all touch one", 100, star_of(100));
  measure("all touch one", 10000, star_of(10000));
  Links square;
  for (std::uint32_t y = 0; y < 8; ++y) {
    for (std::uint32_t x = 0; x < 8; ++x) {
      if (x > 0) square.emplace_back(8 * y + x - 1, 8 * y + x);
      if (y > 0) square.emplace_back(8 * y + x - 8, 8 * y + x);
    }
  }
  measure("square", 64, square);
  Links all;
  for (std::uint32_t i = 0; i < 16; ++i) {
    for (std::uint32_t j = 0; j < i; ++j) all.emplace_back(j, i);
  }
  measure("all touch each other", 16, all);
}
