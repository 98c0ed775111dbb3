/// @file
/// Features that scenes need of an engine; a driver leaves out the scenes that it cannot run.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scenes/rigid/trial.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

namespace bristle::work_precision {

/// Features of a driver beyond bodies and ball joints without limits.
struct Features {
  bool has_paths = false;
  /// [-] True if driven bodies carry others along: contacts see their velocity.
  bool has_moving_surfaces = false;
  bool has_capsules = false;
  bool has_cylinders = false;
  bool has_surfaces = false;
  bool has_families = false;
  bool has_hinges = false;
  bool has_swing_limits = false;
  bool has_motors = false;
  bool has_torque_limits = false;
};

/// @throws scenes::Unsupported that says what a scene has and a driver does not know.
inline void require_known(const scenes::Scene& scene, const Features& known) {
  const auto refuse = [](bool is_known, bool is_there, const char* what) {
    if (is_there && !is_known) throw scenes::Unsupported(what);
  };
  for (const scenes::SceneBody& body : scene.bodies) {
    refuse(known.has_paths, body.is_driven(), "no bodies that follow a path");
    refuse(known.has_moving_surfaces, body.is_driven() && body.meets != scenes::Meets::nothing,
           "what follows a path carries nothing along");
    refuse(known.has_capsules, std::holds_alternative<Capsule<double>>(body.shape), "no capsules");
    refuse(known.has_cylinders, std::holds_alternative<Cylinder<double>>(body.shape),
           "no cylinders among these shapes");
    refuse(known.has_surfaces, std::holds_alternative<scenes::Surface>(body.shape),
           "no meshes that are not convex");
    refuse(known.has_families, body.family != 0, "no families of bodies");
  }
  for (const scenes::SceneJoint& joint : scene.joints) {
    refuse(known.has_hinges, joint.kind == scenes::SceneJointKind::hinge, "no hinges");
    refuse(known.has_swing_limits, std::isfinite(joint.swing), "no stops of the swing");
    refuse(known.has_motors, joint.motor.has_value(), "no drives");
    refuse(known.has_torque_limits, joint.motor && std::isfinite(joint.motor->max_torque),
           "no torque limits of drives");
  }
  refuse(false, !scene.sensors.empty(), "no sensors");
}

}  // namespace bristle::work_precision
