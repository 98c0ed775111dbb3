// The scene of the paper's Fig. 6 (b): a gripper, two fingers on prismatic joints with a round pad
// of sensors each, holds a part in the air by sensors alone, however the part lies in it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/shapes/quickhull.hpp>
#include <bristle/math/rotation.hpp>
#include <bristle/sensors/tuning.hpp>
#include <bristle/world/world.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

namespace fig6 {

using bristle::Vec3;

/// How the part lies between the fingers, which close along x.
enum class Posture { aligned, rolled, turned, off_centre, tapered, ball, roller };

inline constexpr std::array<Posture, 7> postures{
    Posture::aligned, Posture::rolled, Posture::turned, Posture::off_centre,
    Posture::tapered, Posture::ball,   Posture::roller};

inline const char* name_of(Posture posture) {
  constexpr std::array<const char*, 7> names{"cube",
                                             "cube rolled by 30 deg",
                                             "cube turned by 8 deg",
                                             "cube 8 mm off centre",
                                             "wedge of 8 deg",
                                             "ball",
                                             "roller"};
  return names[static_cast<std::size_t>(posture)];
}

struct GripDef {
  Posture posture = Posture::aligned;
  double mass = 0.5;        // [kg]
  double force = 10;        // [N] of each finger
  double time_step = 1e-3;  // [s]
  bristle::Integration integration = bristle::Integration::implicit;
  bristle::SlipReset reset = bristle::SlipReset::release;
  /// Unset: tuned for a friction of 1 at a creep of 1 mm.
  std::optional<bristle::SensorParameters<double>> parameters{};
  /// Sees the world after every step.
  std::function<void(const bristle::World<double>&)> watch{};
};

inline constexpr double half_part = 0.025;   // [m]
inline constexpr double half_finger = 0.01;  // [m]
inline constexpr double pitch = 0.002;       // [m] between sensors
inline constexpr int rings = 6;              // sensors from the middle of a pad to its rim
inline constexpr double pad_radius = rings * pitch;
inline constexpr double depth = 0.004;  // [m] of the rays' starts below the pad
inline constexpr double range = 0.008;  // [m]

/// Sensors of a round pad on a finger's face, looking along `inwards`, the finger's x or -x.
inline bristle::SensorLayout<double> round_pad(double inwards) {
  bristle::SensorLayout<double> pad;
  for (int i = -rings; i <= rings; ++i) {
    for (int j = -rings; j <= rings; ++j) {
      if (i * i + j * j > rings * rings) continue;
      pad.add(Vec3<double>(inwards * (half_finger - depth), pitch * i, pitch * j),
              Vec3<double>(inwards, 0, 0), range);
    }
  }
  return pad;
}

/// [m] Distances of the sensors from the middle of a pad.
inline std::vector<double> pad_radii() {
  const auto pad = round_pad(1);
  std::vector<double> radii;
  for (std::size_t i = 0; i < pad.size(); ++i) {
    radii.push_back(std::hypot(pad.start.y[i], pad.start.z[i]));
  }
  return radii;
}

/// A wedge that is narrower above: faces of 8 degrees to either side.
inline bristle::ConvexHull<double> wedge() {
  const double lean = half_part * std::tan(8 * std::numbers::pi / 180);
  std::vector<Vec3<double>> corners;
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) {
      for (const double z : {-1.0, 1.0}) {
        corners.emplace_back(x * (half_part - z * lean), y * half_part, z * half_part);
      }
    }
  }
  return bristle::convex_hull<double>(std::span<const Vec3<double>>(corners));
}

/// The part of a posture, between the fingers and at rest.
inline bristle::BodyDef<double> part_of(const GripDef& def) {
  using namespace bristle;
  constexpr double degree = std::numbers::pi / 180;
  BodyDef<double> part{.mass = def.mass, .filter = {1, 2, 0}};
  part.shape = Box<double>{{half_part, half_part, half_part}};
  switch (def.posture) {
    case Posture::aligned:
      break;
    case Posture::rolled:
      part.orientation = exp_rotation<double>({30 * degree, 0, 0});
      break;
    case Posture::turned:
      part.orientation = exp_rotation<double>({0, 0, 8 * degree});
      break;
    case Posture::off_centre:
      part.position.y() = 0.008;
      break;
    case Posture::tapered:
      part.shape = wedge();
      break;
    case Posture::ball:
      part.shape = Sphere<double>{half_part};
      break;
    case Posture::roller:
      part.shape = Cylinder<double>{.radius = half_part, .half_length = half_part};
      part.orientation = exp_rotation<double>({90 * degree, 0, 0});
      break;
  }
  return part;
}

/// [rad] Angle between two attitudes.
inline double turn_between(const bristle::Transform<double>& a,
                           const bristle::Transform<double>& b) {
  return bristle::log_rotation<double>(a.rotation.conjugate() * b.rotation).norm();
}

/// The gripper and its part. Gravity comes on once the fingers have closed.
class Grip {
 public:
  explicit Grip(const GripDef& def)
      : def_(def), world_({.gravity = {0, 0, 0}, .time_step = def.time_step}) {
    using namespace bristle;
    part_ = world_.add_body(part_of(def));
    const BodyId palm = world_.add_body({.motion = Motion::fixed});
    for (std::size_t k = 0; k < 2; ++k) {
      const double inwards = k == 0 ? 1 : -1;
      fingers_[k] =
          world_.add_body({.mass = 0.1,
                           .shape = Box<double>{{half_finger, 0.015, 0.015}},
                           .filter = {4, 0, 0},
                           .position = {-inwards * (half_part + half_finger + 0.008), 0, 0}});
      PatchDef<double> pad;
      pad.sensors = round_pad(inwards);
      pad.parameters =
          def.parameters ? *def.parameters
                         : tuned_for<double>(
                               {.friction = 1, .creep = 1e-3, .load = def.force, .mass = def.mass})
                               .parameters(pad.sensors);
      // As in the paper: the closed forms are for forces along the rays.
      pad.options = {.reset = def.reset, .normal = bristle::NormalDirection::ray};
      pad.integration = def.integration;
      pad.sense_mask = 1;
      parameters_ = pad.parameters;
      pads_[k] = world_.add_patch(fingers_[k], pad);

      JointDef<double> slide;
      slide.kind = JointKind::prismatic;
      slide.body_a = palm;
      slide.body_b = fingers_[k];
      // The joint's x axis points inwards.
      const double turn = k == 0 ? 0 : std::numbers::pi;
      slide.X_AJ.rotation = slide.X_BJ.rotation =
          exp_rotation<double>(turn * Vec3<double>::UnitZ());
      slide.motor = {MotorMode::velocity, 0.05, def.force};
      slides_[k] = world_.add_joint(slide);
    }
  }

  /// Closes the fingers, and stops the first where it is, so that the second squeezes against it.
  void close() {
    run(0.6);
    world_.set_motor(slides_[0], {bristle::MotorMode::position, world_.reading(slides_[0]).position,
                                  10 * def_.force});
    run(0.2);
    place_when_closed_ = place();
  }
  /// Lets the weight come on.
  void lift() {
    const long steps = std::lround(0.4 / def_.time_step);
    for (long i = 1; i <= steps; ++i) {
      world_.set_gravity({0, 0, -gravity * static_cast<double>(i) / static_cast<double>(steps)});
      step();
    }
  }
  void run(double seconds) {
    const long steps = std::lround(seconds / def_.time_step);
    for (long i = 0; i < steps; ++i) step();
  }

  [[nodiscard]] bristle::World<double>& world() { return world_; }
  [[nodiscard]] bristle::BodyId part() const { return part_; }
  [[nodiscard]] const bristle::SensorParameters<double>& parameters() const { return parameters_; }
  [[nodiscard]] bristle::PatchReading<double> pad(std::size_t k) const {
    return world_.reading(pads_[k]);
  }
  [[nodiscard]] bristle::Transform<double> place() const { return world_.pose(part_); }
  /// [N] Normal forces of both pads.
  [[nodiscard]] double squeeze() const { return pad(0).total_normal() + pad(1).total_normal(); }
  /// [N] Load on both pads, upwards.
  [[nodiscard]] double carried() const {
    return -(pad(0).wrench.force.z() + pad(1).wrench.force.z());
  }
  /// [m] How far the part sank since the fingers closed.
  [[nodiscard]] double sag() const {
    return place_when_closed_.translation.z() - place().translation.z();
  }
  /// [rad] How far it turned since then.
  [[nodiscard]] double turn() const { return turn_between(place_when_closed_, place()); }
  /// [N m] Largest torsion about x that both pads resist if all their bristles drag along at
  /// sigma_a, 2 (2/3) mu F R for pressure that is even: the sum of mu F_N r.
  [[nodiscard]] double torsion_limit() const {
    return friction() * sum_over_pads([](double r) { return r; });
  }
  /// [N m] The same if bristles release: when the outermost ones do, 2 (1/2) mu F R.
  [[nodiscard]] double first_release() const { return torsion_stiffness() * sigma() / pad_radius; }
  /// [N m/rad] Torsion by rotation, the sum of mu_S F_N r^2.
  [[nodiscard]] double torsion_stiffness() const {
    return friction() / sigma() * sum_over_pads([](double r) { return r * r; });
  }

  static constexpr double gravity = 9.81;

 private:
  void step() {
    world_.step();
    if (def_.watch) def_.watch(world_);
  }
  [[nodiscard]] double sigma() const { return parameters_.breakaway_distance; }
  [[nodiscard]] double friction() const { return parameters_.static_friction * sigma(); }
  template <typename Weight>
  [[nodiscard]] double sum_over_pads(Weight&& weight) const {
    const std::vector<double> radii = pad_radii();
    double sum = 0;
    for (std::size_t k = 0; k < 2; ++k) {
      const bristle::PatchReading<double> reading = pad(k);
      for (std::size_t i = 0; i < radii.size(); ++i)
        sum += reading.normal_force[i] * weight(radii[i]);
    }
    return sum;
  }

  GripDef def_;
  bristle::World<double> world_;
  bristle::BodyId part_{};
  std::array<bristle::BodyId, 2> fingers_{};
  std::array<bristle::PatchId, 2> pads_{};
  std::array<bristle::JointId, 2> slides_{};
  bristle::SensorParameters<double> parameters_{};
  bristle::Transform<double> place_when_closed_{};
};

/// How a part is held. Expected: m g / (mu_S sum F_N) down, and for a part off the pads' centre
/// a turn by its weight's torque over the torsion's stiffness, which lowers its centre, too.
struct Held {
  double squeeze = 0;        // [N] of both pads
  double carried = 0;        // [N] by both pads
  double weight = 0;         // [N]
  double sag = 0;            // [m] since the weight came on
  double expected_sag = 0;   // [m]
  double turn = 0;           // [rad] likewise
  double expected_turn = 0;  // [rad]
  double drift = 0;          // [m] during the watch
  double drift_turn = 0;     // [rad]

  [[nodiscard]] bool is_lost() const { return !(squeeze > 0 && std::abs(sag) < half_part); }
  /// Still, carried, and where statics puts it.
  [[nodiscard]] bool is_right() const {
    return !is_lost() && drift < 1e-9 && drift_turn < 1e-9 &&
           std::abs(carried - weight) < 1e-6 * weight &&
           std::abs(sag - expected_sag) < 0.01 * expected_sag &&
           std::abs(turn - expected_turn) < 0.01 * expected_turn + 1e-6;
  }
};

/// Takes the part, lets it settle and watches it [s].
inline Held hold(const GripDef& def, double settle = 2, double watch = 5) {
  Grip grip(def);
  grip.close();
  grip.lift();
  grip.run(settle);
  const bristle::Transform<double> before = grip.place();
  grip.run(watch);
  const bristle::Transform<double> after = grip.place();
  const double offset = std::abs(part_of(def).position.y());
  Held held;
  held.squeeze = grip.squeeze();
  held.carried = grip.carried();
  held.weight = def.mass * Grip::gravity;
  held.sag = grip.sag();
  held.turn = grip.turn();
  held.expected_turn = held.weight * offset / grip.torsion_stiffness();
  held.expected_sag = held.weight / (grip.parameters().static_friction * held.squeeze) +
                      offset * held.expected_turn;
  held.drift = (after.translation - before.translation).norm();
  held.drift_turn = turn_between(before, after);
  return held;
}

/// How a cube resists torsion about the line between the pads, without weight.
struct Torsion {
  double stiffness = 0;           // [N m/rad] measured at half the limit
  double expected_stiffness = 0;  // sum mu_S F_N r^2
  double limit = 0;               // [N m] when it had turned by 0.3 rad
  double expected_limit = 0;      // sum mu F_N r if bristles drag, until the first lets go if not

  /// The limit is what the torque had grown to in the time that the cube took to turn.
  [[nodiscard]] bool is_right() const {
    return std::abs(stiffness - expected_stiffness) < 0.01 * expected_stiffness &&
           limit > 0.99 * expected_limit && limit < 1.05 * expected_limit;
  }
};

/// Turns the cube with a torque that grows by an eighth of the limit a second. `observe(torque,
/// turn)` sees every step.
template <typename Observe>
Torsion twist(const GripDef& def, Observe&& observe) {
  Grip grip(def);
  grip.close();
  Torsion torsion;
  torsion.expected_stiffness = grip.torsion_stiffness();
  torsion.expected_limit =
      def.reset == bristle::SlipReset::drag ? grip.torsion_limit() : grip.first_release();
  const double rate = torsion.expected_limit / 8;
  double torque = 0;
  while (grip.turn() < 0.3 && torque < 2 * torsion.expected_limit) {
    torque += rate * def.time_step;
    grip.world().apply_wrench(grip.part(), {{0, 0, 0}, {torque, 0, 0}});
    grip.run(def.time_step);
    observe(torque, grip.turn());
    if (torque < 0.5 * torsion.expected_limit) torsion.stiffness = torque / grip.turn();
  }
  torsion.limit = torque;
  return torsion;
}
inline Torsion twist(const GripDef& def) {
  return twist(def, [](double, double) {});
}

}  // namespace fig6
