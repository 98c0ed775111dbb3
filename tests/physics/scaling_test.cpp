/// @file
/// No hidden lengths: a scene and its copy at another size, or at another place, behave alike.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/plate.hpp"
#include "support/relative.hpp"

#include <doctest/doctest.h>

#include <cmath>

using namespace bristle;
using namespace bristle::scenes;

namespace {

/// A plate that drops, slides, slips and settles, 0.5 s of it.
template <typename S>
PlateScene<S> eventful(S scale, bool has_contact, Integration integration) {
  PlateDef<S> def;
  def.scale = scale;
  def.has_contact = has_contact;
  def.integration = integration;
  def.incline = S(0.2);
  def.drop = S(0.002);
  def.parameters.sliding_friction = S(2);
  auto scene = make_plate<S>(def);
  scene.world.set_velocity(
      scene.plate, {scale * Vec3<S>(S(0.1), S(0.05), S(0)), Vec3<S>(S(0.1), S(0.2), S(0.3))});
  scene.run(S(0.5));
  return scene;
}

}  // namespace

TEST_CASE("scaling: a scene at x0.01 and x100 agrees with itself") {
  for (const bool has_contact : {false, true}) {
    for (const Integration integration : {Integration::explicit_, Integration::implicit}) {
      const auto reference = eventful<double>(1, has_contact, integration);
      for (const double scale : {0.01, 100.0}) {
        const auto scaled = eventful<double>(scale, has_contact, integration);
        INFO("scale ", scale, ", contact ", has_contact);
        CHECK((scaled.position() - reference.position()).norm() < 1e-9);
        CHECK((scaled.velocity() - reference.velocity()).norm() < 1e-8);
        CHECK(scaled.world.report().sensors_touching == reference.world.report().sensors_touching);
        const auto a = scaled.world.reading(scaled.patch);
        const auto b = reference.world.reading(reference.patch);
        CHECK(a.total_normal() / scale == test::relative(b.total_normal()).epsilon(1e-6));
      }
    }
  }
}

TEST_CASE("scaling: float scenes at x0.01 and x100 come to rest alike") {
  const auto reference = eventful<float>(1, false, Integration::implicit);
  for (const float scale : {0.01F, 100.0F}) {
    const auto scaled = eventful<float>(scale, false, Integration::implicit);
    // Slips may differ by a round-off, and a stair by what it carries over: a tenth of sigma_a.
    CHECK((scaled.position() - reference.position()).norm() < 1e-4F);
  }
}

TEST_CASE("scaling: in double, a hold does not notice 1 km from the origin") {
  PlateDef<double> def;
  def.incline = 0.5;
  def.parameters.sliding_friction = 5;
  auto here = make_plate<double>(def);
  def.origin = {1000, -500, 300};
  auto there = make_plate<double>(def);
  here.run(3);
  there.run(3);
  // Positions of 1 km are known to 1e-13 m.
  CHECK((here.position() - there.position()).norm() < 1e-10);
}

TEST_CASE("scaling: in float, a hold far from the origin errs by the resolution of positions") {
  PlateDef<float> def;
  def.incline = 0.5F;
  def.parameters.sliding_friction = 5;
  auto here = make_plate<float>(def);
  here.run(3);
  for (const float far : {8.0F, 100.0F}) {
    def.origin = {far, -0.5F * far, 0};
    auto there = make_plate<float>(def);
    there.run(3);
    const Vec3<float> settled = there.position();
    // An ulp of the position: 1 um at 8 m, 8 um at 100 m. Bristles see differences of positions.
    const float ulp = far * std::numeric_limits<float>::epsilon();
    CHECK((settled - here.position()).norm() < 4 * ulp);
    there.run(3);
    CHECK((there.position() - settled).norm() < 2 * ulp);
  }
}
