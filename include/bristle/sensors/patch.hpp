/// @file
/// A patch: many resistive sensors on one body, as structures of arrays, with what they remember.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/slot_map.hpp>
#include <bristle/dynamics/body.hpp>
#include <bristle/geometry/aabb.hpp>
#include <bristle/geometry/ray.hpp>
#include <bristle/geometry/ray_bundles.hpp>
#include <bristle/sensors/law.hpp>
#include <bristle/sensors/reading.hpp>
#include <bristle/sensors/sensor_layout.hpp>
#include <bristle/sensors/sensor_parameters.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace bristle {

struct PatchTag;
/// Names a patch of a world.
using PatchId = Id<PatchTag>;

/// Describes a patch to `World::add_patch`.
template <Scalar S>
struct PatchDef {
  /// [m] Where the sensors are, in the body frame.
  SensorLayout<S> sensors{};
  /// [-] Constants that all sensors share.
  SensorParameters<S> parameters{};
  /// [-] Constants of each sensor instead, in the order of the layout; empty to share.
  std::vector<SensorParameters<S>> per_sensor{};
  /// [-] How the forces enter the step.
  Integration integration = Integration::automatic;
  /// [-] Readings of the law.
  LawOptions options{};
  /// [1] Below this Lambda, the stability measure of docs/sensors.md (4 is the limit of a single
  /// mode), `automatic` integrates explicitly. 0: never.
  S explicit_below = S(0.5);
  /// [-] Categories of bodies the sensors see; their collision masks do not matter to sensors.
  std::uint32_t sees = 0xffffffffu;
  /// [-] Bodies the sensors never see, besides their own.
  std::vector<BodyId> excluded{};
};

/// One sensor that meets a body in this step: geometry, the linear model of its impulse, and the
/// impulse it finally gave. World axes; the reference point c belongs to its `PatchPair`.
template <Scalar S>
struct PatchContact {
  std::uint32_t sensor = 0;
  /// Whether it touches at the start of the step (else it may within it), whether its normal part
  /// acts, and whether its bristle slips in this step.
  bool is_touching = false;
  bool is_pushing = false;
  bool is_slipping = false;
  bool is_damping_slip = false;
  /// [1] Ray direction n and depth gradient g.
  Vec3<S> n = Vec3<S>::UnitX();
  Vec3<S> g = Vec3<S>::UnitX();
  /// [m] From c to the point of touch.
  Vec3<S> rho = Vec3<S>::Zero();
  /// [m] Stretch at the start of the step.
  Vec3<S> stretch = Vec3<S>::Zero();
  /// [m/s] Relative velocity at the start of the step, and tangential one of the last pass.
  Vec3<S> start_velocity = Vec3<S>::Zero();
  Vec3<S> last_slip = Vec3<S>::Zero();
  /// [1], [m] Depth at the start of the step and length of the ray.
  S depth = S(0);
  S length = S(1);
  /// [N] Normal force that sets the friction of this pass.
  S force = S(0);

  /// Impulse on B as a function of the relative velocity v at the end of the step:
  /// constant + a_normal (g.v) g + a_across v_T + (a_along - a_across) (along.v) along.
  Vec3<S> constant = Vec3<S>::Zero();
  Vec3<S> along = Vec3<S>::Zero();
  S normal_constant = S(0);
  S a_normal = S(0);
  S a_across = S(0);
  S a_along = S(0);

  /// [N s] What it gave: its normal part, and all of it on B.
  S normal_impulse = S(0);
  Vec3<S> impulse = Vec3<S>::Zero();
};

/// All contacts of one patch with one body in one step.
template <Scalar S>
struct PatchPair {
  /// [-] Slot of the touched body; its contacts are [first, first + count).
  std::uint32_t body_b = 0;
  std::uint32_t first = 0;
  std::uint32_t count = 0;
  PairPose<S> pose{};
  /// [m] From each centre of mass to the reference point c.
  Vec3<S> arm_a = Vec3<S>::Zero();
  Vec3<S> arm_b = Vec3<S>::Zero();
  /// [1] Lambda of these contacts alone.
  S lambda = S(0);
  bool is_implicit = false;
  /// [1] Weights of the implicit scheme (docs/sensors.md).
  S alpha = S(1);
  S beta = S(0);
  S theta = S(1);
  /// [-] Its block among the step's soft blocks, when implicit.
  std::uint32_t soft = 0;
};

/// What an implicit pair gave in the last step: where a sweep starts from in this one.
template <Scalar S>
struct PairImpulse {
  BodyId body{};
  /// [N s; N m s] On B about the pair's point c, world axes.
  Vec6<S> impulse = Vec6<S>::Zero();
};

/// State of a patch. Arrays have one entry a sensor unless said otherwise.
template <Scalar S>
struct SensorPatch {
  PatchDef<S> def{};
  /// [-] Body A.
  BodyId body{};
  /// [m] Rays from A's centre of mass in A's axes; [1] unit directions; [m] lengths.
  Vec3Array<S> start, direction;
  std::vector<S> length;
  /// The rays as queries want them.
  RayBundles<S> bundles{};
  /// [m] Around all rays, from A's centre of mass in A's axes.
  Aabb<S> box{};

  /// Bristles: their roots, and the body they are rooted in (none while they are not rooted).
  Vec3Array<S> root_a, root_b;
  std::vector<BodyId> rooted_in;

  /// This step's hits, contacts and pairs.
  RayHits<S> hits{};
  std::vector<PatchContact<S>> contacts;
  std::vector<PatchPair<S>> pairs;
  std::vector<PairImpulse<S>> last_impulses;
  /// Sensors whose readings are not zero.
  std::vector<std::uint32_t> felt;
  ReadingStore<S> readings{};

  [[nodiscard]] std::size_t size() const { return length.size(); }
  [[nodiscard]] const SensorParameters<S>& parameters(std::size_t sensor) const {
    return def.per_sensor.empty() ? def.parameters : def.per_sensor[sensor];
  }
  [[nodiscard]] RayBatch<S> rays(S extra_length) const {
    return {start.x,     start.y, start.z,      direction.x, direction.y,
            direction.z, length,  extra_length, &bundles};
  }
  /// Forgets that a sensor touched anything.
  void release(std::size_t sensor) { rooted_in[sensor] = BodyId{}; }
};

/// Checks a definition and turns it into a patch of a body with its centre of mass at `center_B`
/// [m].
/// @throws InvalidArgument naming the field.
template <Scalar S>
[[nodiscard]] SensorPatch<S> make_patch(PatchDef<S> def, BodyId body, const Vec3<S>& center_B) {
  def.sensors.validate();
  const std::size_t n = def.sensors.size();
  detail::require(n > 0, "PatchDef::sensors.size()", S(0), "must be > 0");
  validate(def.parameters);
  for (const SensorParameters<S>& p : def.per_sensor) validate(p);
  detail::require(def.per_sensor.empty() || def.per_sensor.size() == n,
                  "PatchDef::per_sensor.size()", static_cast<S>(def.per_sensor.size()),
                  "must be 0 or the number of sensors");
  detail::require_not_negative("PatchDef::explicit_below", def.explicit_below);
  detail::require(def.options.law == Law::paper || def.integration != Integration::implicit,
                  "PatchDef::integration", S(1), "must not be implicit with the AMBF law");

  SensorPatch<S> patch;
  patch.body = body;
  patch.start = def.sensors.start;
  patch.direction = def.sensors.direction;
  patch.length = def.sensors.length;
  for (std::size_t i = 0; i < n; ++i) {
    patch.start.set(i, patch.start[i] - center_B);
    patch.box.include(patch.start[i]);
    patch.box.include(patch.start[i] + patch.length[i] * patch.direction[i]);
  }
  patch.bundles = RayBundles<S>(patch.rays(S(0)));
  patch.root_a.resize(n);
  patch.root_b.resize(n);
  patch.rooted_in.resize(n);
  patch.hits.reset(n);
  patch.contacts.reserve(n);
  patch.felt.reserve(n);
  patch.readings.resize(n);
  def.sensors = {};  // The arrays above replace it.
  patch.def = std::move(def);
  return patch;
}

}  // namespace bristle
