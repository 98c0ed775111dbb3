// A ball falls for a tenth of a second, by headers or by the compiled library.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/bristle.hpp>

#include <cmath>
#include <cstdio>

int main() {
  using namespace bristle;
  World<double> world({.gravity = {0, 0, -10}, .time_step = 1e-3});
  const BodyId ball = world.add_body({.shape = Sphere<double>{.radius = 0.1}});
  for (int i = 0; i < 100; ++i) world.step();
  const double height = world.pose(ball).translation.z();
  std::printf("bristle %s: a ball fell to %.6f m\n", BRISTLE_VERSION_STRING, height);
  return std::abs(height + 0.05) < 1e-12 ? 0 : 1;
}
