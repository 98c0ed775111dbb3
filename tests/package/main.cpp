// The smallest program of a user, in two translation units that both include everything.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/bristle.hpp>

#include <cstdio>

double other_mass(double radius);

namespace {

double mass(double radius) {
  const bristle::MassProperties<double> ball{.mass = radius * radius * radius};
  return ball.mass;
}

}  // namespace

int main() {
  std::printf("bristle %d.%d.%d\n", BRISTLE_VERSION_MAJOR, BRISTLE_VERSION_MINOR,
              BRISTLE_VERSION_PATCH);
  return mass(2.0) == other_mass(2.0) ? 0 : 1;
}
