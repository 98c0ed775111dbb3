/// @file
/// Reads the sensors of an AMBF description, in the current form and in the two older ones.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/io/adf/adf_map.hpp>
#include <bristle/io/adf/adf_model.hpp>
#include <bristle/io/text_scanner.hpp>

#include <cstddef>
#include <string>
#include <utility>

namespace bristle::inline BRISTLE_ABI::detail {

/// Most rows of a fan. Its rays are that many squared.
inline constexpr std::size_t adf_max_resolution = 10'000;

inline void read_adf_constants(AdfMap& map, AdfSensor& sensor) {
  if (map.has("friction")) {
    AdfMap friction = map.map("friction");
    sensor.static_friction = friction.number("static", sensor.static_friction, adf_not_negative);
    sensor.dynamic_friction = friction.number("dynamic", sensor.dynamic_friction, adf_not_negative);
    sensor.friction_damping = friction.number("damping", sensor.friction_damping, adf_not_negative);
    sensor.variable_friction = friction.flag("variable", sensor.variable_friction);
    friction.finish();
  }
  sensor.contact_area = map.number("contact area", sensor.contact_area, adf_positive);
  sensor.contact_stiffness =
      map.number("contact stiffness", sensor.contact_stiffness, adf_not_negative);
  sensor.contact_damping = map.number("contact damping", sensor.contact_damping, adf_not_negative);
}

inline void read_adf_array(AdfMap& map, AdfSensor& sensor) {
  for (AdfMap& ray : map.maps("array")) {
    const Vec3<double> offset = ray.vector("offset");
    sensor.array.push_back({offset, ray.direction("direction")});
    ray.finish();
  }
}

inline void read_adf_fan(AdfMap& map, AdfSensor& sensor) {
  AdfMap fan = map.map("parametric");
  sensor.fan = AdfFan{.resolution = fan.count("resolution", 2, adf_max_resolution),
                      .horizontal_angle = fan.number("horizontal angle", adf_finite),
                      .vertical_angle = fan.number("vertical angle", adf_finite),
                      .start_offset = fan.number("start offset", adf_finite)};
  fan.finish();
}

/// Reads the form of 2019: a flat location {x, y, z}, and one direction.
inline void read_adf_single_ray(AdfMap& map, AdfSensor& sensor) {
  const Vec3<double> offset = map.has("location") ? map.vector("location") : zero<Vec3<double>>();
  sensor.array.push_back({offset, map.direction("direction")});
}

/// Reads all of a sensor but its names.
inline void read_adf_sensor(AdfMap& map, AdfSensor& sensor) {
  const std::string type = to_lower(map.text("type"));
  if (type == "resistance") {
    sensor.type = AdfSensorType::resistance;
  } else if (type != "proximity") {
    map.fail("type", "must be Proximity or Resistance");
  }
  sensor.parent = map.text("parent");
  sensor.range = map.number("range", sensor.range, adf_positive);

  const bool has_rays = map.has("array") || map.has("mesh") || map.has("parametric");
  if (!has_rays && map.has("direction")) {
    read_adf_single_ray(map, sensor);
  } else {
    sensor.location = map.pose("location");
    if (map.has("array")) {
      read_adf_array(map, sensor);
    } else if (map.has("mesh")) {
      sensor.mesh = map.text("mesh");
    } else if (map.has("parametric")) {
      read_adf_fan(map, sensor);
    } else {
      map.fail("array", "must be given, or mesh, or parametric: where the rays are");
    }
  }
  if (sensor.array.empty() && sensor.mesh.empty() && !sensor.fan) {
    map.fail("array", "must not be empty");
  }
  map.pass({"array", "mesh", "parametric"});
  if (sensor.type == AdfSensorType::resistance) read_adf_constants(map, sensor);
  if (sensor.type == AdfSensorType::resistance && sensor.variable_friction &&
      sensor.contact_stiffness == 0.0) {
    map.note(AdfNoteKind::changed, "contact stiffness",
             "0, with variable friction: the sensor neither pushes nor holds");
  }
  map.skip({"visible", "visible size"}, "looks");
  map.skip({"publish frequency", "passive", "plugins"}, "communication");
}

/// Reads the block of 2019 in a body: a sensor on each face of a mesh, by default the visual one.
[[nodiscard]] inline AdfSensor read_adf_resistive_surface(AdfMap& map,
                                                          const std::string& visual_mesh) {
  AdfSensor sensor;
  sensor.type = AdfSensorType::resistance;
  sensor.static_friction = 1.0;
  sensor.dynamic_friction = 0.1;
  sensor.friction_damping = 1.0;
  sensor.contact_area = 0.001;
  sensor.is_legacy_surface = true;
  sensor.range = map.number("range", 0.1, adf_positive);
  sensor.depth = map.number("depth", 0.0, adf_not_negative);
  if (!(sensor.range > sensor.depth)) map.fail("range", "must exceed the depth");
  sensor.mesh = map.text("mesh", visual_mesh);
  if (sensor.mesh.empty()) map.fail("mesh", "must be given where the body has none");
  read_adf_constants(map, sensor);
  map.pass({"enable"});
  map.skip({"face resolution", "edge resolution"}, "one sensor a face");
  map.skip({"visible", "visible size"}, "looks");
  map.finish();
  return sensor;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
