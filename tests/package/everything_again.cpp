// The second translation unit: what a header defines twice breaks the link, and the explicit
// instantiation compiles every member of the world.
// SPDX-License-Identifier: BSD-3-Clause
#define BRISTLE_WITH_FILES 1
#define BRISTLE_WITH_THREADS 1
#include <bristle/bristle.hpp>

template class bristle::World<float>;

float fallen_height_in_float(int steps);

float fallen_height_in_float(int steps) {
  using namespace bristle;
  World<float> world({.gravity = {0, 0, -10}, .time_step = 1e-3F});
  const BodyId ball = world.add_body({.shape = Sphere<float>{.radius = 0.1F}});
  for (int i = 0; i < steps; ++i) world.step();
  return world.pose(ball).translation.z();
}
