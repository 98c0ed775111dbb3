// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/sensors/placement.hpp>
#include <bristle/sensors/tuning.hpp>
#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

using namespace bristle;

namespace {

/// A fixed pad of 80 mm with 33 x 33 sensors of 10 mm on its upper face, and a ball on it.
template <typename S>
struct BallOnPad {
  World<S> world{{.gravity = {0, 0, S(-9.81)}, .time_step = S(1e-3)}};
  BodyId pad{};
  BodyId ball{};
  PatchId skin{};

  static constexpr S length = S(0.01);

  /// @param below  [m] Part of the rays below the surface of the pad.
  BallOnPad(S radius, const GripSpec<S>& spec, S below, bool is_hard) {
    constexpr S half = S(0.05);
    pad = world.add_body(
        {.motion = Motion::fixed, .shape = Box<S>{.half_extents = {half, half, half}}});
    BodyDef<S> def{.mass = spec.mass,
                   .shape = Sphere<S>{radius},
                   .position = {0, 0, half + length - below + radius}};
    if (!is_hard) def.filter.mask = 0;
    ball = world.add_body(def);
    SensorLayout<S> layout;
    for (int i = -16; i <= 16; ++i) {
      for (int j = -16; j <= 16; ++j) {
        layout.add(Vec3<S>(S(i) * S(0.0025), S(j) * S(0.0025), half - below), Vec3<S>(0, 0, 1),
                   length);
      }
    }
    skin = world.add_patch(pad, layout, tuned_for(spec));
  }

  void settle() {
    for (int i = 0; i < 2000; ++i) world.step();
  }
  [[nodiscard]] S deepest() const {
    S most = S(0);
    for (const S e : world.reading(skin).depth) most = std::max(most, e);
    return most;
  }
};

template <typename S>
GripSpec<S> ball_spec(S radius, S press = S(0.3)) {
  GripSpec<S> spec;
  spec.load = S(9.81);
  spec.mass = S(1);
  spec.press = press;
  spec.radius = radius;
  return spec;
}

}  // namespace

TEST_CASE_TEMPLATE("patch_report: a ball rests as deep as its spec says, whatever its radius", S,
                   double, float) {
  for (const S radius : {S(0.01), S(0.03), S(0.1)}) {
    // Few sensors carry it at a tenth: all 1089 together are good for 2000 times its weight.
    for (const S press : {S(0.1), S(0.3), S(0.6)}) {
      for (const bool is_hard : {false, true}) {
        CAPTURE(radius);
        CAPTURE(press);
        CAPTURE(is_hard);
        BallOnPad<S> scene(radius, ball_spec(radius, press), S(0.002), is_hard);
        scene.settle();
        // The constants are of the same sensors: what is left is that the ball comes to rest.
        CHECK(scene.deepest() == test::relative(press).epsilon(1e-3));
        CHECK(scene.world.reading(scene.skin).total_normal() ==
              test::relative(S(9.81)).epsilon(1e-3));
        CHECK(scene.world.reading(scene.skin).bottomed_out() == 0);
        CHECK(scene.world.report().sensors_bottomed_out == 0);
        CHECK(scene.world.patch_report(scene.skin).warnings().empty());
      }
    }
  }
}

TEST_CASE("patch_report: between four sensors a ball rests a little less deep") {
  for (const double radius : {0.01, 0.03, 0.1}) {
    for (const double press : {0.3, 0.6}) {
      CAPTURE(radius);
      CAPTURE(press);
      BallOnPad<double> scene(radius, ball_spec(radius, press), 0.002, true);
      const Vec3<double> beside(0.00125, 0.00125, 0);
      scene.world.set_pose(scene.ball, {scene.world.pose(scene.ball).rotation,
                                        scene.world.pose(scene.ball).translation + beside});
      scene.settle();
      // Over the corners of its cell a ball is higher by r^2 / (2 R) than in the middle. Sums over
      // the lattice differ by less than half a percent.
      const double higher = beside.squaredNorm() / (2 * radius) / (press * 0.01);
      CHECK(scene.deepest() < press);
      CHECK(scene.deepest() > press * (1 - higher - 0.005));
    }
  }
}

TEST_CASE("patch_report: constants for a plane let a ball sink to the bottom, and it says so") {
  GripSpec<double> spec = ball_spec(0.03);
  spec.radius = 0;
  // All but a twentieth of each ray lies in the pad.
  BallOnPad<double> scene(0.03, spec, 0.0095, false);
  scene.settle();
  const PatchReading<double> reading = scene.world.reading(scene.skin);
  CHECK(scene.deepest() == 1);
  CHECK(reading.bottomed_out() > 0);
  std::size_t whole = 0;
  for (const double e : reading.depth) whole += e == 1 ? 1u : 0u;
  CHECK(reading.bottomed_out() == whole);
  CHECK(scene.world.report().sensors_bottomed_out == whole);
  const PatchReport<double> report = scene.world.patch_report(scene.skin);
  CHECK(report.bottomed_out == whole);
  CHECK(report.load == reading.total_normal());
  REQUIRE(report.warnings().size() == 2);
  CHECK(report.warnings()[0].find("less than 0.1 of their ray outside") != std::string::npos);
  CHECK(report.warnings()[1].find(std::to_string(whole) + " of 1089 sensors were fully pressed") ==
        0);
  CHECK(report.warnings()[1].find("a larger GripSpec::load carries it, or GripSpec::radius") !=
        std::string::npos);
}

TEST_CASE("patch_report: shares of rays outside of the body, of all of its shapes") {
  World<double> world;
  const BodyId body = world.add_body({.mass = 1, .shape = Box<double>{{0.05, 0.05, 0.05}}});
  // A second shape over half of the face, 8 mm high, and a trigger that does not count.
  world.add_shape(body, {.shape = Box<double>{{0.025, 0.05, 0.004}},
                         .X_BS = {Quat<double>::Identity(), {0.025, 0, 0.054}}});
  world.add_shape(body, {.shape = Sphere<double>{0.2}, .is_trigger = true});
  PatchDef<double> def;
  def.may_point_inwards = true;
  def.parameters.normal_stiffness = 10;
  // From 5 mm below the face; the third from above it, the fourth into it.
  def.sensors.add({-0.02, 0, 0.045}, {-0.02, 0, 0.055});
  def.sensors.add({0.02, 0, 0.0485}, {0.02, 0, 0.0585});
  def.sensors.add({-0.02, 0, 0.06}, {-0.02, 0, 0.07});
  def.sensors.add({-0.02, 0, 0.06}, {-0.02, 0, 0.045});
  const PatchReport<double> report = world.patch_report(world.add_patch(body, def));
  REQUIRE(report.share_outside.size() == 4);
  CHECK(report.share_outside[0] == test::relative(0.5));
  CHECK(report.share_outside[1] == test::relative(0.05));
  CHECK(report.share_outside[2] == 1);
  CHECK(report.share_outside[3] == 0);
  CHECK(report.buried() == std::vector<std::uint32_t>{1, 3});
  REQUIRE(report.warnings().size() == 1);
  CHECK(report.warnings()[0].find("2 of 4 sensors") == 0);
  CHECK(report.warnings()[0].find("sensor 1 the first") != std::string::npos);
}

TEST_CASE("patch_report: rays behind a thin plate, about a centre of mass that is not the origin") {
  World<double> world;
  // A plate of 1 mm, 0.1 m above its body's origin.
  BodyDef<double> def{.mass = 1, .position = {1, 2, 3}};
  def.center_of_mass = Vec3<double>(0.01, -0.02, 0.1);
  def.shapes.push_back({.shape = Box<double>{{0.05, 0.05, 0.0005}},
                        .X_BS = {Quat<double>::Identity(), {0, 0, 0.1}}});
  const BodyId plate = world.add_body(def);
  PatchDef<double> patch;
  patch.parameters.normal_stiffness = 2;
  patch.sensors.add({0, 0, 0.095}, {0, 0, 0.105});
  patch.sensors.add({0, 0, 0.091}, {0, 0, 0.101});
  patch.per_sensor.assign(2, patch.parameters);
  patch.per_sensor[1].normal_stiffness = 5;
  patch.may_point_inwards = true;  // They start behind the plate.
  const PatchReport<double> report = world.patch_report(world.add_patch(plate, patch));
  CHECK(report.share_outside[0] == test::relative(0.45));
  CHECK(report.share_outside[1] == test::relative(0.05));
  CHECK(report.largest_load == 7);
  CHECK(report.buried() == std::vector<std::uint32_t>{1});
}

TEST_CASE_TEMPLATE("patch_report: weights of the patch's own body and of those that it may sense",
                   S, double, float) {
  World<S> world({.gravity = {0, S(6), S(8)}});
  const auto add = [&](S mass, Motion motion, std::uint32_t category, S gravity_scale) {
    BodyDef<S> def{.motion = motion, .mass = mass, .shape = Sphere<S>{S(0.01)}};
    def.position = {0, 0, S(1)};
    def.filter.category = category;
    const BodyId id = world.add_body(def);
    if (motion == Motion::dynamic) world.set_gravity_scale(id, gravity_scale);
    return id;
  };
  const BodyId own = add(S(5), Motion::dynamic, 1, S(1));
  const BodyId excluded = add(S(1e4), Motion::dynamic, 1, S(1));
  (void)add(S(1e5), Motion::dynamic, 2, S(1));
  (void)add(S(1), Motion::kinematic, 1, S(1));
  (void)add(S(3), Motion::dynamic, 1, S(-2));
  (void)add(S(2), Motion::dynamic, 1, S(1));
  PatchDef<S> def;
  def.sensors.add({0, 0, 0}, {0, 0, S(0.02)});
  def.parameters.normal_stiffness = S(1);
  def.sense_mask = 1;
  def.excluded = {excluded};
  const PatchReport<S> report = world.patch_report(world.add_patch(own, def));
  CHECK(report.least_weight == test::relative(S(20)));
  CHECK(report.largest_weight == test::relative(S(60)));
  CHECK(report.share_outside[0] == test::relative(S(0.5)));
}

TEST_CASE("patch_report: loads that the bodies of the world do not have") {
  World<double> world({.gravity = {0, 0, -10}});
  const BodyId pad =
      world.add_body({.motion = Motion::fixed, .shape = Box<double>{{0.05, 0.05, 0.05}}});
  const auto warnings_with = [&](double load) {
    SensorLayout<double> layout;
    layout.add({0, 0, 0.045}, {0, 0, 0.055});
    layout.add({0.01, 0, 0.045}, {0.01, 0, 0.055});
    const PatchId skin =
        world.add_patch(pad, layout, tuned_for<double>({.load = load, .press = 0.5}));
    const PatchReport<double> report = world.patch_report(skin);
    CHECK(report.largest_load == test::relative(2 * load));
    CHECK(report.intended_load == load);
    world.set_parameters(skin, {});
    CHECK(world.patch_report(skin).intended_load == 0);
    world.remove_patch(skin);
    return report.warnings();
  };
  // Nothing to be sensed, nothing to be said.
  CHECK(warnings_with(1e-6).empty());
  const auto add = [&](double mass) {
    return world.add_body({.mass = mass, .shape = Sphere<double>{0.01}, .position = {0, 0, mass}});
  };
  (void)add(1);
  const BodyId heavy = add(20);
  CHECK(warnings_with(10).empty());
  REQUIRE(warnings_with(4.9).size() == 1);
  CHECK(warnings_with(4.9)[0].find("the lightest body, 10 N") != std::string::npos);
  CHECK(warnings_with(1.999e5).empty());
  REQUIRE(warnings_with(2.001e5).size() == 1);
  CHECK(warnings_with(2.001e5)[0].find("the heaviest body, 200 N") != std::string::npos);
  world.remove_body(heavy);
  CHECK(warnings_with(1.999e5).size() == 1);
  world.set_gravity({0, 0, 0});
  CHECK(warnings_with(1e9).empty());
  CHECK_THROWS_AS((void)world.patch_report({}), InvalidArgument);
  PatchDef<double> def;
  def.sensors.add({0, 0, 0.045}, {0, 0, 0.055});
  def.load = -1;
  CHECK_THROWS_AS(world.add_patch(pad, def), InvalidArgument);
}
