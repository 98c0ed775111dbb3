/// @file
/// A world as lines, triangles, points and text, for a renderer of one's own. Opt-in.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/dynamics/bodies/body.hpp>
#include <bristle/geometry/meshes/drawn_mesh.hpp>
#include <bristle/math/transform.hpp>
#include <bristle/sensors/patch.hpp>
#include <bristle/sensors/touch_force.hpp>
#include <bristle/world/world.hpp>

#include <concepts>
#include <cstddef>
#include <cstdio>
#include <string>
#include <string_view>

namespace bristle::inline BRISTLE_ABI {

/// Meaning of a drawn thing. A renderer gives each a colour.
enum class DrawnKind {
  /// Triangles of a shape, of a body that moves or does not.
  moving_shape,
  fixed_shape,
  /// Line of a sensor's ray.
  free_sensor,
  stuck_sensor,
  slipping_sensor,
  /// Point where a sensor touches, and line from there: its force on what it touches.
  touch,
  touch_force,
  /// Point where two shapes press on each other, and line from there: the force on `Drawn::body`.
  contact,
  contact_force,
  /// Line along the axis of a joint, or point where one without an axis is.
  joint,
  /// Text at a body's centre of mass: its number.
  body_name,
  /// Text in the middle of a patch: its number, normal force and slipping sensors.
  patch_name
};

/// Owner of a drawn thing.
struct Drawn {
  /// Meaning of the thing.
  DrawnKind kind = DrawnKind::moving_shape;
  /// [-] Body that carries it, or that is pressed; body B of a joint.
  BodyId body{};
  /// [-] Patch, if the thing belongs to one.
  PatchId patch{};
  /// [-] Index of the sensor in the patch, if the thing is one of a sensor.
  std::size_t sensor = 0;
};

/// Choice of the things that are drawn, and their size.
template <Scalar S>
struct DrawDef {
  /// [m/N] Length of a line for a newton of its force, > 0.
  S metres_per_newton = S(0.01);
  /// [m] Side of the square that a half-space is drawn as, > 0.
  S plane_size = S(2);
  /// [m] Length of the line of a joint, > 0.
  S joint_length = S(0.1);
  /// [-] Draws shapes. They are made anew in each call: ask for them once, and draw them
  /// where their bodies are then.
  bool has_shapes = true;
  /// [-] Draws the rays of sensors.
  bool has_sensors = true;
  /// [-] Draws contact points and forces of sensors.
  bool has_forces = true;
  /// [-] Draws contacts and their forces.
  bool has_contacts = true;
  /// [-] Draws joints.
  bool has_joints = true;
  /// [-] Draws the names of bodies and patches.
  bool has_names = true;
};

/// Receiver of the things that `for_each_drawn` draws. Points are in the world [m]; a mesh is in a
/// frame of its own, whose pose in the world is X_WM.
template <typename V, typename S>
concept DrawVisitor = requires(V& visitor, const Drawn& drawn, const Vec3<S>& point,
                               const TriangleMesh<S>& mesh, const Transform<S>& X_WM,
                               std::string_view text) {
  visitor.line(drawn, point, point);
  visitor.point(drawn, point);
  visitor.triangles(drawn, mesh, X_WM);
  visitor.text(drawn, point, text);
};

/// Tells a visitor all that is to be drawn of a world as it is after its last step: shapes, where
/// the backend tells them, then sensors with their forces, contacts, joints and names, each in the
/// order of slots. Active patches only.
///
/// Changes nothing and costs nothing unless called. Allocates for shapes and names only.
/// @throws InvalidArgument naming the field of the definition, before anything is drawn.
template <Scalar S, typename Backend, DrawVisitor<S> Visitor>
void for_each_drawn(const World<S, Backend>& world, Visitor&& visitor, const DrawDef<S>& def = {});

// Implementation ----------------------------------------------------------------------------------

namespace detail {

template <Scalar S, typename Backend, typename Visitor>
class WorldDrawer {
 public:
  WorldDrawer(const World<S, Backend>& world, Visitor& visitor, const DrawDef<S>& def)
      : world_(world), visitor_(visitor), def_(def) {}

  void draw_shapes(BodyId id) {
    if constexpr (TellsShapes<Backend, S>) {
      const Transform<S> X_WB = world_.pose(id);
      const bool moves = world_.body(id).motion != Motion::fixed;
      const Drawn drawn{.kind = moves ? DrawnKind::moving_shape : DrawnKind::fixed_shape,
                        .body = id};
      // A trigger would hide what is in it.
      world_.for_each_shape(id, [&](ShapeId, const ShapeDef<S>& shape) {
        if (shape.is_trigger) return;
        visitor_.triangles(drawn, drawn_mesh<S>(shape.shape, def_.plane_size), X_WB * shape.X_BS);
      });
    }
  }

  void draw_sensors(PatchId id) {
    const SensorPatch<S>& patch = world_.patch(id);
    const PatchReading<S> reading = world_.reading(id);
    const Transform<S> X_WA = world_.body(patch.body).center_pose;
    for (std::size_t i = 0; i < patch.size(); ++i) {
      const bool is_free = reading.state[i] == SensorState::free;
      Drawn drawn{.body = patch.body, .patch = id, .sensor = i};
      if (def_.has_sensors) {
        drawn.kind = is_free                                     ? DrawnKind::free_sensor
                     : reading.state[i] == SensorState::slipping ? DrawnKind::slipping_sensor
                                                                 : DrawnKind::stuck_sensor;
        const Vec3<S> start = patch.geometry->start[i];
        visitor_.line(
            drawn, X_WA * start,
            X_WA * Vec3<S>(start + patch.geometry->length[i] * patch.geometry->direction[i]));
      }
      if (is_free || !def_.has_forces) continue;
      const Vec3<S> point(reading.point_x[i], reading.point_y[i], reading.point_z[i]);
      drawn.kind = DrawnKind::touch;
      visitor_.point(drawn, point);
      drawn.kind = DrawnKind::touch_force;
      draw_force(drawn, point,
                 X_WA.rotate(touch_force<S>(reading, i, patch.geometry->direction[i])));
    }
  }

  void draw_contacts() {
    const S dt = world_.time_step();
    world_.for_each_contact([&](const ContactReading<S>& pair) {
      pair.for_each_point([&](const typename ContactReading<S>::Point& point) {
        const Vec3<S> impulse = point.normal_impulse * point.normal + point.friction_impulse;
        if (impulse.isZero(S(0))) return;
        visitor_.point({.kind = DrawnKind::contact, .body = pair.body_b}, point.position);
        draw_force({.kind = DrawnKind::contact_force, .body = pair.body_b}, point.position,
                   impulse / dt);
      });
    });
  }

  void draw_joint(JointId id) {
    const JointDef<S>& def = world_.joint(id).def;
    const Transform<S> X_WJ = world_.pose(def.body_b) * def.X_BJ;
    const Drawn drawn{.kind = DrawnKind::joint, .body = def.body_b};
    const bool has_axis = def.kind == JointKind::revolute || def.kind == JointKind::prismatic ||
                          def.kind == JointKind::cone_twist;
    if (!has_axis) return visitor_.point(drawn, X_WJ.translation);
    const Vec3<S> half = X_WJ.rotate(Vec3<S>(def_.joint_length / S(2), S(0), S(0)));
    visitor_.line(drawn, X_WJ.translation - half, X_WJ.translation + half);
  }

  void draw_body_name(BodyId id) {
    visitor_.text({.kind = DrawnKind::body_name, .body = id},
                  world_.body(id).center_pose.translation, "body " + std::to_string(id.index));
  }
  void draw_patch_name(PatchId id) {
    const SensorPatch<S>& patch = world_.patch(id);
    const PatchReading<S> reading = world_.reading(id);
    // Words, a number of three digits and two whole numbers are less than 64 characters.
    char text[96];
    std::snprintf(text, sizeof text, "patch %u: %.3g N, %zu slip", unsigned{id.index},
                  static_cast<double>(reading.total_normal()), reading.slipping());
    visitor_.text({.kind = DrawnKind::patch_name, .body = patch.body, .patch = id},
                  world_.body(patch.body).center_pose * patch.geometry->box.center(), text);
  }

 private:
  void draw_force(const Drawn& drawn, const Vec3<S>& point, const Vec3<S>& force) {
    if (force.isZero(S(0))) return;
    visitor_.line(drawn, point, Vec3<S>(point + def_.metres_per_newton * force));
  }

  const World<S, Backend>& world_;
  Visitor& visitor_;
  const DrawDef<S>& def_;
};

}  // namespace detail

template <Scalar S, typename Backend, DrawVisitor<S> Visitor>
void for_each_drawn(const World<S, Backend>& world, Visitor&& visitor, const DrawDef<S>& def) {
  detail::require_positive("DrawDef::metres_per_newton", def.metres_per_newton);
  detail::require_positive("DrawDef::plane_size", def.plane_size);
  detail::require_positive("DrawDef::joint_length", def.joint_length);
  detail::WorldDrawer drawer(world, visitor, def);
  const auto for_active_patches = [&](auto&& draw) {
    world.for_each_patch([&](PatchId id) {
      if (world.patch(id).is_active) draw(id);
    });
  };
  if (def.has_shapes) world.for_each_body([&](BodyId id) { drawer.draw_shapes(id); });
  if (def.has_sensors || def.has_forces) {
    for_active_patches([&](PatchId id) { drawer.draw_sensors(id); });
  }
  if (def.has_contacts) drawer.draw_contacts();
  if (def.has_joints) world.for_each_joint([&](JointId id) { drawer.draw_joint(id); });
  if (!def.has_names) return;
  world.for_each_body([&](BodyId id) { drawer.draw_body_name(id); });
  for_active_patches([&](PatchId id) { drawer.draw_patch_name(id); });
}

}  // namespace bristle::inline BRISTLE_ABI
