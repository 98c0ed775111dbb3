// Cost of the smooth motion of chains, and the energy it loses.
//
// Chains of n links of 0.2 m and 1 kg, released level, for ten seconds: median time of a step, time
// and number of evaluations, and the largest change of energy relative to n m g times half the
// length.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/mechanism.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <vector>

using namespace bristle;

namespace {

template <typename S>
void measure(const char* scalar, int n, double rate) {
  auto m = test::chain<S>(n);
  std::vector<Transform<S>> poses(m.bodies.size());
  std::vector<Twist<S>> twists(m.bodies.size());
  std::vector<Wrench<S>> impulses(m.joints.size());
  std::vector<double> times;
  double error = 0, evaluations = 0;
  int most = 0;
  const double start = static_cast<double>(m.energy());
  for (long i = std::lround(10 * rate); i > 0; --i) {
    const auto begin = std::chrono::steady_clock::now();
    if (!m.flow.advance(m.bodies, m.joints, S(1 / rate), poses, twists, impulses)) {
      std::printf("gave up\n");
      return;
    }
    const auto end = std::chrono::steady_clock::now();
    times.push_back(std::chrono::duration<double, std::micro>(end - begin).count());
    evaluations += m.flow.evaluations();
    most = std::max(most, m.flow.evaluations());
    for (std::size_t b = 0; b < m.bodies.size(); ++b) {
      m.bodies[b].center_pose = poses[b];
      m.bodies[b].twist = twists[b];
    }
    error = std::max(error, std::abs(static_cast<double>(m.energy()) - start));
  }
  const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
  std::nth_element(times.begin(), middle, times.end());
  std::printf("%-6s %5d  1/%-4g  %8.2f  %10.1f  %4d  %10.2g\n", scalar, n, rate, *middle,
              evaluations / static_cast<double>(times.size()), most, error / (n * 9.81 * n * 0.1));
}

}  // namespace

int main() {
  std::printf("scalar links  dt      us/step  evals/step  most  energy error\n");
  for (const int n : {1, 2, 10}) {
    for (const double rate : {60.0, 240.0, 1000.0}) measure<double>("double", n, rate);
  }
  for (const int n : {2, 10}) measure<float>("float", n, 240.0);
}
