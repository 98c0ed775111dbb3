// A ball bounces: events say when it touches, impulses how hard.
//
// It falls 0.1 m, hits the floor with sqrt(2 g h) = 1.40 m/s and leaves it with half of that: an
// impulse of 0.2 kg * 2.1 m/s = 0.42 N s. In the end it lies there with its weight, 1.962 N.
//
// Expected output: 10_contacts.expected
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/bristle.hpp>

#include <cstdio>

int main() {
  using namespace bristle;
  World<double> world({.time_step = 1e-3});
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
  const BodyId ball = world.add_body({.mass = 0.2,
                                      .shape = Sphere<double>{.radius = 0.05},
                                      .material = {.restitution = 0.5},
                                      .position = {0, 0, 0.15}});
  for (int i = 1; i <= 2000; ++i) {
    world.step();
    if (i > 380) continue;
    world.for_each_contact_event([&](const ContactEvent& event) {
      if (event.phase != ContactEvent::Phase::begin) return;
      std::printf("%.2f s: an impulse of %.2f N s\n", 1e-3 * i,
                  world.contact_impulse(ball).force.z());
    });
  }
  std::printf("at rest: %.3f N\n", world.contact_impulse(ball).force.z() / world.time_step());
}
