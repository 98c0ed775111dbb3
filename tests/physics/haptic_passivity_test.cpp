/// @file
/// The energy at the port of a haptic loop: by closed form against a wall, and bounded on a box.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/stylus.hpp"
#include "support/relative.hpp"

#include <bristle/sensors/passivity_observer.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

using namespace bristle;
using namespace bristle::scenes;

namespace {

/// Energy that a port gave and took. The force of a substep acts while the hand moves to the next
/// one.
class Port {
 public:
  explicit Port(double h) : h_(h) {}

  /// The hand is at `p` now, and `reading` acts from now on.
  void substep(const Vec3<double>& p, const Wrench<double>& reading) {
    arrive(p);
    felt_ = reading;
  }
  /// The hand arrived at `p` by the end of a substep.
  void arrive(const Vec3<double>& p) {
    if (has_last_) observer.observe(felt_, {(p - last_) / h_, Vec3<double>::Zero()}, h_);
    last_ = p;
    has_last_ = true;
  }

  PassivityObserver<double> observer;

 private:
  double h_;
  Wrench<double> felt_{};
  Vec3<double> last_ = Vec3<double>::Zero();
  bool has_last_ = false;
};

/// [m] Height of a tip whose 10 mm rays reach 2 to 6 mm into what ends at `top`, up and down
/// `times` a second.
double pressing(double top, double times, double time) {
  return top + 0.01 - 0.004 + 0.002 * std::cos(2 * std::numbers::pi * times * time);
}

}  // namespace

// A substep's force is that of the depth and rate at its end, if the tool keeps its velocity:
// f_i = K (x_i + D_i) + B D_i / h with D_i = x_i - x_(i-1), and it works along D_(i+1). Where a
// path ends at the depth at which it began, K sum x_i D_(i+1) = -K/2 sum D^2, so that
//   E = -K/2 sum D_i^2 + (K + B/h) sum D_i D_(i+1).
// For a sine sum D_i D_(i+1) = cos(w h) sum D_i^2: without damping the wall gives energy where
// w h > pi/3, at a sixth of the rate of the substeps, and takes it below.
TEST_CASE("haptic_passivity: the energy of a wall, by the closed form") {
  struct Case {
    std::uint32_t substeps;
    double damping;
    double times;
    bool gives;
  };
  for (const Case& c : {Case{1, 0, 12, true}, Case{1, 0, 6, false}, Case{16, 0, 12, false},
                        Case{16, 0.005, 12, false}, Case{16, 0, 192, true}}) {
    CAPTURE(c.substeps);
    CAPTURE(c.times);
    StylusScene<double> scene({.substeps = c.substeps, .normal_damping = c.damping});
    scene.world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
    const auto at = [&](int i) -> Vec3<double> {
      return {0, 0, pressing(0, c.times, i * scene.substep_length())};
    };
    scene.loop.move(scene.tool, {Quat<double>::Identity(), at(0)});
    scene.world.open(scene.loop);
    const double h = scene.substep_length();
    const double K = scene.stiffness();
    const double B = 16 * c.damping / scene.ray;
    Port port(h);
    double squares = 0;
    double products = 0;
    const int substeps = 60 * static_cast<int>(c.substeps);  // A second: whole periods.
    for (int i = 0; i < substeps; ++i) {
      port.substep(at(i), scene.tick_at(at(i)));
      if (scene.loop.substeps_done() == c.substeps) scene.world.step(scene.loop);
      const double next = at(i + 1).z() - at(i).z();
      squares += next * next;
      products += i == 0 ? 0 : next * (at(i).z() - at(i - 1).z());
    }
    port.arrive(at(substeps));
    const double expected = -K / 2 * squares + (K + B / h) * products;
    CHECK(port.observer.energy() == test::relative(expected).epsilon(1e-6));
    CHECK((expected < 0) == c.gives);
  }
}

// The box on a table is stepped at 60 Hz and, dragged, slides. Pressed at 12 Hz, sensors at the
// rate of the world give energy. Sensors in substeps do not; they give it to a hand at 180 Hz. The
// energy grows with time, but not with a controller that counts what it sent by the tool's motion.
// Its damping is wrong by the change of velocity, force times that a substep. The error is paid in
// the next substep, or in the one after where the tool turned and was slow: two substeps' worth at
// most.
TEST_CASE("haptic_passivity: a box that is pressed and dragged, alone and with a controller") {
  struct Outcome {
    double energy = 0;
    double lowest = 0;
    double damped = 0;
    /// [J] The most that a controller's force did in a substep because the velocity changed.
    double missed = 0;
  };
  const auto run = [](std::uint32_t substeps, double drag, double times, double seconds,
                      bool is_controlled) {
    StylusScene<double> scene({.substeps = substeps, .normal_damping = 0});
    scene.world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
    const BodyId box = scene.world.add_body({.mass = 0.2,
                                             .shape = Box<double>{{0.02, 0.02, 0.02}},
                                             .material = {.friction = 0.3},
                                             .position = {0, 0, 0.02}});
    for (int i = 0; i < 60; ++i) scene.world.step();
    const double top = scene.world.pose(box).translation.z() + 0.02;
    const auto at = [&](int i) -> Vec3<double> {
      const double t = i * scene.substep_length();
      return {drag * std::sin(20 * t), 0.6 * drag * std::sin(27 * t), pressing(top, times, t)};
    };
    const double h = scene.substep_length();
    scene.loop.move(scene.tool, {Quat<double>::Identity(), at(0)});
    scene.world.open(scene.loop);
    Port port(h);
    PassivityObserver<double> controller(0, 1e3);
    Outcome found;
    const int count = static_cast<int>(std::lround(seconds / h));
    for (int i = 0; i < count; ++i) {
      Wrench<double> sent = scene.tick_at(at(i));
      if (is_controlled) {
        const Vec3<double> was = i == 0 ? Vec3<double>::Zero() : Vec3<double>(at(i) - at(i - 1));
        sent = controller.control(sent, {was / h, Vec3<double>::Zero()}, h);
        found.missed = std::max(found.missed, std::abs(sent.force.dot(at(i + 1) - at(i) - was)));
      }
      port.substep(at(i), sent);
      if (scene.loop.substeps_done() == substeps) scene.world.step(scene.loop);
    }
    port.arrive(at(count));
    if (is_controlled) {
      const Vec3<double> was = at(count) - at(count - 1);
      (void)controller.control({}, {was / h, Vec3<double>::Zero()}, h);
      CHECK(controller.energy() == test::relative(port.observer.energy()).epsilon(1e-12));
      CHECK(controller.lowest_energy() ==
            test::relative(port.observer.lowest_energy()).epsilon(1e-12));
    }
    found.energy = port.observer.energy();
    found.lowest = port.observer.lowest_energy();
    found.damped = controller.damped_energy();
    return found;
  };
  const Outcome quick = run(16, 1e-4, 12, 2, false);
  CHECK(quick.energy > 0.005);
  CHECK(run(16, 2e-3, 12, 2, false).energy > quick.energy);
  // It is not in the way of what is passive.
  const Outcome left_alone = run(16, 1e-4, 12, 2, true);
  CHECK(left_alone.energy == quick.energy);
  CHECK(left_alone.damped == 0);

  struct Case {
    std::uint32_t substeps;
    double drag;
    double times;
    double seconds;
    /// [J] Energy given without the controller, and the most that is owed with it.
    double given;
    double owed;
  };
  // As decision 0024 has them.
  for (const Case& c :
       {Case{1, 1e-4, 12, 2, 0.0493, 0.0066}, Case{1, 1e-4, 12, 8, 0.2, 0.0066},
        Case{16, 2e-3, 180, 2, 0.337, 0.007}, Case{16, 2e-3, 180, 8, 1.35, 0.007}}) {
    CAPTURE(c.times);
    CAPTURE(c.seconds);
    CHECK(run(c.substeps, c.drag, c.times, c.seconds, false).energy ==
          test::relative(-c.given).epsilon(0.02));
    const Outcome controlled = run(c.substeps, c.drag, c.times, c.seconds, true);
    CHECK(controlled.lowest >= -2 * controlled.missed);
    CHECK(controlled.lowest > -c.owed);
    CHECK(controlled.damped > 0.8 * c.given);
  }
}
