/// @file
/// Values of an AMBF description as its author wrote them, for errors of the world.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/io/adf/adf_model.hpp>
#include <bristle/io/adf/adf_report.hpp>

#include <string>
#include <string_view>
#include <variant>

namespace bristle::inline BRISTLE_ABI::detail {

/// A vector as files have it.
[[nodiscard]] inline std::string adf_words(const Vec3<double>& v) {
  return "{x: " + to_text(v.x()) + ", y: " + to_text(v.y()) + ", z: " + to_text(v.z()) + "}";
}

/// The `collision geometry` of a primitive: whole extents, and heights with caps.
struct AdfGeometryWords {
  std::string operator()(const Sphere<double>& s) const {
    return "{radius: " + to_text(s.radius) + "}";
  }
  std::string operator()(const Box<double>& s) const {
    return adf_words(Vec3<double>(2.0 * s.half_extents));
  }
  std::string operator()(const Capsule<double>& s) const {
    return round(s.radius, 2.0 * (s.half_length + s.radius));
  }
  std::string operator()(const Cylinder<double>& s) const {
    return round(s.radius, 2.0 * s.half_length);
  }
  std::string operator()(const Cone<double>& s) const {
    return round(s.radius, 2.0 * s.half_length);
  }
  std::string operator()(const HalfSpace<double>& s) const {
    return "{normal: " + adf_words(s.normal) + ", offset: " + to_text(s.offset) + "}";
  }
  /// Descriptions have no other primitives.
  template <typename Other>
  std::string operator()(const Other&) const {
    return {};
  }

 private:
  [[nodiscard]] static std::string round(double radius, double height) {
    return "{radius: " + to_text(radius) + ", height: " + to_text(height) + "}";
  }
};

/// Value of a key of a body. Empty if it is not given, or the key has no short text.
[[nodiscard]] inline std::string adf_words(const AdfBody& body, std::string_view key) {
  if (key == "mass") return to_text(body.mass);
  if (key == "location") return adf_words(body.location.translation);
  if (key == "inertial offset" && body.inertial_offset) {
    return adf_words(body.inertial_offset->translation);
  }
  if (key == "inertia" && body.inertia) return adf_words(*body.inertia);
  if (key == "gravity" && body.gravity) return adf_words(*body.gravity);
  if (key == "friction") return to_text(body.friction);
  if (key == "restitution") return to_text(body.restitution);
  // Of a compound the key names no single shape.
  if (body.shapes.size() != 1) return {};
  if (key == "collision offset") return adf_words(body.shapes[0].X_BS.translation);
  if (key == "collision geometry" || key == "collision shape") {
    return std::visit(AdfGeometryWords{}, body.shapes[0].shape);
  }
  return {};
}

/// Value of a key of a joint.
[[nodiscard]] inline std::string adf_words(const AdfJoint& joint, std::string_view key) {
  if (key == "child") return printable(joint.child, joint.child.size());
  if (key == "parent pivot") return adf_words(joint.parent_pivot);
  if (key == "child pivot") return adf_words(joint.child_pivot);
  if (key == "joint limits" && joint.type == AdfJointType::cone_twist) {
    return adf_words(joint.cone_limits);
  }
  if (key == "joint limits" && joint.limits) {
    return "{low: " + to_text(joint.limits->low) + ", high: " + to_text(joint.limits->high) + "}";
  }
  if (joint.type == AdfJointType::six_dof_spring) return {};
  if (key == "stiffness") return to_text(joint.stiffness);
  if (key == "damping") return to_text(joint.damping);
  if (key == "equilibrium point") return to_text(joint.equilibrium);
  if (key == "max motor impulse") return to_text(joint.max_motor_impulse);
  return {};
}

/// Value of a key of a sensor.
[[nodiscard]] inline std::string adf_words(const AdfSensor& sensor, std::string_view key) {
  if (key == "location") return adf_words(sensor.location.translation);
  if (key == "range") return to_text(sensor.range);
  if (key == "depth") return to_text(sensor.depth);
  if (key == "friction/static") return to_text(sensor.static_friction);
  if (key == "friction/dynamic") return to_text(sensor.dynamic_friction);
  if (key == "contact area") return to_text(sensor.contact_area);
  if (key == "contact stiffness") return to_text(sensor.contact_stiffness);
  if (key == "contact damping") return to_text(sensor.contact_damping);
  return {};
}

}  // namespace bristle::inline BRISTLE_ABI::detail
