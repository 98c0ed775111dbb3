// The thread of Fig. 8 (b), with the numbers of the authors' scene KnotEnv: cylinders with a bead
// between any two and at both ends, joined by revolutes that turn about the thread and across it by
// turns. KnotEnv has two of 16 cylinders, whose ends are tied to mounts by four revolutes more;
// here they are one, end to end, of as many inner joints, and hands hold its ends.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "fig8_thread/hand.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace fig8b {

inline constexpr std::size_t cylinder_count = 32;
inline constexpr std::size_t link_count = 2 * cylinder_count + 1;
inline constexpr double pitch = 1.291 / 16;       // [m] from bead to bead
inline constexpr double thread_radius = 0.0175;   // [m] of cylinders
inline constexpr double bead_radius = 0.017;      // [m]
inline constexpr double cylinder_height = 0.076;  // [m]
inline constexpr double cylinder_mass = 0.005;    // [kg]
inline constexpr double bead_mass = 0.002;        // [kg]
inline constexpr double largest_angle = 0.175;    // [rad] of every joint
// KnotEnv's joints have controllers, which act when somebody commands them; their damping is taken
// for that of the thread. Its stiffness is this program's.
inline constexpr double joint_damping = 0.014;   // [N m s/rad]
inline constexpr double joint_stiffness = 0.05;  // [N m/rad]
inline constexpr double gravity = 9.81;          // [m/s^2]

class Thread {
 public:
  /// Adds a straight thread along y, its middle at a height [m].
  Thread(World& world, double height, double friction);

  [[nodiscard]] const std::vector<BodyId>& links() const { return links_; }
  /// [m] Places of all beads, from end to end.
  [[nodiscard]] std::vector<Vec3<double>> beads(const World& world) const;
  /// [1] Relative error of the length of the line through all beads.
  [[nodiscard]] double length_error(const World& world) const;
  /// [m] Largest distance between the two frames of a joint.
  [[nodiscard]] double largest_gap(const World& world) const;
  /// [J] Stored in its joints.
  [[nodiscard]] double stored_energy(const World& world) const;
  /// [W] Lost in its joints.
  [[nodiscard]] double damping_power(const World& world) const;
  /// [-] The link that is nearest to a point.
  [[nodiscard]] BodyId nearest(const World& world, const Vec3<double>& point) const;

 private:
  std::vector<BodyId> links_;  // bead, cylinder, bead, ...
  std::vector<JointId> joints_;
  std::vector<bristle::JointDef<double>> joint_defs_;
};

// Implementation ----------------------------------------------------------------------------------

inline Thread::Thread(World& world, double height, double friction) {
  using namespace bristle;
  for (std::size_t i = 0; i < link_count; ++i) {
    const bool is_bead = i % 2 == 0;
    BodyDef<double> link{.mass = is_bead ? bead_mass : cylinder_mass,
                         .filter = {thread_category, post_category, 0}};
    ShapeDef<double> shape{.material = {.friction = friction}};
    if (is_bead) {
      shape.shape = Sphere<double>{bead_radius};
    } else {
      shape.shape = Cylinder<double>{thread_radius, cylinder_height / 2};
      shape.X_BS.rotation = exp_rotation<double>({std::numbers::pi / 2, 0, 0});
    }
    link.shapes.push_back(shape);
    link.position = {0, 0.5 * pitch * (static_cast<double>(i) - cylinder_count), height};
    links_.push_back(world.add_body(link));
    if (i == 0) continue;
    // All joints lie in the middle of a bead: from bead to cylinder they turn about the thread,
    // from cylinder to bead across it.
    JointDef<double> joint{.kind = JointKind::revolute,
                           .body_a = links_[i - 1],
                           .body_b = links_[i],
                           .lower_limit = -largest_angle,
                           .upper_limit = largest_angle,
                           .spring = {joint_stiffness, joint_damping, 0}};
    if (is_bead) {
      joint.X_AJ.translation.y() = 0.5 * pitch;
    } else {
      joint.X_BJ.translation.y() = -0.5 * pitch;
      joint.X_AJ.rotation = joint.X_BJ.rotation =
          exp_rotation<double>({0, 0, std::numbers::pi / 2});
    }
    joint_defs_.push_back(joint);
    joints_.push_back(world.add_joint(joint));
  }
}

inline std::vector<Vec3<double>> Thread::beads(const World& world) const {
  std::vector<Vec3<double>> result;
  for (std::size_t i = 0; i < links_.size(); i += 2) {
    result.push_back(world.pose(links_[i]).translation);
  }
  return result;
}

inline double Thread::length_error(const World& world) const {
  const std::vector<Vec3<double>> line = beads(world);
  double length = 0;
  for (std::size_t i = 1; i < line.size(); ++i) length += (line[i] - line[i - 1]).norm();
  return length / (pitch * cylinder_count) - 1;
}

inline double Thread::largest_gap(const World& world) const {
  double gap = 0;
  for (const bristle::JointDef<double>& joint : joint_defs_) {
    const Vec3<double> a = world.pose(joint.body_a) * joint.X_AJ.translation;
    const Vec3<double> b = world.pose(joint.body_b) * joint.X_BJ.translation;
    gap = std::max(gap, (a - b).norm());
  }
  return gap;
}

inline double Thread::stored_energy(const World& world) const {
  double sum = 0;
  for (const JointId joint : joints_) {
    const double angle = world.reading(joint).position;
    sum += 0.5 * joint_stiffness * angle * angle;
  }
  return sum;
}

inline double Thread::damping_power(const World& world) const {
  double sum = 0;
  for (const JointId joint : joints_) {
    const double rate = world.reading(joint).velocity;
    sum += joint_damping * rate * rate;
  }
  return sum;
}

inline BodyId Thread::nearest(const World& world, const Vec3<double>& point) const {
  const auto distance = [&](BodyId link) { return (world.pose(link).translation - point).norm(); };
  return *std::min_element(links_.begin(), links_.end(),
                           [&](BodyId a, BodyId b) { return distance(a) < distance(b); });
}

}  // namespace fig8b
