/// @file
/// Converts sensors of an AMBF description to layouts of rays and patch definitions.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/io/adf/adf_body_builder.hpp>
#include <bristle/io/adf/adf_meshes.hpp>
#include <bristle/io/adf/adf_model.hpp>
#include <bristle/io/adf/adf_scene.hpp>
#include <bristle/sensors/patch.hpp>
#include <bristle/sensors/placement.hpp>
#include <bristle/sensors/sensor_layout.hpp>
#include <bristle/sensors/sensor_parameters.hpp>

#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

namespace bristle::inline BRISTLE_ABI::detail {

/// Rays of a fan: azimuth within elevation, both from the first to the last angle.
template <Scalar S>
[[nodiscard]] SensorLayout<S> fan_rays(const AdfFan& fan, const Transform<S>& X_AC, S range) {
  SensorLayout<S> rays;
  const auto angle = [&](std::size_t i, double whole) {
    return (static_cast<double>(i) / static_cast<double>(fan.resolution - 1) - 0.5) * whole;
  };
  for (std::size_t i = 0; i < fan.resolution; ++i) {
    const double azimuth = angle(i, fan.horizontal_angle);
    for (std::size_t j = 0; j < fan.resolution; ++j) {
      const double pitch = angle(j, fan.vertical_angle);
      const Vec3<double> d(std::cos(azimuth) * std::cos(pitch), std::sin(azimuth) * std::cos(pitch),
                           -std::sin(pitch));
      const Vec3<S> direction = d.cast<S>();
      rays.add(X_AC * Vec3<S>(S(fan.start_offset) * direction), X_AC.rotate(direction).normalized(),
               range);
    }
  }
  return rays;
}

template <Scalar S>
class AdfSensorBuilder {
 public:
  AdfSensorBuilder(const AdfModel& model, const AdfBuildDef<S>& def, AdfMeshes<S>& meshes,
                   AdfReport& report)
      : model_(model), def_(def), meshes_(meshes), report_(report) {}

  /// Rays of a sensor in the frame of the body that carries it.
  [[nodiscard]] SensorLayout<S> rays(const AdfSensor& sensor, const AdfBody* carrier) {
    const Transform<S> X_AC = scaled_pose<S>(sensor.location, 1.0);
    const S range = S(sensor.range);
    SensorLayout<S> result;
    if (!sensor.array.empty()) {
      for (const AdfRay& ray : sensor.array) {
        result.add(X_AC * Vec3<S>(ray.offset.cast<S>()),
                   X_AC.rotate(ray.direction.cast<S>()).normalized(), range);
      }
    } else if (!sensor.mesh.empty()) {
      result = on_mesh(sensor, carrier, X_AC);
    } else {
      result = fan_rays(*sensor.fan, X_AC, range);
    }
    count(sensor, result.size());
    return result;
  }

  [[nodiscard]] PatchDef<S> patch(const AdfSensor& sensor, const AdfBody* carrier) {
    PatchDef<S> result;
    result.sensors = rays(sensor, carrier);
    result.parameters = {.normal_stiffness = S(sensor.contact_stiffness),
                         .normal_damping = S(sensor.contact_damping) * def_.authored_step,
                         .static_friction = S(sensor.static_friction),
                         .sliding_friction = S(sensor.dynamic_friction) + bristle_damping(sensor),
                         .breakaway_distance = S(sensor.contact_area)};
    // AMBF takes any ray, and so does this loader for its files.
    result.may_point_inwards = true;
    result.integration = def_.integration;
    result.options = def_.law;
    result.options.scaling =
        sensor.variable_friction ? FrictionScaling::normal_force : FrictionScaling::none;
    return result;
  }

 private:
  [[nodiscard]] SensorLayout<S> on_mesh(const AdfSensor& sensor, const AdfBody* carrier,
                                        const Transform<S>& X_AC) {
    const TriangleMesh<S>& mesh =
        meshes_.load(sensor, "mesh", sensor.mesh, AdfResolution::high, carrier);
    count(sensor, mesh.triangles.size());
    rays_ -= mesh.triangles.size();
    PlacementReport placed;
    SensorLayout<S> result = sensors_from_mesh<S>(
        mesh, {.depth = S(sensor.depth), .range = S(sensor.range), .X_AM = X_AC}, &placed);
    if (!placed.degenerate_faces.empty()) {
      report_.add(AdfNoteKind::changed, sensor.key + "/mesh",
                  std::to_string(placed.degenerate_faces.size()) +
                      " faces without a normal carry no sensor",
                  sensor.line);
    }
    return result;
  }

  /// [N s/m] Contribution of `friction: damping` to the sliding friction. The paper's law scales
  /// neither; AMBF's scales only sliding friction with the normal force.
  [[nodiscard]] S bristle_damping(const AdfSensor& sensor) {
    if (def_.law.law == Law::ambf && sensor.variable_friction) {
      if (sensor.friction_damping > 0.0) {
        report_.add(AdfNoteKind::changed, "sensor/friction/damping",
                    "not taken: sliding friction of the AMBF law grows with the normal force here",
                    sensor.line);
      }
      return S(0);
    }
    return S(sensor.friction_damping) * def_.authored_step;
  }

  void count(const AdfSensor& sensor, std::size_t more) {
    rays_ += more;
    if (rays_ > def_.limits.max_rays) {
      raise(AdfError(model_.file.string(), sensor.line, sensor.key, "",
                     "more than " + std::to_string(def_.limits.max_rays) + " rays"));
    }
  }

  const AdfModel& model_;
  const AdfBuildDef<S>& def_;
  AdfMeshes<S>& meshes_;
  AdfReport& report_;
  std::size_t rays_ = 0;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
