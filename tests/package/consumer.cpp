// A project that found the library can include all of it, compile, link and run.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/bristle.hpp>

#include <cstdio>

int main() {
  const bristle::MassProperties<double> a{.mass = 1, .center = {0, 0, 0}};
  const bristle::MassProperties<double> b{.mass = 3, .center = {4, 0, 0}};
  const bristle::MassProperties<double> both = a + b;
  std::printf("bristle %s: 1 kg at 0 m and 3 kg at 4 m balance at %g m\n", BRISTLE_VERSION_STRING,
              both.center.x());
  return both.mass == 4.0 && both.center.x() == 3.0 ? 0 : 1;
}
