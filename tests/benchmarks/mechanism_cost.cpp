// Cost of the smooth motion of chains, and the energy it loses.
//
// Chains of n links of 0.2 m and 1 kg, released level, for ten seconds: median time of a step, time
// and number of evaluations, and the largest change of energy relative to n m g times half the
// length. And of joints that hold the same: n welds of two boxes that fall and turn, the time to
// add them, the median of a step, and the largest gap.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/mechanism.hpp"

#include <bristle/world/world.hpp>

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
    if (!m.integrator.advance(m.bodies, m.joints, S(1 / rate), poses, twists, impulses)) {
      std::printf("gave up\n");
      return;
    }
    const auto end = std::chrono::steady_clock::now();
    times.push_back(std::chrono::duration<double, std::micro>(end - begin).count());
    evaluations += m.integrator.evaluations();
    most = std::max(most, m.integrator.evaluations());
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

void measure_redundant(int n) {
  using Clock = std::chrono::steady_clock;
  const auto milliseconds = [](Clock::duration d) {
    return std::chrono::duration<double, std::milli>(d).count();
  };
  World<double> world({.time_step = 1e-3});
  BodyDef<double> box{.mass = 1, .shape = Box<double>{{0.1, 0.1, 0.1}}};
  box.angular_velocity = {0, 0, 1};
  const BodyId a = world.add_body(box);
  box.position = {1, 0, 0};
  const BodyId b = world.add_body(box);
  JointDef<double> weld;
  weld.kind = JointKind::fixed;
  weld.body_a = a;
  weld.body_b = b;
  weld.X_AJ.translation = {0.5, 0, 0};
  weld.X_BJ.translation = {-0.5, 0, 0};
  const auto begin = Clock::now();
  JointId last{};
  for (int i = 0; i < n; ++i) last = world.add_joint(weld);
  const double added = milliseconds(Clock::now() - begin);
  std::vector<double> times;
  double gap = 0;
  for (int i = 0; i < 11; ++i) {
    const auto start = Clock::now();
    world.step();
    times.push_back(milliseconds(Clock::now() - start));
    gap = std::max(gap, world.reading(last).gap);
  }
  std::nth_element(times.begin(), times.begin() + 5, times.end());
  std::printf("%6d  %8.2f  %8.3f  %8.1e\n", n, added, times[5], gap);
}

}  // namespace

int main() {
  std::printf("scalar links  dt      us/step  evals/step  most  energy error\n");
  for (const int n : {1, 2, 10}) {
    for (const double rate : {60.0, 240.0, 1000.0}) measure<double>("double", n, rate);
  }
  for (const int n : {2, 10}) measure<float>("float", n, 240.0);
  std::printf("\nwelds   add [ms]  step [ms]  gap [m]\n");
  for (const int n : {1, 20, 200, 2000, 20000}) measure_redundant(n);
}
