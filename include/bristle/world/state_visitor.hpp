/// @file
/// What the state of a world is: the one list that snapshots, their restoration and the hash
/// follow.
///
/// State is what a step reads and a step or a caller changes. Shapes, masses, layouts and settings
/// are not: they come from the calls that built the world. What of them identifies the world goes
/// through `same`. New state is one more line here.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/world/world_state.hpp>

#include <type_traits>

namespace bristle {

/// Shows the whole state to a visitor, always in the same order. The visitor has
///
/// - `same(name, value)`: not state, but must be what it was;
/// - `value(x)`: a number, truth value, enumerator, handle, matrix, or a span of such;
/// - `list(name, items, each) -> count`: any number of items, each shown by `each(item)`;
/// - `require(name, holds)`: what the code relies on, since items may come from outside.
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

template <typename Body, typename Visitor>
void visit_body(Body& body, Visitor& visit) {
  visit.same("bodies (motion)", body.motion);
  visit.same("bodies (mass)", body.mass);
  for (std::size_t i = 0; i < 3; ++i) {
    visit.same("bodies (locked axes)", body.locked.linear[i]);
    visit.same("bodies (locked axes)", body.locked.angular[i]);
  }
  visit.value(body.center_pose.rotation.coeffs());
  visit.value(body.center_pose.translation);
  visit.value(body.twist.linear);
  visit.value(body.twist.angular);
  visit_wrench(body.applied, visit);
  visit.value(body.filter.category);
  visit.value(body.filter.mask);
  visit.value(body.filter.group);
  visit.value(body.sleep.rest_time);
  visit.value(body.sleep.island);
  visit.value(body.sleep.is_stirred);
}

template <typename Collider, typename Visitor>
void visit_collider(Collider& collider, Visitor& visit) {
  visit.same("shapes (body)", collider.body.index);
  visit.same("shapes (kind)", collider.kind);
  visit.same("shapes (size)", collider.radius);
}

template <typename Joint, typename Visitor>
void visit_joint(Joint& joint, Visitor& visit) {
  visit.same("joints (kind)", joint.def.kind);
  visit.same("joints (body_a)", joint.def.body_a.index);
  visit.same("joints (body_b)", joint.def.body_b.index);
  visit.value(joint.def.drive.mode);
  visit.value(joint.def.drive.target);
  visit.value(joint.def.drive.max_force);
  visit.value(joint.def.drive.max_speed);
  visit.value(joint.def.drive.stiffness);
  visit.value(joint.def.drive.damping);
  visit.value(joint.angle);
  visit.value(std::span(joint.impulses));
  visit_wrench(joint.spring_impulse, visit);
  visit_wrench(joint.total, visit);
}

template <typename Parameters, typename Visitor>
void visit_parameters(Parameters& p, Visitor& visit) {
  visit.value(p.normal_stiffness);
  visit.value(p.normal_damping);
  visit.value(p.static_friction);
  visit.value(p.sliding_friction);
  visit.value(p.breakaway_distance);
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

template <typename Tile, typename Visitor>
void visit_bristles(Tile& tile, Visitor& visit) {
  visit.value(tile.is_rooted);
  visit_vectors(tile.root_a, visit);
  visit_vectors(tile.root_b, visit);
  visit.value(tile.rooted_in.common);
  visit.value(std::span(tile.rooted_in.own));
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
  visit.value(pair.R_WA);
  visit.value(pair.start_motion.linear);
  visit.value(pair.start_motion.angular);
  visit.value(pair.center);
  visit.value(pair.arm_a);
  visit.value(pair.arm_b);
}

template <typename Readings, typename Visitor>
void visit_readings(Readings& r, Visitor& visit) {
  visit.value(std::span(r.depth));
  visit.value(std::span(r.normal_force));
  visit.value(std::span(r.shear_1));
  visit.value(std::span(r.shear_2));
  visit_vectors(r.point, visit);
  visit.value(std::span(r.body));
  visit.value(std::span(r.state));
  visit_wrench(r.wrench, visit);
  visit.value(r.shear_W);
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
    visit.require("patches (kept hits)", kept.tile >= next && kept.tile < patch.tiles.size());
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
  for (auto& tile : patch.tiles) visit_bristles(tile, visit);
  const std::size_t contacts = visit.list("patches (contacts)", patch.contacts, [&](auto& tile) {
    visit_contact_tile(tile, visit);
    visit.require("patches (contacts)", tile.tile < patch.tiles.size());
  });
  visit.value(std::span(patch.hits.distance));
  visit_vectors(patch.hits.normal, visit);
  visit.list("patches (pairs)", patch.pairs, [&](auto& pair) {
    visit_patch_pair(pair, visit);
    visit.require("patches (pairs)",
                  pair.count == 0 || (state.bodies.is_live(pair.body_b) && pair.first <= contacts &&
                                      pair.count <= contacts - pair.first));
  });
  visit.list("patches (impulses)", patch.last_impulses, [&](auto& last) {
    visit.value(last.body);
    visit.value(last.impulse);
  });
  visit.value(std::span(patch.felt));
  visit.value(patch.has_felt);
  visit.value(patch.is_active);
  visit_kept_hits(patch, visit);
  visit_readings(patch.readings, visit);
}

template <typename State, typename Cache, typename Visitor>
void visit_contacts(const State& state, Cache& cache, Visitor& visit) {
  const std::size_t points = visit.list("contacts (points)", cache.points(), [&](auto& point) {
    visit.value(point.arm_a);
    visit.value(point.arm_b);
    visit.value(point.gap);
    visit.value(point.feature);
    visit.value(std::span(point.impulse));
    visit.value(std::span(point.passing));
    visit.value(point.took_impact);
  });
  std::size_t next = 0;
  visit.list("contacts (manifolds)", cache.manifolds(), [&](auto& m) {
    visit.value(m.shapes.a);
    visit.value(m.shapes.b);
    visit.value(m.key);
    visit.value(m.normal);
    visit.value(m.center_a);
    visit.value(m.first);
    visit.value(m.count);
    visit.require("contacts (manifolds)", state.colliders.is_live(m.shapes.a) &&
                                              state.colliders.is_live(m.shapes.b) &&
                                              m.first == next && m.count <= points - next);
    next += m.count;
  });
  visit.require("contacts (points)", next == points);
}

}  // namespace detail

template <typename State, typename Visitor>
void for_each_state(State& state, Visitor& visit) {
  visit.value(state.def.time_step);
  visit.value(state.def.gravity);
  visit.same("sleep time", state.def.sleep.time);
  visit.same("integrator", state.def.integrator);
  visit.value(state.is_idle);
  visit.value(state.steps);
  detail::visit_slots("bodies", state.bodies, visit,
                      [&](auto& body) { detail::visit_body(body, visit); });
  detail::visit_slots("shapes", state.colliders, visit,
                      [&](auto& collider) { detail::visit_collider(collider, visit); });
  detail::visit_slots("joints", state.joints, visit,
                      [&](auto& joint) { detail::visit_joint(joint, visit); });
  detail::visit_slots("patches", state.patches, visit,
                      [&](auto& patch) { detail::visit_patch(state, patch, visit); });
  detail::visit_contacts(state, state.contacts, visit);
}

}  // namespace bristle
