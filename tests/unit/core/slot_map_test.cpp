// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/core/slot_map.hpp>

#include <doctest/doctest.h>

#include <string>

using namespace bristle;

namespace {
struct Tag;
using Map = SlotMap<std::string, Tag>;
}  // namespace

TEST_CASE("SlotMap: an element is found by its handle, and by no other") {
  Map map;
  const auto a = map.insert("a");
  const auto b = map.insert("b");
  CHECK(map.size() == 2);
  CHECK(map.get(a, "id") == "a");
  CHECK(map.at(b.index) == "b");
  CHECK(map.contains(a));
  CHECK_FALSE(map.contains(Map::Handle{}));
  CHECK_FALSE(map.contains({a.index, a.generation + 1}));
  CHECK_FALSE(map.contains({99, 0}));
  CHECK(map.handle(b.index) == b);
}

TEST_CASE("SlotMap: a stale handle is recognised after its slot was reused") {
  Map map;
  const auto a = map.insert("a");
  map.insert("b");
  map.erase(a);
  CHECK_FALSE(map.contains(a));
  CHECK_FALSE(map.is_live(a.index));
  CHECK(map.size() == 1);
  CHECK(map.slot_count() == 2);
  const auto c = map.insert("c");
  CHECK(c.index == a.index);
  CHECK(c.generation == a.generation + 1);
  CHECK(map.get(c, "id") == "c");
  CHECK_FALSE(map.contains(a));
}

TEST_CASE("SlotMap: get names the field of a bad handle") {
  Map map;
  const auto a = map.insert("a");
  map.erase(a);
  try {
    (void)map.get(a, "JointDef::body_a");
    FAIL("nothing thrown");
  } catch (const InvalidArgument& error) {
    CHECK(error.field() == "JointDef::body_a");
    CHECK(error.value() == "{0, 0}");
  }
  const Map& constant = map;
  CHECK_THROWS_AS((void)constant.get(Map::Handle{}, "x"), InvalidArgument);
}

TEST_CASE("SlotMap: iterates in slot order, whatever was erased between") {
  Map map;
  Map::Handle handles[5];
  for (int i = 0; i < 5; ++i) handles[i] = map.insert(std::string(1, static_cast<char>('a' + i)));
  map.erase(handles[1]);
  map.erase(handles[3]);
  map.insert("x");  // Into the slot freed last.
  std::string all;
  for (std::uint32_t i = 0; i < map.slot_count(); ++i) {
    if (map.is_live(i)) all += map.at(i);
  }
  CHECK(all == "acxe");
}

TEST_CASE("Id: is ordered by slot, and names nothing by default") {
  using Handle = Map::Handle;
  CHECK(Handle{1, 5} < Handle{2, 0});
  CHECK(Handle{1, 0} < Handle{1, 1});
  CHECK(Handle{} == Handle{0xffffffffu, 0});
}
