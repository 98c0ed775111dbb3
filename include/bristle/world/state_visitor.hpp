/// @file
/// The state of a world: the one list that snapshots, their restoration and the hash follow.
///
/// A value is state if a step reads it and a step or a caller changes it. Shapes, layouts and
/// settings are not state: they come from the calls that built the world. Those that identify the
/// world go through `same`. New state is one more line here.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/math/finite.hpp>
#include <bristle/world/world_state.hpp>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

namespace bristle::inline BRISTLE_ABI::detail {

/// Shows the whole state to a visitor, always in the same order. The visitor has
///
/// - `same(name, value)`: not state, but must be equal;
/// - `value(x)`: a number, truth value, enumerator, handle, matrix, or a span of such; all numbers
///   are finite;
/// - `any(x)`: the same for numbers that need not be finite;
/// - `item(name, x, each, holds)`: shown by `each(x)`. The code relies on `holds(x)`; bytes from
///   outside may break it;
/// - `list(name, items, each) -> count`: any number of items, each shown by `each(item)`;
/// - `require(name, holds)`: a rule that the code relies on in items of a list;
/// - `is_checking`: true if it evaluates `holds`.
///
/// @param state  `WorldState`, const for visitors that read only.
template <typename State, typename Visitor>
void for_each_state(State& state, Visitor& visit);

// Implementation ----------------------------------------------------------------------------------

template <typename Map, typename Visitor, typename Each>
void visit_slots(const char* name, Map& map, Visitor& visit, Each&& each) {
  visit.same(name, map.size());
  for (const std::uint32_t i : map.live_slots()) {
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

/// Returns whether a step may multiply by a number.
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
  return cwise_abs(R.transpose() * R - identity<Mat3<S>>()).maxCoeff() <= Tolerance<S>::equal() &&
         R.determinant() > S(0);
}

/// Returns whether a step can start from the state of a body.
/// @param slots  [-] Largest number of bodies.
template <Scalar S>
[[nodiscard]] bool is_valid_state(const Body<S>& body, std::uint32_t slots) {
  const bool stays = body.twist.linear.isZero(S(0)) && body.twist.angular.isZero(S(0));
  return is_pose(body.center_pose) && has_finite_square<S>(body.twist) &&
         (body.motion != Motion::fixed || stays) && has_finite_square<S>(body.applied.force) &&
         has_finite_square<S>(body.applied.torque) && has_finite_square(body.gravity_scale) &&
         is_not_negative(body.linear_damping) && is_not_negative(body.angular_damping) &&
         (body.is_dynamic() || !is_damped(body)) && body.sleep.rest_time >= S(0) &&
         (!body.is_asleep() || (body.is_dynamic() && body.sleep.island < slots));
}

template <Scalar S>
[[nodiscard]] bool has_valid_limits(const JointDef<S>& def) {
  const bool is_limited = def.lower_limit != -infinity<S> || def.upper_limit != infinity<S>;
  return def.lower_limit <= def.upper_limit && def.lower_limit != infinity<S> &&
         def.upper_limit != -infinity<S> &&
         (!is_limited || has_free_axis(def.kind) || has_angle(def.kind));
}

template <Scalar S>
[[nodiscard]] bool is_valid_state(const JointSpring<S>& spring, JointKind kind) {
  const bool pulls = !(spring.stiffness == S(0)) || !(spring.damping == S(0));
  return is_not_negative(spring.stiffness) && is_not_negative(spring.damping) &&
         has_finite_square(spring.rest) && (!pulls || has_free_axis(kind));
}

template <Scalar S>
[[nodiscard]] bool is_valid_state(const Joint<S>& joint) {
  const JointMotor<S>& motor = joint.def.motor;
  const bool is_driven = motor.mode != MotorMode::none;
  return motor.mode >= MotorMode::none && motor.mode <= MotorMode::spring &&
         (!is_driven || has_free_axis(joint.def.kind)) && has_finite_square(motor.target) &&
         motor.max_force >= S(0) && motor.max_speed > S(0) && is_not_negative(motor.stiffness) &&
         is_not_negative(motor.damping) && has_finite_square(joint.angle) &&
         has_valid_limits(joint.def) && is_valid_state(joint.def.spring, joint.def.kind);
}

/// Returns whether mass and inertia are possible for a body after `set_mass`: those of its own
/// solid in another density, with matching inverses.
template <Scalar S>
[[nodiscard]] bool is_of_same_solid(const Body<S>& changed, const Body<S>& body) {
  if (!body.is_dynamic()) {
    return changed.mass == body.mass && changed.inverse_mass == body.inverse_mass &&
           changed.inertia_B == body.inertia_B &&
           changed.inverse_inertia_B == body.inverse_inertia_B;
  }
  if (!is_positive(changed.mass) || changed.inverse_mass != S(1) / changed.mass) return false;
  const Mat3<S> expected = (changed.mass * body.inverse_mass) * body.inertia_B;
  const S difference = cwise_abs(changed.inertia_B - expected).maxCoeff();
  return difference <= Tolerance<S>::equal() * diagonal_of<S>(expected).maxCoeff() &&
         changed.inverse_inertia_B == inverse_inertia<S>(changed.inertia_B);
}

template <Scalar S>
[[nodiscard]] bool is_valid_state(const SensorParameters<S>& p) {
  return is_not_negative(p.normal_stiffness) && is_not_negative(p.normal_damping) &&
         is_not_negative(p.static_friction) && is_not_negative(p.sliding_friction) &&
         is_positive(p.breakaway_distance);
}

/// Returns whether a packet's used lanes hold vectors.
template <Scalar S>
[[nodiscard]] bool has_vectors(const Row3<S>& rows, LaneBits lanes) {
  for (std::uint32_t rest = lanes; rest != 0; rest &= rest - 1) {
    const auto i = static_cast<std::size_t>(std::countr_zero(rest));
    if (!has_finite_square<S>(Vec3<S>(rows[i]))) return false;
  }
  return true;
}

/// Lanes of a patch's packet that are sensors.
template <Scalar S>
[[nodiscard]] LaneBits lanes_of(const SensorPatch<S>& patch, std::size_t packet) {
  const std::size_t left = patch.size() - packet * packet_size;
  return left >= packet_size ? LaneBits(0xffffu) : static_cast<LaneBits>((1u << left) - 1u);
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
    visit.value(item.gravity_scale);
    visit.value(item.linear_damping);
    visit.value(item.angular_damping);
    visit.value(item.filter.category);
    visit.value(item.filter.mask);
    visit.value(item.filter.group);
    visit.value(item.sleep.rest_time);
    visit.value(item.sleep.island);
    visit.value(item.sleep.is_dirty);
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
  visit.same("shapes (trigger)", collider.is_trigger);
  const auto each = [&](auto& material) {
    visit.value(material.friction);
    visit.value(material.restitution);
    visit.value(material.surface_velocity);
    visit.value(material.rolling_friction);
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
    visit.value(item.def.motor.mode);
    visit.value(item.def.motor.target);
    visit.value(item.def.motor.max_force);
    visit.any(item.def.motor.max_speed);
    visit.value(item.def.motor.stiffness);
    visit.value(item.def.motor.damping);
    visit.any(item.def.lower_limit);
    visit.any(item.def.upper_limit);
    visit.value(item.def.spring.stiffness);
    visit.value(item.def.spring.damping);
    visit.value(item.def.spring.rest);
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

/// Visits the anchors of a packet. Unanchored lanes may hold any anchor.
/// @param is_anchored  Its anchored lanes.
/// @param hit          Lanes that hit anything. Others let go.
template <typename Packet, typename Bits, typename Visitor>
void visit_bristles(Packet& packet, Bits& is_anchored, LaneBits hit, Visitor& visit) {
  LaneBits anchored = 0;
  visit.item(
      "patches (bristles)", is_anchored, [&](auto& bits) { visit.value(bits); },
      [&](LaneBits bits) {
        anchored = bits;
        return (bits & ~hit) == 0;
      });
  const auto each = [&](auto& item) {
    for (auto* roots : {&item.anchor_a, &item.anchor_b}) {
      visit.any(std::span(roots->x));
      visit.any(std::span(roots->y));
      visit.any(std::span(roots->z));
    }
  };
  visit.item("patches (bristles)", packet, each, [&](const auto& item) {
    return has_vectors(item.anchor_a, anchored) && has_vectors(item.anchor_b, anchored);
  });
}

template <typename Sensed, typename Visitor>
void visit_sensed(Sensed& sensed, Visitor& visit) {
  visit.value(sensed.body);
  visit.value(sensed.pose.R_AB);
  visit.value(sensed.pose.p_AB);
  visit_wrench(sensed.on_a, visit);
  visit.value(sensed.shear_W);
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

/// The plane cache of patches that do not cast their rays in every step.
template <typename Patch, typename Visitor>
void visit_plane_cache(Patch& patch, Visitor& visit) {
  visit.same("patches (cast_every)", patch.def.cast_every);
  if (patch.def.cast_every == 1) return;
  visit.list("patches (plane cache shapes)", patch.plane_cache.shapes, [&](auto& shape) {
    visit.value(shape.tag);
    visit.value(shape.generation);
    visit.value(shape.pose.R_AB);
    visit.value(shape.pose.p_AB);
    visit.value(shape.reserve);
    visit.require("patches (plane cache shapes)", is_rotation(shape.pose.R_AB));
  });
  std::size_t next = 0;  // Packets ascend.
  visit.list("patches (plane cache)", patch.plane_cache.packets, [&](auto& kept) {
    visit.value(kept.packet);
    visit.value(kept.is_hit);
    for (std::size_t i = 0; i < packet_size; ++i) {
      if ((kept.is_hit >> i & 1u) == 0) continue;
      visit_lane(kept.point, i, visit);
      visit_lane(kept.normal, i, visit);
      visit.value(kept.tag[i]);
    }
    const bool is_next = kept.packet >= next && kept.packet < patch.bristles.size();
    visit.require("patches (plane cache)", is_next &&
                                               (kept.is_hit & ~lanes_of(patch, kept.packet)) == 0 &&
                                               has_vectors(kept.point, kept.is_hit) &&
                                               has_vectors(kept.normal, kept.is_hit));
    next = kept.packet + std::size_t(1);
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
  bool has_hits = false;
  for (std::size_t i = 0; i < patch.hit_bits.size(); ++i) {
    LaneBits hit = 0;
    visit.item(
        "patches (hits)", patch.hit_bits[i], [&](auto& bits) { visit.value(bits); },
        [&](LaneBits bits) {
          hit = bits;
          has_hits = has_hits || bits != 0;
          return (bits & ~lanes_of(patch, i)) == 0;
        });
    visit_bristles(patch.bristles[i], patch.is_anchored[i], hit, visit);
  }
  visit.item(
      "patches (hits)", patch.has_hits, [&](auto& any) { visit.value(any); },
      [&](bool any) { return any == has_hits; });
  visit.list("patches (bodies)", patch.sensed, [&](auto& sensed) {
    visit_sensed(sensed, visit);
    visit.require("patches (bodies)",
                  state.bodies.is_live(sensed.body) && is_rotation(sensed.pose.R_AB));
  });
  visit.list("patches (impulses)", patch.last_impulses, [&](auto& last) {
    visit.value(last.body);
    visit.value(last.impulse);
  });
  for (std::size_t i = 0; i < patch.active_lanes.size(); ++i) {
    visit.item(
        "patches (active sensors)", patch.active_lanes[i],
        [&](auto& active) { visit.value(active); },
        [&](LaneBits active) { return (active & ~lanes_of(patch, i)) == 0; });
  }
  visit.value(patch.was_active);
  visit.value(patch.is_active);
  visit_plane_cache(patch, visit);
  visit_readings(patch.readings, visit);
}

/// Returns whether a cached manifold may follow `last`. Manifolds are sorted by pairs. Each has at
/// most as many points as a manifold can hold. The points are in order.
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
    visit.value(std::span(point.transient_impulse));
    visit.value(point.position_excess);
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
    visit.value(m.rolling_impulse);
    visit.require("contacts (manifolds)", is_valid_state(m, last, next, points, state));
    next += m.count;
    last = m.shapes;
  });
  visit.require("contacts (points)", next == points);
}

template <typename State, typename Visitor>
void for_each_state(State& state, Visitor& visit) {
  visit.item(
      "time step", state.def.time_step, [&](auto& dt) { visit.value(dt); },
      [](const auto& dt) { return is_positive(dt); });
  visit.item(
      "gravity", state.def.gravity, [&](auto& g) { visit.value(g); },
      [](const auto& g) { return has_finite_square(g); });
  visit.same("sleep time", state.def.sleep.time);
  visit.same("integrator", state.def.integrator);
  visit.value(state.is_idle);
  visit.value(state.steps);
  visit_slots("bodies", state.bodies, visit,
              [&](auto& body) { visit_body(body, state.bodies.slot_count(), visit); });
  visit_slots("shapes", state.colliders, visit,
              [&](auto& collider) { visit_collider(collider, visit); });
  visit_slots("joints", state.joints, visit, [&](auto& joint) { visit_joint(joint, visit); });
  visit_slots("patches", state.patches, visit,
              [&](auto& patch) { visit_patch(state, patch, visit); });
  visit_contacts(state, state.contacts, visit);
}

}  // namespace bristle::inline BRISTLE_ABI::detail
