/// @file
/// The implicit patch: all sensors that touch one body as one soft 6x6 constraint.
///
/// Every sensor's impulse is made an affine function of the velocity at the end of the step; since
/// all of them see the same relative motion of two rigid bodies, their sum is one 6x6 matrix and
/// one 6-vector, whatever their number. Sensors that change state within the step (touch, let go,
/// slip) are linearised anew around the last solution, a few passes at most. docs/sensors.md
/// derives every line; the equations are numbered there. Sweeps over the contacts of a large patch
/// are shared by the threads of `parallel_for`, with the same bits for any number of them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/parallel.hpp>
#include <bristle/dynamics/soft_block.hpp>
#include <bristle/sensors/lane_parameters.hpp>
#include <bristle/sensors/linear_model.hpp>
#include <bristle/sensors/patch.hpp>

#include <span>

namespace bristle {

/// Sets the weights of the implicit scheme from x = w (dt^2 sum k_t + dt sum mu_V): for soft
/// bristles nearly conservative and fourth-order in phase, for stiff ones implicit Euler.
/// @param w  [1/kg] Mobility of the pair at c: a third of the trace of its linear part.
template <Scalar S>
void set_scheme(PatchPair<S>& pair, S bristle_sum, S viscous_sum, S w, S dt);

/// Linearises all contacts of a pair for the first pass, around the motion at the start of the
/// step, and sums their models.
template <Scalar S>
void start_linearisation(SensorPatch<S>& patch, PatchPair<S>& pair, S dt,
                         const ParallelFor& parallel_for = serial_for);

/// Moves the linearisation to the motion that was found, after `evaluate_impulses` there.
/// @param motion        u at the end of the step, as the solver found it.
/// @param pass          Number of the solve that found it, from 1.
/// @param is_last_pass  Whether there is one more solve only.
/// @return Whether anything changed that matters: another solve is needed.
template <Scalar S>
bool update_linearisation(SensorPatch<S>& patch, PatchPair<S>& pair, const Vec6<S>& motion, S dt,
                          int pass, bool is_last_pass,
                          const ParallelFor& parallel_for = serial_for);

/// Puts the sum of the linear models of a pair's contacts into its soft block.
template <Scalar S>
void fill_block(const PatchPair<S>& pair, SoftBlock<S>& block);

/// Takes back what the contacts of a pair gave.
template <Scalar S>
void clear_impulses(SensorPatch<S>& patch, const PatchPair<S>& pair);

/// Evaluates the impulse of every contact at the motion that was found.
/// @return [N s, N m s] Their sum on B about c.
template <Scalar S>
Wrench<S> evaluate_impulses(SensorPatch<S>& patch, const PatchPair<S>& pair, const Vec6<S>& motion,
                            const ParallelFor& parallel_for = serial_for);

// Implementation -----------------------------------------------------------------------------------

template <Scalar S>
void set_scheme(PatchPair<S>& pair, S bristle_sum, S viscous_sum, S w, S dt) {
  const S x = w * (dt * dt * bristle_sum + dt * viscous_sum);
  pair.alpha = x / (S(1) + x);
  pair.beta = (S(1) - pair.alpha) * (S(1) - pair.alpha) / S(12);
  pair.theta = (S(1) + pair.alpha) / S(2);
}

namespace detail {

/// The contact tiles of a pair.
template <Scalar S>
[[nodiscard]] std::span<ContactTile<S>> contacts_of(SensorPatch<S>& patch,
                                                    const PatchPair<S>& pair) {
  return std::span(patch.contacts).subspan(pair.first, pair.count);
}

/// Adds up part(tiles, sum) over a pair's contact tiles, in slices that threads may share.
template <typename Sum, Scalar S, typename Part>
[[nodiscard]] Sum sum_of_contacts(SensorPatch<S>& patch, const PatchPair<S>& pair,
                                  const ParallelFor& parallel_for, const Part& part) {
  const std::span<ContactTile<S>> all = contacts_of(patch, pair);
  return sum_in_slices<Sum>(all.size(), slice_tiles, fewest_shared_slices, parallel_for,
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
      : LaneMotion(pair.R_WA.transpose() * u.template head<3>(),
                   pair.R_WA.transpose() * u.template tail<3>()) {}

  [[nodiscard]] BRISTLE_LANES Pack3<S> at(const Pack3<S>& rho) const {
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
    return {product<S>(pair.R_WA, sum_of_lanes(force)),
            product<S>(pair.R_WA, sum_of_lanes(torque))};
  }
};

/// Loads what is known of the contacts of a pack before anything is linearised.
template <Scalar S>
BRISTLE_LANES void load_geometry(const SensorTile<S>& sensors, const ContactTile<S>& tile,
                                 std::size_t at, const Pack3<S>& center, PatchContact<Pack<S>>& c) {
  c.n = load_pack(sensors.direction, at);
  c.inverse_length = load_pack(sensors.inverse_length, at);
  c.g = load_pack(tile.g, at);
  c.rho = load_pack(tile.point, at) - center;
  c.stretch = load_pack(tile.stretch, at);
  c.depth = load_pack(tile.depth, at);
  c.force = load_pack(tile.force, at);
  c.is_touching = load_mask<S>(tile.is_touching, at);
}

/// Loads what the last pass found them to do.
template <Scalar S>
BRISTLE_LANES void load_states(const ContactTile<S>& tile, std::size_t at,
                               PatchContact<Pack<S>>& c) {
  c.is_pushing = load_mask<S>(tile.is_pushing, at);
  c.is_slipping = load_mask<S>(tile.is_slipping, at);
  c.is_damping_slip = load_mask<S>(tile.is_damping_slip, at);
}

/// Keeps the linear model of the contacts of a pack and adds it to the sum. `a_normal` is stored as
/// 0 where nothing pushes, so that the evaluation need not ask.
template <Scalar S>
BRISTLE_LANES void store_model(ContactTile<S>& tile, std::size_t at, PatchContact<Pack<S>>& c,
                               ModelSum<Pack<S>>& sum) {
  c.a_normal = select(c.is_pushing, c.a_normal, Pack<S>(S(0)));
  store_mask(tile.is_pushing, at, c.is_pushing);
  store_pack(tile.constant, at, c.constant);
  store_pack(tile.a_normal, at, c.a_normal);
  store_pack(tile.a_across, at, c.a_across);
  sum.add(c);
}

/// First models of some contacts, around the motion at the start of the step.
template <Scalar S, typename Parameters>
void linearise_at_start(SensorPatch<S>& patch, const PatchPair<S>& pair,
                        std::span<ContactTile<S>> tiles, const Parameters& parameters, S dt,
                        ModelSum<Pack<S>>& total) {
  using T = Pack<S>;
  const LawOptions options = patch.def.options;
  const PatchPair<S> scheme = pair;
  const LaneMotion<S> start(pair.start_motion.at(pair.center), pair.start_motion.angular);
  const Pack3<S> center = Pack3<S>::all(pair.center);
  ModelSum<T> sum;
  for (ContactTile<S>& tile : tiles) {
    const SensorTile<S>& sensors = patch.tiles[tile.tile];
    tile.is_slipping = 0;
    for (std::size_t at = 0; at < tile_size; at += lanes<S>) {
      if (pack_bits<S>(tile.is_met, at) == 0) continue;
      PatchContact<T> c;
      load_geometry(sensors, tile, at, center, c);
      const SensorParameters<T>& p = parameters(tile.tile, at);
      c.start_velocity = start.at(c.rho);
      linearise_normal<T>(p, c, dt);
      c.is_pushing = load_mask<S>(tile.is_met, at) &
                     (c.normal_constant + c.a_normal * dot(c.g, c.start_velocity) > T(S(0)));
      c.normal_impulse = T(dt) * c.force;
      // Nothing slips yet: the mask is empty, which the compiler sees.
      c.is_slipping = c.is_damping_slip = Mask<S>::from_bits(0);
      linearise<T>(p, options, scheme, c, c.start_velocity, dt);
      store_model(tile, at, c, sum);
    }
  }
  total = sum;
}

/// What a pass knows when it moves the linearisation.
template <Scalar S>
struct PassDef {
  /// [m/s, rad/s] u at the end of the step, as the solver found it.
  Vec6<S> motion = Vec6<S>::Zero();
  /// [s] The step.
  S dt = S(0);
  /// [-] Number of the solve that found it, from 1.
  int pass = 0;
  /// [-] Whether there is one more solve only.
  bool is_last = false;
};

/// Finds out what some contacts do at the motion that was found.
template <Scalar S, typename Parameters>
void find_changes(SensorPatch<S>& patch, const PatchPair<S>& pair, std::span<ContactTile<S>> tiles,
                  const Parameters& parameters, const PassDef<S>& def, PassChange<Pack<S>>& total) {
  using T = Pack<S>;
  const LawOptions options = patch.def.options;
  const S dt = def.dt;
  const LaneMotion<S> found(pair, def.motion);
  const Pack3<S> center = Pack3<S>::all(pair.center);
  PassChange<T> change;
  for (ContactTile<S>& tile : tiles) {
    const SensorTile<S>& sensors = patch.tiles[tile.tile];
    for (std::size_t at = 0; at < tile_size; at += lanes<S>) {
      if (pack_bits<S>(tile.is_met, at) == 0) continue;
      PatchContact<T> c;
      load_geometry(sensors, tile, at, center, c);
      load_states(tile, at, c);
      if (any(c.is_slipping)) c.last_slip = load_pack(tile.last_slip, at);
      const SensorParameters<T>& p = parameters(tile.tile, at);
      const Pack3<S> v = found.at(c.rho);
      linearise_normal<T>(p, c, dt);
      update_normal<T>(c, load_mask<S>(tile.is_met, at), v, dt, change);
      update_slip<T>(c, tangential<T>(v, c.n), p.breakaway_distance, options.reset, dt, def.pass,
                     def.is_last, change);
      store_pack(tile.force, at, c.force);
      store_mask(tile.is_pushing, at, c.is_pushing);
      if (any(c.is_slipping)) store_pack(tile.last_slip, at, c.last_slip);
      store_mask(tile.is_slipping, at, c.is_slipping);
      store_mask(tile.is_damping_slip, at, c.is_damping_slip);
    }
  }
  total = change;
}

/// Models around another motion, and by how much they change the friction there.
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

/// Models of some contacts around the motion that was found.
/// @param lagged  [s] The step, or 0 for normal forces that have not settled.
template <Scalar S, typename Parameters>
void linearise_at_motion(SensorPatch<S>& patch, const PatchPair<S>& pair,
                         std::span<ContactTile<S>> tiles, const Parameters& parameters,
                         const PassDef<S>& def, S lagged, MovedModels<Pack<S>>& total) {
  using T = Pack<S>;
  const LawOptions options = patch.def.options;
  const S dt = def.dt;
  const LaneMotion<S> found(pair, def.motion);
  const PatchPair<S> scheme = pair;
  const LaneMotion<S> start(pair.start_motion.at(pair.center), pair.start_motion.angular);
  const Pack3<S> center = Pack3<S>::all(pair.center);
  MovedModels<T> sum;
  for (ContactTile<S>& tile : tiles) {
    const SensorTile<S>& sensors = patch.tiles[tile.tile];
    for (std::size_t at = 0; at < tile_size; at += lanes<S>) {
      if (pack_bits<S>(tile.is_met, at) == 0) continue;
      PatchContact<T> c;
      load_geometry(sensors, tile, at, center, c);
      load_states(tile, at, c);
      const SensorParameters<T>& p = parameters(tile.tile, at);
      const Pack3<S> v = found.at(c.rho);
      c.start_velocity = start.at(c.rho);
      c.normal_impulse = T(lagged) * c.force;
      linearise_normal<T>(p, c, dt);
      linearise<T>(p, options, scheme, c, tangential<T>(v, c.n), dt);
      store_model(tile, at, c, sum.models);
      if (any(c.is_slipping)) {
        store_pack(tile.along, at, c.along);
        store_pack(tile.a_along, at, c.a_along);
      }
      const Mask<S> is_met = load_mask<S>(tile.is_met, at);
      const Pack3<S> before = tangential<T>(load_pack(tile.impulse, at), c.n);
      const Pack3<S> after = tangential<T>(model_impulse<T>(c, v), c.n);
      const Pack3<S> difference = after - before;
      sum.friction_change += select(is_met, sqrt(dot(difference, difference)), T(S(0)));
      sum.friction_sum += select(is_met, sqrt(dot(before, before)), T(S(0)));
    }
  }
  total = sum;
}

/// Impulses of some contacts at the motion that was found.
template <Scalar S>
void evaluate(SensorPatch<S>& patch, const PatchPair<S>& pair, std::span<ContactTile<S>> tiles,
              const Vec6<S>& motion, LaneWrench<S>& total) {
  using T = Pack<S>;
  const LaneMotion<S> found(pair, motion);
  const Pack3<S> center = Pack3<S>::all(pair.center);
  LaneWrench<S> sum;
  for (ContactTile<S>& tile : tiles) {
    const SensorTile<S>& sensors = patch.tiles[tile.tile];
    for (std::size_t at = 0; at < tile_size; at += lanes<S>) {
      if (pack_bits<S>(tile.is_met, at) == 0) continue;
      PatchContact<T> c;
      c.n = load_pack(sensors.direction, at);
      c.g = load_pack(tile.g, at);
      c.rho = load_pack(tile.point, at) - center;
      c.constant = load_pack(tile.constant, at);
      c.a_normal = load_pack(tile.a_normal, at);
      c.a_across = load_pack(tile.a_across, at);
      c.is_slipping = load_mask<S>(tile.is_slipping, at);
      if (any(c.is_slipping)) {
        c.along = load_pack(tile.along, at);
        c.a_along = load_pack(tile.a_along, at);
      }
      Pack3<S> impulse = model_impulse<T>(c, found.at(c.rho));
      T normal = select(load_mask<S>(tile.is_pushing, at), dot(impulse, c.n), T(S(0)));
      const Mask<S> pulls = normal < T(S(0));
      if (any(pulls)) {
        // The passes ran out before these sensors were seen to part: they must not pull.
        impulse = select(pulls, tangential<T>(impulse, c.n), impulse);
        normal = select(pulls, T(S(0)), normal);
      }
      store_pack(tile.impulse, at, impulse);
      store_pack(tile.normal_impulse, at, normal);
      sum.force += impulse;
      sum.torque += cross(c.rho, impulse);
    }
  }
  total = sum;
}

}  // namespace detail

template <Scalar S>
void start_linearisation(SensorPatch<S>& patch, PatchPair<S>& pair, S dt,
                         const ParallelFor& parallel_for) {
  using Sum = detail::ModelSum<Pack<S>>;
  detail::with_parameters<S>(patch.def, [&](const auto& parameters) {
    const Sum sum = detail::sum_of_contacts<Sum>(
        patch, pair, parallel_for, [&](std::span<ContactTile<S>> tiles, Sum& part) {
          detail::linearise_at_start<S>(patch, pair, tiles, parameters, dt, part);
        });
    sum.get(pair.matrix, pair.offset);
  });
}

template <Scalar S>
bool update_linearisation(SensorPatch<S>& patch, PatchPair<S>& pair, const Vec6<S>& motion, S dt,
                          int pass, bool is_last_pass, const ParallelFor& parallel_for) {
  // Changes count when they reach a thousandth of what the patch carries: friction follows the
  // normal force of the pass before.
  const S negligible = S(1e-3);
  const detail::PassDef<S> def{motion, dt, pass, is_last_pass};
  using Change = detail::PassChange<Pack<S>>;
  using Moved = detail::MovedModels<Pack<S>>;
  return detail::with_parameters<S>(patch.def, [&](const auto& parameters) {
    const Change change = detail::sum_of_contacts<Change>(
        patch, pair, parallel_for, [&](std::span<ContactTile<S>> tiles, Change& part) {
          detail::find_changes<S>(patch, pair, tiles, parameters, def, part);
        });
    const bool has_changed = change.did_switch || sum_of_lanes(change.force_change) >
                                                      negligible * sum_of_lanes(change.force_sum);
    if (!has_changed && !change.has_slip) return false;

    // Normal forces that have not settled by the last pass point along the gradient, which cannot
    // give energy, and not along the ray with an impulse that was wrong the pass before.
    const S lagged = is_last_pass && has_changed ? S(0) : dt;
    const Moved moved = detail::sum_of_contacts<Moved>(
        patch, pair, parallel_for, [&](std::span<ContactTile<S>> tiles, Moved& part) {
          detail::linearise_at_motion<S>(patch, pair, tiles, parameters, def, lagged, part);
        });
    moved.models.get(pair.matrix, pair.offset);
    return has_changed ||
           sum_of_lanes(moved.friction_change) > negligible * sum_of_lanes(moved.friction_sum);
  });
}

template <Scalar S>
void fill_block(const PatchPair<S>& pair, SoftBlock<S>& block) {
  const Mat3<S>& R = pair.R_WA;
  const Mat3<S> top = R * pair.matrix.template topRightCorner<3, 3>() * R.transpose();
  block.matrix.template topLeftCorner<3, 3>() =
      rotated<S>(R, pair.matrix.template topLeftCorner<3, 3>());
  block.matrix.template topRightCorner<3, 3>() = top;
  block.matrix.template bottomLeftCorner<3, 3>() = top.transpose();
  block.matrix.template bottomRightCorner<3, 3>() =
      rotated<S>(R, pair.matrix.template bottomRightCorner<3, 3>());
  block.offset.template head<3>() = R * pair.offset.template head<3>();
  block.offset.template tail<3>() = R * pair.offset.template tail<3>();
}

template <Scalar S>
void clear_impulses(SensorPatch<S>& patch, const PatchPair<S>& pair) {
  for (ContactTile<S>& tile : detail::contacts_of(patch, pair)) {
    tile.impulse = {};
    tile.normal_impulse = {};
  }
}

template <Scalar S>
Wrench<S> evaluate_impulses(SensorPatch<S>& patch, const PatchPair<S>& pair, const Vec6<S>& motion,
                            const ParallelFor& parallel_for) {
  using Sum = detail::LaneWrench<S>;
  return detail::sum_of_contacts<Sum>(patch, pair, parallel_for,
                                      [&](std::span<ContactTile<S>> tiles, Sum& part) {
                                        detail::evaluate<S>(patch, pair, tiles, motion, part);
                                      })
      .in_world(pair);
}

}  // namespace bristle
