/// @file
/// Definitions of `World`: bodies and shapes. Included by world.hpp.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/world/near_shapes.hpp>
#include <bristle/world/waking.hpp>
#include <bristle/world/world.hpp>

namespace bristle::inline BRISTLE_ABI {

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::require_known_contacts(BodyId id, bool is_dynamic,
                                               const CollisionFilter& filter,
                                               ShapeKind kind) const {
  // Most kinds of shapes may meet all others, which spares the search.
  bool meets_all = true;
  for (std::size_t other = 0; other < shape_kind_count; ++other) {
    meets_all = meets_all && Backend::can_collide(kind, static_cast<ShapeKind>(other));
  }
  if (meets_all) return;
  for (const std::uint32_t i : state_.colliders.live_slots()) {
    const detail::Collider<S>& other = state_.colliders.at(i);
    const Body<S>& other_body = state_.body_of(other);
    if (other.body == id || (!is_dynamic && !other_body.is_dynamic()) ||
        !may_meet(filter, other_body.filter) || Backend::can_collide(kind, other.kind)) {
      continue;
    }
    detail::raise(InvalidArgument(
        "ShapeDef::shape", name_of(kind),
        std::string("the backend knows no contact between it and the ") + name_of(other.kind) +
            " of another body; keep the two apart with a CollisionFilter, or use a backend that "
            "does"));
  }
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S> detail::Collider<S> World<S, Backend>::make_collider(
    const Body<S>& body, Prepared prepared, const ShapeDef<S>& def) {
  detail::Collider<S> c;
  c.X_CmS = def.X_BS;
  c.X_CmS.translation -= body.center_B;
  c.is_centered = c.X_CmS.translation == detail::zero<Vec3<S>>() &&
                  c.X_CmS.rotation.coeffs() == Quat<S>::Identity().coeffs();
  c.kind = Backend::kind(prepared);
  c.material = def.material;
  c.is_trigger = def.is_trigger;
  c.user_data = def.user_data;
  c.bounds = Backend::bounds(prepared);
  c.shape = {stepper_.kernels().queries(), std::move(prepared)};
  if (const auto* half_space = std::get_if<HalfSpace<S>>(&def.shape)) {
    c.half_space = *half_space;
  } else {
    c.radius = (c.X_CmS * c.bounds.center()).norm() + c.bounds.half_extents().norm();
  }
  detail::require_finite("ShapeDef::shape: farthest point", c.radius);
  c.inner = detail::inner_ball(def.shape);
  c.inner.center = c.X_CmS * c.inner.center;
  return c;
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S> ShapeId World<S, Backend>::insert_shape(BodyId id,
                                                                          detail::Collider<S> c) {
  c.body = id;
  const ShapeId shape_id = state_.colliders.insert(std::move(c));
  const Aabb<S> box = detail::box_of(state_, state_.colliders.at(shape_id.index));
  state_.broad_phase.insert(shape_id.index, box);
  state_.shapes_of_bodies.add(id.index, shape_id.index);
  return shape_id;
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S> BodyId World<S, Backend>::add_body(const BodyDef<S>& def) {
  detail::DynamicArray<Prepared> prepared;
  MassProperties<S> solid;
  bool has_solid = false;
  const auto add = [&](const ShapeDef<S>& shape, const char* field) {
    detail::require(def.motion != Motion::dynamic || kind_of(shape.shape) != ShapeKind::half_space,
                    field,
                    field == std::string_view("BodyDef::motion") ? name_of(def.motion)
                                                                 : name_of(kind_of(shape.shape)),
                    "must not be dynamic with a HalfSpace, which has no mass");
    prepared.push_back(Backend::template make<S>(shape.shape));
    if (shape.is_trigger) return;
    const MassProperties<S> part =
        Backend::mass_properties(prepared.back()).transformed(shape.X_BS);
    solid = has_solid ? solid + part : part;
    has_solid = true;
  };
  ShapeDef<S> first{.material = def.material, .user_data = def.user_data};
  if (def.shape) {
    first.shape = *def.shape;
    add(first, "BodyDef::motion");
  }
  for (const ShapeDef<S>& shape : def.shapes) {
    validate(shape);
    add(shape, "ShapeDef::shape");
  }
  const Body<S> body = make_body(def, solid);
  for (const Prepared& shape : prepared) {
    require_known_contacts(BodyId{}, body.is_dynamic(), body.filter, Backend::kind(shape));
  }
  detail::DynamicArray<detail::Collider<S>> colliders;
  auto next = prepared.begin();
  if (def.shape) colliders.push_back(make_collider(body, std::move(*next++), first));
  for (const ShapeDef<S>& shape : def.shapes) {
    colliders.push_back(make_collider(body, std::move(*next++), shape));
  }
  const BodyId id = state_.bodies.insert(body);
  for (detail::Collider<S>& collider : colliders) insert_shape(id, std::move(collider));
  detail::mark_dirty(state_, id);
  return id;
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S> BodyId World<S, Backend>::ground() {
  if (!contains(state_.ground)) state_.ground = add_body({.motion = Motion::fixed});
  return state_.ground;
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S> ShapeId World<S, Backend>::add_shape(BodyId id,
                                                                       const ShapeDef<S>& def) {
  const Body<S>& body = state_.bodies.get(id, "BodyId");
  validate(def);
  detail::require(!body.is_dynamic() || kind_of(def.shape) != ShapeKind::half_space,
                  "ShapeDef::shape", name_of(kind_of(def.shape)),
                  "must not be on a dynamic body: it has no mass");
  detail::Collider<S> collider = make_collider(body, Backend::template make<S>(def.shape), def);
  require_known_contacts(id, body.is_dynamic(), body.filter, kind_of(def.shape));
  detail::mark_dirty(state_, id);
  return insert_shape(id, std::move(collider));
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::remove_shape(ShapeId id) {
  (void)state_.colliders.get(id, "ShapeId");
  for_each_contact([&](const ContactReading<S>& contact) {
    if ((contact.shape_a == id || contact.shape_b == id) && contact.is_touching()) {
      state_.ended_since.push_back({ContactEvent::Phase::end, contact.shape_a, contact.shape_b,
                                    contact.body_a, contact.body_b});
    }
  });
  detail::mark_dirty(state_, state_.colliders.at(id.index).body);
  state_.broad_phase.remove(id.index);
  state_.contacts.forget(id.index);
  state_.shapes_of_bodies.remove(state_.colliders.at(id.index).body.index, id.index);
  state_.colliders.erase(id);
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::remove_body(BodyId id) {
  (void)state_.bodies.get(id, "BodyId");
  detail::mark_dirty(state_, id);
  for (const std::uint32_t i : state_.joints.live_slots()) {
    const JointDef<S>& def = state_.joints.at(i).def;
    if (def.body_a == id || def.body_b == id) erase_joint(i);
  }
  for (const std::uint32_t i : state_.patches.live_slots()) {
    if (state_.patches.at(i).body == id) {
      state_.patches.erase(state_.patches.handle(i));
    }
  }
  state_.shapes_of_bodies.for_each(
      id.index, [this](std::uint32_t tag) { remove_shape(state_.colliders.handle(tag)); });
  // Patches must neither read nor look up any more what they touched in the last step.
  for (const std::uint32_t i : state_.patches.live_slots()) {
    detail::forget_body(state_.patches.at(i), id);
  }
  state_.bodies.erase(id);
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::refresh_box(std::uint32_t tag) {
  const detail::Collider<S>& c = state_.colliders.at(tag);
  if (c.half_space) return;
  state_.broad_phase.move(tag, detail::box_of(state_, c));
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::set_pose(BodyId id, const Transform<S>& X_WB) {
  Body<S>& body = state_.bodies.get(id, "BodyId");
  detail::require_all_finite("X_WB.translation", X_WB.translation);
  detail::require_unit<S>("X_WB.rotation", X_WB.rotation);
  detail::require_all_finite("X_WB.translation: centre of mass", X_WB * body.center_B);
  body.set_pose({X_WB.rotation.normalized(), X_WB.translation});
  detail::mark_dirty(state_, id);
  state_.shapes_of_bodies.for_each(id.index, [this](std::uint32_t tag) { refresh_box(tag); });
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::set_velocity(BodyId id, const Twist<S>& twist) {
  const Body<S>& body = state_.bodies.get(id, "BodyId");
  detail::require(body.motion != Motion::fixed, "BodyId", id, "must not name a fixed body");
  detail::require_all_finite("twist.linear", twist.linear);
  detail::require_all_finite("twist.angular", twist.angular);
  set_twist(id, twist);
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::set_twist(BodyId id, const Twist<S>& twist) {
  Body<S>& body = state_.bodies.at(id.index);
  detail::require_still(body.locked, twist, "twist.linear", "twist.angular");
  const bool moved = state_.is_active(id.index);
  body.twist = twist;
  // Setting a zero velocity on a body at rest does not wake it.
  if (body.is_dynamic() || moved || state_.is_active(id.index)) detail::mark_dirty(state_, id);
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::move_to(BodyId id, const Transform<S>& X_WB) {
  set_twist(id, twist_to(id, X_WB));
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S> Twist<S> World<S, Backend>::twist_to(BodyId id,
                                                                       const Transform<S>& X_WB)
const {
  const Body<S>& body = state_.bodies.get(id, "BodyId");
  detail::require(body.motion == Motion::kinematic, "BodyId", id,
                  body.is_dynamic() ? "must name a kinematic body, not a dynamic one"
                                    : "must name a kinematic body, not a fixed one");
  detail::require_all_finite("X_WB.translation", X_WB.translation);
  detail::require_unit<S>("X_WB.rotation", X_WB.rotation);
  const S dt = state_.def.time_step;
  const Vec3<S> center = X_WB * body.center_B;
  const Twist<S> twist{
      (center - body.center_pose.translation) / dt,
      log_rotation<S>(X_WB.rotation.normalized() * body.center_pose.rotation.conjugate()) / dt};
  detail::require_all_finite("X_WB.translation: velocity", twist.linear);
  detail::require_all_finite("X_WB.rotation: angular velocity", twist.angular);
  return twist;
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::apply_wrench(BodyId id, const Wrench<S>& wrench) {
  Body<S>& body = state_.bodies.get(id, "BodyId");
  detail::require_all_finite("wrench.force", wrench.force);
  detail::require_all_finite("wrench.torque", wrench.torque);
  Wrench<S> applied = body.applied;
  applied += wrench;
  detail::require_all_finite("wrench.force: sum of the step", applied.force);
  detail::require_all_finite("wrench.torque: sum of the step", applied.torque);
  body.applied = applied;
  if (body.is_dynamic() && !(wrench.force.isZero(S(0)) && wrench.torque.isZero(S(0)))) {
    detail::mark_dirty(state_, id);
  }
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::apply_force(BodyId id, const Vec3<S>& force, const Vec3<S>& point) {
  const Body<S>& body = state_.bodies.get(id, "BodyId");
  detail::require_all_finite("force", force);
  detail::require_all_finite("point", point);
  apply_wrench(id, Wrench<S>::at(point - body.center_pose.translation, force));
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::apply_impulse(BodyId id, const Vec3<S>& impulse, const Vec3<S>& point) {
  const Body<S>& body = state_.bodies.get(id, "BodyId");
  detail::require(body.is_dynamic(), "BodyId", id, "must name a dynamic body");
  detail::require_all_finite("impulse", impulse);
  detail::require_all_finite("point", point);
  const Vec3<S> arm = point - body.center_pose.translation;
  Twist<S> twist = body.twist;
  twist.linear += Vec3<S>(body.inverse_mass_W().cwiseProduct(impulse));
  twist.angular += Vec3<S>(body.inverse_inertia_W() * arm.cross(impulse));
  detail::require_all_finite("impulse: new velocity", twist.linear);
  detail::require_all_finite("impulse: new angular velocity", twist.angular);
  set_twist(id, twist);
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::set_damping(BodyId id, S linear, S angular) {
  Body<S>& body = state_.bodies.get(id, "BodyId");
  detail::require(body.is_dynamic(), "BodyId", id, "must name a dynamic body");
  detail::require_not_negative("set_damping: linear", linear);
  detail::require_not_negative("set_damping: angular", angular);
  body.linear_damping = linear;
  body.angular_damping = angular;
  detail::mark_dirty(state_, id);
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::set_gravity_scale(BodyId id, S scale) {
  Body<S>& body = state_.bodies.get(id, "BodyId");
  detail::require(body.is_dynamic(), "BodyId", id, "must name a dynamic body");
  detail::require_finite("set_gravity_scale: scale", scale);
  body.gravity_scale = scale;
  detail::mark_dirty(state_, id);
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::set_filter(BodyId id, const CollisionFilter& filter) {
  Body<S>& body = state_.bodies.get(id, "BodyId");
  state_.shapes_of_bodies.for_each(id.index, [&](std::uint32_t tag) {
    require_known_contacts(id, body.is_dynamic(), filter, state_.colliders.at(tag).kind);
  });
  body.filter = filter;
  detail::mark_dirty(state_, id);
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::set_mass(BodyId id, S mass) {
  const Body<S>& old = body(id);
  detail::require(old.is_dynamic(), "set_mass: BodyId", id, "must name a dynamic body");
  detail::require_positive("set_mass: mass", mass);
  if (mass == old.mass) return;
  Body<S> changed = old;
  changed.mass = mass;
  changed.inverse_mass = S(1) / mass;
  changed.inertia_B = (mass * old.inverse_mass) * old.inertia_B;
  changed.inverse_inertia_B = inverse_inertia<S>(changed.inertia_B);
  detail::require_invertible(changed, "set_mass: mass", "set_mass: moment of inertia");
  state_.bodies.at(id.index) = changed;
  detail::mark_dirty(state_, id);
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::set_material(BodyId id, const Material<S>& material) {
  (void)body(id);
  validate(material);
  state_.shapes_of_bodies.for_each(
      id.index, [&](std::uint32_t tag) { state_.colliders.at(tag).material = material; });
  detail::mark_dirty(state_, id);
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::set_material(ShapeId id, const Material<S>& material) {
  detail::Collider<S>& collider = state_.colliders.get(id, "ShapeId");
  validate(material);
  collider.material = material;
  detail::mark_dirty(state_, collider.body);
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
void World<S, Backend>::wake(BodyId id) {
  (void)body(id);
  detail::mark_dirty(state_, id);
}

}  // namespace bristle::inline BRISTLE_ABI
