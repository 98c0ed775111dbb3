// A project that found the component adf can read a scene with it.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/io/adf/adf_reader.hpp>

#include <cstdio>

int main() {
  const bristle::detail::AdfModel model =
      bristle::detail::read_adf("bodies: [A]\nA: {mass: 3}\n", "scene.yaml");
  std::printf("%s weighs %g kg\n", model.bodies.at(0).name.c_str(), model.bodies.at(0).mass);
  return model.bodies.at(0).mass == 3.0 ? 0 : 1;
}
