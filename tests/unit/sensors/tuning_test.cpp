// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/sensors/tuning.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <string>

using namespace bristle;

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
    GripWants<double> wants;
    wants.friction = row.mu;
    wants.creep = row.creep;
    wants.load = row.mass * 9.81;
    wants.mass = row.mass;
    wants.press = row.press;
    const SensorParameters<double> p = tuned_for(wants).parameters(row.count, row.length);
    CHECK(p.static_friction == test::relative(row.mu_S).epsilon(1e-9));
    CHECK(p.breakaway_distance == row.creep);
    CHECK(p.normal_stiffness == test::relative(row.K_N).epsilon(2e-3));
    CHECK(p.normal_damping == test::relative(row.K_D).epsilon(2e-2));
    CHECK(p.sliding_friction == test::relative(row.mu_V).epsilon(2e-3));
  }
}

TEST_CASE_TEMPLATE("meaning_of: is the inverse of tuned_for, under every scaling", S, float,
                   double) {
  for (const FrictionScaling scaling :
       {FrictionScaling::normal_force, FrictionScaling::depth, FrictionScaling::none}) {
    GripWants<S> wants;
    wants.friction = S(0.8);
    wants.creep = S(5e-4);
    wants.load = S(20);
    wants.mass = S(0.7);
    wants.press = S(0.25);
    wants.normal_damping_ratio = S(0.9);
    wants.bristle_damping_ratio = S(0.6);
    wants.scaling = scaling;
    const SensorParameters<S> p = tuned_for(wants).parameters(30, S(0.012));
    PatchUse<S> use;
    use.count = 30;
    use.length = S(0.012);
    use.load = wants.load;
    use.mass = wants.mass;
    const PatchMeaning<S> m = meaning_of(p, use, scaling);
    const double eps = 100 * static_cast<double>(Tolerance<S>::round_off());
    const auto near = [&](S a, S b) {
      CHECK(static_cast<double>(a) == test::relative(static_cast<double>(b)).epsilon(eps));
    };
    near(m.holding_coefficient, wants.friction);
    near(m.press, wants.press);
    near(m.normal_damping_ratio, wants.normal_damping_ratio);
    near(m.bristle_damping_ratio, wants.bristle_damping_ratio);
    near(m.kinetic_release, wants.friction / S(2));
    near(m.kinetic_drag, wants.friction);
    // At the limit the grip has crept by sigma_a.
    near(m.sag(wants.friction * wants.load), wants.creep);
    near(m.bristle_frequency * m.bristle_frequency * wants.mass, m.bristle_stiffness);
  }
}

TEST_CASE("meaning_of: Fig. 7 in numbers") {
  const SensorParameters<double> p{1, 0, 5000, 0.1, 1e-3};
  PatchUse<double> use;
  use.count = 16;
  use.load = 0.5 * 9.81;
  use.mass = 0.5;
  const PatchMeaning<double> m = meaning_of(p, use);
  CHECK(m.holding_coefficient == test::relative(5));
  CHECK(m.press == test::relative(0.3065625));
  CHECK(m.bristle_frequency / (2 * std::numbers::pi) == test::relative(35.2484).epsilon(1e-5));
  CHECK(m.sudden_coefficient == test::relative(5 * 0.5057).epsilon(1e-3));
  CHECK(m.recommended_explicit_step == test::relative(0.35 * m.largest_explicit_step));
  // Lever gamma = 1.0144 of the 10 mm box: the tabled 8.897 ms.
  use.lever = 1 + 0.5 * 6.934375e-3 * 6.934375e-3 / (0.5 / 3 * 0.010025);
  CHECK(meaning_of(p, use).largest_explicit_step == test::relative(8.897e-3).epsilon(0.01));
  // Overdamped bristles do not overshoot.
  SensorParameters<double> damped = p;
  damped.sliding_friction = 100;
  CHECK(meaning_of(damped, use).sudden_coefficient == meaning_of(damped, use).holding_coefficient);
}

TEST_CASE("tuned_for: unset mass is the heaviest that the grip holds") {
  GripWants<double> wants;
  wants.friction = 0.5;
  wants.load = 19.62;
  GripWants<double> same = wants;
  same.mass = 1;
  CHECK(tuned_for(wants).parameters(10, 0.01).sliding_friction ==
        test::relative(tuned_for(same).parameters(10, 0.01).sliding_friction));
}

TEST_CASE("tuned_for: a layout counts with its number and mean length") {
  SensorLayout<double> layout;
  layout.add({0, 0, 0}, {0, 0, 1}, 0.01);
  layout.add({0, 0, 0}, {0, 0, 1}, 0.03);
  const Tuning<double> tuning = tuned_for<double>({});
  CHECK(tuning.parameters(layout).normal_damping == tuning.parameters(2, 0.02).normal_damping);
}

TEST_CASE("tuned_for and meaning_of: name what is wrong") {
  const auto wants = [](auto change) {
    return field_of([&] {
      GripWants<double> w;
      change(w);
      (void)tuned_for(w);
    });
  };
  CHECK(wants([](auto&) {}).empty());
  CHECK(wants([](auto& w) { w.friction = 0; }) == "GripWants::friction");
  CHECK(wants([](auto& w) { w.creep = -1; }) == "GripWants::creep");
  CHECK(wants([](auto& w) { w.load = std::nan(""); }) == "GripWants::load");
  CHECK(wants([](auto& w) { w.mass = -1; }) == "GripWants::mass");
  CHECK(wants([](auto& w) { w.press = 0; }) == "GripWants::press");
  CHECK(wants([](auto& w) { w.press = 1.5; }) == "GripWants::press");
  CHECK(wants([](auto& w) { w.normal_damping_ratio = -1; }) == "GripWants::normal_damping_ratio");
  CHECK(wants([](auto& w) { w.bristle_damping_ratio = -1; }) == "GripWants::bristle_damping_ratio");
  const auto use = [](auto change) {
    return field_of([&] {
      PatchUse<double> u;
      change(u);
      (void)meaning_of(SensorParameters<double>{1, 0, 1, 0, 1e-3}, u);
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
