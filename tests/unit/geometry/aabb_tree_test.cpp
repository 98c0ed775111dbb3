// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/trees/aabb_tree.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <support/random.hpp>
#include <vector>

using namespace bristle;

using namespace bristle::detail;
using bristle::test::Random;

namespace {

template <typename S>
Aabb<S> random_box(Random& random, S world, S size) {
  const Vec3<S> center = random.in_cube(world);
  const Vec3<S> half = (random.in_cube(size) + Vec3<S>::Constant(size)) / S(2);
  return {center - half, center + half};
}

template <typename S>
std::vector<std::uint32_t> overlapping(const AabbTree<S>& tree, const Aabb<S>& box) {
  std::vector<std::uint32_t> found;
  tree.overlap(box, [&](std::uint32_t payload) {
    found.push_back(payload);
    return true;
  });
  std::sort(found.begin(), found.end());
  return found;
}

/// Every box, one by one.
template <typename S>
std::vector<std::uint32_t> overlapping(const std::vector<Aabb<S>>& boxes, const Aabb<S>& box) {
  std::vector<std::uint32_t> found;
  for (std::uint32_t i = 0; i < boxes.size(); ++i) {
    if (boxes[i].overlaps(box)) found.push_back(i);
  }
  return found;
}

template <typename S>
std::vector<std::uint32_t> met(const AabbTree<S>& tree, const Ray<S>& ray) {
  std::vector<std::uint32_t> found;
  tree.walk_ray(ray, [&](std::uint32_t payload, S reach) {
    found.push_back(payload);
    return reach;
  });
  std::sort(found.begin(), found.end());
  return found;
}

/// Returns whether the ray meets the box, by clipping in long double. Exact for the small integers
/// below.
template <typename S>
bool meets(const Aabb<S>& box, const Ray<S>& ray) {
  long double enter = 0;
  long double leave = static_cast<long double>(ray.length);
  for (int i = 0; i < 3; ++i) {
    const long double o = static_cast<long double>(ray.origin[i]);
    const long double d = static_cast<long double>(ray.direction[i]);
    const long double low = static_cast<long double>(box.lower[i]);
    const long double high = static_cast<long double>(box.upper[i]);
    if (d == 0) {
      if (o < low || o > high) return false;
    } else {
      enter = std::max(enter, std::min((low - o) / d, (high - o) / d));
      leave = std::min(leave, std::max((low - o) / d, (high - o) / d));
    }
  }
  return enter <= leave;
}

}  // namespace

TEST_CASE_TEMPLATE("AabbTree: an empty tree finds nothing", S, float, double) {
  AabbTree<S> tree;
  CHECK(tree.size() == 0);
  CHECK(tree.height() == 0);
  CHECK(tree.root_box().is_empty());
  CHECK(overlapping(tree, Aabb<S>{Vec3<S>::Constant(-1), Vec3<S>::Constant(1)}).empty());
  CHECK(met(tree, Ray<S>{}).empty());
  tree.build({});
  CHECK(tree.size() == 0);
}

TEST_CASE_TEMPLATE("AabbTree: touching counts as overlapping", S, float, double) {
  AabbTree<S> tree;
  tree.insert({{0, 0, 0}, {1, 1, 1}}, 7);
  CHECK(overlapping(tree, Aabb<S>{{1, 1, 1}, {2, 2, 2}}) == std::vector<std::uint32_t>{7});
  const S beyond = S(1) + std::numeric_limits<S>::epsilon();
  CHECK(overlapping(tree, Aabb<S>{{beyond, 0, 0}, {2, 2, 2}}).empty());
}

TEST_CASE_TEMPLATE("AabbTree: a visit that returns false ends the search", S, float, double) {
  AabbTree<S> tree;
  for (std::uint32_t i = 0; i < 10; ++i) tree.insert({{0, 0, 0}, {1, 1, 1}}, i);
  int visits = 0;
  tree.overlap({{0, 0, 0}, {1, 1, 1}}, [&](std::uint32_t) { return ++visits < 3; });
  CHECK(visits == 3);
}

TEST_CASE_TEMPLATE("AabbTree: finds what brute force finds, through inserts, moves and removals", S,
                   float, double) {
  Random random(11);
  AabbTree<S> tree;
  std::vector<Aabb<S>> boxes;
  std::vector<typename AabbTree<S>::NodeId> ids;
  const Aabb<S> nowhere{Vec3<S>::Constant(100), Vec3<S>::Constant(100)};
  for (int step = 0; step < 3000; ++step) {
    const std::size_t action = random.index(4);
    if (action == 0 || ids.size() < 20) {
      boxes.push_back(random_box<S>(random, S(10), S(1)));
      ids.push_back(tree.insert(boxes.back(), static_cast<std::uint32_t>(boxes.size() - 1)));
    } else if (action == 1) {
      const std::size_t i = random.index(ids.size());
      if (ids[i] != detail::no_index) {
        tree.remove(ids[i]);
        ids[i] = detail::no_index;
        boxes[i] = nowhere;
      }
    } else {
      const std::size_t i = random.index(ids.size());
      if (ids[i] != detail::no_index) {
        const Vec3<S> shift = random.in_cube(action == 2 ? S(0.1) : S(5));
        boxes[i] = {boxes[i].lower + shift, boxes[i].upper + shift};
        tree.update(ids[i], boxes[i]);
        CHECK(tree.box(ids[i]).lower == boxes[i].lower);
        CHECK(tree.payload(ids[i]) == i);
      }
    }
    const Aabb<S> query = random_box<S>(random, S(10), S(4));
    REQUIRE(overlapping(tree, query) == overlapping(boxes, query));
  }
  Aabb<S> all;
  std::size_t live = 0;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (ids[i] == detail::no_index) continue;
    all.include(boxes[i]);
    ++live;
  }
  CHECK(tree.size() == live);
  CHECK(tree.root_box().lower == all.lower);
  CHECK(tree.root_box().upper == all.upper);
}

TEST_CASE_TEMPLATE("AabbTree: build gives ids and payloads in the order of the boxes", S, float,
                   double) {
  Random random(12);
  for (const std::size_t count : {1u, 2u, 3u, 17u, 1000u}) {
    std::vector<Aabb<S>> boxes;
    for (std::size_t i = 0; i < count; ++i) boxes.push_back(random_box<S>(random, S(10), S(1)));
    AabbTree<S> tree;
    tree.insert(boxes[0], 99);
    tree.build(boxes);
    REQUIRE(tree.size() == count);
    for (std::uint32_t i = 0; i < count; ++i) {
      CHECK(tree.payload(i) == i);
      CHECK(tree.box(i).upper == boxes[i].upper);
    }
    for (int k = 0; k < 100; ++k) {
      const Aabb<S> query = random_box<S>(random, S(10), S(3));
      REQUIRE(overlapping(tree, query) == overlapping(boxes, query));
    }
  }
}

TEST_CASE_TEMPLATE("AabbTree: a built tree can be changed like any other", S, float, double) {
  Random random(13);
  std::vector<Aabb<S>> boxes;
  for (int i = 0; i < 200; ++i) boxes.push_back(random_box<S>(random, S(10), S(1)));
  AabbTree<S> tree;
  tree.build(boxes);
  for (std::uint32_t i = 0; i < 200; i += 3) {
    boxes[i] = random_box<S>(random, S(10), S(1));
    tree.update(i, boxes[i]);
  }
  tree.remove(4);
  boxes[4] = {Vec3<S>::Constant(100), Vec3<S>::Constant(100)};
  for (int k = 0; k < 200; ++k) {
    const Aabb<S> query = random_box<S>(random, S(10), S(3));
    REQUIRE(overlapping(tree, query) == overlapping(boxes, query));
  }
}

TEST_CASE_TEMPLATE("AabbTree: boxes inserted in order do not make a list", S, float, double) {
  AabbTree<S> tree;
  for (std::uint32_t i = 0; i < 2048; ++i) {
    const Vec3<S> p(S(i), S(0), S(0));
    tree.insert({p, p + Vec3<S>::Ones()}, i);
  }
  // 11 levels at best; without rotations it would be hundreds.
  CHECK(tree.height() <= 30);
}

TEST_CASE_TEMPLATE("AabbTree: no sequence of boxes makes it higher than the stack", S, float,
                   double) {
  // Each box around all before it, which the heuristic would hang into a chain.
  AabbTree<S> tree;
  std::vector<Aabb<S>> boxes;
  S size = S(1);
  for (std::uint32_t i = 0; i < 300; ++i) {
    size *= S(1.2);
    boxes.push_back({Vec3<S>::Constant(-size), Vec3<S>::Constant(size)});
    tree.insert(boxes.back(), i);
    REQUIRE(tree.height() <= AabbTree<S>::max_height);
  }
  const Vec3<S> p = Vec3<S>::Constant(boxes[150].upper.x());
  CHECK(overlapping(tree, Aabb<S>{p, p}).size() == 150);
  tree.build(boxes);
  CHECK(tree.height() <= AabbTree<S>::max_height);
  CHECK(overlapping(tree, Aabb<S>{p, p}).size() == 150);

  // The same box many times gives no direction to split in.
  boxes.assign(1000, {Vec3<S>::Zero(), Vec3<S>::Ones()});
  tree.build(boxes);
  CHECK(tree.height() == 10);
  tree.clear();
  for (std::uint32_t i = 0; i < 1000; ++i) {
    tree.insert(boxes[i], i);
    REQUIRE(tree.height() <= AabbTree<S>::max_height);
  }
  CHECK(overlapping(tree, boxes[0]).size() == 1000);
}

TEST_CASE_TEMPLATE("AabbTree: infinite boxes are found and spoil nothing", S, float, double) {
  Random random(14);
  const S inf = infinity<S>;
  AabbTree<S> tree;
  std::vector<Aabb<S>> boxes;
  for (std::uint32_t i = 0; i < 100; ++i) {
    if (i % 20 == 3) {
      boxes.push_back({{-inf, -inf, -inf}, {inf, inf, S(0)}});
    } else if (i % 20 == 5) {
      boxes.push_back({{-inf, -inf, -inf}, {inf, inf, inf}});
    } else {
      boxes.push_back(random_box<S>(random, S(10), S(1)));
    }
    tree.insert(boxes.back(), i);
  }
  const auto check_all = [&] {
    for (int k = 0; k < 200; ++k) {
      const Aabb<S> query = random_box<S>(random, S(10), S(3));
      REQUIRE(overlapping(tree, query) == overlapping(boxes, query));
      const Ray<S> ray{random.in_cube(S(10)), random.direction<S>(), inf};
      const std::vector<std::uint32_t> found = met(tree, ray);
      for (std::uint32_t i = 0; i < boxes.size(); ++i) {
        if (meets(boxes[i], ray)) REQUIRE(std::binary_search(found.begin(), found.end(), i));
      }
    }
  };
  check_all();
  CHECK(tree.height() < 30);
  tree.build(boxes);
  check_all();
}

TEST_CASE_TEMPLATE("AabbTree: a ray meets all boxes in its way and few others", S, float, double) {
  Random random(15);
  std::vector<Aabb<S>> boxes;
  for (int i = 0; i < 500; ++i) boxes.push_back(random_box<S>(random, S(10), S(1)));
  AabbTree<S> tree;
  tree.build(boxes);
  for (int k = 0; k < 500; ++k) {
    const S length = k % 3 == 0 ? infinity<S> : random.uniform(S(0), S(20));
    const Ray<S> ray{random.in_cube(S(12)), random.direction<S>(), length};
    const std::vector<std::uint32_t> found = met(tree, ray);
    std::size_t expected = 0;
    for (std::uint32_t i = 0; i < boxes.size(); ++i) {
      if (!meets(boxes[i], ray)) continue;
      ++expected;
      REQUIRE(std::binary_search(found.begin(), found.end(), i));
    }
    CHECK(found.size() <= expected + 1);
  }
}

TEST_CASE_TEMPLATE("AabbTree: a ray in the plane of a face or along an edge meets the box", S,
                   float, double) {
  AabbTree<S> tree;
  tree.insert({{0, 0, 0}, {1, 1, 1}}, 0);
  // A flat box, as an axis-parallel triangle has.
  tree.insert({{3, 0, 0}, {3, 1, 1}}, 1);
  const auto count = [&](Vec3<S> origin, Vec3<S> direction) {
    return met(tree, Ray<S>{origin, direction, S(10)}).size();
  };
  CHECK(count({-1, 0, S(0.5)}, {1, 0, 0}) == 2);
  CHECK(count({-1, 1, 1}, {1, 0, 0}) == 2);
  CHECK(count({-1, 1, 1}, {1, S(-0.0), 0}) == 2);
  CHECK(count({3, -1, S(0.5)}, {0, 1, 0}) == 1);
  CHECK(count({3, 2, 1}, {0, -1, 0}) == 1);
  CHECK(count({-1, 0, -1}, Vec3<S>(1, 0, 1).normalized()) == 1);
  // From a face outwards: it touches.
  CHECK(count({1, S(0.5), S(0.5)}, {0, 0, 1}) == 1);
  CHECK(count({S(1.5), S(0.5), S(0.5)}, {0, 0, 1}) == 0);
  CHECK(count({-1, S(0.5), S(0.5)}, {-1, 0, 0}) == 0);
}

TEST_CASE_TEMPLATE("AabbTree: a ray walks from near to far and stops where it is told", S, float,
                   double) {
  AabbTree<S> tree;
  for (std::uint32_t i = 0; i < 64; ++i) {
    const S x = S((i * 37) % 64);
    tree.insert({{x, 0, 0}, {x + S(0.5), 1, 1}}, (i * 37) % 64);
  }
  const Ray<S> ray{{-1, S(0.5), S(0.5)}, {1, 0, 0}, infinity<S>};
  std::uint32_t next = 0;
  tree.walk_ray(ray, [&](std::uint32_t payload, S reach) {
    CHECK(payload == next++);
    return reach;
  });
  CHECK(next == 64);
  int visits = 0;
  tree.walk_ray(ray, [&](std::uint32_t, S) {
    ++visits;
    return S(11.25);  // Ends within box 10.
  });
  CHECK(visits == 11);
  visits = 0;
  tree.walk_ray(ray, [&](std::uint32_t, S) {
    ++visits;
    return S(-1);
  });
  CHECK(visits == 1);
}

TEST_CASE_TEMPLATE("AabbTree: the same calls give the same order of visits", S, float, double) {
  std::vector<std::uint32_t> order[2];
  for (auto& visits : order) {
    Random random(16);
    AabbTree<S> tree;
    for (std::uint32_t i = 0; i < 300; ++i) {
      tree.insert(random_box<S>(random, S(10), S(2)), i);
    }
    tree.overlap({Vec3<S>::Constant(-5), Vec3<S>::Constant(5)}, [&](std::uint32_t payload) {
      visits.push_back(payload);
      return true;
    });
  }
  CHECK(order[0] == order[1]);
}
