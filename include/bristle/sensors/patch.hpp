/// @file
/// A patch: many resistive sensors on one body, as structures of arrays, with what they remember.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/refill.hpp>
#include <bristle/core/slot_map.hpp>
#include <bristle/dynamics/bodies/body.hpp>
#include <bristle/geometry/contacts/kept_candidates.hpp>
#include <bristle/geometry/rays/ray.hpp>
#include <bristle/geometry/rays/ray_bundles.hpp>
#include <bristle/geometry/trees/aabb.hpp>
#include <bristle/math/lane_vector.hpp>
#include <bristle/math/rotation.hpp>
#include <bristle/sensors/kept_hits.hpp>
#include <bristle/sensors/law.hpp>
#include <bristle/sensors/reading.hpp>
#include <bristle/sensors/sensor_layout.hpp>
#include <bristle/sensors/sensor_parameters.hpp>
#include <bristle/sensors/sensor_tiles.hpp>
#include <bristle/sensors/tile_boxes.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

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
  /// [-] Accepts rays that end inside their own body. `World::add_patch` refuses them otherwise: the
  /// end of a ray must lie outside of all shapes that the body has then. A ray that never leaves its
  /// body feels what comes through the body, and presses the body towards that.
  bool may_point_inwards = false;
  /// [-] Rays are cast in every so many-th step, >= 1; in the steps between, and in all of them the
  /// law is evaluated, the surfaces met move on as planes (docs/sensors.md, section 8). Patches
  /// take turns by their slots. Rays are cast sooner when another shape
  /// comes into reach, or bodies have moved by a quarter of the shortest ray.
  std::uint32_t cast_every = 1;
};

/// One sensor that meets a body in this step: geometry, the linear model of its impulse, and the
/// impulse it finally gave. In A's axes; the reference point c belongs to its `PatchPair`. Patches
/// work on PatchContact<Pack<S>>, of which `ContactTile`s keep what cannot be found again.
template <Value T>
struct PatchContact {
  /// Whether it touches at the start of the step (else it may within it), whether its normal part
  /// acts, and whether its bristle slips in this step, damped or not.
  Truth<T> is_touching{};
  Truth<T> is_pushing{};
  Truth<T> is_slipping{};
  Truth<T> is_damping_slip{};
  /// [1] Ray direction n and depth gradient g.
  Vector3<T> n, g;
  /// [m] From c to the point of touch.
  Vector3<T> rho;
  /// [m] Stretch at the start of the step.
  Vector3<T> stretch;
  /// [m/s] Relative velocity at the start of the step, and tangential one of the last pass.
  Vector3<T> start_velocity, last_slip;
  /// [1], [1/m] Depth at the start of the step and inverse length of the ray.
  T depth, inverse_length;
  /// [N] Normal force that sets the friction of this pass.
  T force;

  /// Impulse on B as a function of the relative velocity v at the end of the step:
  /// constant + a_normal (g.v) g + a_across v_T + (a_along - a_across) (along.v) along,
  /// of which the part with a_normal acts while it pushes.
  Vector3<T> constant, along;
  T normal_constant, a_normal, a_across, a_along;

  /// [N s] What it gave: its normal part, and all of it on B.
  T normal_impulse;
  Vector3<T> impulse;
};

/// What the stiffness of a pair's contacts adds up to, about the middle of the patch's box.
template <Scalar S>
struct PairStiffness {
  /// [N/m], [N s/m] Of the bristles that touch.
  S bristle_sum = S(0), viscous_sum = S(0);
  /// [kg] Sums of s, of s rho, of s rho^2 (`measure_pair`), across the rays and along them.
  S tangential = S(0), normal = S(0);
  Vec3<S> tangential_first = Vec3<S>::Zero(), normal_first = Vec3<S>::Zero();
  S tangential_second = S(0), normal_second = S(0);
};

/// All contacts of one patch with one body in one step.
template <Scalar S>
struct PatchPair {
  /// [-] Slot of the touched body; its contact tiles are [first, first + count).
  std::uint32_t body_b = 0;
  std::uint32_t first = 0;
  std::uint32_t count = 0;
  /// [-] Axes of A in the world, and B as A sees it.
  Mat3<S> R_WA = Mat3<S>::Identity();
  PairPose<S> pose{};
  /// [m/s, rad/s] Motion of A relative to B at the start of the step about A's centre of mass, in
  /// A's axes.
  Twist<S> start_motion{};
  /// [m] From A's centre of mass to the reference point c, in A's axes; from each centre of mass to
  /// it, in the world's.
  Vec3<S> center = Vec3<S>::Zero();
  Vec3<S> arm_a = Vec3<S>::Zero();
  Vec3<S> arm_b = Vec3<S>::Zero();
  PairStiffness<S> stiffness{};
  /// [N s, N m s] Impulse on B about c in A's axes, where it was given with the contacts.
  bool is_given = false;
  Wrench<S> given{};
  /// [1] Lambda of these contacts alone, where anybody asks (`CollectDef`).
  S lambda = S(0);
  bool is_implicit = false;
  /// [1] Weights of the implicit scheme (docs/sensors.md).
  S alpha = S(1);
  S beta = S(0);
  S theta = S(1);
  /// Whether its linear models were moved to a motion that was found; these its tiles keep. The
  /// first ones, around the motion at the start of the step, follow from the hits and the stretch.
  bool has_moved_models = false;
  /// [-] Sum of the contacts' linear models about c, in A's axes: impulse = offset + matrix u.
  Mat6<S> matrix = Mat6<S>::Zero();
  Vec6<S> offset = Vec6<S>::Zero();
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

/// A shape that rays hit in this step, and the pair of its body.
struct TouchedShape {
  std::uint32_t tag = 0;
  std::uint32_t pair = 0;
};

/// State of a patch. Arrays have one entry a sensor unless said otherwise.
template <Scalar S>
struct SensorPatch {
  PatchDef<S> def{};
  /// [-] Body A.
  BodyId body{};
  /// [m] Rays from A's centre of mass in A's axes; [1] unit directions; [m] lengths.
  Vec3Array<S> start, direction;
  LaneVector<S> length;
  /// The rays as queries want them.
  RayBundles<S> bundles{};
  /// What they keep of a fine mesh: no part of the state, since answers do not depend on it.
  KeptCandidates<S> candidates{};
  /// [m] Around all rays, from A's centre of mass in A's axes.
  Aabb<S> box{};

  /// The same sensors for the kernels, and their bristles; [0, size()) in order, then nothing.
  std::vector<SensorTile<S>> tiles;
  TileBoxes<S> tile_boxes{};
  /// [m] Farthest point of the rays from A's centre of mass, and the length of the shortest.
  S reach = S(0);
  S shortest = S(0);
  /// Whether it senses at all.
  bool is_active = true;

  /// This step's hits, in rays, valid in the tiles that can be near anything: their numbers,
  /// ascending. All of them until somebody knows better. And contacts and pairs.
  RayHits<S> hits{};
  std::vector<std::uint32_t> near;
  KeptHits<S> kept{};
  /// Which lanes of each tile hit anything in this step, and in the one before.
  std::vector<LaneBits> hit_bits, hit_before;
  std::vector<TouchedShape> touched;
  /// Of the pair at hand: which lanes of a near tile hit its body, and the first contact of each
  /// slice of near tiles.
  std::vector<LaneBits> pair_bits;
  std::vector<std::uint32_t> slice_contacts;
  std::vector<ContactTile<S>> contacts;
  std::vector<PatchPair<S>> pairs;
  std::vector<PairImpulse<S>> last_impulses;
  /// Sensors of each tile whose readings are not zero.
  std::vector<LaneBits> felt, felt_before;
  bool has_felt = false;
  ReadingStore<S> readings{};

  [[nodiscard]] std::size_t size() const { return length.size(); }
  [[nodiscard]] const SensorParameters<S>& parameters(std::size_t sensor) const {
    return def.per_sensor.empty() ? def.parameters : def.per_sensor[sensor];
  }
  /// Whether any sensor can give a force, whatever it touches.
  [[nodiscard]] bool can_push() const {
    const auto of = [&](const SensorParameters<S>& p) { return bristle::can_push(p, def.options); };
    return def.per_sensor.empty() ? of(def.parameters)
                                  : std::any_of(def.per_sensor.begin(), def.per_sensor.end(), of);
  }
  [[nodiscard]] RayBatch<S> rays(S extra_length) const {
    return {start.x,     start.y, start.z,      direction.x, direction.y,
            direction.z, length,  extra_length, &bundles};
  }
  /// The same rays, of which only those of the near tiles need to be answered.
  [[nodiscard]] RayBatch<S> near_rays(S extra_length) const {
    RayBatch<S> batch = rays(extra_length);
    batch.near_runs = &near;
    return batch;
  }
  /// [m] Distances of the hits from sensor `first` on; 0 in the lanes that are not asked for.
  [[nodiscard]] BRISTLE_INLINE Pack<S> distances_of(std::size_t first, const Mask<S>& asked) const {
    return select(asked, Pack<S>::load(hits.distance.data() + first), Pack<S>(S(0)));
  }
  /// [-] Sensors of the near tiles.
  [[nodiscard]] std::size_t near_count() const {
    const std::size_t all = near.size() * tile_size;
    // Only the last tile may be filled up.
    const bool has_last = !near.empty() && near.back() + 1 == tiles.size();
    return has_last ? all - (tiles.size() * tile_size - size()) : all;
  }
  /// [-] First tile of a slice, and one behind its last, which may be filled up where the slice is
  /// not. Only of slices that are runs of sensors (`RayBundles::has_runs_in_slices`), or of all.
  [[nodiscard]] std::array<std::size_t, 2> tiles_in(RaySlice slice) const {
    static_assert(tile_size == ray_run_size);
    const std::size_t end = slice.end / tile_size + (slice.end % tile_size != 0 ? 1u : 0u);
    return {slice.first / tile_size, std::min(tiles.size(), end)};
  }
  /// [-] Those of them that can be near anything.
  [[nodiscard]] std::span<const std::uint32_t> near_in(RaySlice slice) const {
    const auto [begin, end] = tiles_in(slice);
    const auto first = std::lower_bound(near.begin(), near.end(), begin);
    return {first, std::lower_bound(first, near.end(), end)};
  }
  /// Forgets the hits of the near tiles of a slice.
  void reset_near_hits(RaySlice slice = {}) {
    for (const std::uint32_t tile : near_in(slice)) {
      const auto first = static_cast<std::ptrdiff_t>(tile * tile_size);
      std::fill_n(hits.distance.begin() + first, tile_size, infinity<S>);
    }
  }
  /// [-] Sensors whose readings are not zero.
  [[nodiscard]] std::size_t felt_count() const {
    std::size_t count = 0;
    for (const LaneBits bits : felt) count += static_cast<std::size_t>(std::popcount(bits));
    return count;
  }
};

/// Checks a definition and turns it into a patch of a body with its centre of mass at `center_B`
/// [m].
/// @throws InvalidArgument naming the field.
template <Scalar S>
[[nodiscard]] SensorPatch<S> make_patch(PatchDef<S> def, BodyId body, const Vec3<S>& center_B) {
  def.sensors.validate();
  const std::size_t n = def.sensors.size();
  detail::require(n > 0, "PatchDef::sensors.size()", n, "must be > 0");
  validate(def.parameters);
  for (const SensorParameters<S>& p : def.per_sensor) validate(p);
  detail::require(def.per_sensor.empty() || def.per_sensor.size() == n,
                  "PatchDef::per_sensor.size()", static_cast<S>(def.per_sensor.size()),
                  "must be 0 or the number of sensors");
  detail::require_not_negative("PatchDef::explicit_below", def.explicit_below);
  detail::require(def.cast_every > 0, "PatchDef::cast_every", def.cast_every, "must be > 0");
  detail::require(def.options.law == Law::paper || def.integration != Integration::implicit,
                  "PatchDef::integration", "implicit", "must not be implicit with the AMBF law");

  SensorPatch<S> patch;
  patch.body = body;
  patch.start = def.sensors.start;
  patch.direction = def.sensors.direction;
  patch.length = def.sensors.length;
  for (std::size_t i = 0; i < n; ++i) {
    patch.start.set(i, patch.start[i] - center_B);
    patch.box.include(patch.start[i]);
    const Vec3<S> end = patch.start[i] + patch.length[i] * patch.direction[i];
    patch.box.include(end);
    patch.reach = std::max({patch.reach, patch.start[i].norm(), end.norm()});
  }
  detail::require_finite("PatchDef::sensors: farthest point of a ray", patch.reach);
  patch.shortest = *std::min_element(patch.length.begin(), patch.length.end());
  patch.tile_boxes = TileBoxes<S>(patch.rays(S(0)));
  patch.bundles = RayBundles<S>(patch.rays(S(0)));
  const std::size_t tile_count = (n + tile_size - 1) / tile_size;
  patch.tiles.resize(tile_count);
  for (std::size_t i = 0; i < tile_count * tile_size; ++i) {
    SensorTile<S>& tile = patch.tiles[i / tile_size];
    const std::size_t lane = i % tile_size;
    // Lanes behind the last sensor never hit anything; a unit direction keeps them finite.
    const Vec3<S> direction = i < n ? patch.direction[i] : Vec3<S>(Vec3<S>::UnitX());
    Vec3<S> t1, t2;
    tangent_basis<S>(direction, t1, t2);
    tile.direction.set(lane, direction);
    tile.tangent.set(lane, t1);
    if (i < n) tile.start.set(lane, patch.start[i]);
    tile.inverse_length[lane] = i < n ? S(1) / patch.length[i] : S(1);
  }
  patch.hits.reset(tile_count * tile_size);
  patch.hit_bits.resize(tile_count);
  patch.hit_before.resize(tile_count);
  patch.pair_bits.resize(tile_count);
  patch.slice_contacts.resize(slice_count(tile_count));
  patch.near.resize(tile_count);
  detail::fill_numbers(patch.near);
  patch.contacts.reserve(tile_count);
  patch.felt.resize(tile_count);
  patch.felt_before.resize(tile_count);
  patch.readings.resize(n);
  def.sensors = {};  // The arrays above replace it.
  patch.def = std::move(def);
  return patch;
}

}  // namespace bristle::inline BRISTLE_ABI
