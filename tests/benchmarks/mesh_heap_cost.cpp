// Cost of worlds of meshes beside how well they behave: two ball meshes apart and half in each
// other, nuts that fall into a box, and boxes that are all at one place. 1/240 s, double, defaults.
// SPDX-License-Identifier: BSD-3-Clause
#include "benchmarks/benchmark_table.hpp"
#include "benchmarks/thread_clock.hpp"

#include <bristle/bristle.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

using namespace bristle;
using benchmarks::in_short;
using benchmarks::Table;

namespace {

constexpr double time_step = 1.0 / 240;

/// Times of steps [ms].
struct StepTimes {
  double first = 0;
  double sum = 0;
  double worst = 0;
  int count = 0;

  void step(World<double>& world) {
    const double start = benchmarks::thread_seconds();
    world.step();
    const double time = 1e3 * (benchmarks::thread_seconds() - start);
    if (count == 0) first = time;
    sum += time;
    worst = std::max(worst, time);
    ++count;
  }
  [[nodiscard]] double mean() const { return sum / count; }
};

/// A hexagonal nut with a round hole, its axis along z: `around` times `layers` quads outside and
/// inside.
TriangleMesh<double> nut(double outer, double hole, double half_height, std::uint32_t around,
                         std::uint32_t layers) {
  TriangleMesh<double> mesh;
  const double pi = std::numbers::pi;
  for (const bool is_hole : {false, true}) {
    for (std::uint32_t k = 0; k <= layers; ++k) {
      for (std::uint32_t i = 0; i < around; ++i) {
        const double angle = 2 * pi * i / around;
        const double off_corner = std::fmod(angle, pi / 3) - pi / 6;
        const double r = is_hole ? hole : outer * std::cos(pi / 6) / std::cos(off_corner);
        mesh.vertices.push_back(
            {r * std::cos(angle), r * std::sin(angle), half_height * (2.0 * k / layers - 1)});
      }
    }
  }
  const auto at = [&](std::uint32_t side, std::uint32_t k, std::uint32_t i) {
    return (side * (layers + 1) + k) * around + i % around;
  };
  const auto add_quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  };
  for (std::uint32_t i = 0; i < around; ++i) {
    for (std::uint32_t k = 0; k < layers; ++k) {
      add_quad(at(0, k, i), at(0, k, i + 1), at(0, k + 1, i + 1), at(0, k + 1, i));
      add_quad(at(1, k, i), at(1, k + 1, i), at(1, k + 1, i + 1), at(1, k, i + 1));
    }
    add_quad(at(0, layers, i), at(0, layers, i + 1), at(1, layers, i + 1), at(1, layers, i));
    add_quad(at(0, 0, i), at(1, 0, i), at(1, 0, i + 1), at(0, 0, i + 1));
  }
  return mesh;
}

/// Two balls of 0.2 m and 1 kg at a distance, without gravity, for half a second.
void two_balls(Table& table, std::uint32_t frequency, double distance, const char* name) {
  const TriangleMesh<double> ball = sphere_mesh<double>(0.2, frequency);
  World<double> world({.gravity = Vec3<double>::Zero(), .time_step = time_step});
  const BodyId a = world.add_body({.mass = 1.0, .shape = ball});
  const BodyId b = world.add_body({.mass = 1.0,
                                   .shape = ball,
                                   .position = {distance, 0, 0},
                                   .orientation = Quat<double>(1, 0.1, 0.2, 0.3).normalized()});
  StepTimes times;
  for (int n = 0; n < 120; ++n) times.step(world);
  const double moved =
      (world.body(b).center_pose.translation - world.body(a).center_pose.translation).norm() -
      distance;
  const double speed = world.body(a).twist.linear.norm() + world.body(b).twist.linear.norm();
  table.add({std::string(name) + ", " + std::to_string(ball.triangles.size()) + " triangles each",
             in_short(times.mean()), in_short(times.first), in_short(times.worst),
             "moved " + in_short(1e3 * moved) + " mm, " + in_short(speed) + " m/s at the end"});
}

/// Walls of a box of 0.12 m around the origin, and its floor.
void add_box(World<double>& world) {
  const auto add = [&](const Vec3<double>& normal, double offset) {
    world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{normal, offset}});
  };
  add(Vec3<double>::UnitZ(), 0);
  for (const double side : {-1.0, 1.0}) {
    add({side, 0, 0}, -0.06);
    add({0, side, 0}, -0.06);
  }
}

/// Steel nuts of 4 cm fall into a box.
void nuts(Table& table, int count, std::uint32_t around, std::uint32_t layers) {
  const TriangleMesh<double> mesh = nut(0.02, 0.011, 0.008, around, layers);
  World<double> world({.time_step = time_step});
  add_box(world);
  std::vector<BodyId> ids;
  for (int i = 0; i < count; ++i) {
    const double turn = i;
    ids.push_back(world.add_body(
        {.density = 7800,
         .shape = mesh,
         .material = {0.5, 0},
         .position = {0.05 * (i % 2) - 0.025, 0.05 * (i / 2 % 2) - 0.025, 0.03 + 0.045 * (i / 4)},
         .orientation = Quat<double>(1, std::sin(turn), std::cos(2 * turn), std::sin(3 * turn))
                            .normalized()}));
  }
  StepTimes times;
  double speed = 0;
  double deepest = 0;
  for (int n = 0; n < 480; ++n) {
    times.step(world);
    speed = 0;
    for (const BodyId id : ids) {
      speed = std::max(speed, world.body(id).twist.linear.norm());
    }
    world.for_each_contact([&](const ContactReading<double>& contact) {
      contact.for_each_point([&](const auto& point) { deepest = std::min(deepest, point.gap); });
    });
  }
  table.add(
      {std::to_string(count) + " nuts of " + std::to_string(mesh.triangles.size()) + " triangles",
       in_short(times.mean()), in_short(times.first), in_short(times.worst),
       in_short(speed) + " m/s after 2 s, overlap " + in_short(-1e3 * deepest) + " mm"});
}

void crowd(Table& table, int count) {
  World<double> world({.time_step = time_step});
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{Vec3<double>::UnitZ(), 0}});
  std::vector<BodyId> ids;
  for (int i = 0; i < count; ++i) {
    ids.push_back(world.add_body(
        {.mass = 1.0, .shape = Box<double>{{0.05, 0.05, 0.05}}, .position = {0, 0, 1}}));
  }
  StepTimes times;
  for (int n = 0; n < 60; ++n) times.step(world);
  double speed = 0;
  for (const BodyId id : ids) speed = std::max(speed, world.body(id).twist.linear.norm());
  table.add({std::to_string(count) + " boxes at one place", in_short(times.mean()),
             in_short(times.first), in_short(times.worst), in_short(speed) + " m/s after 0.25 s"});
}

}  // namespace

int main(int argc, char** argv) {
  Table table(argc > 1 && std::string(argv[1]) == "--markdown",
              {"                                    scene", "mean [ms]", "first [ms]", "worst [ms]",
               "how it behaves"});
  for (const std::uint32_t frequency : {5u, 9u, 19u}) {
    two_balls(table, frequency, 0.401, "balls 1 mm apart");
    two_balls(table, frequency, 0.2, "balls half in each other");
  }
  nuts(table, 20, 24, 1);
  nuts(table, 20, 72, 6);
  nuts(table, 50, 72, 6);
  crowd(table, 200);
  crowd(table, 1000);
}
