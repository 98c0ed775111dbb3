/// @file
/// From hits to contacts: sorts the hits of a patch by body and advances its bristles.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/no_index.hpp>
#include <bristle/core/parallel.hpp>
#include <bristle/sensors/lane_parameters.hpp>
#include <bristle/sensors/patch.hpp>
#include <bristle/sensors/patch_scratch.hpp>
#include <bristle/sensors/patch_touch.hpp>
#include <bristle/sensors/sensor_constants.hpp>

namespace bristle::inline BRISTLE_ABI::detail {

/// A body that a ray hit, and its handle. Worlds, haptic loops and hosts number shapes differently,
/// so each looks up the body of a tag.
template <Scalar S>
struct TouchedBody {
  const Body<S>* body = nullptr;
  BodyId id{};
};

/// Purpose for which contacts are collected.
template <Scalar S>
struct CollectDef {
  /// [s] The step that follows.
  S dt = S(0);
  /// [-] True if a patch chooses between explicit and implicit by Lambda.
  bool measures_lambda = true;
  /// [-] Tag of all hits if only one shape was queried; `no_index` otherwise.
  std::uint32_t only_tag = no_index;
  /// [-] True if `begin_hit_mask` and then `find_hit_mask` ran over ranges of all sensors.
  bool knows_hit_mask = false;
};

/// Clears the readings and state of a patch. Costs nothing if they are clear already.
template <Scalar S>
void clear_patch(SensorPatch<S>& patch);

/// Clears what a patch reads and remembers of a body that is removed.
template <Scalar S>
void forget_body(SensorPatch<S>& patch, BodyId body);

/// Saves the hit mask of the step before. Call it once a step, before any `find_hit_mask`.
template <Scalar S>
void begin_hit_mask(SensorPatch<S>& patch, PatchScratch<S>& scratch);

/// Finds the lanes of the near packets of a range that hit anything. Packets of the range without
/// any hit let go. `collect_contacts` does both for all sensors unless told that they were done.
/// Threads that share the ranges have the hits of their own ranges in cache.
template <Scalar S>
void find_hit_mask(SensorPatch<S>& patch, PatchScratch<S>& scratch, RayRange range);

/// Fills `contacts` and `pairs` of the scratch from its hits. A sensor without a hit lets go. Under
/// the paper's law the bristles advance, too. Patches that are explicit by definition apply their
/// impulses here, which spares a second sweep over the contacts.
///
/// @param A        The patch's own body.
/// @param find     Callable: TouchedBody<S> find(tag), the body that owns the shape with that tag.
/// @param parallel_for  Shares the sensors of a large patch; the contacts are the same bits.
template <Scalar S, typename FindBody>
void collect_contacts(SensorPatch<S>& patch, PatchScratch<S>& scratch, const Body<S>& A,
                      FindBody&& find, const CollectDef<S>& def,
                      const ParallelFor& parallel_for = serial_for);

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
void clear_patch(SensorPatch<S>& patch) {
  for (std::size_t i = 0; patch.has_hits && i < patch.hit_bits.size(); ++i) {
    if (patch.hit_bits[i] != 0) patch.is_anchored[i] = 0;
    patch.hit_bits[i] = 0;
  }
  patch.has_hits = false;
  for (std::size_t i = 0; patch.was_active && i < patch.active_lanes.size(); ++i) {
    if (patch.active_lanes[i] != 0) patch.readings.clear_packet(i);
    patch.active_lanes[i] = 0;
  }
  patch.was_active = false;
  patch.sensed.clear();
  patch.last_impulses.clear();
  patch.plane_cache.clear();
  patch.readings.wrench = {};
  set_zero(patch.readings.shear_W);
}

template <Scalar S>
void forget_body(SensorPatch<S>& patch, BodyId body) {
  const auto* const other =
      std::find_if(patch.sensed.begin(), patch.sensed.end(),
                   [body](const SensedBody<S>& sensed) { return sensed.body == body.index; });
  if (other == patch.sensed.end()) return;
  patch.sensed.erase(other);
  erase_if(patch.last_impulses, [body](const PairImpulse<S>& last) { return last.body == body; });
  ReadingStore<S>& readings = patch.readings;
  for (std::size_t i = 0; i < readings.count; ++i) {
    if (readings.body[i] != body) continue;
    const LaneBits others = static_cast<LaneBits>(~(1u << i % packet_size));
    patch.is_anchored[i / packet_size] &= others;
    patch.active_lanes[i / packet_size] &= others;
    readings.clear_sensor(i);
  }
  // In the order in which the step added them: that leaves no round-off of the removed body.
  readings.wrench = {};
  set_zero(readings.shear_W);
  for (const SensedBody<S>& sensed : patch.sensed) {
    readings.wrench += sensed.on_a;
    readings.shear_W += sensed.shear_W;
  }
}

template <Scalar S>
void begin_hit_mask(SensorPatch<S>& patch, PatchScratch<S>& scratch) {
  std::swap(patch.hit_bits, scratch.hit_before);
  std::fill(patch.hit_bits.begin(), patch.hit_bits.end(), LaneBits(0));
}

template <Scalar S>
void find_hit_mask(SensorPatch<S>& patch, PatchScratch<S>& scratch, RayRange range) {
  for (const std::uint32_t number : scratch.near_in(range)) {
    const S* distance = scratch.hits.distance.data() + number * packet_size;
    std::uint32_t hit = 0;
    for (std::size_t at = 0; at < packet_size; at += lanes<S>) {
      hit |= bits(Pack<S>::load(distance + at) < Pack<S>(infinity<S>)) << at;
    }
    patch.hit_bits[number] = static_cast<LaneBits>(hit);
  }
  // Only packets hit in the step before hold anchors. The others are not read, which saves memory
  // traffic.
  const auto [begin, end] = scratch.packets_in(range);
  for (std::size_t i = begin; i < end; ++i) {
    if (scratch.hit_before[i] != 0 && patch.hit_bits[i] == 0) patch.is_anchored[i] = 0;
  }
}

/// Makes an entry in `PatchScratch::touched`, without its pair, for every shape that was hit.
template <Scalar S>
void find_touched(const SensorPatch<S>& patch, PatchScratch<S>& scratch, std::uint32_t only_tag) {
  scratch.touched.clear();
  for (const std::uint32_t number : scratch.near) {
    std::uint32_t rest = patch.hit_bits[number];
    if (rest == 0) continue;
    if (only_tag != no_index) {
      scratch.touched.push_back({only_tag, 0});
      return;
    }
    const std::uint32_t* tags = scratch.hits.tag.data() + number * packet_size;
    for (const TouchedShape& shape : scratch.touched) {
      rest &= ~std::uint32_t(equal_lanes(tags, shape.tag));
      if (rest == 0) break;
    }
    while (rest != 0) {
      const std::uint32_t tag = tags[std::countr_zero(rest)];
      rest &= ~std::uint32_t(equal_lanes(tags, tag));
      scratch.touched.push_back({tag, 0});
    }
  }
}

/// Lanes of a packet that hit a pair's body.
template <Scalar S>
[[nodiscard]] LaneBits hit_mask(const SensorPatch<S>& patch, const PatchScratch<S>& scratch,
                                std::size_t number, std::uint32_t pair) {
  const LaneBits hit = patch.hit_bits[number];
  if (hit == 0) return hit;
  std::uint32_t of_pair = 0;
  for (const TouchedShape& shape : scratch.touched) {
    if (shape.pair != pair) continue;
    of_pair |= equal_lanes(scratch.hits.tag.data() + number * packet_size, shape.tag);
  }
  return static_cast<LaneBits>(hit & of_pair);
}

/// Finds which near packets belong to a pair. Reserves their contacts from contact `first` on.
/// @return One behind the last of them.
template <Scalar S>
std::uint32_t place_contacts(const SensorPatch<S>& patch, PatchScratch<S>& scratch,
                             std::uint32_t pair, std::uint32_t first) {
  const bool is_only = scratch.pairs.size() == 1;
  const std::size_t range = packets_per_range(scratch.near.size());
  std::uint32_t next = first;
  for (std::size_t from = 0, number = 0; from < scratch.near.size(); from += range) {
    scratch.range_contacts[number++] = next;
    const std::size_t to = std::min(scratch.near.size(), from + range);
    for (std::size_t k = from; k < to; ++k) {
      const std::uint32_t packet = scratch.near[k];
      const LaneBits hit =
          is_only ? patch.hit_bits[packet] : hit_mask(patch, scratch, packet, pair);
      scratch.pair_bits[k] = hit;
      next += hit != 0 ? 1u : 0u;
    }
  }
  // Existing entries stay as they are, which costs nothing.
  if (scratch.contacts.size() < next) scratch.contacts.resize(next);
  return next;
}

/// Sums over the contacts of a pair, lane by lane, filled while they are made.
template <Scalar S>
struct ContactSums {
  using T = Pack<S>;
  /// [-] Contacts.
  std::uint32_t count = 0;
  Pack3<S> point = zero_vector<T>();
  T bristle = S(0), viscous = S(0);
  T tangential = S(0), tangential_second = S(0);
  Pack3<S> tangential_first = zero_vector<T>();
  T normal = S(0), normal_second = S(0);
  Pack3<S> normal_first = zero_vector<T>();
  /// Explicit impulses, about A's centre of mass.
  Pack3<S> impulse = zero_vector<T>();
  Pack3<S> impulse_moment = zero_vector<T>();

  ContactSums& operator+=(const ContactSums& more) {
    count += more.count;
    point += more.point;
    bristle += more.bristle;
    viscous += more.viscous;
    tangential += more.tangential;
    tangential_second += more.tangential_second;
    tangential_first += more.tangential_first;
    normal += more.normal;
    normal_second += more.normal_second;
    normal_first += more.normal_first;
    impulse += more.impulse;
    impulse_moment += more.impulse_moment;
    return *this;
  }

  /// [N s, N m s] Sum of the applied impulses on B about the arm `center`, A's axes.
  [[nodiscard]] Wrench<S> applied(const Vec3<S>& center) const {
    return Wrench<S>{sum_of_lanes(impulse), sum_of_lanes(impulse_moment)}.shifted(center);
  }
  [[nodiscard]] PairStiffness<S> stiffness() const {
    return {sum_of_lanes(bristle),           sum_of_lanes(viscous),
            sum_of_lanes(tangential),        sum_of_lanes(normal),
            sum_of_lanes(tangential_first),  sum_of_lanes(normal_first),
            sum_of_lanes(tangential_second), sum_of_lanes(normal_second)};
  }
};

/// Adds the impulses of a pack of contacts at the start of a step to its packet and to the sums.
template <Scalar S>
BRISTLE_FORCE_INLINE void apply_impulses(ContactPacket<S>& packet, std::size_t at,
                                         const SensorParameters<Pack<S>>& p,
                                         const LawOptions& options,
                                         const SensorContact<Pack<S>>& contact,
                                         const Pack3<S>& stretch, const Pack3<S>& point,
                                         const Mask<S>& is_in_contact, S dt, Pack3<S>& sum,
                                         Pack3<S>& moment_sum) {
  using T = Pack<S>;
  const SensorForce<T> force = sensor_force<T>(p, options, contact, stretch, dt);
  const Pack3<S> impulse = select(is_in_contact, T(dt) * force.total(), zero_vector<T>());
  store_pack(packet.normal_impulse, at, select(is_in_contact, T(dt) * force.normal, T(S(0))));
  store_pack(packet.impulse, at, impulse);
  sum += impulse;
  moment_sum += cross(point, impulse);
}

/// Makes contacts from the hits of some packets of one patch on one body.
template <Scalar S>
class ContactMaker {
 public:
  using T = Pack<S>;

  /// @param first  [-] Index of the first contact.
  ContactMaker(SensorPatch<S>& patch, PatchScratch<S>& scratch, const PatchPair<S>& pair,
               BodyId id_b, const LaneParameters<S>& parameters, const CollectDef<S>& def,
               std::uint32_t first)
      : patch_(patch),
        hits_(scratch.hits),
        next_(scratch.contacts.data() + first),
        parameters_(parameters),
        options_(patch.def.options),
        pose_(pair.pose),
        linear_(broadcast<T>(pair.start_motion.linear)),
        angular_(broadcast<T>(pair.start_motion.angular)),
        middle_(broadcast<T>(patch.geometry->box.center())),
        id_b_(id_b),
        dt_(def.dt),
        measures_lambda_(def.measures_lambda),
        applies_(is_explicit(patch.def)) {}

  /// Returns whether a patch's impulses are applied here.
  [[nodiscard]] static bool is_explicit(const PatchDef<S>& def) {
    return def.integration == Integration::explicit_ && def.options.law == Law::paper;
  }

  /// Adds contacts for the lanes `hit` of a packet that meet the body at more than a grazing angle.
  BRISTLE_FORCE_INLINE void add_packet(std::size_t number, LaneBits hit) {
    const RayPacket<S>& rays = patch_.geometry->packets[number];
    BristlePacket<S>& bristles = patch_.bristles[number];
    ContactPacket<S>& out = *next_++;
    out.begin(static_cast<std::uint32_t>(number));
    // A sensor without a hit lets go.
    LaneBits& is_anchored = patch_.is_anchored[number];
    const auto was_anchored = static_cast<LaneBits>(is_anchored & patch_.hit_bits[number]);
    BodyId* bodies = patch_.readings.body.data() + number * packet_size;
    const LaneBits anchored =
        was_anchored == 0 ? LaneBits(0)
                          : static_cast<LaneBits>(was_anchored & equal_lanes(bodies, id_b_));
    for (std::size_t at = 0; at < packet_size; at += lanes<S>) {
      if (pack_bits<S>(hit, at) != 0) add_pack(rays, bristles, out, at, hit, anchored);
    }
    // AMBF's law anchors later, with the impulses.
    const LaneBits fresh =
        options_.law == Law::ambf
            ? LaneBits(0)
            : static_cast<LaneBits>(out.is_in_contact & ~std::uint32_t(anchored));
    is_anchored = static_cast<LaneBits>((was_anchored & (~hit | out.is_in_contact)) | fresh);
    for (std::uint32_t rest = fresh; rest != 0; rest &= rest - 1) {
      bodies[std::countr_zero(rest)] = id_b_;
    }
    sums_.count += static_cast<std::uint32_t>(std::popcount(out.is_in_range));
  }

  [[nodiscard]] const ContactSums<S>& sums() const { return sums_; }

 private:
  BRISTLE_FORCE_INLINE void add_pack(const RayPacket<S>& rays, BristlePacket<S>& bristles,
                                     ContactPacket<S>& out, std::size_t at, LaneBits hit,
                                     LaneBits anchored) {
    const TouchPack<S> touch(hits_, rays, out.packet, at, hit, true);
    SensorParameters<T> scratch;
    const SensorParameters<T>& p = parameters_(out.packet, at, scratch);
    const Mask<S> is_in_range = touch.is_in_range;
    const Mask<S> is_in_contact = is_in_range & (touch.depth > T(0));
    const Pack3<S> n = touch.n, g = touch.g, point = touch.point;
    const T depth = touch.depth, inverse_length = touch.inverse_length;
    const Pack3<S> velocity = linear_ + cross(angular_, point);
    const T force =
        select(is_in_contact, normal_force(p, depth, T(dot(g, velocity) * inverse_length)), T(0));
    store_mask(out.is_in_range, at, is_in_range);
    store_mask(out.is_in_contact, at, is_in_contact);
    if (options_.law == Law::paper) {
      // Most bristles keep their anchor. Anchoring is a call that reloads its operands: inlined, it
      // would push this loop's values out of the registers.
      const Anchor<T> anchor{load_pack(bristles.anchor_a, at), load_pack(bristles.anchor_b, at)};
      Pack3<S> stretch = anchor_stretch<T>(anchor, pose_, n);
      const T sigma = p.breakaway_distance;
      const Mask<S> is_kept = load_mask<S>(anchored, at) & (dot(stretch, stretch) <= sigma * sigma);
      const bool is_any_moved = any(is_in_contact & !is_kept);
      // With the impulses applied here, nothing else reads it.
      Row3<S>& row = applies_ ? stretch_ : out.stretch;
      if (!applies_ || is_any_moved) store_pack(row, at, stretch);
      if (is_any_moved) {
        anchor_anew(rays, bristles, out, at, anchored, sigma, row);
        stretch = load_pack(row, at);
      }
      if (applies_) {
        apply_impulses<S>(out, at, p, options_, {depth, inverse_length, n, g, velocity}, stretch,
                          point, is_in_contact, dt_, sums_.impulse, sums_.impulse_moment);
      }
    }
    sums_.point += select(is_in_range, point, zero_vector<T>());
    if (!applies_ || measures_lambda_) {
      add_sums(p, point, depth, force, inverse_length, is_in_range, is_in_contact);
    }
  }

  /// Advances the bristles of the lanes in contact. Leaves the other lanes alone.
  BRISTLE_NOINLINE void anchor_anew(const RayPacket<S>& rays, BristlePacket<S>& bristles,
                                    ContactPacket<S>& out, std::size_t at, LaneBits anchored,
                                    const T& sigma, Row3<S>& row) const {
    Anchor<T> anchor{load_pack(bristles.anchor_a, at), load_pack(bristles.anchor_b, at)};
    const Mask<S> is_in_contact = load_mask<S>(out.is_in_contact, at);
    const T distance = distances_of(hits_, out.packet * packet_size + at, is_in_contact);
    const Pack3<S> point = load_pack(rays.start, at) + distance * load_pack(rays.direction, at);
    Mask<S> did_slip;
    // Lanes out of contact keep their anchor at any stretch.
    Pack3<S> stretch = load_pack(row, at);
    anchor_where_needed<T>(anchor, load_mask<S>(anchored, at) | !is_in_contact, stretch, pose_,
                           point, select(is_in_contact, sigma, T(infinity<S>)), options_.reset,
                           did_slip);
    store_pack(row, at, stretch);
    store_mask(out.is_slipping, at, did_slip);
    store_pack(bristles.anchor_a, at, anchor.q_A);
    store_pack(bristles.anchor_b, at, anchor.q_B);
  }

  BRISTLE_FORCE_INLINE void add_sums(const SensorParameters<T>& p, const Pack3<S>& point,
                                     const T& depth, const T& force, const T& inverse_length,
                                     const Mask<S>& is_in_range, const Mask<S>& is_in_contact) {
    const T k_t = select(is_in_contact, bristle_stiffness(p, options_.scaling, force, depth), T(0));
    const T c_t = select(is_in_contact, p.sliding_friction, T(0));
    sums_.bristle += k_t;
    sums_.viscous += c_t;
    if (!measures_lambda_) return;
    const T tangential = T(dt_ * dt_) * k_t + T(S(2) * dt_) * c_t;
    const T normal = select(
        is_in_range,
        (T(dt_ * dt_) * p.normal_stiffness + T(S(2) * dt_) * p.normal_damping) * inverse_length,
        T(0));
    const Pack3<S> arm = point - middle_;
    const T arm2 = dot(arm, arm);
    sums_.tangential += tangential;
    sums_.tangential_first += tangential * arm;
    sums_.tangential_second += tangential * arm2;
    sums_.normal += normal;
    sums_.normal_first += normal * arm;
    sums_.normal_second += normal * arm2;
  }

  SensorPatch<S>& patch_;
  const RayHits<S>& hits_;
  ContactPacket<S>* next_;
  const LaneParameters<S>& parameters_;
  const LawOptions options_;
  const PairPose<S> pose_;
  const Pack3<S> linear_, angular_, middle_;
  const BodyId id_b_;
  const S dt_;
  const bool measures_lambda_;
  const bool applies_;
  ContactSums<S> sums_{};
  alignas(64) Row3<S> stretch_;
};

/// [m/s, rad/s] Motion of A relative to B, about A's centre of mass, in A's axes.
template <Scalar S>
[[nodiscard]] Twist<S> motion_between(const Body<S>& A, const Body<S>& B, const Mat3<S>& R_WA) {
  const Vec3<S> p_AB_W = B.center_pose.translation - A.center_pose.translation;
  const Mat3<S> R_AW = transposed(R_WA);
  return {R_AW * (A.twist.linear - B.twist.at(-p_AB_W)),
          R_AW * (A.twist.angular - B.twist.angular)};
}

/// Makes the contacts of pair `index`, from contact `first` on, and measures them.
/// @return One behind the last contact.
template <Scalar S>
std::uint32_t meet_body(SensorPatch<S>& patch, PatchScratch<S>& scratch, std::uint32_t index,
                        const Body<S>& A, const TouchedBody<S>& B, const CollectDef<S>& def,
                        std::uint32_t first, const ParallelFor& parallel_for) {
  PatchPair<S>& pair = scratch.pairs[index];
  pair.R_WA = A.center_pose.rotation_matrix();
  pair.pose = pair_pose(A.center_pose, B.body->center_pose);
  const Vec3<S> p_AB_W = B.body->center_pose.translation - A.center_pose.translation;
  pair.start_motion = motion_between(A, *B.body, pair.R_WA);
  const std::uint32_t end = place_contacts(patch, scratch, index, first);
  const std::size_t range = packets_per_range(scratch.near.size());
  using Maker = ContactMaker<S>;
  const LaneParameters<S> parameters(patch.def);
  const auto meet = [&](std::size_t from, std::size_t to, ContactSums<S>& sums) {
    Maker maker(patch, scratch, pair, B.id, parameters, def, scratch.range_contacts[from / range]);
    for (std::size_t k = from; k < to; ++k) {
      if (scratch.pair_bits[k] != 0) maker.add_packet(scratch.near[k], scratch.pair_bits[k]);
    }
    sums = maker.sums();
  };
  const auto sums = sum_in_ranges<ContactSums<S>>(scratch.near.size(), range,
                                                  chosen::fewest_shared_ranges, parallel_for, meet);
  pair.stiffness = sums.stiffness();
  // Moments are smallest about the middle of the contacts.
  pair.center = sum_of_lanes(sums.point) / S(std::max(sums.count, 1u));
  pair.is_applied = Maker::is_explicit(patch.def);
  pair.applied = sums.applied(pair.center);
  // A body met only at grazing angles does not count.
  pair.first = first;
  pair.count = sums.count > 0 ? end - first : 0;
  pair.arm_a = pair.R_WA * pair.center;
  pair.arm_b = pair.arm_a - p_AB_W;
  return end;
}

template <Scalar S, typename FindBody>
void collect_contacts(SensorPatch<S>& patch, PatchScratch<S>& scratch, const Body<S>& A,
                      FindBody&& find, const CollectDef<S>& def, const ParallelFor& parallel_for) {
  scratch.pairs.clear();
  patch.sensed.clear();
  // No hits to collect, and no anchor to release.
  if (scratch.near.empty() && !patch.has_hits) return;
  if (!def.knows_hit_mask) {
    begin_hit_mask(patch, scratch);
    find_hit_mask(patch, scratch, RayRange{});
  }
  find_touched(patch, scratch, def.only_tag);
  for (TouchedShape& shape : scratch.touched) {
    const std::uint32_t slot = find(shape.tag).id.index;
    while (shape.pair < scratch.pairs.size() && scratch.pairs[shape.pair].body_b != slot)
      ++shape.pair;
    if (shape.pair == scratch.pairs.size()) scratch.pairs.emplace_back().body_b = slot;
  }
  std::uint32_t contacts = 0;
  for (std::uint32_t index = 0; index < scratch.pairs.size(); ++index) {
    for (const TouchedShape& shape : scratch.touched) {
      if (shape.pair != index) continue;
      contacts = meet_body(patch, scratch, index, A, find(shape.tag), def, contacts, parallel_for);
      break;
    }
  }
  scratch.contacts.resize(contacts);
  patch.has_hits = contacts > 0;
  for (const PatchPair<S>& pair : scratch.pairs) {
    if (pair.count > 0) patch.sensed.push_back({pair.body_b, pair.pose});
  }
}

}  // namespace bristle::inline BRISTLE_ABI::detail
