// Prints the hashes of worlds after some steps. Built header-only and against the compiled library,
// it prints the same.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/bristle.hpp>

#include <cstddef>
#include <cstdio>

using namespace bristle;

namespace {

template <typename S>
void print_hash(const char* scene, World<S>& world, int steps) {
  for (int i = 0; i < steps; ++i) world.step();
  std::printf("%s of %zu bytes: %016llx\n", scene, sizeof(S),
              static_cast<unsigned long long>(world.state_hash()));
}

template <typename S>
World<S> with_floor(S time_step) {
  World<S> world({.gravity = {S(0), S(0), S(-9.81)}, .time_step = time_step});
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<S>{}});
  return world;
}

// Boxes, balls, cylinders and meshes of triangles fall on each other.
template <typename S>
void heap() {
  auto world = with_floor<S>(S(1) / S(240));
  for (int i = 0; i < 24; ++i) {
    Shape<S> shape = Box<S>{{S(0.05), S(0.04), S(0.03)}};
    if (i % 4 == 1) shape = Sphere<S>{S(0.04)};
    if (i % 4 == 2) shape = Cylinder<S>{S(0.03), S(0.04)};
    if (i % 4 == 3) shape = box_mesh<S>({S(0.04), S(0.04), S(0.04)});
    world.add_body({.mass = S(0.3),
                    .shape = shape,
                    .position = {S(0.02) * S(i % 3), S(0.03) * S(i % 2), S(0.1) + S(0.09) * S(i)}});
  }
  print_hash("heap", world, 200);
}

// A box slides and stops on a skin of sensors.
template <typename S>
void skin() {
  auto world = with_floor<S>(S(1) / S(500));
  const BodyId box = world.add_body({.mass = S(0.5),
                                     .shape = Box<S>{{S(0.03), S(0.03), S(0.03)}},
                                     .position = {S(0), S(0), S(0.034)},
                                     .velocity = {S(0.3), S(0.1), S(0)}});
  world.add_patch(box,
                  sensor_grid<S>({.center = {S(0), S(0), S(-0.03)},
                                  .side_u = {S(0), S(0.06), S(0)},
                                  .side_v = {S(0.06), S(0), S(0)},
                                  .count_u = 9,
                                  .count_v = 9}),
                  tuned_for<S>({.friction = S(0.4), .creep = S(1e-3), .load = S(4.905)}));
  print_hash("skin", world, 300);
}

// A chain of hinges swings against a wall.
template <typename S>
void chain() {
  auto world = with_floor<S>(S(1) / S(240));
  world.add_body({.motion = Motion::fixed,
                  .shape = Box<S>{{S(0.1), S(1), S(1)}},
                  .position = {S(0.3), S(0), S(1)}});
  BodyId last = world.add_body(
      {.motion = Motion::fixed, .shape = Sphere<S>{S(0.02)}, .position = {S(0), S(0), S(2)}});
  for (int i = 0; i < 6; ++i) {
    const BodyId link = world.add_body({.mass = S(0.2),
                                        .shape = Capsule<S>{S(0.02), S(0.05)},
                                        .position = {S(-0.15) * S(i + 1), S(0), S(2)}});
    world.add_joint({.kind = JointKind::revolute,
                     .body_a = last,
                     .body_b = link,
                     .X_AJ = {.translation = {i == 0 ? S(0) : S(-0.075), S(0), S(0)}},
                     .X_BJ = {.translation = {S(0.075), S(0), S(0)}}});
    last = link;
  }
  print_hash("chain", world, 200);
}

}  // namespace

int main() {
  heap<double>();
  heap<float>();
  skin<double>();
  skin<float>();
  chain<double>();
  chain<float>();
}
