// A hand of the paper's Fig. 8 (a): three slides and a wrist carry a palm with two fingers, each
// with a pad of sensors. All that moves it are motors of limited force; it touches the driver by
// its sensors only. Its arm is balanced: weight does not act on it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "bench.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace fig8 {

/// Table II's constants for the screwdriver, with K_D per step of the paper's loop of 1 kHz, for
/// pads of `table_count` sensors.
inline constexpr bristle::SensorParameters<double> table_constants{.normal_stiffness = 0.8,
                                                                   .normal_damping = 1e-4,
                                                                   .static_friction = 5000,
                                                                   .sliding_friction = 0.8,
                                                                   .breakaway_distance = 1e-3};
inline constexpr int table_count = 128;

/// Rows and columns of a pad's sensors.
struct PadGrid {
  int across = 8;
  int along = 16;

  [[nodiscard]] int count() const { return across * along; }
  /// Constants of a sensor such that the pad is what one of `table_count` sensors would be.
  /// Friction grows with the normal force and needs no share.
  [[nodiscard]] bristle::SensorParameters<double> parameters() const {
    const double share = static_cast<double>(table_count) / count();
    bristle::SensorParameters<double> result = table_constants;
    result.normal_stiffness *= share;
    result.normal_damping *= share;
    result.sliding_friction *= share;
    return result;
  }
};

struct HandDef {
  double radius = handle_radius;  // [m] of what it grips
  double half_width = 0.02;       // [m] of the pads, across what it grips
  double half_height = 0.06;      // [m] and along it
  Vec3<double> start = Vec3<double>::Zero();
  PadGrid grid{};
  bristle::Integration integration = bristle::Integration::implicit;
};

/// Where the middle between the pads shall be, and how far the wrist shall turn.
struct Goal {
  Vec3<double> place = Vec3<double>::Zero();  // [m]
  double turn = 0;                            // [rad] about z
};

/// The fingers close along x of the palm, whose origin lies between the pads.
class Hand {
 public:
  Hand(bristle::World<double>& world, const Bench& bench, const HandDef& def)
      : def_(def), driver_(bench.driver), goal_{def.start, 0} {
    using namespace bristle;
    BodyId carrier = bench.base;
    const std::array<Vec3<double>, 4> axis_turns{
        Vec3<double>{0, 0, 0}, {0, 0, 90 * degree}, {0, -90 * degree, 0}, {0, -90 * degree, 0}};
    for (std::size_t i = 0; i < 4; ++i) {
      BodyDef<double> link{.mass = link_mass};
      link.inertia = link_inertia * Mat3<double>::Identity();
      link.gravity_scale = 0;
      for (Eigen::Index k = 0; k < 3; ++k) {
        if (k <= static_cast<Eigen::Index>(i)) link.position[k] = def.start[k];
      }
      const BodyId body = world.add_body(link);
      JointDef<double> joint;
      joint.kind = i < 3 ? JointKind::prismatic : JointKind::revolute;
      joint.body_a = carrier;
      joint.body_b = body;
      joint.X_AJ.rotation = joint.X_BJ.rotation = exp_rotation<double>(axis_turns[i]);
      // Places of the slides are the world's.
      if (i == 0) joint.X_AJ.translation = -world.pose(bench.base).translation;
      joints_[i] = world.add_joint(joint);
      bodies_.push_back(body);
      carrier = body;
    }
    palm_ = carrier;
    for (std::size_t k = 0; k < 2; ++k) add_finger(world, k);
    move_to(world, goal_);
    open(world);
  }

  /// Sends the motors of the arm to a goal.
  void move_to(bristle::World<double>& world, const Goal& goal) {
    using bristle::MotorMode;
    goal_ = goal;
    for (std::size_t i = 0; i < 3; ++i) {
      world.set_motor(joints_[i], {MotorMode::position, goal.place[static_cast<Eigen::Index>(i)],
                                   i < 2 ? side_force : lift_force});
    }
    world.set_motor(joints_[3], {MotorMode::position, goal.turn, wrist_torque});
  }

  /// Takes the fingers back.
  void open(bristle::World<double>& world) {
    for (const bristle::JointId slide : slides_) {
      world.set_motor(slide, {bristle::MotorMode::position, -(touching() + opening), finger_force,
                              finger_speed});
    }
  }
  /// Closes both fingers with the same force [N]: they follow what they grip wherever it goes.
  void close(bristle::World<double>& world, double force) {
    for (const bristle::JointId slide : slides_) {
      world.set_motor(slide, {bristle::MotorMode::velocity, finger_speed, force});
    }
  }
  /// Stops the first finger where it is; the second squeezes against it. Slip counts from here.
  void hold(bristle::World<double>& world) {
    world.set_motor(slides_[0], {bristle::MotorMode::position, world.reading(slides_[0]).position,
                                 finger_force});
    held_at_ = grip(world);
  }

  /// [m] How far the surface of what it grips has moved along the pads since `hold`, on the pad
  /// where it is more.
  [[nodiscard]] double slip(const bristle::World<double>& world) const {
    const bristle::Transform<double> now = grip(world);
    // The point of the driver that was between the pads.
    const Vec3<double> point = held_at_.inverse().translation;
    const Vec3<double> shift = now * point;
    const double turn =
        bristle::log_rotation<double>(held_at_.rotation.conjugate() * now.rotation).z();
    return std::hypot(std::abs(shift.y()) + def_.radius * std::abs(turn), shift.z());
  }

  [[nodiscard]] const Goal& goal() const { return goal_; }
  [[nodiscard]] bristle::BodyId finger(std::size_t k) const { return fingers_[k]; }
  [[nodiscard]] bristle::PatchId pad(std::size_t k) const { return pads_[k]; }
  /// [N] Mean normal force of the two pads.
  [[nodiscard]] double squeeze(const bristle::World<double>& world) const {
    return 0.5 * (world.reading(pads_[0]).total_normal() + world.reading(pads_[1]).total_normal());
  }
  /// [N m] Torque of the wrist's drive.
  [[nodiscard]] double torque(const bristle::World<double>& world) const {
    return world.reading(joints_[3]).motor_force;
  }
  /// [-] Bristles that let go in the last step.
  [[nodiscard]] std::size_t released(const bristle::World<double>& world) const {
    return world.reading(pads_[0]).slipping() + world.reading(pads_[1]).slipping();
  }
  /// Its bodies and joints, for budgets.
  [[nodiscard]] const std::vector<bristle::BodyId>& bodies() const { return bodies_; }
  [[nodiscard]] std::vector<bristle::JointId> joints() const {
    std::vector<bristle::JointId> all(joints_.begin(), joints_.end());
    all.insert(all.end(), slides_.begin(), slides_.end());
    return all;
  }

  static constexpr double side_force = 60;     // [N] of the arm's slides along x and y
  static constexpr double lift_force = 20;     // [N] along z
  static constexpr double wrist_torque = 5;    // [N m]
  static constexpr double finger_force = 300;  // [N] of a finger that is stopped or goes back

 private:
  static constexpr double link_mass = 0.3;      // [kg]
  static constexpr double link_inertia = 1e-3;  // [kg m^2]
  static constexpr double half_finger = 0.01;   // [m]
  static constexpr double ray_depth = 0.01;     // [m] of the rays' starts below the pad
  static constexpr double ray_length = 0.02;    // [m]
  static constexpr double opening = 0.04;       // [m] of an open finger's way to what it grips
  static constexpr double finger_speed = 0.1;   // [m/s]

  void add_finger(bristle::World<double>& world, std::size_t k) {
    using namespace bristle;
    const double inwards = k == 0 ? 1 : -1;
    fingers_[k] = world.add_body(
        {.mass = 0.1,
         .shape = Box<double>{{half_finger, def_.half_width, def_.half_height}},
         .filter = finger_filter,
         .position = def_.start - Vec3<double>(inwards * (touching() + opening), 0, 0),
         .gravity_scale = 0});
    bodies_.push_back(fingers_[k]);

    PatchDef<double> pad;
    const auto place = [](int i, int count, double half) {
      return half * ((2 * i + 1.0) / count - 1);
    };
    for (int i = 0; i < def_.grid.across; ++i) {
      for (int j = 0; j < def_.grid.along; ++j) {
        pad.sensors.add(Vec3<double>(inwards * (half_finger - ray_depth),
                                     place(i, def_.grid.across, def_.half_width),
                                     place(j, def_.grid.along, def_.half_height)),
                        Vec3<double>(inwards, 0, 0), ray_length);
      }
    }
    pad.parameters = def_.grid.parameters();
    pad.integration = def_.integration;
    pad.sense_mask = driver_filter.category;
    pads_[k] = world.add_patch(fingers_[k], pad);

    JointDef<double> slide;
    slide.kind = JointKind::prismatic;
    slide.body_a = palm_;
    slide.body_b = fingers_[k];
    // The joint's x axis points inwards.
    slide.X_AJ.rotation = slide.X_BJ.rotation =
        exp_rotation<double>({0, 0, k == 0 ? 0 : std::numbers::pi});
    slides_[k] = world.add_joint(slide);
  }
  /// [m] From the middle between the pads to that of a finger whose pad just touches.
  [[nodiscard]] double touching() const { return def_.radius + half_finger; }
  /// Pose of the driver in the palm.
  [[nodiscard]] bristle::Transform<double> grip(const bristle::World<double>& world) const {
    return bristle::relative_pose(world.pose(palm_), world.pose(driver_));
  }

  HandDef def_;
  bristle::BodyId driver_{};
  Goal goal_{};
  std::array<bristle::JointId, 4> joints_{};
  std::array<bristle::JointId, 2> slides_{};
  std::array<bristle::BodyId, 2> fingers_{};
  std::array<bristle::PatchId, 2> pads_{};
  bristle::BodyId palm_{};
  std::vector<bristle::BodyId> bodies_;
  /// Pose of the driver in the palm when `hold` was called.
  bristle::Transform<double> held_at_{};
};

}  // namespace fig8
