// Parcels on a conveyor pass a light barrier, and the host counts them by its own numbers.
//
// The belt runs at v = 0.5 m/s and friction is 0.5. A parcel that is put down slips for v / (mu g)
// = 0.10 s and lags v^2 / (2 mu g) = 25 mm behind the belt. Its front is 0.9, 1.4 and 1.9 m from
// the barrier, so it gets there after (0.9 + 0.025) / 0.5 = 1.85 s, 2.85 s and 3.85 s.
//
// Expected output: 20_conveyor.expected
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/bristle.hpp>

#include <cstdint>
#include <cstdio>

int main() {
  using namespace bristle;
  World<double> world({.time_step = 1.0 / 240, .keeps_contact_events = true});
  world.add_body({.motion = Motion::fixed,
                  .shape = Box<double>{.half_extents = {3, 0.3, 0.1}},
                  .material = {.friction = 0.5, .surface_velocity = {0.5, 0, 0}},
                  .position = {0, 0, -0.1}});
  // 10 mm thick, from x = 2 m on, above the belt.
  ShapeDef<double> light;
  light.shape = Box<double>{.half_extents = {0.005, 0.3, 0.1}};
  light.is_trigger = true;
  const BodyId barrier =
      world.add_body({.motion = Motion::fixed, .shapes = {light}, .position = {2.005, 0, 0.12}});
  for (std::uint64_t i = 0; i < 3; ++i) {
    world.add_body({.mass = 2.0,
                    .shape = Box<double>{.half_extents = {0.1, 0.1, 0.1}},
                    .material = {.friction = 0.5},
                    .position = {1 - 0.5 * static_cast<double>(i), 0, 0.1},
                    .user_data = 100 + i});
  }
  // A frame of the host has four steps.
  for (int frame = 1; frame <= 300; ++frame) {
    for (int i = 0; i < 4; ++i) world.step();
    for (const ContactEvent& event : world.contact_events()) {
      const bool is_a = event.body_a == barrier;
      if (!is_a && event.body_b != barrier) continue;
      const BodyId parcel = is_a ? event.body_b : event.body_a;
      if (!world.contains(parcel)) continue;  // It was taken off while in the light.
      std::printf("%.2f s: parcel %llu %s\n", frame / 60.0,
                  static_cast<unsigned long long>(world.user_data(parcel)),
                  event.phase == ContactEvent::Phase::begin ? "is in the light" : "has passed");
    }
    world.clear_contact_events();
  }
}
