// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/sensors/tuning.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <string>

using namespace bristle;

using namespace bristle::detail;

namespace {
template <typename Call>
std::string field_of(Call&& call) {
  try {
    call();
  } catch (const InvalidArgument& error) {
    return error.field();
  }
  return {};
}
}  // namespace

TEST_CASE("tuned_for: reproduces the table of docs/sensors.md from wants") {
  struct Row {
    double mass, mu, creep, press;
    std::size_t count;
    double length, mu_S, K_N, K_D, mu_V;
  };
  // The constants in the table are rounded to two to four digits.
  for (const Row& row : {Row{0.5, 5, 1e-3, 0.3, 16, 0.01, 5000, 1.022, 0.0357, 9.689},
                         Row{0.5, 0.8, 0.5e-3, 0.3, 16, 0.01, 1600, 1.022, 0.0357, 5.481},
                         Row{0.05, 1, 0.1e-3, 0.3, 25, 0.01, 1e4, 0.0654, 0.00229, 0.877},
                         Row{20, 0.6, 2e-3, 0.4, 100, 0.02, 300, 4.905, 0.280, 15.19},
                         Row{0.002, 1, 5e-3, 0.3, 4, 0.01, 200, 0.01635, 5.72e-4, 0.0310},
                         Row{1000, 1.2, 1e-3, 0.3, 400, 0.02, 1200, 81.75, 4.04, 379.7}}) {
    GripSpec<double> spec;
    spec.friction = row.mu;
    spec.creep = row.creep;
    spec.load = row.mass * 9.81;
    spec.mass = row.mass;
    spec.press = row.press;
    const SensorParameters<double> p = tuned_for(spec).parameters(row.count, row.length);
    CHECK(p.static_friction == test::relative(row.mu_S).epsilon(1e-9));
    CHECK(p.breakaway_distance == row.creep);
    CHECK(p.normal_stiffness == test::relative(row.K_N).epsilon(2e-3));
    CHECK(p.normal_damping == test::relative(row.K_D).epsilon(2e-2));
    CHECK(p.sliding_friction == test::relative(row.mu_V).epsilon(2e-3));
  }
}

TEST_CASE_TEMPLATE("tuned_for: a ball meets a dense grid as a plane cuts a cap of it", S, float,
                   double) {
  // 1 mm apart. Of the ball a cap goes below the rays' ends, of the volume pi d^2 (R - d / 3), and
  // the depths of the sensors are its heights.
  constexpr S length = S(0.01);
  const Quat<double> tilt = Quat<double>(0.3, 0.5, -0.1, 0.8).normalized();
  SensorLayout<S> grid;
  for (int i = -40; i <= 40; ++i) {
    for (int j = -40; j <= 40; ++j) {
      const Vec3<double> start = tilt * Vec3<double>(i * 1e-3, j * 1e-3, 0);
      const Vec3<double> direction = tilt * Vec3<double>(0, 0, 1);
      grid.add(start.cast<S>(), direction.cast<S>(), length);
    }
  }
  GripSpec<S> spec;
  spec.load = S(20);
  spec.mass = S(0.7);
  for (const S radius : {S(0.01), S(0.04), S(0.08)}) {
    for (const S press : {S(0.3), S(0.9)}) {
      spec.radius = radius;
      spec.press = press;
      const double R = double(radius);
      const double d = double(press * length);
      // [-] Sums over the grid: sensors that the cap meets, and their depths.
      const double count = std::numbers::pi * d * (2 * R - d) * 1e6;
      const double depths = std::numbers::pi * d * d * (R - d / 3) * 1e6 / double(length);
      const SensorParameters<S> p = tuned_for(spec).parameters(grid);
      CAPTURE(radius);
      CAPTURE(press);
      CHECK(p.normal_stiffness == test::relative(20 / depths).epsilon(0.01));
      CHECK(p.normal_damping ==
            test::relative(2 * std::sqrt(20 / depths * 0.7 * 0.01 / count)).epsilon(0.03));
      CHECK(p.sliding_friction ==
            test::relative(2 * 0.7 * std::sqrt(0.8 * 20 / 1e-3 * 0.7) / count).epsilon(0.03));
      CHECK(p.static_friction == test::relative(S(800)).epsilon(1e-6));
    }
  }
  // A ball as large as a hill is a plane.
  spec.radius = S(1e4);
  const SensorParameters<S> hill = tuned_for(spec).parameters(grid);
  spec.radius = S(0);
  const SensorParameters<S> plane = tuned_for(spec).parameters(grid);
  CHECK(hill.normal_stiffness == test::relative(plane.normal_stiffness).epsilon(1e-4));
  CHECK(hill.normal_damping == test::relative(plane.normal_damping).epsilon(1e-4));
  CHECK(hill.sliding_friction == test::relative(plane.sliding_friction).epsilon(1e-4));
}

TEST_CASE("tuned_for: a ball is met as well in grids of rows of any number") {
  const auto stiffness_in = [](int side) {
    SensorLayout<double> grid;
    for (int i = 0; i < side; ++i) {
      for (int j = 0; j < side; ++j) {
        grid.add({i * 0.0025, j * 0.0025, 0}, Vec3<double>(0, 0, 1), 0.01);
      }
    }
    return tuned_for<double>({.press = 0.3, .radius = 0.01}).parameters(grid).normal_stiffness;
  };
  const double expected = stiffness_in(33);
  for (const int side : {32, 63, 64, 65, 96, 128}) {
    CAPTURE(side);
    CHECK(stiffness_in(side) == test::relative(expected).epsilon(1e-9));
  }
}

TEST_CASE("tuned_for: among rays of unlike lengths a ball is as deep as it may be in the deepest") {
  // Every second ray is 20 mm long, the others 5 mm.
  SensorLayout<double> grid;
  for (int i = 0; i < 41; ++i) {
    for (int j = 0; j < 41; ++j) {
      grid.add({i * 0.001, j * 0.001, 0}, Vec3<double>(0, 0, 1), (i + j) % 2 == 0 ? 0.02 : 0.005);
    }
  }
  // Over the middle of the grid the long rays meet it first. Depths of a cap of d = 6 mm on half of
  // the places: pi d^2 (R - d / 3) / (2 L), and the ball's lowest point stays above the short ones.
  const double depths = std::numbers::pi * 0.006 * 0.006 * (0.03 - 0.002) * 0.5e6 / 0.02;
  const SensorParameters<double> p =
      tuned_for<double>({.load = 7, .press = 0.3, .radius = 0.03}).parameters(grid);
  CHECK(p.normal_stiffness == test::relative(7 / depths).epsilon(0.02));
}

TEST_CASE("tuned_for: the smallest ball meets one sensor") {
  SensorLayout<float> grid;
  for (int i = 0; i < 5; ++i) grid.add({float(i) * 0.01f, 0, 0}, Vec3<float>(0.6f, 0, 0.8f), 0.01f);
  for (const float radius : {1e-3f, 1e-30f}) {
    const SensorParameters<float> p =
        tuned_for<float>({.load = 7, .press = 0.25f, .radius = radius}).parameters(grid);
    CHECK(p.normal_stiffness == test::relative(28.0f).epsilon(1e-5));
  }
  CHECK(field_of([] { (void)tuned_for<double>({.radius = 0.1}).parameters(5, 0.01); }) ==
        "GripSpec::radius");
}

TEST_CASE("tuned_for: a ball among rays of a round skin, from its border, and of no radius") {
  // Rays outwards from a ball of 20 mm, 15 mm long, over a half of it, in no order.
  SensorLayout<double> skin;
  for (int ring = 0; ring <= 20; ++ring) {
    for (int k = 0; k < 60; ++k) {
      const double polar = (ring * 7 % 21) * std::numbers::pi / 40;
      const double azimuth = k * std::numbers::pi / 30;
      const Vec3<double> out(std::sin(polar) * std::cos(azimuth),
                             std::sin(polar) * std::sin(azimuth), std::cos(polar));
      skin.add(Vec3<double>(0.01 * out), out, 0.015);
    }
  }
  GripSpec<double> spec;
  spec.radius = 0.03;
  spec.scaling = FrictionScaling::depth;
  const SensorParameters<double> p = tuned_for(spec).parameters(skin);
  spec.scaling = FrictionScaling::none;
  const SensorParameters<double> q = tuned_for(spec).parameters(skin);
  // One ball, one sum of depths D and one number n of sensors: K_N = N / D, and friction of
  // mu N / (creep D) or of mu N / (creep n).
  CHECK(p.normal_stiffness == q.normal_stiffness);
  CHECK(p.static_friction ==
        test::relative(p.normal_stiffness * spec.friction / spec.creep).epsilon(1e-12));
  const double n = spec.friction * spec.load / spec.creep / q.static_friction;
  const double depths = spec.load / q.normal_stiffness;
  CHECK(n == std::round(n));
  CHECK(n > 1);
  CHECK(n < 1260);
  // No sensor is deeper than the one that the ball meets head-on.
  CHECK(depths < n * spec.press);
  CHECK(depths > spec.press);
  CHECK(field_of([&] { (void)tuned_for<double>({.radius = -1}); }) == "GripSpec::radius");
}

TEST_CASE_TEMPLATE("describe: is the inverse of tuned_for, under every scaling", S, float, double) {
  for (const FrictionScaling scaling :
       {FrictionScaling::normal_force, FrictionScaling::depth, FrictionScaling::none}) {
    GripSpec<S> spec;
    spec.friction = S(0.8);
    spec.creep = S(5e-4);
    spec.load = S(20);
    spec.mass = S(0.7);
    spec.press = S(0.25);
    spec.normal_damping_ratio = S(0.9);
    spec.bristle_damping_ratio = S(0.6);
    spec.scaling = scaling;
    const SensorParameters<S> p = tuned_for(spec).parameters(30, S(0.012));
    PatchUse<S> use;
    use.count = 30;
    use.length = S(0.012);
    use.load = spec.load;
    use.mass = spec.mass;
    const PatchDescription<S> m = describe(p, use, scaling);
    const double eps = 100 * static_cast<double>(Tolerance<S>::round_off());
    const auto near = [&](S a, S b) {
      CHECK(static_cast<double>(a) == test::relative(static_cast<double>(b)).epsilon(eps));
    };
    near(m.holding_coefficient, spec.friction);
    near(m.press, spec.press);
    near(m.normal_damping_ratio, spec.normal_damping_ratio);
    near(m.bristle_damping_ratio, spec.bristle_damping_ratio);
    near(m.kinetic_release, spec.friction / S(2));
    near(m.kinetic_drag, spec.friction);
    // At the limit the grip has crept by sigma_a.
    near(m.sag(spec.friction * spec.load), spec.creep);
    near(m.bristle_frequency * m.bristle_frequency * spec.mass, m.bristle_stiffness);
  }
}

TEST_CASE("describe: Fig. 7 in numbers") {
  const SensorParameters<double> p{1, 0, 5000, 0.1, 1e-3};
  PatchUse<double> use;
  use.count = 16;
  use.load = 0.5 * 9.81;
  use.mass = 0.5;
  const PatchDescription<double> m = describe(p, use);
  CHECK(m.holding_coefficient == test::relative(5));
  CHECK(m.press == test::relative(0.3065625));
  CHECK(m.bristle_frequency / (2 * std::numbers::pi) == test::relative(35.2484).epsilon(1e-5));
  CHECK(m.sudden_coefficient == test::relative(5 * 0.5057).epsilon(1e-3));
  CHECK(m.recommended_explicit_step == test::relative(0.35 * m.largest_explicit_step));
  // Lever gamma = 1.0144 of the 10 mm box: the tabled 8.897 ms.
  use.lever = 1 + 0.5 * 6.934375e-3 * 6.934375e-3 / (0.5 / 3 * 0.010025);
  CHECK(describe(p, use).largest_explicit_step == test::relative(8.897e-3).epsilon(0.01));
  // Overdamped bristles do not overshoot.
  SensorParameters<double> damped = p;
  damped.sliding_friction = 100;
  CHECK(describe(damped, use).sudden_coefficient == describe(damped, use).holding_coefficient);
}

TEST_CASE("tuned_for: unset mass is the heaviest that the grip holds") {
  GripSpec<double> spec;
  spec.friction = 0.5;
  spec.load = 19.62;
  GripSpec<double> same = spec;
  same.mass = 1;
  CHECK(tuned_for(spec).parameters(10, 0.01).sliding_friction ==
        test::relative(tuned_for(same).parameters(10, 0.01).sliding_friction));
}

TEST_CASE("tuned_for: a layout counts with its number and mean length") {
  SensorLayout<double> layout;
  layout.add({0, 0, 0}, {0, 0, 1}, 0.01);
  layout.add({0, 0, 0}, {0, 0, 1}, 0.03);
  const Tuning<double> tuning = tuned_for<double>({});
  CHECK(tuning.parameters(layout).normal_damping == tuning.parameters(2, 0.02).normal_damping);
}

TEST_CASE("tuned_for and describe: name what is wrong") {
  const auto field_after = [](auto change) {
    return field_of([&] {
      GripSpec<double> w;
      change(w);
      (void)tuned_for(w);
    });
  };
  CHECK(field_after([](auto&) {}).empty());
  CHECK(field_after([](auto& w) { w.friction = 0; }) == "GripSpec::friction");
  CHECK(field_after([](auto& w) { w.creep = -1; }) == "GripSpec::creep");
  CHECK(field_after([](auto& w) { w.load = std::nan(""); }) == "GripSpec::load");
  CHECK(field_after([](auto& w) { w.mass = -1; }) == "GripSpec::mass");
  CHECK(field_after([](auto& w) { w.press = 0; }) == "GripSpec::press");
  CHECK(field_after([](auto& w) { w.press = 1.5; }) == "GripSpec::press");
  CHECK(field_after([](auto& w) { w.normal_damping_ratio = -1; }) ==
        "GripSpec::normal_damping_ratio");
  CHECK(field_after([](auto& w) { w.bristle_damping_ratio = -1; }) ==
        "GripSpec::bristle_damping_ratio");
  const auto use = [](auto change) {
    return field_of([&] {
      PatchUse<double> u;
      change(u);
      (void)describe(SensorParameters<double>{1, 0, 1, 0, 1e-3}, u);
    });
  };
  CHECK(use([](auto&) {}).empty());
  CHECK(use([](auto& u) { u.count = 0; }) == "PatchUse::count");
  CHECK(use([](auto& u) { u.length = 0; }) == "PatchUse::length");
  CHECK(use([](auto& u) { u.load = 0; }) == "PatchUse::load");
  CHECK(use([](auto& u) { u.mass = 0; }) == "PatchUse::mass");
  CHECK(use([](auto& u) { u.lever = 0; }) == "PatchUse::lever");
  CHECK(field_of([] { (void)tuned_for<double>({}).parameters(0, 1); }) == "count");
  CHECK(field_of([] { (void)tuned_for<double>({}).parameters(1, 0); }) == "length");
}
