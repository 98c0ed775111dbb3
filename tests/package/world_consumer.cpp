// A project that links the compiled library gets sensors that hold a box and a ball, in each
// instruction set that there is. The box has the figures of examples/01_falling_box.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/bristle.hpp>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <set>
#include <string>

using namespace bristle;

template <typename S>
SensorLayout<S> square(S side, std::size_t count, S height, S up) {
  return sensor_grid<S>({.center = {0, 0, height},
                         .side_u = up > 0 ? Vec3<S>(side, 0, 0) : Vec3<S>(0, side, 0),
                         .side_v = up > 0 ? Vec3<S>(0, side, 0) : Vec3<S>(side, 0, 0),
                         .count_u = count,
                         .count_v = count});
}

/// Drops a box with a skin of 25 sensors; it rests on them, pressed in by 3 of the 5 mm that they
/// reach out, and they carry its weight.
template <typename S>
bool holds_a_box() {
  World<S> world({.gravity = {0, 0, S(-9.81)}, .time_step = S(1e-3)});
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<S>{}});
  const BodyId box = world.add_body({.mass = S(0.5),
                                     .shape = Box<S>{.half_extents = {S(0.03), S(0.03), S(0.03)}},
                                     .position = {0, 0, S(0.1)}});
  const PatchId skin =
      world.add_patch(box, square<S>(S(0.06), 5, S(-0.03), S(-1)),
                      tuned_for<S>({.friction = S(0.8), .creep = S(1e-3), .load = S(0.5 * 9.81)}));
  for (int i = 0; i < 1000; ++i) world.step();
  const World<S> copy = world;
  const double height = static_cast<double>(copy.pose(box).translation.z());
  const double force = static_cast<double>(copy.reading(skin).total_normal());
  std::printf("%.2f mm, %.3f N\n", 1e3 * height, force);
  return std::abs(height - 0.032) < 1e-5 && std::abs(force - 0.5 * 9.81) < 1e-3;
}

/// A ball that rolls on a pad of 1024 sensors: a state whose last bits tell the order of sums.
World<double> rolling_ball() {
  World<double> world({.time_step = 1e-3});
  const BodyId pad =
      world.add_body({.motion = Motion::fixed, .shape = Box<double>{{0.1, 0.1, 0.01}}});
  const BodyId ball = world.add_body(
      {.mass = 1.0, .shape = Sphere<double>{0.05}, .position = {0.003, 0.002, 0.06}});
  world.set_velocity(ball, {{0.05, 0.02, 0}, {0, 1, 0}});
  world.add_patch(pad, square<double>(0.1, 32, 0.01, 1.0),
                  tuned_for<double>({.friction = 0.8, .creep = 1e-3, .load = 9.81}));
  return world;
}

std::uint64_t end_of(World<double> world) {
  for (int i = 0; i < 300; ++i) world.step();
  return world.state_hash();
}

int main() {
  bool is_right = true;
  std::set<std::uint64_t> ends;
  std::size_t sets = 0;
  set_instruction_set(InstructionSet::baseline);
  const World<double> first = rolling_ball();
  const std::uint64_t end_of_first = end_of(first);
  for (const InstructionSet set :
       {InstructionSet::baseline, InstructionSet::v3, InstructionSet::v4}) {
    try {
      set_instruction_set(set);
    } catch (const InvalidArgument& error) {
      std::printf("%s\n", error.what());
      continue;
    }
    std::printf("%s\n", std::string(name_of(set)).c_str());
    is_right = holds_a_box<double>() && holds_a_box<float>() && is_right;
    // Each set has its own order of sums, and keeps to it; a world keeps the set it was made with.
    const std::uint64_t end = end_of(rolling_ball());
    is_right = end == end_of(rolling_ball()) && end_of(first) == end_of_first && is_right;
    ends.insert(end);
    ++sets;
  }
  if (ends.size() != sets) std::printf("%zu sets, %zu states\n", sets, ends.size());
  return is_right && ends.size() == sets ? 0 : 1;
}
