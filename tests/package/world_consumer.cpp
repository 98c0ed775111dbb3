// What a project that links the compiled library can do with it: a skin that holds a box, a haptic
// loop, each instruction set that there is. The same figures as examples/01_falling_box.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/bristle.hpp>

#include <cmath>
#include <cstdio>

using namespace bristle;

template <typename S>
bool holds() {
  World<S> world({.gravity = {0, 0, S(-9.81)}, .time_step = S(1e-3)});
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<S>{}});
  const BodyId box = world.add_body({.mass = S(0.5),
                                     .shape = Box<S>{.half_extents = {S(0.03), S(0.03), S(0.03)}},
                                     .position = {0, 0, S(0.1)}});
  const PatchId skin =
      world.add_patch(box,
                      sensor_grid<S>({.center = {0, 0, S(-0.03)},
                                      .side_u = {0, S(0.06), 0},
                                      .side_v = {S(0.06), 0, 0},
                                      .count_u = 5,
                                      .count_v = 5}),
                      tuned_for<S>({.friction = S(0.8), .creep = S(1e-3), .load = S(0.5 * 9.81)}));
  for (int i = 0; i < 1000; ++i) world.step();
  const World<S> copy = world;
  const double height = static_cast<double>(copy.pose(box).translation.z());
  const double force = static_cast<double>(copy.reading(skin).total_normal());
  std::printf("%s: %.2f mm, %.3f N\n", std::string(name_of(instruction_set())).c_str(),
              1e3 * height, force);
  // It rests on its sensors, pressed in by 3 of the 5 mm that they reach out, and carries its
  // weight.
  return std::abs(height - 0.032) < 1e-5 && std::abs(force - 0.5 * 9.81) < 1e-3;
}

int main() {
  bool all_hold = true;
  for (const InstructionSet set :
       {InstructionSet::baseline, InstructionSet::v3, InstructionSet::v4}) {
    try {
      set_instruction_set(set);
    } catch (const InvalidArgument& error) {
      std::printf("%s\n", error.what());
      continue;
    }
    all_hold = holds<double>() && holds<float>() && all_hold;
  }
  return all_hold ? 0 : 1;
}
