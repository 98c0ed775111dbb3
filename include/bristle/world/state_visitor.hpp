/// @file
/// What the state of a world is: the one list that snapshots, their restoration and the hash
/// follow.
///
/// State is what a step reads and a step or a caller changes. Shapes, layouts and settings are not:
/// they come from the calls that built the world. What of them identifies the world goes
/// through `same`. New state is one more line here.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/finite.hpp>
#include <bristle/world/world_state.hpp>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// Shows the whole state to a visitor, always in the same order. The visitor has
///
/// - `same(name, value)`: not state, but must be what it was;
/// - `value(x)`: a number, truth value, enumerator, handle, matrix, or a span of such; all numbers
///   are finite;
/// - `any(x)`: the same where they need not be;
/// - `item(name, x, each, holds)`: shown by `each(x)`, and `holds(x)` is what the code relies on:
///   bytes that come from outside may say anything;
/// - `list(name, items, each) -> count`: any number of items, each shown by `each(item)`;
/// - `require(name, holds)`: what the code relies on in items of a list;
/// - `is_checking`: whether it does anything with `holds`.
///
/// @param state  `WorldState`, const for visitors that read only.
template <typename State, typename Visitor>
void for_each_state(State& state, Visitor& visit);

// Implementation -----------------------------------------------------------------------------------

namespace detail {

template <typename Map, typename Visitor, typename Each>
void visit_slots(const char* name, Map& map, Visitor& visit, Each&& each) {
  visit.same(name, map.size());
  for (std::uint32_t i = 0; i < map.slot_count(); ++i) {
    if (!map.is_live(i)) continue;
    visit.same(name, i);
    visit.same(name, map.handle(i).generation);
    each(map.at(i));
  }
}

template <typename Wrench, typename Visitor>
void visit_wrench(Wrench& wrench, Visitor& visit) {
  visit.value(wrench.force);
  visit.value(wrench.torque);
}

/// Whether a number may stand where a step multiplies it.
template <Scalar S>
[[nodiscard]] bool is_not_negative(const S& x) {
  return x >= S(0) && x <= largest_number<S>;
}
template <Scalar S>
[[nodiscard]] bool is_positive(const S& x) {
  return is_not_negative(x) && x * largest_number<S> >= S(1);
}

template <Scalar S>
[[nodiscard]] bool is_rotation(const Mat3<S>& R) {
  return (R.transpose() * R - Mat3<S>::Identity()).cwiseAbs().maxCoeff() <= Tolerance<S>::equal() &&
         R.determinant() > S(0);
}

/// Whether a step can start from what of a body is state.
/// @param slots  [-] Bodies there are at most.
template <Scalar S>
[[nodiscard]] bool is_valid_state(const Body<S>& body, std::uint32_t slots) {
  const bool stays = body.twist.linear.isZero(S(0)) && body.twist.angular.isZero(S(0));
  return is_pose(body.center_pose) && has_finite_square<S>(body.twist) &&
         (body.motion != Motion::fixed || stays) && has_finite_square<S>(body.applied.force) &&
         has_finite_square<S>(body.applied.torque) && body.sleep.rest_time >= S(0) &&
         (!body.is_asleep() || (body.is_dynamic() && body.sleep.island < slots));
}

template <Scalar S>
[[nodiscard]] bool is_valid_state(const Joint<S>& joint) {
  const JointDrive<S>& drive = joint.def.drive;
  const bool is_driven = drive.mode != DriveMode::none;
  return drive.mode >= DriveMode::none && drive.mode <= DriveMode::spring &&
         (!is_driven || has_free_axis(joint.def.kind)) && has_finite_square(drive.target) &&
         drive.max_force >= S(0) && drive.max_speed > S(0) && is_not_negative(drive.stiffness) &&
         is_not_negative(drive.damping) && has_finite_square(joint.angle);
}

template <Scalar S>
[[nodiscard]] bool is_valid_state(const Material<S>& material) {
  return is_not_negative(material.friction) && is_not_negative(material.restitution) &&
         material.restitution <= S(1);
}

/// Whether mass and inertia can be those of a body after `set_mass`: of its own solid in another
/// density, with the inverses that belong to them.
template <Scalar S>
[[nodiscard]] bool is_of_same_solid(const Body<S>& changed, const Body<S>& body) {
  if (!body.is_dynamic()) {
    return changed.mass == body.mass && changed.inverse_mass == body.inverse_mass &&
           changed.inertia_B == body.inertia_B &&
           changed.inverse_inertia_B == body.inverse_inertia_B;
  }
  if (!is_positive(changed.mass) || changed.inverse_mass != S(1) / changed.mass) return false;
  const Mat3<S> expected = (changed.mass * body.inverse_mass) * body.inertia_B;
  const S difference = (changed.inertia_B - expected).cwiseAbs().maxCoeff();
  return difference <= Tolerance<S>::equal() * expected.diagonal().maxCoeff() &&
         changed.inverse_inertia_B == inverse_inertia<S>(changed.inertia_B);
}

template <Scalar S>
[[nodiscard]] bool is_valid_state(const SensorParameters<S>& p) {
  return is_not_negative(p.normal_stiffness) && is_not_negative(p.normal_damping) &&
         is_not_negative(p.static_friction) && is_not_negative(p.sliding_friction) &&
         is_positive(p.breakaway_distance);
}

/// Whether the lanes of a tile that are used hold vectors.
template <Scalar S>
[[nodiscard]] bool has_vectors(const Row3<S>& rows, LaneBits lanes) {
  for (std::uint32_t rest = lanes; rest != 0; rest &= rest - 1) {
    const auto i = static_cast<std::size_t>(std::countr_zero(rest));
    if (!has_finite_square<S>(Vec3<S>(rows[i]))) return false;
  }
  return true;
}

/// Lanes of a tile of a patch that are sensors.
template <Scalar S>
[[nodiscard]] LaneBits lanes_of(const SensorPatch<S>& patch, std::size_t tile) {
  const std::size_t left = patch.size() - tile * tile_size;
  return left >= tile_size ? LaneBits(0xffffu) : static_cast<LaneBits>((1u << left) - 1u);
}

template <typename Body, typename Visitor>
void visit_body(Body& body, std::uint32_t slots, Visitor& visit) {
  visit.same("bodies (motion)", body.motion);
  for (std::size_t i = 0; i < 3; ++i) {
    visit.same("bodies (locked axes)", body.locked.linear[i]);
    visit.same("bodies (locked axes)", body.locked.angular[i]);
  }
  const auto each = [&](auto& item) {
    visit.value(item.center_pose.rotation.coeffs());
    visit.value(item.center_pose.translation);
    visit.value(item.twist.linear);
    visit.value(item.twist.angular);
    visit_wrench(item.applied, visit);
    visit.value(item.mass);
    visit.value(item.inverse_mass);
    visit.value(item.inertia_B);
    visit.value(item.inverse_inertia_B);
    visit.value(item.filter.category);
    visit.value(item.filter.mask);
    visit.value(item.filter.group);
    visit.value(item.sleep.rest_time);
    visit.value(item.sleep.island);
    visit.value(item.sleep.is_stirred);
  };
  visit.item("bodies (state)", body, each, [&](const auto& item) {
    return is_valid_state(item, slots) && is_of_same_solid(item, body);
  });
}

template <typename Collider, typename Visitor>
void visit_collider(Collider& collider, Visitor& visit) {
  visit.same("shapes (body)", collider.body.index);
  visit.same("shapes (kind)", collider.kind);
  visit.same("shapes (size)", collider.radius);
  const auto each = [&](auto& material) {
    visit.value(material.friction);
    visit.value(material.restitution);
  };
  visit.item("shapes (surface)", collider.material, each,
             [](const auto& material) { return is_valid_state(material); });
}

template <typename Joint, typename Visitor>
void visit_joint(Joint& joint, Visitor& visit) {
  visit.same("joints (kind)", joint.def.kind);
  visit.same("joints (body_a)", joint.def.body_a.index);
  visit.same("joints (body_b)", joint.def.body_b.index);
  const auto each = [&](auto& item) {
    visit.value(item.def.drive.mode);
    visit.value(item.def.drive.target);
    visit.value(item.def.drive.max_force);
    visit.any(item.def.drive.max_speed);
    visit.value(item.def.drive.stiffness);
    visit.value(item.def.drive.damping);
    visit.value(item.angle);
    visit.value(std::span(item.impulses));
    visit_wrench(item.spring_impulse, visit);
    visit_wrench(item.total, visit);
  };
  visit.item("joints (state)", joint, each, [](const auto& item) { return is_valid_state(item); });
}

template <typename Parameters, typename Visitor>
void visit_parameters(Parameters& parameters, Visitor& visit) {
  const auto each = [&](auto& p) {
    visit.value(p.normal_stiffness);
    visit.value(p.normal_damping);
    visit.value(p.static_friction);
    visit.value(p.sliding_friction);
    visit.value(p.breakaway_distance);
  };
  visit.item("patches (parameters)", parameters, each,
             [](const auto& p) { return is_valid_state(p); });
}

template <typename Array, typename Visitor>
void visit_vectors(Array& array, Visitor& visit) {
  visit.value(std::span(array.x));
  visit.value(std::span(array.y));
  visit.value(std::span(array.z));
}

template <typename Rows, typename Visitor>
void visit_lane(Rows& rows, std::size_t i, Visitor& visit) {
  visit.value(rows.x[i]);
  visit.value(rows.y[i]);
  visit.value(rows.z[i]);
}

/// @param lanes  Those that are sensors. What is not rooted may have anything for roots.
template <typename Tile, typename Visitor>
void visit_bristles(Tile& tile, LaneBits lanes, Visitor& visit) {
  const auto each = [&](auto& item) {
    visit.value(item.is_rooted);
    for (auto* roots : {&item.root_a, &item.root_b}) {
      visit.any(std::span(roots->x));
      visit.any(std::span(roots->y));
      visit.any(std::span(roots->z));
    }
    visit.value(item.rooted_in.common);
    visit.value(std::span(item.rooted_in.own));
  };
  visit.item("patches (bristles)", tile, each, [&](const auto& item) {
    return (item.is_rooted & ~lanes) == 0 && has_vectors(item.root_a, item.is_rooted) &&
           has_vectors(item.root_b, item.is_rooted);
  });
}

/// Of contacts and pairs, what is read between steps; the rest is one step's work.
template <typename Tile, typename Visitor>
void visit_contact_tile(Tile& tile, Visitor& visit) {
  visit.value(tile.tile);
  visit.value(tile.is_touching);
}

template <typename Pair, typename Visitor>
void visit_patch_pair(Pair& pair, Visitor& visit) {
  visit.value(pair.body_b);
  visit.value(pair.first);
  visit.value(pair.count);
  visit.any(pair.R_WA);
  visit.any(pair.start_motion.linear);
  visit.any(pair.start_motion.angular);
  visit.any(pair.center);
  visit.any(pair.arm_a);
  visit.any(pair.arm_b);
}

/// Whether the contacts of a pair, if it has any, are among those of the patch.
template <Scalar S, typename State>
[[nodiscard]] bool is_valid_state(const PatchPair<S>& pair, const State& state,
                                  std::size_t contacts) {
  if (pair.count == 0) return true;
  return state.bodies.is_live(pair.body_b) && pair.first <= contacts &&
         pair.count <= contacts - pair.first && is_rotation<S>(pair.R_WA) &&
         has_finite_square<S>(pair.start_motion) && has_finite_square<S>(pair.center) &&
         has_finite_square<S>(pair.arm_a) && has_finite_square<S>(pair.arm_b);
}

template <typename Readings, typename Visitor>
void visit_readings(Readings& r, Visitor& visit) {
  visit.value(std::span(r.depth));
  visit.value(std::span(r.normal_force));
  visit.value(std::span(r.shear_1));
  visit.value(std::span(r.shear_2));
  visit_vectors(r.point, visit);
  visit.value(std::span(r.body));
  for (auto& state : r.state) {
    visit.item(
        "patches (readings)", state, [&](auto& own) { visit.value(own); },
        [](SensorState own) { return own <= SensorState::slipping; });
  }
  visit_wrench(r.wrench, visit);
  visit.value(r.shear_W);
}

/// Whether the lanes that touch have hits.
template <Scalar S>
[[nodiscard]] bool is_valid_state(const RayHits<S>& hits, const std::vector<LaneBits>& touching) {
  for (std::size_t tile = 0; tile < touching.size(); ++tile) {
    for (std::uint32_t rest = touching[tile]; rest != 0; rest &= rest - 1) {
      const std::size_t i = tile * tile_size + static_cast<std::size_t>(std::countr_zero(rest));
      if (!is_not_negative(hits.distance[i]) || !is_unit(hits.normal[i])) return false;
    }
  }
  return true;
}

/// Hits of the last step: what the sensors that touched met, and anything in other places.
/// @param touching  Lanes that touch, of each tile, where the visitor checks.
template <typename Hits, typename Visitor>
void visit_hits(Hits& hits, const std::vector<LaneBits>& touching, Visitor& visit) {
  const auto each = [&](auto& item) {
    visit.any(std::span(item.distance));
    visit.any(std::span(item.normal.x));
    visit.any(std::span(item.normal.y));
    visit.any(std::span(item.normal.z));
  };
  visit.item("patches (hits)", hits, each,
             [&](const auto& item) { return is_valid_state(item, touching); });
}

/// Of patches that cast their rays every so many steps.
template <typename Patch, typename Visitor>
void visit_kept_hits(Patch& patch, Visitor& visit) {
  visit.same("patches (cast_every)", patch.def.cast_every);
  if (patch.def.cast_every == 1) return;
  visit.list("patches (kept shapes)", patch.kept.shapes, [&](auto& shape) {
    visit.value(shape.tag);
    visit.value(shape.generation);
    visit.value(shape.pose.R_AB);
    visit.value(shape.pose.p_AB);
    visit.value(shape.reserve);
    visit.require("patches (kept shapes)", is_rotation(shape.pose.R_AB));
  });
  std::size_t next = 0;  // Tiles ascend.
  visit.list("patches (kept hits)", patch.kept.tiles, [&](auto& kept) {
    visit.value(kept.tile);
    visit.value(kept.is_hit);
    for (std::size_t i = 0; i < tile_size; ++i) {
      if ((kept.is_hit >> i & 1u) == 0) continue;
      visit_lane(kept.point, i, visit);
      visit_lane(kept.normal, i, visit);
      visit.value(kept.tag[i]);
    }
    const bool is_next = kept.tile >= next && kept.tile < patch.tiles.size();
    visit.require("patches (kept hits)", is_next &&
                                             (kept.is_hit & ~lanes_of(patch, kept.tile)) == 0 &&
                                             has_vectors(kept.point, kept.is_hit) &&
                                             has_vectors(kept.normal, kept.is_hit));
    next = kept.tile + std::size_t(1);
  });
}

template <typename State, typename Patch, typename Visitor>
void visit_patch(const State& state, Patch& patch, Visitor& visit) {
  visit.same("patches (body)", patch.body.index);
  visit.same("patches (number of sensors)", patch.size());
  visit_parameters(patch.def.parameters, visit);
  const std::size_t own = visit.list("patches (parameters)", patch.def.per_sensor,
                                     [&](auto& p) { visit_parameters(p, visit); });
  visit.require("patches (parameters)", own == 0 || own == patch.size());
  for (std::size_t i = 0; i < patch.tiles.size(); ++i) {
    visit_bristles(patch.tiles[i], lanes_of(patch, i), visit);
  }
  // Of each tile, the lanes of its contacts.
  std::vector<LaneBits> touching(Visitor::is_checking ? patch.tiles.size() : 0);
  const std::size_t contacts = visit.list("patches (contacts)", patch.contacts, [&](auto& tile) {
    visit_contact_tile(tile, visit);
    visit.require("patches (contacts)", tile.tile < patch.tiles.size() &&
                                            (tile.is_touching & ~lanes_of(patch, tile.tile)) == 0);
    if constexpr (Visitor::is_checking) {
      touching[tile.tile] = static_cast<LaneBits>(touching[tile.tile] | tile.is_touching);
    }
  });
  visit_hits(patch.hits, touching, visit);
  visit.list("patches (pairs)", patch.pairs, [&](auto& pair) {
    visit_patch_pair(pair, visit);
    visit.require("patches (pairs)", is_valid_state(pair, state, contacts));
  });
  visit.list("patches (impulses)", patch.last_impulses, [&](auto& last) {
    visit.value(last.body);
    visit.value(last.impulse);
  });
  for (std::size_t i = 0; i < patch.felt.size(); ++i) {
    visit.item(
        "patches (felt)", patch.felt[i], [&](auto& felt) { visit.value(felt); },
        [&](LaneBits felt) { return (felt & ~lanes_of(patch, i)) == 0; });
  }
  visit.value(patch.has_felt);
  visit.value(patch.is_active);
  visit_kept_hits(patch, visit);
  visit_readings(patch.readings, visit);
}

/// Whether the manifolds of a contact cache may follow each other like that: by pairs, each of as
/// many points as a manifold can have, all of them in order.
template <Scalar S, typename State>
[[nodiscard]] bool is_valid_state(const CachedManifold<S>& m, const ShapePair& last,
                                  std::size_t next, std::size_t points, const State& state) {
  const auto is_live = [&](std::uint32_t tag) { return state.colliders.is_live(tag); };
  return is_live(m.shapes.a) && is_live(m.shapes.b) && m.shapes.a < m.shapes.b &&
         state.colliders.at(m.shapes.a).body != state.colliders.at(m.shapes.b).body &&
         !(m.shapes < last) && m.first == next && m.count <= points - next &&
         m.count <= ContactManifold<S>::capacity && is_unit(m.normal) &&
         has_finite_square<S>(m.center_a);
}

template <typename State, typename Cache, typename Visitor>
void visit_contacts(const State& state, Cache& cache, Visitor& visit) {
  visit.item(
      "contacts (last step)", cache.last_step(), [&](auto& dt) { visit.value(dt); },
      [](const auto& dt) { return is_positive(dt); });
  const std::size_t points = visit.list("contacts (points)", cache.points(), [&](auto& point) {
    visit.value(point.arm_a);
    visit.value(point.arm_b);
    visit.value(point.mid_offset_a);
    visit.value(point.mid_offset_b);
    visit.value(point.gap);
    visit.value(point.feature);
    visit.value(std::span(point.impulse));
    visit.value(std::span(point.passing));
    visit.value(point.took_impact);
    visit.value(point.acts_at_mid);
    visit.require("contacts (points)",
                  has_finite_square(point.arm_a) && has_finite_square(point.arm_b) &&
                      has_finite_square(point.mid_offset_a) &&
                      has_finite_square(point.mid_offset_b) && has_finite_square(point.gap));
  });
  std::size_t next = 0;
  ShapePair last{0, 0};
  visit.list("contacts (manifolds)", cache.manifolds(), [&](auto& m) {
    visit.value(m.shapes.a);
    visit.value(m.shapes.b);
    visit.value(m.key);
    visit.value(m.normal);
    visit.value(m.center_a);
    visit.value(m.first);
    visit.value(m.count);
    visit.require("contacts (manifolds)", is_valid_state(m, last, next, points, state));
    next += m.count;
    last = m.shapes;
  });
  visit.require("contacts (points)", next == points);
}

}  // namespace detail

template <typename State, typename Visitor>
void for_each_state(State& state, Visitor& visit) {
  visit.item(
      "time step", state.def.time_step, [&](auto& dt) { visit.value(dt); },
      [](const auto& dt) { return detail::is_positive(dt); });
  visit.item(
      "gravity", state.def.gravity, [&](auto& g) { visit.value(g); },
      [](const auto& g) { return has_finite_square(g); });
  visit.same("sleep time", state.def.sleep.time);
  visit.same("integrator", state.def.integrator);
  visit.value(state.is_idle);
  visit.value(state.steps);
  detail::visit_slots("bodies", state.bodies, visit, [&](auto& body) {
    detail::visit_body(body, state.bodies.slot_count(), visit);
  });
  detail::visit_slots("shapes", state.colliders, visit,
                      [&](auto& collider) { detail::visit_collider(collider, visit); });
  detail::visit_slots("joints", state.joints, visit,
                      [&](auto& joint) { detail::visit_joint(joint, visit); });
  detail::visit_slots("patches", state.patches, visit,
                      [&](auto& patch) { detail::visit_patch(state, patch, visit); });
  detail::visit_contacts(state, state.contacts, visit);
}

}  // namespace bristle::inline BRISTLE_ABI
