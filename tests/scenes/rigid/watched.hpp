/// @file
/// Scenes whose motion no closed form tells: they are watched for overlaps, joints that part, stops
/// that give way, and energy from nowhere.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scenes/rigid/measures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace bristle::scenes {

using namespace bristle::detail;

/// Bounds that a watched scene must keep.
struct Bounds {
  /// [m] Overlap or gap of a joint.
  double depth = 0.01;
  /// [J] Energy that nothing may exceed, as the gain over the energy at the start; infinite where
  /// paths or drives do work.
  double gain = std::numeric_limits<double>::infinity();
  /// [rad] Angle beyond a stop.
  double stop = 0.05;
};

/// Bodies that move. The error is the larger of the deepest overlap and the largest gap of a joint,
/// sampled every 10 ms [m].
class Watched : public Trial {
 public:
  Watched(Scene scene, const Bounds& bounds) : Trial(std::move(scene)), bounds_(bounds) {}

  void observe(const Engine& engine, const Instant& now) override {
    if (!now.is_sampled() && !now.is(scene().duration)) return;
    const Overlaps found = overlaps(scene(), engine);
    if (now.step == 0) {
      // Overlaps at the start belong to the scene.
      energy_at_start_ = total_energy(scene(), engine);
    }
    depth_ = std::max(depth_, found.largest);
    gap_ = std::max(gap_, largest_joint_gap(scene(), engine));
    stop_ = std::max(stop_, largest_limit_excess(scene(), engine));
    fastest_ = 0;
    for (std::size_t i = 0; i < scene().bodies.size(); ++i) {
      if (!scene().bodies[i].moves()) continue;
      const BodyState state = engine.state(i);
      is_finite_ = is_finite_ && state.position.allFinite() && state.velocity.allFinite();
      fastest_ = std::max(fastest_, state.velocity.norm());
    }
    peak_ = std::max(peak_, fastest_);
    gain_ = std::max(gain_, total_energy(scene(), engine) - energy_at_start_);
  }
  [[nodiscard]] Outcome outcome() const override {
    const double error =
        is_finite_ ? std::max(depth_, gap_) : std::numeric_limits<double>::infinity();
    Outcome result{error,
                   error < bounds_.depth && gain_ <= bounds_.gain && stop_ < bounds_.stop,
                   {{"depth", depth_}, {"v_max", peak_}, {"v_end", fastest_}}};
    if (!scene().joints.empty()) {
      result.further.push_back({"joint_gap", gap_});
      result.further.push_back({"limit_excess", stop_});
    }
    if (std::isfinite(bounds_.gain)) result.further.push_back({"E_gain [J]", gain_});
    return result;
  }

 private:
  Bounds bounds_;
  double depth_ = 0;
  double gap_ = 0;
  double stop_ = 0;
  double fastest_ = 0;
  double peak_ = 0;
  double energy_at_start_ = 0;
  double gain_ = 0;
  bool is_finite_ = true;
};

}  // namespace bristle::scenes
