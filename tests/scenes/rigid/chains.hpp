/// @file
/// Chains of links on ball joints: one that swings freely, one that swings against a plate.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scenes/rigid/measures.hpp"

#include <cmath>
#include <numbers>

namespace bristle::scenes {

using namespace bristle::detail;

/// Links of 0.2 m and 1 kg on ball joints, from the world's origin along a direction.
[[nodiscard]] inline Scene chain_scene(int links, const Vector& direction, Meets meets) {
  constexpr double length = 0.2;
  const Rotation along = turn_between(Vector::UnitX(), direction);
  Scene scene;
  scene.duration = 10;
  for (int i = 0; i < links; ++i) {
    SceneBody link = box_body({length / 2, 0.02, 0.02}, 1, length * (i + 0.5) * direction, 0);
    link.orientation = along;
    link.meets = meets;
    scene.add(link);
    scene.joints.push_back({i - 1, i, length * i * direction});
  }
  return scene;
}

/// [m] Largest distance between the two ends that a joint holds together; `links` come first.
[[nodiscard]] inline double joint_gap(const Engine& engine, int links) {
  double largest = 0;
  Vector end = Vector::Zero();
  for (int i = 0; i < links; ++i) {
    const BodyState link = engine.state(static_cast<std::size_t>(i));
    const Vector half = link.orientation * Vector(0.1, 0, 0);
    largest = std::max(largest, (link.position - half - end).norm());
    end = link.position + half;
  }
  return largest;
}

/// A chain is let go horizontally and swings for 10 s. The error is the largest change of its
/// energy, as a part of what it gains from its start to hanging straight [1].
class Chain : public Trial {
 public:
  explicit Chain(int links)
      : Trial(chain_scene(links, Vector::UnitX(), Meets::nothing)), links_(links) {}

  void observe(const Engine& engine, const Instant& now) override {
    const double e = total_energy(scene(), engine);
    if (now.step == 0) at_start_ = e;
    at_end_ = (e - at_start_) / (links_ * earth_gravity * (links_ * 0.2) / 2);
    error_ = std::max(error_, std::abs(at_end_));
    gap_ = std::max(gap_, joint_gap(engine, links_));
  }
  [[nodiscard]] Outcome outcome() const override {
    return {error_, error_ < 0.1, {{"E_end", at_end_}, {"joint_gap", gap_}}};
  }

 private:
  int links_;
  double at_start_ = 0;
  double at_end_ = 0;
  double error_ = 0;
  double gap_ = 0;
};

/// Five links, let go at 60 degrees from hanging, swing against an upright plate 0.05 m beyond the
/// pivot (mu = 0.5, no restitution). The error is the larger of the gap of a joint and the depth in
/// the plate [m]; energy can only be lost, so what is gained is shown too.
class ContactChain : public Trial {
 public:
  ContactChain() : Trial(make()) {}

  void observe(const Engine& engine, const Instant& now) override {
    const double e = total_energy(scene(), engine);
    if (now.step == 0) at_start_ = e;
    const double scale = links * earth_gravity * (links * 0.2) / 2;
    gain_ = std::max(gain_, (e - at_start_) / scale);
    loss_ = (at_start_ - e) / scale;
    gap_ = std::max(gap_, joint_gap(engine, links));
    depth_ = std::max(depth_, overlaps_with_plate(engine));
  }
  [[nodiscard]] Outcome outcome() const override {
    const double error = std::max(gap_, depth_);
    return {error,
            error < 0.02 && gain_ < 0.01,
            {{"joint_gap", gap_}, {"depth", depth_}, {"E_gain", gain_}, {"E_lost", loss_}}};
  }

 private:
  static constexpr int links = 5;

  static Scene make() {
    const double angle = std::numbers::pi / 3;
    Scene scene = chain_scene(links, {-std::sin(angle), 0, -std::cos(angle)}, Meets::fixed_bodies);
    for (SceneBody& link : scene.bodies) link.friction = std::sqrt(0.5);
    scene.add(box_body({0.05, 1, 1}, 0, {0.1, 0, -1}, 0.5));
    return scene;
  }

  [[nodiscard]] double overlaps_with_plate(const Engine& engine) const {
    const SceneBody& plate = scene().bodies.back();
    double most = 0;
    for (std::size_t i = 0; i < links; ++i) {
      most =
          std::max(most, depth(scene().bodies[i], engine.state(i), plate, state_at_start(plate)));
    }
    return most;
  }

  double at_start_ = 0;
  double gain_ = 0;
  double loss_ = 0;
  double gap_ = 0;
  double depth_ = 0;
};

}  // namespace bristle::scenes
