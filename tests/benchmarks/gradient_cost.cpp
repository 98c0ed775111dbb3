// Cost of derivatives: a step of World<Dual<double, n>> beside the same one of World<double>.
//
// A grasp of 50 sensors at rest, by its constants and its load, and five cubes at rest on each
// other, by their masses. Medians of eleven runs of 100 steps in turn; time of the thread.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/grasp.hpp"
#include "scenes/stack.hpp"
#include "thread_clock.hpp"

#include <bristle/math/dual.hpp>

#include <algorithm>
#include <array>
#include <cstdio>

using namespace bristle;

namespace {

template <typename S>
S variable(double value, std::size_t i) {
  if constexpr (derivatives_of<S> != 0) {
    return i < derivatives_of<S> ? S::variable(value, i) : S(value);
  } else {
    return value;
  }
}

template <typename S>
auto grasp() {
  scenes::GraspDef<S> def;
  def.gravity = variable<S>(9.81, 0);
  def.static_friction = variable<S>(1000, 1);
  def.part_mass = variable<S>(0.5, 2);
  def.sliding_friction = variable<S>(2, 3);
  return scenes::make_grasp<S>(def);
}

template <typename S>
auto stack() {
  scenes::StackDef<S> def;
  for (std::size_t i = 0; i < 4; ++i) def.masses[i] = variable<S>(1, i);
  return scenes::make_stack<S>(def);
}

/// [us] Time of a step, from where the scene was left.
template <typename Scene>
double step_time(Scene& scene) {
  constexpr int steps = 100;
  const double start = benchmarks::thread_seconds();
  for (int i = 0; i < steps; ++i) scene.world.step();
  return 1e6 * (benchmarks::thread_seconds() - start) / steps;
}

template <typename... Scene>
void measure(const char* name, Scene... scene) {
  const auto all = [&](auto&& use) {
    std::size_t i = 0;
    (use(scene, i++), ...);
  };
  all([](auto& s, std::size_t) {
    for (int i = 0; i < 5; ++i) step_time(s);
  });
  std::array<std::array<double, 11>, sizeof...(Scene)> times{};
  for (std::size_t k = 0; k < 11; ++k) {
    all([&](auto& s, std::size_t i) { times[i][k] = step_time(s); });
  }
  std::printf("%-8s", name);
  for (auto& t : times) {
    std::nth_element(t.begin(), t.begin() + 5, t.end());
    std::printf("  %9.2f (%4.1f)", t[5], t[5] / times[0][5]);
  }
  std::printf("\n");
}

}  // namespace

int main() {
  using D1 = Dual<double, 1>;
  using D4 = Dual<double, 4>;
  std::printf("us/step     double           Dual 1            Dual 4\n");
  measure("grasp", grasp<double>(), grasp<D1>(), grasp<D4>());
  measure("stack", stack<double>(), stack<D1>(), stack<D4>());
}
