/// @file
/// A part between two pads on slides, for whatever engine steps it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/sensors/tuning.hpp>
#include <bristle/world/world.hpp>

#include <array>
#include <cmath>
#include <cstddef>

namespace bristle::scenes {

/// The same in every engine. Pads weigh 100 g and slide along x; pads and part are boxes of
/// 10 x 20 x 20 mm, 0.1 mm from each other.
struct PinchDef {
  /// [kg], [N], [m] Mass of the part, squeeze of each pad, and how far the part's centre of mass
  /// lies beside the pads along y.
  double mass = 0.045;
  double squeeze = 12;
  double offset = 0;
  /// [s] Step, and [-] steps of the engine's own in one that a caller takes.
  double dt = 1e-3;
  int substeps = 1;
  /// [1] Coulomb's coefficient.
  double friction = 0.7;
  /// True if both pads hang on an arm of seven joints.
  bool has_arm = false;
  /// True if one motor drives both pads against each other, as a gripper's does.
  bool is_geared = false;
  /// [-] Sensors of a pad along each of its sides.
  int across = 6;
  /// True if pads and part collide in the engine, too, with `friction`; else by sensors only.
  /// Sensors then are for half of the squeeze, and contacts bear the rest.
  bool has_contacts = false;

  [[nodiscard]] GripSpec<double> spec() const {
    const double share = has_contacts ? 0.5 : 1.0;
    return {.friction = friction, .load = share * squeeze, .mass = mass, .press = 0.45};
  }
};

/// [m] Side of the square of a pad that has sensors.
inline constexpr double pinch_pad_side = 0.018;

/// Sensors over 18 x 18 mm that start 3 mm below a pad's face and reach 5 mm beyond.
/// @param side    [1] 1 for the pad at negative x, whose face looks to positive x; else -1.
/// @param across  [-] Sensors along y, and along z.
[[nodiscard]] inline PatchDef<double> pinch_pad(double side, const GripSpec<double>& spec,
                                                int across = 6) {
  PatchDef<double> patch;
  const double distance = pinch_pad_side / across;
  for (int i = 0; i < across * across; ++i) {
    const double y = distance * (i % across - 0.5 * (across - 1));
    const double z = distance * (i / across - 0.5 * (across - 1));
    patch.sensors.add({side * 0.002, y, z}, {side * 0.010, y, z});
  }
  patch.parameters = tuned_for<double>(spec).parameters(patch.sensors);
  return patch;
}

/// Queries and actions of the pinch that tests need in every engine.
class Pinch {
 public:
  static constexpr double pad_mass = 0.1;

  explicit Pinch(const PinchDef& d) : def(d) {}
  virtual ~Pinch() = default;

  PinchDef def;
  std::array<PatchId, 2> patches{};
  /// [m/s^2] Mean over the next step.
  Vec3<double> gravity = Vec3<double>::Zero();

  /// The sensors' world.
  [[nodiscard]] virtual World<double>& world() = 0;
  /// Bodies without a state in the last step.
  [[nodiscard]] virtual std::size_t missing() = 0;
  /// [m] The part's centre of mass, and a pad's frame, as the engine has them.
  [[nodiscard]] virtual Vec3<double> part() const = 0;
  [[nodiscard]] virtual Vec3<double> pad(std::size_t k) const = 0;
  /// Moves each pad away from the part by `gap` [m], and lets both approach it at `speed` [m/s].
  virtual void open(double gap, double speed) = 0;
  /// A step of the engine with sensors, squeeze and gravity; all of its substeps.
  virtual void step() = 0;

  void run(double seconds) {
    const long steps = std::lround(seconds / (def.dt * def.substeps));
    for (long i = 0; i < steps; ++i) step();
  }
  /// [m] Where the part is between the pads.
  [[nodiscard]] Vec3<double> place() const { return part() - 0.5 * (pad(0) + pad(1)); }
  [[nodiscard]] PatchReading<double> reading(std::size_t k) { return world().reading(patches[k]); }
  /// [N] Force of the pads on the part, or their readings of it.
  [[nodiscard]] double normal() { return reading(0).total_normal() + reading(1).total_normal(); }
  [[nodiscard]] double weight() {
    return -reading(0).wrench.force.z() - reading(1).wrench.force.z();
  }
  /// [m] How far the part's centre of mass sags under its weight: m g / (mu_S sum F_N) between the
  /// pads, and beside them more, as bristles at a mean square distance from the pads' middle resist
  /// its turn.
  [[nodiscard]] double expected_sag() {
    const double mu_S = world().patch(patches[0]).def.parameters.static_friction;
    const double distance = pinch_pad_side / def.across;
    const double mean_square = distance * distance * (def.across * def.across - 1) / 6;
    const double turn = 1 + def.offset * def.offset / mean_square;
    return turn * def.mass * 9.81 / (mu_S * normal());
  }

 protected:
  Pinch(const Pinch&) = default;
  Pinch& operator=(const Pinch&) = default;
};

}  // namespace bristle::scenes
