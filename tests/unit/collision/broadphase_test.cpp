// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"

#include <bristle/collision/broadphase.hpp>

#include <doctest/doctest.h>

using namespace bristle;

using namespace bristle::detail;

namespace {

template <typename S>
Aabb<S> box_at(const Vec3<S>& center, S half) {
  const Vec3<S> h = Vec3<S>::Constant(half);
  return {center - h, center + h};
}

template <typename S>
Aabb<S> everywhere() {
  return {Vec3<S>::Constant(-infinity<S>), Vec3<S>::Constant(infinity<S>)};
}

}  // namespace

TEST_CASE_TEMPLATE("BroadPhase: finds exactly the pairs that overlap, each once, in order", S,
                   float, double) {
  test::Random random(7);
  BroadPhase<S> phase;
  DynamicArray<Aabb<S>> boxes;
  DynamicArray<std::uint32_t> moving;
  for (std::uint32_t i = 0; i < 80; ++i) {
    boxes.push_back(box_at<S>(random.in_cube(S(2)), random.uniform(S(0.1), S(0.5))));
    phase.insert(i, boxes.back());
    if (i % 3 != 0) moving.push_back(i);
  }
  for (int round = 0; round < 5; ++round) {
    for (const std::uint32_t i : moving) {
      const Vec3<S> step = random.in_cube(S(0.4));
      boxes[i].lower += step;
      boxes[i].upper += step;
      phase.move(i, boxes[i]);
    }
    DynamicArray<ShapePair> expected;
    for (std::uint32_t a = 0; a < 80; ++a) {
      for (std::uint32_t b = a + 1; b < 80; ++b) {
        if ((a % 3 != 0 || b % 3 != 0) && boxes[a].overlaps(boxes[b])) expected.push_back({a, b});
      }
    }
    DynamicArray<ShapePair> found;
    std::uint64_t tested = 0;
    phase.find_pairs(
        moving, [](auto, auto) { return true; }, found, tested);
    CHECK(found == expected);
    CHECK(tested >= found.size());
    found.clear();
    phase.find_pairs(
        moving, [](auto, auto) { return false; }, found, tested);
    CHECK(found.empty());
  }
}

TEST_CASE_TEMPLATE("BroadPhase: remembers pairs through moves, rests, removals and insertions", S,
                   float, double) {
  test::Random random(8);
  constexpr std::uint32_t count = 60;
  BroadPhase<S> phase;
  DynamicArray<Aabb<S>> boxes(count);
  DynamicArray<bool> is_there(count, false);
  const auto is_fixed = [](std::uint32_t i) { return i % 4 == 0; };
  const auto insert = [&](std::uint32_t i) {
    boxes[i] = i % 20 == 3 ? everywhere<S>()
                           : box_at<S>(random.in_cube(S(1.5)), random.uniform(S(0.1), S(0.5)));
    phase.insert(i, boxes[i]);
    is_there[i] = true;
  };
  for (std::uint32_t i = 0; i < count; ++i) insert(i);
  DynamicArray<std::uint32_t> moving;
  DynamicArray<ShapePair> expected;
  DynamicArray<ShapePair> found;
  std::size_t total = 0;
  for (int round = 0; round < 300; ++round) {
    const auto any = [&] { return static_cast<std::uint32_t>(random.uniform(0.0, count - 0.01)); };
    const std::uint32_t changed = any();
    if (is_there[changed]) {
      phase.remove(changed);
      is_there[changed] = false;
    } else {
      insert(changed);
    }
    // A tag may change hands within one step.
    const std::uint32_t replaced = any();
    if (is_there[replaced]) {
      phase.remove(replaced);
      insert(replaced);
    }
    moving.clear();
    const bool all_rest = round % 10 == 0;
    for (std::uint32_t i = 0; i < count; ++i) {
      if (!is_there[i] || is_fixed(i) || all_rest || random.uniform(0.0, 1.0) < 0.3) continue;
      moving.push_back(i);
      // Mostly steps that stay within the grown box.
      const Vec3<S> step = random.in_cube(S(random.uniform(0.0, 1.0) < 0.1 ? 0.5 : 0.002));
      boxes[i].lower += step;
      boxes[i].upper += step;
      phase.move(i, boxes[i]);
    }
    expected.clear();
    DynamicArray<bool> moves(count, false);
    for (const std::uint32_t i : moving) moves[i] = true;
    for (std::uint32_t a = 0; a < count; ++a) {
      for (std::uint32_t b = a + 1; b < count; ++b) {
        if (!is_there[a] || !is_there[b] || (!moves[a] && !moves[b])) continue;
        if (boxes[a].overlaps(boxes[b]) && (a + b) % 7 != 0) expected.push_back({a, b});
      }
    }
    found.clear();
    std::uint64_t tested = 0;
    phase.find_pairs(
        moving, [](auto a, auto b) { return (a + b) % 7 != 0; }, found, tested);
    REQUIRE(found == expected);
    CHECK(tested >= found.size());
    total += found.size();
  }
  CHECK(total > 10000);
}

TEST_CASE_TEMPLATE("BroadPhase: unbounded shapes overlap everything, until removed", S, float,
                   double) {
  BroadPhase<S> phase;
  phase.insert(0, everywhere<S>());
  phase.insert(1, box_at<S>(Vec3<S>::Zero(), S(1)));
  phase.insert(2, everywhere<S>());
  DynamicArray<std::uint32_t> seen;
  phase.overlap(box_at<S>(Vec3<S>(100, 0, 0), S(1)), [&](std::uint32_t tag) {
    seen.push_back(tag);
    return true;
  });
  CHECK(seen == DynamicArray<std::uint32_t>{0, 2});
  phase.remove(0);
  phase.remove(1);
  seen.clear();
  phase.overlap(box_at<S>(Vec3<S>::Zero(), S(1)), [&](std::uint32_t tag) {
    seen.push_back(tag);
    return true;
  });
  CHECK(seen == DynamicArray<std::uint32_t>{2});
}

TEST_CASE("BroadPhase: an overlap query stops when told to") {
  BroadPhase<double> phase;
  for (std::uint32_t i = 0; i < 10; ++i) {
    phase.insert(i, i < 8 ? box_at<double>(Vec3<double>::Zero(), 1) : everywhere<double>());
  }
  int visits = 0;
  phase.overlap(box_at<double>(Vec3<double>::Zero(), 1),
                [&](std::uint32_t) { return ++visits < 3; });
  CHECK(visits == 3);
}

TEST_CASE("BroadPhase: a ray meets unbounded shapes first, and what shortens it hides the rest") {
  BroadPhase<double> phase;
  phase.insert(0, box_at<double>({5, 0, 0}, 1));
  phase.insert(1, box_at<double>({50, 0, 0}, 1));
  phase.insert(2, everywhere<double>());
  DynamicArray<std::uint32_t> seen;
  Ray<double> ray;
  ray.origin.setZero();
  ray.direction = {1, 0, 0};
  ray.length = 100;
  phase.walk_ray(ray, [&](std::uint32_t tag, double nearest) {
    seen.push_back(tag);
    return tag == 0 ? 4.0 : nearest;
  });
  CHECK(seen == DynamicArray<std::uint32_t>{2, 0});
}

TEST_CASE_TEMPLATE("BroadPhase: a box that was everywhere for one step finds its pairs after", S,
                   float, double) {
  BroadPhase<S> phase;
  phase.insert(0, box_at<S>(Vec3<S>::Zero(), S(1)));
  phase.insert(1, box_at<S>(Vec3<S>(S(5), S(0), S(0)), S(1)));
  const auto pairs = [&] {
    DynamicArray<ShapePair> found;
    std::uint64_t tested = 0;
    phase.find_pairs(
        {0}, [](auto, auto) { return true; }, found, tested);
    return found.size();
  };
  CHECK(pairs() == 0);
  phase.move(0, everywhere<S>());
  CHECK(pairs() == 1);
  phase.move(0, box_at<S>(Vec3<S>::Zero(), S(1)));
  CHECK(pairs() == 0);
  phase.move(0, box_at<S>(Vec3<S>(S(3.5), S(0), S(0)), S(1)));
  CHECK(pairs() == 1);
}

TEST_CASE_TEMPLATE("BroadPhase: who is alone need not be looked at while in its box of the tree", S,
                   float, double) {
  BroadPhase<S> phase;
  phase.insert(0, box_at<S>(Vec3<S>::Zero(), S(1)));
  phase.insert(1, box_at<S>(Vec3<S>(S(9), S(0), S(0)), S(1)));
  const auto find_pairs = [&] {
    DynamicArray<ShapePair> found;
    std::uint64_t tested = 0;
    phase.find_pairs(
        {0, 1}, [](auto, auto) { return true; }, found, tested);
    return found.size();
  };
  const auto at = [](S x) { return Vec3<S>(x, S(0), S(0)); };
  // It goes 0.1 a step along x, so that its box in the tree reaches farther there.
  const auto follow = [&](S x) {
    phase.move(0, box_at<S>(at(x), S(1.1)), S(0.1), at(x));
    return find_pairs();
  };
  CHECK(follow(S(0)) == 0);
  CHECK(follow(S(2)) == 0);
  CHECK(phase.stays(0, S(0.1), at(S(2))));
  CHECK(phase.stays(0, S(0.1), at(S(3))));
  CHECK(phase.is_loose(0));
  CHECK(phase.swept(0).contains(box_at<S>(at(S(3)), S(1.1))));
  CHECK(phase.settle(0, at(S(3)), S(1), S(0), S(0.1)));
  // Backwards, by its reach, or by turning it would leave the box.
  CHECK_FALSE(phase.stays(0, S(0.1), at(S(1))));
  CHECK_FALSE(phase.stays(0, S(5), at(S(3))));
  CHECK_FALSE(phase.settle(0, at(S(3)), S(0), S(5), S(0.1)));
  CHECK_FALSE(phase.stays(0, S(0.1), at(S(3))));
  // Whoever asked for its swept box will do so again, until it leaves its box in the tree.
  CHECK(follow(S(3)) == 0);
  CHECK(phase.stays(0, S(0.1), at(S(3))));
  phase.refine(0, box_at<S>(at(S(3)), S(1.1)));
  CHECK_FALSE(phase.is_loose(0));
  CHECK_FALSE(phase.stays(0, S(0.1), at(S(3))));
  CHECK(follow(S(30)) == 0);
  CHECK(phase.stays(0, S(0.1), at(S(30))));
  // In company it is looked at.
  CHECK(follow(S(8)) == 1);
  CHECK_FALSE(phase.stays(0, S(0.1), at(S(8))));
}
