// The second translation unit: what a header defines twice breaks the link here.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/bristle.hpp>

double other_mass(double radius);

double other_mass(double radius) {
  const bristle::MassProperties<double> ball{.mass = radius * radius * radius};
  return ball.mass;
}
