/// @file
/// A scene with what pushes it, what measures it, and what an engine must offer to run it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scenes/rigid/scene.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace bristle::scenes {

using namespace bristle::detail;

/// Thrown for a feature that an engine cannot simulate: a shape, a pair of shapes.
struct Unsupported : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Counters of the last step of an engine, as far as it tells.
struct StepCounters {
  std::uint64_t sweeps = 0;
  std::uint64_t factorisations = 0;
};

/// An engine with one scene in it.
class Engine {
 public:
  Engine() = default;
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;
  virtual ~Engine() = default;

  virtual void step() = 0;
  /// State of a moving body, by its number in the scene.
  [[nodiscard]] virtual BodyState state(std::size_t body) const = 0;
  /// [N] Force at the centre of mass during the next step.
  virtual void push(std::size_t body, const Vector& force) = 0;
  /// Has a driven body be at a place at the end of the next step of `dt` [s].
  virtual void move_to(std::size_t body, const Place& place, double dt) {
    static_cast<void>(body), static_cast<void>(place), static_cast<void>(dt);
    throw Unsupported("no bodies that follow a path");
  }
  /// [m/s^2] Changes gravity.
  virtual void set_gravity(const Vector& gravity) {
    static_cast<void>(gravity);
    throw Unsupported("no change of gravity");
  }
  [[nodiscard]] virtual StepCounters counters() const { return {}; }
};

/// A moment of a run: after `step` steps of `dt`.
struct Instant {
  double time = 0;
  double dt = 0;
  long step = 0;

  /// Returns whether this is the step nearest to a time.
  [[nodiscard]] bool is(double when) const { return std::abs(time - when) < 0.5 * dt + 1e-12; }
  /// Returns whether a metric that is taken every 10 ms is due.
  [[nodiscard]] bool is_sampled() const {
    return step % std::max(1L, static_cast<long>(0.01 / dt)) == 0;
  }
};

/// A further number of a run.
struct Metric {
  std::string name;
  double value = 0;
};

/// Result of a run.
struct Outcome {
  double error = 0;
  bool passes = false;
  std::vector<Metric> further{};
};

/// One run of one scene.
class Trial {
 public:
  explicit Trial(Scene scene) : scene_(std::move(scene)) {}
  Trial(const Trial&) = delete;
  Trial& operator=(const Trial&) = delete;
  virtual ~Trial() = default;

  [[nodiscard]] const Scene& scene() const { return scene_; }
  /// Applies the input of the step that starts now: paths of driven bodies, and `push`.
  void prepare(Engine& engine, const Instant& now) const {
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      const SceneBody& body = scene_.bodies[i];
      if (body.is_driven()) engine.move_to(i, body.path(now.time + now.dt), now.dt);
    }
    push(engine, now);
  }
  /// Forces of the step that starts now.
  virtual void push(Engine&, const Instant&) const {}
  /// Looks at the engine; at the start and after every step.
  virtual void observe(const Engine& engine, const Instant& now) = 0;
  [[nodiscard]] virtual Outcome outcome() const = 0;
  /// Takes another trial of the same scene, run in fine steps, as what is right
  /// (`Recipe::reference_step`).
  virtual void compare(const Trial& reference) { static_cast<void>(reference); }

 private:
  Scene scene_;
};

/// A scene by name, and how to make its runs.
struct Recipe {
  std::string group;
  std::string name;
  /// [-] Description, and the measure of its error.
  std::string description;
  /// [s] Steps it is run at.
  std::vector<double> time_steps;
  std::function<std::unique_ptr<Trial>()> make_one{};
  /// [-] Runs that differ in a phase or a seed, if there is more than one; the error is the
  /// largest.
  int variations = 1;
  std::function<std::unique_ptr<Trial>(int)> make_variation{};
  /// [-] True if it runs only on request.
  bool is_optional = false;
  /// [s] Step of a run by the same engine in the same setting that the error is measured against;
  /// 0 where a closed form or an invariant tells.
  double reference_step = 0;

  [[nodiscard]] std::unique_ptr<Trial> make(int variation) const {
    return make_variation ? make_variation(variation) : make_one();
  }
};

}  // namespace bristle::scenes
