// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/core/slot_map.hpp>
#include <bristle/dynamics/bodies/body.hpp>
#include <bristle/dynamics/joints/joint.hpp>
#include <bristle/sensors/patch.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <functional>
#include <set>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

using namespace bristle;

using namespace bristle::detail;

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

TEST_CASE("SlotMap: the range of live slots skips free ones, at the ends too") {
  Map map;
  const Map& constant = map;
  for (const std::uint32_t slot : constant.live_slots()) FAIL("an empty map has no slot " << slot);
  std::vector<Map::Handle> handles;
  for (int i = 0; i < 6; ++i) handles.push_back(map.insert("x"));
  for (const int gone : {0, 2, 3, 5}) map.erase(handles[static_cast<std::size_t>(gone)]);
  std::vector<std::uint32_t> slots;
  for (const std::uint32_t slot : constant.live_slots()) slots.push_back(slot);
  CHECK(slots == std::vector<std::uint32_t>{1, 4});
  // The loop may erase the element it is at.
  for (const std::uint32_t slot : map.live_slots()) map.erase(map.handle(slot));
  CHECK(map.size() == 0);
  CHECK(constant.live_slots().begin() == constant.live_slots().end());
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
  for (const std::uint32_t i : map.live_slots()) all += map.at(i);
  CHECK(all == "acxe");
}

TEST_CASE("Id: is ordered by slot, and names nothing by default") {
  using Handle = Map::Handle;
  CHECK(Handle{1, 5} < Handle{2, 0});
  CHECK(Handle{1, 0} < Handle{1, 1});
  CHECK(Handle{} == Handle{0xffffffffu, 0});
}

TEST_CASE("Id: is a key of unordered containers, each kind of handle") {
  std::unordered_map<Map::Handle, std::string> names;
  Map map;
  const auto a = map.insert("a");
  const auto b = map.insert("b");
  names[a] = "a";
  names[b] = "b";
  map.erase(a);
  const auto c = map.insert("c");
  names[c] = "c";
  REQUIRE(c.index == a.index);
  CHECK(names.size() == 3);
  CHECK(names.at(a) == "a");
  CHECK(names.at(b) == "b");
  CHECK(names.at(c) == "c");
  CHECK(names.count(Map::Handle{}) == 0);

  CHECK(std::unordered_set<BodyId>{{1, 0}, {1, 0}, {1, 1}, {2, 0}, {}}.size() == 4);
  CHECK(std::unordered_set<ShapeId>{{1, 0}, {1, 0}, {1, 1}}.size() == 2);
  CHECK(std::unordered_set<JointId>{{1, 0}, {1, 0}, {1, 1}}.size() == 2);
  CHECK(std::unordered_set<PatchId>{{1, 0}, {1, 0}, {1, 1}}.size() == 2);
}

TEST_CASE(
    "Id: equal handles have one hash, different ones others, which fill small tables evenly") {
  const std::hash<Map::Handle> hash;
  std::set<std::size_t> seen;
  std::vector<int> rows(256);
  for (std::uint32_t generation = 0; generation < 64; ++generation) {
    for (std::uint32_t index = 0; index < 256; ++index) {
      const Map::Handle id{index, generation};
      CHECK(hash(id) == hash(Map::Handle{id}));
      seen.insert(hash(id));
      ++rows[hash(id) % rows.size()];
    }
  }
  // One to one where std::size_t has 64 bits.
  if (sizeof(std::size_t) == 8) CHECK(seen.size() == 64 * 256);
  // 64 in each of the 256 rows on average. Of keys thrown at random the fullest row would have
  // 64 + 5 sqrt(64) but in one of some thousand throws.
  CHECK(*std::max_element(rows.begin(), rows.end()) <= 104);
}
