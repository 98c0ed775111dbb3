// A ball falls, in float and in double, with every header in both translation units.
// SPDX-License-Identifier: BSD-3-Clause
#define BRISTLE_WITH_FILES 1
#define BRISTLE_WITH_THREADS 1
#include <bristle/bristle.hpp>

#include <cmath>
#include <cstdio>

float fallen_height_in_float(int steps);

int main() {
  using namespace bristle;
  constexpr int steps = 100;
  World<double> world({.gravity = {0, 0, -10}, .time_step = 1e-3});
  const BodyId ball = world.add_body({.shape = Sphere<double>{.radius = 0.1}});
  for (int i = 0; i < steps; ++i) world.step();

  // Constant acceleration is integrated exactly: z = -g t^2 / 2.
  const double expected = -10 * 1e-6 * steps * steps / 2;
  const double height = world.pose(ball).translation.z();
  const double in_float = static_cast<double>(fallen_height_in_float(steps));
  std::printf("bristle %s: a ball fell to %.6f m, in float to %.6f m\n", BRISTLE_VERSION_STRING,
              height, in_float);
  const bool is_right = std::abs(height - expected) < 1e-12 && std::abs(in_float - expected) < 1e-5;
  return is_right ? 0 : 1;
}
