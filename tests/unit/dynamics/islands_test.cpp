// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/dynamics/bodies/islands.hpp>

#include <doctest/doctest.h>

#include <algorithm>

using namespace bristle;

using namespace bristle::detail;

namespace {

DynamicArray<SolverBody<double>> bodies(std::initializer_list<bool> moving) {
  DynamicArray<SolverBody<double>> out;
  for (const bool moves : moving) {
    out.emplace_back().moves = moves;
  }
  return out;
}

void connect(Constraints<double>& c, std::uint32_t a, std::uint32_t b) {
  ConstraintBlock<double> block;
  block.body_a = a;
  block.body_b = b;
  c.blocks.push_back(block);
}

DynamicArray<std::uint32_t> list(std::span<const std::uint32_t> items) {
  return {items.begin(), items.end()};
}

using List = DynamicArray<std::uint32_t>;

}  // namespace

TEST_CASE("IslandBuilder: what acts on each other is one island, fixed bodies connect nothing") {
  // 0 is the floor; 1-3-5 form a chain, 2-4 a pair by sensors, 6 is alone.
  const auto b = bodies({false, true, true, true, true, true, true});
  Constraints<double> c;
  connect(c, 0, 2);
  connect(c, 5, 3);
  connect(c, 1, 3);
  connect(c, 0, 1);
  SoftBlock<double> soft;
  soft.body_a = 4;
  soft.body_b = 2;
  c.soft.push_back(soft);
  IslandBuilder<double> builder;
  const DynamicArray<Island>& islands = builder.build(b, c);
  REQUIRE(islands.size() == 3);
  CHECK(list(islands[0].bodies) == List{1, 3, 5});
  CHECK(list(islands[0].blocks) == List{1, 2, 3});
  CHECK(list(islands[0].soft).empty());
  CHECK(list(islands[1].bodies) == List{2, 4});
  CHECK(list(islands[1].blocks) == List{0});
  CHECK(list(islands[1].soft) == List{0});
  CHECK(list(islands[2].bodies) == List{6});
  CHECK(islands[2].blocks.empty());
}

TEST_CASE("IslandBuilder: constraints between bodies that do not move belong to no island") {
  const auto b = bodies({false, false, true});
  Constraints<double> c;
  connect(c, 0, 1);
  IslandBuilder<double> builder;
  const DynamicArray<Island>& islands = builder.build(b, c);
  REQUIRE(islands.size() == 1);
  CHECK(islands[0].blocks.empty());
}

TEST_CASE("IslandBuilder: a long chain is one island however it is listed") {
  const std::uint32_t n = 200;
  const DynamicArray<SolverBody<double>> b = [&] {
    DynamicArray<SolverBody<double>> out(n);
    for (auto& body : out) body.moves = true;
    return out;
  }();
  Constraints<double> c;
  for (std::uint32_t i = n - 1; i > 0; --i) connect(c, i, i - 1);
  IslandBuilder<double> builder;
  CHECK(builder.build(b, c).size() == 1);
  CHECK(builder.build(b, Constraints<double>{}).size() == n);
}
