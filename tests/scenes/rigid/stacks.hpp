/// @file
/// Boxes on top of each other: set down exactly, dropped askew, and left standing for long.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scenes/rigid/measures.hpp"
#include "support/random.hpp"

#include <cmath>

namespace bristle::scenes {

using namespace bristle::detail;

/// How a stack of cubes of 0.2 m is set up. Defaults: ten of 1 kg, exactly on each other.
struct StackSetup {
  int count = 10;
  /// [kg] Mass of the top cube; the others have 1 kg.
  double top_mass = 1;
  /// [m], [rad], [m] Largest offset sideways along x and y, largest yaw, gap under each cube.
  double offset = 0;
  double yaw = 0;
  double gap = 0;
  std::uint64_t seed = 0;
  /// [s] How long it stands.
  double duration = 10;
};

/// A stack on a floor, mu = 0.5. The error is the larger of the drift (how far any cube ever is
/// sideways from where it was put) and of the deepest overlap [m], sampled every 10 ms.
class Stack : public Trial {
 public:
  explicit Stack(const StackSetup& setup) : Trial(make(setup)) {}

  void observe(const Engine& engine, const Instant& now) override {
    if (!now.is_sampled() && !now.is(scene().duration)) return;
    const std::vector<SceneBody>& bodies = scene().bodies;
    for (std::size_t i = 1; i < bodies.size(); ++i) {
      const BodyState cube = engine.state(i);
      const Vector moved = cube.position - bodies[i].position;
      drift_ = std::max(drift_, moved.head<2>().norm());
      tilt_ = std::max(tilt_, angle_between(cube.orientation, bodies[i].orientation));
      if (!moved.allFinite()) drift_ = std::numeric_limits<double>::infinity();
    }
    const Overlaps found = overlaps(scene(), engine);
    deepest_ = std::max(deepest_, found.largest);
    if (!now.is(scene().duration)) return;
    const std::size_t top = bodies.size() - 1;
    end_depth_ = found.largest;
    top_dz_ = engine.state(top).position.z() - (0.2 * static_cast<double>(top) - 0.1);
    kinetic_ = total_kinetic_energy(scene(), engine);
  }

  [[nodiscard]] Outcome outcome() const override {
    const double error = std::max(drift_, deepest_);
    return {error,
            error < 0.02,
            {{"drift", drift_},
             {"max_depth", deepest_},
             {"end_depth", end_depth_},
             {"top_dz", top_dz_},
             {"tilt", tilt_},
             {"KE_end", kinetic_}}};
  }

 private:
  static Scene make(const StackSetup& setup) {
    Scene scene;
    scene.duration = setup.duration;
    scene.add(floor_body(0.5));
    test::Random random(setup.seed);
    for (int i = 0; i < setup.count; ++i) {
      const double mass = i + 1 == setup.count ? setup.top_mass : 1;
      const double x = random.uniform(-setup.offset, setup.offset);
      const double y = random.uniform(-setup.offset, setup.offset);
      const double yaw = random.uniform(-setup.yaw, setup.yaw);
      SceneBody cube =
          box_body({0.1, 0.1, 0.1}, mass, {x, y, 0.1 + 0.2 * i + setup.gap * (i + 1)}, 0.5);
      cube.orientation = turn_about(Vector::UnitZ(), yaw);
      scene.add(cube);
    }
    return scene;
  }

  double drift_ = 0;
  double tilt_ = 0;
  double deepest_ = 0;
  double end_depth_ = 0;
  double top_dz_ = 0;
  double kinetic_ = 0;
};

}  // namespace bristle::scenes
