// Cost of one contact query of two primitive shapes.
//
// A hundred poses a case, asked again and again. Printed for each: processor time of a query, the
// median of 11 runs, and how many points it finds. Instructions, which do not depend on what else
// the machine does, are the difference of two runs of different length:
//
//   valgrind --tool=callgrind benchmark_contact_query_cost stacked 1
//   valgrind --tool=callgrind benchmark_contact_query_cost stacked 11      # 1000 queries more
//
// Usage: benchmark_contact_query_cost [case rounds]
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/backends/analytic_backend.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <string>
#include <support/random.hpp>
#include <vector>

using namespace bristle;
using bristle::test::Random;

namespace {

using S = double;
using Prepared = AnalyticBackend::Collidable<S>;

constexpr std::size_t pose_count = 100;
// [m] Of all queries: what a body of this size sweeps in a step.
constexpr S margin = 1e-4;

struct Case {
  std::string name;
  Shape<S> a;
  Shape<S> b;
  std::function<Transform<S>(Random&)> pose;
};

Transform<S> turned(Random& random, S angle, const Vec3<S>& position) {
  return {exp_rotation<S>(angle * random.direction<S>()), position};
}

std::vector<Case> all_cases() {
  const Box<S> box{{0.5, 0.5, 0.5}};
  const Sphere<S> ball{0.5};
  const HalfSpace<S> ground{};
  const S eighth = std::atan(S(1));
  // Cubes that stand on their edges, across each other.
  const Quat<S> on_edge = exp_rotation<S>({eighth, 0, 0});
  const Transform<S> crossed{on_edge.conjugate() * exp_rotation<S>({0, eighth, 0.1}),
                             on_edge.conjugate() * Vec3<S>(0.1, 0.05, 1.4)};
  const auto at = [](S angle, const Vec3<S>& position) {
    return [=](Random& random) { return turned(random, angle, position); };
  };
  return {{"stacked", box, box, at(1e-11, {0, 0, 1 - 1e-6})},
          {"bricks", box, box, at(1e-5, {0.5, 0, 1 - 1e-5})},
          {"turned", box, box, at(1e-5, {0, 0, 1 - 1e-5})},
          {"overlapping", box, box, [](Random& random) { return random.pose<S>(0.8); }},
          {"crossed_edges", box, box, [=](Random&) { return crossed; }},
          {"apart", box, box,
           [](Random& random) {
             return Transform<S>{random.rotation<S>(), 1.7 * random.direction<S>()};
           }},
          {"box_on_ground", ground, box, at(1e-5, {0, 0, 0.5 - 1e-5})},
          {"balls", ball, ball, at(1, {0, 0.1, 0.99})},
          {"box_ball", box, ball, at(1, {0, 0.1, 0.99})},
          {"ball_box", ball, box, at(1e-5, {0, 0.1, 0.99})}};
}

/// Asks for all poses, `rounds` times; the number of points found.
std::size_t run(const Prepared& a, const Prepared& b, const std::vector<Transform<S>>& poses,
                int rounds) {
  ContactManifolds<S> found;
  std::size_t points = 0;
  for (int i = 0; i < rounds; ++i) {
    for (const Transform<S>& X_AB : poses) {
      found.clear();
      AnalyticBackend::collide(a, b, X_AB, margin, found);
      for (const ContactManifold<S>& m : found) points += m.size;
    }
  }
  return points;
}

void measure(const Case& c, int rounds) {
  Random random(5);
  std::vector<Transform<S>> poses;
  for (std::size_t i = 0; i < pose_count; ++i) poses.push_back(c.pose(random));
  const Prepared a = AnalyticBackend::make<S>(c.a);
  const Prepared b = AnalyticBackend::make<S>(c.b);
  const double queries = static_cast<double>(pose_count) * rounds;
  std::array<double, 11> times{};
  std::size_t points = 0;
  // One run where instructions are counted.
  const std::size_t runs = rounds < 100 ? 1 : times.size();
  for (std::size_t i = 0; i < runs; ++i) {
    const std::clock_t start = std::clock();
    points = run(a, b, poses, rounds);
    times[i] = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC * 1e9 / queries;
  }
  std::sort(times.begin(), times.begin() + static_cast<std::ptrdiff_t>(runs));
  std::printf("%-14s %7.0f ns %6.2f points\n", c.name.c_str(), times[runs / 2],
              static_cast<double>(points) / queries);
}

}  // namespace

int main(int argc, char** argv) {
  for (const Case& c : all_cases()) {
    if (argc < 3) measure(c, 2000);
    if (argc >= 3 && c.name == argv[1]) measure(c, std::atoi(argv[2]));
  }
  return 0;
}
