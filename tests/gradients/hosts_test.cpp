/// @file
/// Derivatives of sensors in somebody else's engine, against closed forms.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/block_on_plate.hpp"
#include "support/relative.hpp"

#include <bristle/math/dual.hpp>

#include <doctest/doctest.h>

#include <cmath>

using namespace bristle;
using namespace bristle::scenes;

TEST_CASE("HostSensors: the sag of a pushed block has derivatives by mu_S and by the push") {
  using D = Dual<double, 2>;
  CastingBlockOnPlate<D> host;
  HostSensors<D> sensors;
  PatchDef<D> def = plate_patch<D>();
  const double mu_S = def.parameters.static_friction.value();
  def.parameters.static_friction = D::variable(mu_S, 0);
  const PatchId patch = host.attach(sensors, def);
  host.push = {D::variable(1.5, 1), D(0), D(0)};
  for (int i = 0; i < 600; ++i) {
    sensors.step(host, D(1.0 / 60));
    host.step(D(1.0 / 60));
  }
  const double sag = 1.5 / (mu_S * 4.905);
  CHECK(host.block.x().value() == test::relative(sag).epsilon(1e-6));
  CHECK(host.block.x().partial(0) == test::relative(-sag / mu_S).epsilon(1e-6));
  CHECK(host.block.x().partial(1) == test::relative(sag / 1.5).epsilon(1e-6));
  CHECK(std::abs(sensors.world().reading(patch).total_shear().partial(0)) < 1e-9 * 1.5 / mu_S);
  CHECK(sensors.world().reading(patch).total_shear().partial(1) == test::relative(1).epsilon(1e-9));
}
