// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/sensors/solve_passes.hpp>

#include <doctest/doctest.h>

#include <vector>

using namespace bristle;

using namespace bristle::detail;

namespace {

struct Course {
  std::vector<int> numbers, left;
  int solves = 0;
  int passes = 0;
};

/// Runs passes of which the first `changes` ask for another solve.
Course run(int max_passes, int changes) {
  Course course;
  course.passes = solve_in_passes(
      max_passes, [&] { ++course.solves; },
      [&](const SolvePass& pass) {
        CHECK(pass.number == course.solves);
        course.numbers.push_back(pass.number);
        course.left.push_back(pass.left);
        return pass.number <= changes;
      });
  return course;
}

}  // namespace

TEST_CASE("solve_in_passes: every solve is evaluated, until nothing changes or none is left") {
  const Course settled = run(4, 1);
  CHECK(settled.passes == 2);
  CHECK(settled.solves == 2);
  CHECK(settled.numbers == std::vector<int>{1, 2});
  CHECK(settled.left == std::vector<int>{3, 2});
  const Course restless = run(3, 100);
  CHECK(restless.passes == 3);
  CHECK(restless.solves == 3);
  CHECK(restless.left == std::vector<int>{2, 1, 0});
  for (const int few : {1, 0, -5}) {
    const Course one = run(few, 100);
    CHECK(one.passes == 1);
    CHECK(one.left == std::vector<int>{0});
  }
}
