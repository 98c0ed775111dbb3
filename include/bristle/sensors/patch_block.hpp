/// @file
/// The implicit patch: all sensors in contact with one body as one soft 6x6 constraint.
///
/// The impulse of a sensor is an affine function of the velocity at the end of the step. All
/// sensors see the same relative rigid motion. So their sum is one 6x6 matrix and one 6-vector,
/// whatever their number. Sensors may change state within the step: come into contact, let go,
/// slip. A few passes at most linearise them anew around the last solution. docs/sensors.md derives
/// every line and numbers the equations. Threads of `parallel_for` share sweeps over the contacts
/// of a large patch, with the same bits for any number of them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/parallel.hpp>
#include <bristle/dynamics/solver/soft_block.hpp>
#include <bristle/sensors/lane_parameters.hpp>
#include <bristle/sensors/linear_model.hpp>
#include <bristle/sensors/patch.hpp>
#include <bristle/sensors/patch_scratch.hpp>
#include <bristle/sensors/patch_touch.hpp>
#include <bristle/sensors/sensor_constants.hpp>
#include <bristle/sensors/solve_passes.hpp>

#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// Sets the weights of the implicit scheme from x = w (dt^2 sum k_t + dt sum mu_V). Soft bristles
/// get a nearly conservative scheme, fourth-order in phase; stiff ones get implicit Euler.
/// @param w  [1/kg] Mobility of the pair at c: a third of the trace of its linear part.
template <Scalar S>
void set_scheme(PatchPair<S>& pair, S bristle_sum, S viscous_sum, S w, S dt);

/// Linearises all contacts of a pair for the first pass, around the motion at the start of the
/// step. Sums their models.
template <Scalar S>
void start_linearisation(const SensorPatch<S>& patch, const PatchScratch<S>& scratch,
                         PatchPair<S>& pair, S dt, const ParallelFor& parallel_for = serial_for);

/// Impulse of a pair at a motion.
template <Scalar S>
struct PairResponse {
  /// [N s, N m s] Sum of its impulses on B about c.
  Wrench<S> impulse{};
  /// True if its contacts left the state they were linearised for: another solve is needed.
  bool has_changed = false;
};

/// Evaluates all contact impulses at the solved motion. If a solve is left and any contact changed
/// or slips, it moves the linearisation there, which changes `matrix` and `offset`.
/// @param motion  u at the end of the step, as the solver found it.
template <Scalar S>
PairResponse<S> evaluate(const SensorPatch<S>& patch, PatchScratch<S>& scratch, PatchPair<S>& pair,
                         const Vec6<S>& motion, S dt, const SolvePass& pass,
                         const ParallelFor& parallel_for = serial_for);

/// Puts the sum of the linear models of a pair's contacts into its soft block.
template <Scalar S>
void fill_block(const PatchPair<S>& pair, SoftBlock<S>& block);

/// Clears a pair's contact impulses and slip states.
template <Scalar S>
void clear_impulses(PatchScratch<S>& scratch, const PatchPair<S>& pair);

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
void set_scheme(PatchPair<S>& pair, S bristle_sum, S viscous_sum, S w, S dt) {
  const S x = w * (dt * dt * bristle_sum + dt * viscous_sum);
  pair.alpha = x / (S(1) + x);
  pair.beta = (S(1) - pair.alpha) * (S(1) - pair.alpha) / S(12);
  pair.theta = (S(1) + pair.alpha) / S(2);
}

/// The contact packets of a pair.
template <typename Scratch, Scalar S>
[[nodiscard]] auto contacts_of(Scratch& scratch, const PatchPair<S>& pair) {
  return std::span(scratch.contacts).subspan(pair.first, pair.count);
}

/// Sums part(packets, sum) over contact packets, in ranges that threads may share.
template <typename Sum, typename Packet, typename Part>
[[nodiscard]] Sum sum_of_contacts(std::span<Packet> all, const ParallelFor& parallel_for,
                                  const Part& part) {
  return sum_in_ranges<Sum>(all.size(), packets_per_range(all.size()),
                            chosen::fewest_shared_ranges, parallel_for,
                            [&](std::size_t first, std::size_t end, Sum& sum) {
                              part(all.subspan(first, end - first), sum);
                            });
}

/// A motion of A relative to B, in A's axes, for all lanes.
template <Scalar S>
struct LaneMotion {
  Pack3<S> linear, angular;

  LaneMotion(const Vec3<S>& v, const Vec3<S>& w)
      : linear(Pack3<S>::all(v)), angular(Pack3<S>::all(w)) {}
  /// From u of a soft block, in the world's axes.
  LaneMotion(const PatchPair<S>& pair, const Vec6<S>& u)
      : LaneMotion(pair.R_WA.transpose() * first_half<S>(u),
                   pair.R_WA.transpose() * second_half<S>(u)) {}

  [[nodiscard]] BRISTLE_FORCE_INLINE Pack3<S> at(const Pack3<S>& rho) const {
    return velocity_at<Pack<S>>(linear, angular, rho);
  }
};

/// A wrench in lanes, in A's axes.
template <Scalar S>
struct LaneWrench {
  Pack3<S> force = zero_vector<Pack<S>>();
  Pack3<S> torque = zero_vector<Pack<S>>();

  LaneWrench& operator+=(const LaneWrench& more) {
    force += more.force;
    torque += more.torque;
    return *this;
  }
  /// Its sum in the world's axes.
  [[nodiscard]] Wrench<S> in_world(const PatchPair<S>& pair) const {
    return {pair.R_WA * sum_of_lanes(force), pair.R_WA * sum_of_lanes(torque)};
  }
};

/// Finds the geometry of the contacts of a pack, as far as it is known before the linearisation.
template <Scalar S>
BRISTLE_FORCE_INLINE void find_geometry(const RayHits<S>& hits, const RayPacket<S>& rays,
                                        const ContactPacket<S>& packet, std::size_t at,
                                        const Pack3<S>& center, PatchContact<Pack<S>>& c) {
  const TouchPack<S> touch(hits, rays, packet.packet, at, packet.is_in_range, false);
  c.n = touch.n;
  c.g = touch.g;
  c.rho = touch.point - center;
  c.depth = touch.depth;
  c.inverse_length = touch.inverse_length;
  c.stretch = load_pack(packet.stretch, at);
  c.is_in_contact = load_mask<S>(packet.is_in_contact, at);
}

/// Loads the states that the last pass found.
template <Scalar S>
BRISTLE_FORCE_INLINE void load_states(const ContactPacket<S>& packet, std::size_t at,
                                      PatchContact<Pack<S>>& c) {
  c.is_loaded = load_mask<S>(packet.is_loaded, at);
  c.is_slipping = load_mask<S>(packet.is_slipping, at);
  c.is_damping_slip = load_mask<S>(packet.is_damping_slip, at);
}

/// Loads the moved model and its force.
template <Scalar S>
BRISTLE_FORCE_INLINE void load_model(const ContactPacket<S>& packet, std::size_t at,
                                     PatchContact<Pack<S>>& c) {
  c.constant = load_pack(packet.constant, at);
  c.a_normal = load_pack(packet.a_normal, at);
  c.a_across = load_pack(packet.a_across, at);
  c.force = load_pack(packet.force, at);
  if (any(c.is_slipping)) {
    c.along = load_pack(packet.along, at);
    c.a_along = load_pack(packet.a_along, at);
  }
}
template <Scalar S>
BRISTLE_FORCE_INLINE void store_model(ContactPacket<S>& packet, std::size_t at,
                                      const PatchContact<Pack<S>>& c) {
  store_pack(packet.constant, at, c.constant);
  store_pack(packet.a_normal, at, c.a_normal);
  store_pack(packet.a_across, at, c.a_across);
  store_pack(packet.force, at, c.force);
  if (any(c.is_slipping)) {
    store_pack(packet.along, at, c.along);
    store_pack(packet.a_along, at, c.a_along);
  }
}

/// First model of the contacts of a pack, around the motion at the start of the step. `a_normal`
/// becomes 0 where a contact is not loaded, so the evaluation need not test.
template <Scalar S>
BRISTLE_FORCE_INLINE void linearise_at_start(const SensorParameters<Pack<S>>& p,
                                             const LawOptions& options, const PatchPair<S>& pair,
                                             const LaneMotion<S>& start, const Mask<S>& is_in_range,
                                             S dt, PatchContact<Pack<S>>& c) {
  using T = Pack<S>;
  c.start_velocity = start.at(c.rho);
  const T approach = dot(c.g, c.start_velocity);
  c.force =
      select(c.is_in_contact, normal_force(p, c.depth, T(approach * c.inverse_length)), T(S(0)));
  linearise_normal<T>(p, c, dt);
  c.is_loaded = is_in_range & (c.normal_constant + c.a_normal * approach > T(S(0)));
  c.normal_impulse = T(dt) * c.force;
  // Nothing slips yet. The mask is constant and empty, so the compiler drops the slip code.
  c.is_slipping = c.is_damping_slip = Mask<S>::from_bits(0);
  linearise<T>(p, options, pair, c, c.start_velocity, dt);
  c.a_normal = select(c.is_loaded, c.a_normal, T(S(0)));
}

/// Sum of the first models of some contacts.
template <Scalar S>
void sum_first_models(const SensorPatch<S>& patch, const RayHits<S>& hits, const PatchPair<S>& pair,
                      std::span<const ContactPacket<S>> packets,
                      const LaneParameters<S>& parameters, S dt, ModelSum<Pack<S>>& total) {
  using T = Pack<S>;
  const LawOptions options = patch.def.options;
  const PatchPair<S> scheme = pair;
  const LaneMotion<S> start(pair.start_motion.at(pair.center), pair.start_motion.angular);
  const Pack3<S> center = Pack3<S>::all(pair.center);
  ModelSum<T> sum;
  SensorParameters<T> scratch;
  for (const ContactPacket<S>& packet : packets) {
    const RayPacket<S>& rays = patch.geometry->packets[packet.packet];
    for (std::size_t at = 0; at < packet_size; at += lanes<S>) {
      if (pack_bits<S>(packet.is_in_range, at) == 0) continue;
      PatchContact<T> c;
      find_geometry(hits, rays, packet, at, center, c);
      linearise_at_start<S>(parameters(packet.packet, at, scratch), options, scheme, start,
                            load_mask<S>(packet.is_in_range, at), dt, c);
      sum.add(c);
    }
  }
  total = sum;
}

/// Input of a pass that evaluates and moves the models.
template <Scalar S>
struct PassDef {
  /// [m/s, rad/s] Solved u at the end of the step.
  Vec6<S> motion = zero<Vec6<S>>();
  /// [s] The step.
  S dt = S(0);
  /// [-] Solve that found it.
  SolvePass pass{};
};

/// Result of evaluating models.
template <Scalar S>
struct Evaluation {
  LaneWrench<S> impulse{};
  PassChange<Pack<S>> change{};

  Evaluation& operator+=(const Evaluation& more) {
    impulse += more.impulse;
    change += more.change;
    return *this;
  }
};

/// Impulse of the models of the contacts of a pack at the velocities v.
template <Scalar S>
BRISTLE_FORCE_INLINE void apply_model_impulses(const PatchContact<Pack<S>>& c, const Pack3<S>& v,
                                               ContactPacket<S>& packet, std::size_t at,
                                               LaneWrench<S>& sum) {
  using T = Pack<S>;
  Pack3<S> impulse = model_impulse<T>(c, v);
  T normal = select(c.is_loaded, dot(impulse, c.n), T(S(0)));
  const Mask<S> pulls = normal < T(S(0));
  if (any(pulls)) {
    // The passes ran out before these sensors separated. They must not pull.
    impulse = select(pulls, tangential<T>(impulse, c.n), impulse);
    normal = select(pulls, T(S(0)), normal);
  }
  store_pack(packet.impulse, at, impulse);
  store_pack(packet.normal_impulse, at, normal);
  sum.force += impulse;
  sum.torque += cross(c.rho, impulse);
}

/// Finds the states of the contacts of a pack at the velocities v.
template <Scalar S>
BRISTLE_FORCE_INLINE void find_changes(const SensorParameters<Pack<S>>& p, SlipReset reset,
                                       const PassDef<S>& def, const Pack3<S>& v,
                                       ContactPacket<S>& packet, std::size_t at,
                                       PatchContact<Pack<S>>& c, PassChange<Pack<S>>& change) {
  using T = Pack<S>;
  c.last_slip = zero_vector<T>();
  if (any(c.is_slipping)) c.last_slip = load_pack(packet.last_slip, at);
  linearise_normal<T>(p, c, def.dt);
  update_normal<T>(c, load_mask<S>(packet.is_in_range, at), v, def.dt, change);
  update_slip<T>(c, tangential<T>(v, c.n), p.breakaway_distance, reset, def.dt, def.pass.number,
                 def.pass.left == 1, change);
  store_mask(packet.is_loaded, at, c.is_loaded);
  if (any(c.is_slipping)) store_pack(packet.last_slip, at, c.last_slip);
  store_mask(packet.is_slipping, at, c.is_slipping);
  store_mask(packet.is_damping_slip, at, c.is_damping_slip);
}

/// Impulses and states of some contacts at the solved motion.
/// @tparam is_first  True if the models are the first ones, which are not kept.
template <bool is_first, Scalar S>
void evaluate(const SensorPatch<S>& patch, const RayHits<S>& hits, const PatchPair<S>& pair,
              std::span<ContactPacket<S>> packets, const LaneParameters<S>& parameters,
              const PassDef<S>& def, Evaluation<S>& total) {
  using T = Pack<S>;
  const LawOptions options = patch.def.options;
  const PatchPair<S> scheme = pair;
  const LaneMotion<S> start(pair.start_motion.at(pair.center), pair.start_motion.angular);
  const LaneMotion<S> found(pair, def.motion);
  const Pack3<S> center = Pack3<S>::all(pair.center);
  Evaluation<S> sum;
  SensorParameters<T> scratch;
  for (ContactPacket<S>& packet : packets) {
    const RayPacket<S>& rays = patch.geometry->packets[packet.packet];
    if constexpr (is_first) packet.is_slipping = 0;
    for (std::size_t at = 0; at < packet_size; at += lanes<S>) {
      if (pack_bits<S>(packet.is_in_range, at) == 0) continue;
      const SensorParameters<T>& p = parameters(packet.packet, at, scratch);
      PatchContact<T> c;
      find_geometry(hits, rays, packet, at, center, c);
      if constexpr (is_first) {
        linearise_at_start<S>(p, options, scheme, start, load_mask<S>(packet.is_in_range, at),
                              def.dt, c);
      } else {
        load_states(packet, at, c);
        load_model(packet, at, c);
      }
      const Pack3<S> v = found.at(c.rho);
      apply_model_impulses<S>(c, v, packet, at, sum.impulse);
      if (def.pass.left > 0) find_changes<S>(p, options.reset, def, v, packet, at, c, sum.change);
    }
  }
  total = sum;
}

/// Models around another motion, and their friction change.
template <Value T>
struct MovedModels {
  ModelSum<T> models;
  T friction_sum = ScalarOf<T>(0);
  T friction_change = ScalarOf<T>(0);

  MovedModels& operator+=(const MovedModels& more) {
    models += more.models;
    friction_sum += more.friction_sum;
    friction_change += more.friction_change;
    return *this;
  }
};

/// Models of some contacts around the solved motion.
/// @param lagged  [s] The step, or 0 for normal forces that have not settled.
template <Scalar S>
void linearise_at_motion(const SensorPatch<S>& patch, const RayHits<S>& hits,
                         const PatchPair<S>& pair, std::span<ContactPacket<S>> packets,
                         const LaneParameters<S>& parameters, const PassDef<S>& def, S lagged,
                         MovedModels<Pack<S>>& total) {
  using T = Pack<S>;
  const LawOptions options = patch.def.options;
  const S dt = def.dt;
  const LaneMotion<S> found(pair, def.motion);
  const PatchPair<S> scheme = pair;
  const LaneMotion<S> start(pair.start_motion.at(pair.center), pair.start_motion.angular);
  const Pack3<S> center = Pack3<S>::all(pair.center);
  MovedModels<T> sum;
  SensorParameters<T> scratch;
  for (ContactPacket<S>& packet : packets) {
    const RayPacket<S>& rays = patch.geometry->packets[packet.packet];
    for (std::size_t at = 0; at < packet_size; at += lanes<S>) {
      if (pack_bits<S>(packet.is_in_range, at) == 0) continue;
      PatchContact<T> c;
      find_geometry(hits, rays, packet, at, center, c);
      load_states(packet, at, c);
      const SensorParameters<T>& p = parameters(packet.packet, at, scratch);
      const Pack3<S> v = found.at(c.rho);
      c.start_velocity = start.at(c.rho);
      linearise_normal<T>(p, c, dt);
      c.force = force_at<T>(c, v, dt);
      c.normal_impulse = T(lagged) * c.force;
      linearise<T>(p, options, scheme, c, tangential<T>(v, c.n), dt);
      c.a_normal = select(c.is_loaded, c.a_normal, T(S(0)));
      sum.models.add(c);
      store_model(packet, at, c);
      const Mask<S> is_in_range = load_mask<S>(packet.is_in_range, at);
      const Pack3<S> before = tangential<T>(load_pack(packet.impulse, at), c.n);
      const Pack3<S> after = tangential<T>(model_impulse<T>(c, v), c.n);
      const Pack3<S> difference = after - before;
      sum.friction_change += select(is_in_range, sqrt(dot(difference, difference)), T(S(0)));
      sum.friction_sum += select(is_in_range, sqrt(dot(before, before)), T(S(0)));
    }
  }
  total = sum;
}

template <Scalar S>
void start_linearisation(const SensorPatch<S>& patch, const PatchScratch<S>& scratch,
                         PatchPair<S>& pair, S dt, const ParallelFor& parallel_for) {
  using Sum = ModelSum<Pack<S>>;
  pair.has_moved_models = false;
  const LaneParameters<S> parameters(patch.def);
  const Sum sum =
      sum_of_contacts<Sum>(contacts_of(scratch, pair), parallel_for, [&](auto packets, Sum& part) {
        sum_first_models<S>(patch, scratch.hits, pair, packets, parameters, dt, part);
      });
  sum.get(pair.matrix, pair.offset);
}

template <Scalar S>
PairResponse<S> evaluate(const SensorPatch<S>& patch, PatchScratch<S>& scratch, PatchPair<S>& pair,
                         const Vec6<S>& motion, S dt, const SolvePass& pass,
                         const ParallelFor& parallel_for) {
  // A change counts from a thousandth of the patch's load on: friction follows the normal force of
  // the pass before.
  const S negligible = S(chosen::negligible_pass_change);
  const PassDef<S> def{motion, dt, pass};
  const std::span<ContactPacket<S>> contacts = contacts_of(scratch, pair);
  using Evaluation = Evaluation<S>;
  using Moved = MovedModels<Pack<S>>;
  const LaneParameters<S> parameters(patch.def);
  const Evaluation found = sum_of_contacts<Evaluation>(
      contacts, parallel_for, [&](std::span<ContactPacket<S>> packets, Evaluation& part) {
        if (pair.has_moved_models) {
          evaluate<false, S>(patch, scratch.hits, pair, packets, parameters, def, part);
        } else {
          evaluate<true, S>(patch, scratch.hits, pair, packets, parameters, def, part);
        }
      });
  const Wrench<S> impulse = found.impulse.in_world(pair);
  const PassChange<Pack<S>>& change = found.change;
  const bool has_changed = change.did_switch || sum_of_lanes(change.force_change) >
                                                    negligible * sum_of_lanes(change.force_sum);
  if (!has_changed && !change.has_slip) return {impulse, false};

  // Normal forces that have not settled by the last pass point along the gradient, which adds no
  // energy. Along the ray they would use an impulse that was wrong in the pass before.
  const S lagged = pass.left == 1 && has_changed ? S(0) : dt;
  const Moved moved = sum_of_contacts<Moved>(
      contacts, parallel_for, [&](std::span<ContactPacket<S>> packets, Moved& part) {
        linearise_at_motion<S>(patch, scratch.hits, pair, packets, parameters, def, lagged, part);
      });
  pair.has_moved_models = true;
  moved.models.get(pair.matrix, pair.offset);
  return {impulse, has_changed || sum_of_lanes(moved.friction_change) >
                                      negligible * sum_of_lanes(moved.friction_sum)};
}

template <Scalar S>
void fill_block(const PatchPair<S>& pair, SoftBlock<S>& block) {
  const Mat3<S>& R = pair.R_WA;
  const Mat3<S> top = R * quarter<0, 3, S>(pair.matrix) * R.transpose();
  set_quarter<0, 0, S>(block.matrix, rotated<S>(R, quarter<0, 0, S>(pair.matrix)));
  set_quarter<0, 3, S>(block.matrix, top);
  set_quarter<3, 0, S>(block.matrix, transposed(top));
  set_quarter<3, 3, S>(block.matrix, rotated<S>(R, quarter<3, 3, S>(pair.matrix)));
  block.offset = stacked<S>(R * first_half<S>(pair.offset), R * second_half<S>(pair.offset));
}

template <Scalar S>
void clear_impulses(PatchScratch<S>& scratch, const PatchPair<S>& pair) {
  for (ContactPacket<S>& packet : contacts_of(scratch, pair)) {
    packet.impulse = {};
    packet.normal_impulse = {};
    packet.is_slipping = 0;
  }
}

}  // namespace bristle::inline BRISTLE_ABI::detail
