// A hand of Fig. 8 (b): a gripper with sensors on its pads, carried by a gantry.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/rotation.hpp>
#include <bristle/sensors/tuning.hpp>
#include <bristle/world/world.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

namespace fig8b {

using bristle::BodyId;
using bristle::JointId;
using bristle::Vec3;
using World = bristle::World<double>;

inline constexpr std::uint32_t thread_category = 1;
inline constexpr std::uint32_t post_category = 2;
inline constexpr std::uint32_t hand_category = 4;

inline constexpr double half_finger = 0.01;   // [m]
inline constexpr double ray_range = 0.008;    // [m], half of it beyond the pad
inline constexpr double squeeze = 15;         // [N]
inline constexpr double creep = 1e-3;         // [m] at which the pads' bristles let go
inline constexpr double wrist_torque = 3;     // [N m]
inline constexpr double finger_speed = 0.15;  // [m/s]
inline constexpr double catch_up_rate = 20;   // [1/s] at which a hand makes up for what it lags

/// Where a hand is on its gantry, or how fast that changes.
struct Place {
  double y = 0;      // [m]
  double z = 0;      // [m]
  double angle = 0;  // [rad] of the wrist, about x

  friend Place operator-(const Place& a, const Place& b) {
    return {a.y - b.y, a.z - b.z, a.angle - b.angle};
  }
  friend Place operator+(const Place& a, const Place& b) {
    return {a.y + b.y, a.z + b.z, a.angle + b.angle};
  }
  friend Place operator*(double k, const Place& a) { return {k * a.y, k * a.z, k * a.angle}; }
};

/// Sensors of a pad in the plane of y and z that look along `inwards`, x or -x.
inline bristle::SensorLayout<double> pad_sensors(double inwards) {
  bristle::SensorLayout<double> pad;
  for (int i = -3; i <= 3; ++i) {
    for (int j = -2; j <= 2; ++j) {
      pad.add(Vec3<double>(inwards * (half_finger - ray_range / 2), 0.008 * i, 0.004 * j),
              Vec3<double>(inwards, 0, 0), ray_range);
    }
  }
  return pad;
}

/// Two fingers on slides along x, on a wrist that turns about x, on a gantry that moves along y and
/// z. All drives have limits. Its own weight is balanced, and it touches by its sensors only.
class Hand {
 public:
  /// @param radius  [m] Of what it is to hold.
  Hand(World& world, BodyId frame, const Place& place, double radius,
       bristle::Integration integration)
      : closed_at_(radius + half_finger + 0.2 * ray_range),
        open_at_(radius + half_finger + 2 * ray_range) {
    using namespace bristle;
    const auto add_carrier = [&](double mass, const Vec3<double>& position) {
      bodies_.push_back(
          world.add_body({.mass = mass,
                          .inertia = Mat3<double>(2.5e-3 * mass * Mat3<double>::Identity()),
                          .filter = {hand_category, 0, 0},
                          .position = position,
                          .gravity_scale = 0}));
      return bodies_.back();
    };
    const auto add_motor = [&](JointKind kind, BodyId a, BodyId b, const Vec3<double>& turn) {
      JointDef<double> joint{.kind = kind, .body_a = a, .body_b = b};
      joint.X_AJ.rotation = joint.X_BJ.rotation = exp_rotation<double>(turn);
      motors_.push_back(world.add_joint(joint));
    };
    constexpr double half_turn = std::numbers::pi;
    const BodyId sledge = add_carrier(0.2, {0, place.y, 0});
    const BodyId lift = add_carrier(0.1, {0, place.y, place.z});
    palm_ = add_carrier(0.05, {0, place.y, place.z});
    add_motor(JointKind::prismatic, frame, sledge, {0, 0, half_turn / 2});
    add_motor(JointKind::prismatic, sledge, lift, {0, -half_turn / 2, 0});
    add_motor(JointKind::revolute, lift, palm_, {0, 0, 0});
    for (std::size_t k = 0; k < 2; ++k) {
      const double inwards = k == 0 ? 1 : -1;
      const BodyId finger = world.add_body({.mass = 0.05,
                                            .shape = Box<double>{{half_finger, 0.03, 0.012}},
                                            .filter = {hand_category, 0, 0},
                                            .position = {-inwards * open_at_, place.y, place.z},
                                            .gravity_scale = 0});
      bodies_.push_back(finger);
      PatchDef<double> pad;
      pad.sensors = pad_sensors(inwards);
      pad.parameters =
          tuned_for<double>({.friction = 1, .creep = creep, .load = squeeze, .mass = 0.1})
              .parameters(pad.sensors);
      pad.integration = integration;
      pad.sense_mask = thread_category;
      parameters_ = pad.parameters;
      pads_[k] = world.add_patch(finger, pad);
      add_motor(JointKind::prismatic, palm_, finger, {0, 0, k == 0 ? 0 : half_turn});
    }
    open(world);
  }

  /// One finger goes to its place, and the other squeezes against it.
  void close(World& world) const {
    using bristle::MotorMode;
    world.set_motor(motors_[3], {MotorMode::position, -closed_at_, 10 * squeeze, finger_speed});
    world.set_motor(motors_[4], {MotorMode::velocity, finger_speed, squeeze});
  }
  void open(World& world) const {
    for (const std::size_t k : {std::size_t{3}, std::size_t{4}}) {
      world.set_motor(motors_[k],
                      {bristle::MotorMode::position, -open_at_, 10 * squeeze, finger_speed});
    }
  }
  /// Moves towards a place that moves itself, with up to `force` [N] along each axis.
  void follow(World& world, const Place& place, const Place& rate, double force) const {
    using bristle::MotorMode;
    const Place wanted = rate + catch_up_rate * (place - this->place(world));
    world.set_motor(motors_[0], {MotorMode::velocity, wanted.y, force});
    world.set_motor(motors_[1], {MotorMode::velocity, wanted.z, force});
    world.set_motor(motors_[2], {MotorMode::velocity, wanted.angle, wrist_torque});
  }
  /// Pulls down with `force` [N], whichever way it moves.
  void pull_down(World& world, double force) const {
    world.set_motor(motors_[1], {bristle::MotorMode::velocity, -10, force});
  }

  [[nodiscard]] Place place(const World& world) const {
    return {world.reading(motors_[0]).position, world.reading(motors_[1]).position,
            world.reading(motors_[2]).position};
  }
  [[nodiscard]] Vec3<double> middle(const World& world) const {
    return world.pose(palm_).translation;
  }
  /// [N] Force of the thread on both pads.
  [[nodiscard]] Vec3<double> pull(const World& world) const {
    return world.reading(pads_[0]).wrench.force + world.reading(pads_[1]).wrench.force;
  }
  /// Returns whether both pads touch something.
  [[nodiscard]] bool touches(const World& world) const {
    return world.reading(pads_[0]).touching() > 0 && world.reading(pads_[1]).touching() > 0;
  }
  /// [J] Energy that the sensors have stored along their rays, and in their bristles.
  [[nodiscard]] double stored_energy(const World& world) const {
    double sum = 0;
    for (const bristle::PatchId pad : pads_) {
      const bristle::PatchReading<double> reading = world.reading(pad);
      for (std::size_t i = 0; i < reading.size(); ++i) {
        if (!(reading.normal_force[i] > 0)) continue;
        const double shear =
            reading.shear_1[i] * reading.shear_1[i] + reading.shear_2[i] * reading.shear_2[i];
        sum +=
            0.5 * ray_range * parameters_.normal_stiffness * reading.depth[i] * reading.depth[i] +
            0.5 * shear / (parameters_.static_friction * reading.normal_force[i]);
      }
    }
    return sum;
  }
  [[nodiscard]] const std::vector<JointId>& drives() const { return motors_; }
  [[nodiscard]] const std::vector<BodyId>& bodies() const { return bodies_; }

 private:
  double closed_at_;  // [m] from the middle of the hand to that of a finger
  double open_at_;
  BodyId palm_{};
  std::vector<BodyId> bodies_;
  std::vector<JointId> motors_;  // along y and z, wrist, fingers
  std::array<bristle::PatchId, 2> pads_{};
  bristle::SensorParameters<double> parameters_{};
};

}  // namespace fig8b
