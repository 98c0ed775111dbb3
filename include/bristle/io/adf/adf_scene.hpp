/// @file
/// What became of an AMBF description in a world, and how it is to become part of one.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/joints/joint.hpp>
#include <bristle/io/adf/adf_limits.hpp>
#include <bristle/io/adf/adf_names.hpp>
#include <bristle/io/adf/adf_report.hpp>
#include <bristle/sensors/patch.hpp>
#include <bristle/world/proximity.hpp>

namespace bristle::inline BRISTLE_ABI {

/// A proximity sensor and the body that carries it: `world.sense(p.carrier, p.rays)` reads it.
template <Scalar S>
struct AdfProximity {
  BodyId carrier{};
  ProximityArray<S> rays;
};

/// A description that has been added to a world.
template <Scalar S>
struct AdfScene {
  AdfNames<BodyId> bodies;
  AdfNames<JointId> joints;
  AdfNames<PatchId> patches;
  AdfNames<AdfProximity<S>> proximity;
  /// What was not taken as it stands, from reading and from building.
  AdfReport report;
};

/// How a description becomes part of a world.
template <Scalar S>
struct AdfBuildDef {
  /// [m] Pose of the model's frame in the world.
  Transform<S> X_WM{};
  /// [-] Whether joints with a controller are held where they stand, by a spring of its P and a
  /// damper of its D. Else joints are free until they are given a drive, as in AMBF.
  bool hold_joints = false;
  /// [s] Step of the loop for which the file's damping was chosen: constants that the format means
  /// per step are taken for this one.
  S authored_step = S(1e-3);
  /// [-] How the forces of patches enter the step.
  Integration integration = Integration::automatic;
  /// [-] Readings of the law, but for what friction grows with, which each sensor says.
  LawOptions law{};
  /// [-] What meshes and their rays may ask for.
  AdfLimits limits{};
};

}  // namespace bristle::inline BRISTLE_ABI
