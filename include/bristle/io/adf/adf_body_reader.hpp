/// @file
/// Reads the bodies of an AMBF description.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/io/adf/adf_map.hpp>
#include <bristle/io/adf/adf_model.hpp>
#include <bristle/io/adf/adf_sensor_reader.hpp>
#include <bristle/io/text_scanner.hpp>

#include <algorithm>
#include <cstddef>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

namespace bristle::inline BRISTLE_ABI::detail {

/// Largest number of a collision group.
inline constexpr std::size_t adf_max_group = 999;

/// Rotation of z to the axis that a geometry names.
[[nodiscard]] inline Quat<double> adf_axis(AdfMap& geometry) {
  const std::string axis = to_lower(geometry.text("axis", "z"));
  const double quarter = std::numbers::pi / 2.0;
  if (axis == "x") return from_roll_pitch_yaw(0.0, quarter, 0.0);
  if (axis == "y") return from_roll_pitch_yaw(-quarter, 0.0, 0.0);
  if (axis != "z") geometry.fail("axis", "must be x, y or z");
  return Quat<double>::Identity();
}

/// Reads a primitive by its kind and sizes. Extents and heights are whole ones. A capsule's height
/// includes its caps.
[[nodiscard]] inline AdfShape read_adf_shape(AdfMap& body, const char* kind_key,
                                             const char* geometry_key) {
  const std::string kind = to_lower(body.text(kind_key));
  AdfMap geometry = body.map(geometry_key);
  AdfShape result;
  if (kind == "box") {
    result.shape = Box<double>{0.5 * Vec3<double>(geometry.number("x", adf_positive),
                                                  geometry.number("y", adf_positive),
                                                  geometry.number("z", adf_positive))};
  } else if (kind == "sphere") {
    result.shape = Sphere<double>{geometry.number("radius", adf_positive)};
  } else if (kind == "cylinder" || kind == "cone" || kind == "capsule") {
    const double radius = geometry.number("radius", adf_positive);
    const double half = 0.5 * geometry.number("height", adf_positive);
    result.X_BS.rotation = adf_axis(geometry);
    if (kind == "cylinder") result.shape = Cylinder<double>{radius, half};
    if (kind == "cone") result.shape = Cone<double>{radius, half};
    if (kind == "capsule") {
      if (!(half > radius)) geometry.fail("height", "must exceed the diameter, which it includes");
      result.shape = Capsule<double>{radius, half - radius};
    }
  } else if (kind == "plane") {
    result.shape =
        HalfSpace<double>{geometry.direction("normal"), geometry.number("offset", adf_finite)};
  } else {
    body.fail(kind_key, "must be BOX, SPHERE, CYLINDER, CAPSULE, CONE or PLANE");
  }
  geometry.pass({"axis"});
  geometry.finish();
  return result;
}

inline void read_adf_collision(AdfMap& map, AdfBody& body) {
  if (map.has("collision shape")) {
    AdfShape shape = read_adf_shape(map, "collision shape", "collision geometry");
    const Transform<double> offset = map.has("collision offset")
                                         ? map.pose("collision offset")
                                         : body.inertial_offset.value_or(Transform<double>{});
    shape.X_BS = offset * shape.X_BS;
    body.shapes.push_back(std::move(shape));
    map.pass({"compound collision shape", "collision mesh", "collision mesh type"});
  } else if (map.has("compound collision shape")) {
    for (AdfMap& part : map.maps("compound collision shape")) {
      AdfShape shape = read_adf_shape(part, "shape", "geometry");
      shape.X_BS = part.pose("offset") * shape.X_BS;
      body.shapes.push_back(std::move(shape));
      part.finish();
    }
    map.pass({"collision geometry", "collision offset", "collision mesh", "collision mesh type"});
  } else {
    body.collision_mesh = map.text("collision mesh", body.visual_mesh);
    const std::string type = to_lower(map.text("collision mesh type", "CONCAVE_MESH"));
    if (type == "convex_hull" || type == "hull" || type == "convex_mesh" || type == "point_cloud") {
      body.mesh_type = AdfMeshType::convex_hull;
    } else if (type != "concave_mesh" && type != "trimesh") {
      map.fail("collision mesh type",
               "must be CONVEX_HULL, CONVEX_MESH, CONCAVE_MESH or POINT_CLOUD");
    }
    map.pass({"collision geometry", "collision offset"});
  }
}

inline void read_adf_inertia(AdfMap& map, AdfBody& body) {
  if (!map.has("mass")) map.note(AdfNoteKind::changed, "mass", "not given: 1 kg");
  body.mass = map.number("mass", body.mass, adf_not_negative);
  if (map.has("inertial offset")) body.inertial_offset = map.pose("inertial offset");
  if (map.has("inertia")) {
    AdfMap inertia = map.map("inertia");
    // Files give zeros for bodies that do not move.
    const AdfRule& rule = body.mass > 0.0 ? adf_positive : adf_not_negative;
    body.inertia = Vec3<double>(inertia.number("ix", rule), inertia.number("iy", rule),
                                inertia.number("iz", rule));
    inertia.finish();
  }
}

inline void read_adf_surface(AdfMap& map, AdfBody& body) {
  if (map.has("friction")) {
    AdfMap friction = map.map("friction");
    body.friction = friction.number("static", body.friction, adf_not_negative);
    friction.skip({"rolling"}, "not applied: Bullet scales it by the friction of the other body");
    friction.finish();
  }
  body.restitution = map.number("restitution", body.restitution, adf_not_negative);
  if (body.restitution > 1.0) map.fail("restitution", "must be in [0, 1]");
  body.collision_groups = map.counts("collision groups", adf_max_group);
}

/// Reads the damping of a body, which it has even without the key.
inline void read_adf_damping(AdfMap& map, AdfBody& body) {
  if (!map.has("damping")) return;
  AdfMap damping = map.map("damping");
  const auto read = [&damping](const char* key, double otherwise) {
    const double part = damping.number(key, otherwise, adf_not_negative);
    if (part > 1.0) damping.note(AdfNoteKind::changed, key, "1, as in Bullet: no more can be lost");
    return std::min(part, 1.0);
  };
  body.linear_damping = read("linear", body.linear_damping);
  body.angular_damping = read("angular", body.angular_damping);
  damping.finish();
}

/// Reads a sensor in the older form, nested in its body.
[[nodiscard]] inline std::optional<AdfSensor> read_adf_surface_sensor(AdfMap& map,
                                                                      const AdfBody& body) {
  if (!map.has("resistive surface")) return std::nullopt;
  AdfMap block = map.map("resistive surface");
  AdfSensor sensor = read_adf_resistive_surface(block, body.visual_mesh);
  sensor.key = body.key + "/resistive surface";
  sensor.qualified = body.qualified + "/resistive surface";
  sensor.name = body.name + "/resistivesurface";
  sensor.line = block.line();
  sensor.parent = body.qualified;
  return sensor;
}

/// Reads all of a body but its names. Returns the sensor on its surface, if there is one.
inline std::optional<AdfSensor> read_adf_body(AdfMap& map, AdfBody& body) {
  body.location = map.pose("location");
  body.scale = map.number("scale", body.scale, adf_positive);
  body.visual_mesh = map.text("mesh", "");
  body.high_resolution_path = map.text("high resolution path", "");
  body.low_resolution_path = map.text("low resolution path", "");
  read_adf_inertia(map, body);
  read_adf_collision(map, body);
  read_adf_surface(map, body);
  read_adf_damping(map, body);
  if (map.has("gravity")) body.gravity = map.vector("gravity");
  std::optional<AdfSensor> sensor = read_adf_surface_sensor(map, body);

  map.skip({"collision margin"}, "shapes have their exact size");
  map.skip({"controller", "controller output type"},
           "nothing drives a free body: World::move_to, "
           "apply_wrench or a driven joint do");
  map.skip({"shape", "geometry", "compound shape", "color", "color raw", "color rgba",
            "color components", "visible", "shaders", "texture", "normal map"},
           "looks");
  map.skip({"publish joint names", "publish joint positions", "publish children names",
            "publish frequency", "passive", "plugins"},
           "communication");
  return sensor;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
