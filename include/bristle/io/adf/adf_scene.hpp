/// @file
/// Options for building an AMBF description into a world, and the resulting handles.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/joints/joint.hpp>
#include <bristle/io/adf/adf_groups.hpp>
#include <bristle/io/adf/adf_limits.hpp>
#include <bristle/io/adf/adf_names.hpp>
#include <bristle/io/adf/adf_report.hpp>
#include <bristle/sensors/patch.hpp>
#include <bristle/world/proximity.hpp>

#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// A proximity sensor and its body: `world.sense(p.carrier, p.rays)` reads it.
template <Scalar S>
struct AdfProximity {
  /// Body that carries the sensor.
  BodyId carrier{};
  /// Rays in the frame of that body.
  ProximityArray<S> rays;
};

namespace detail {

/// Groups and scales of the files of a scene, which those added later depend on.
struct AdfHistory {
  /// Category bits of collision groups.
  AdfGroups groups;
  /// [1] Scales of the scene's bodies, in their order.
  std::vector<double> scales;
};

}  // namespace detail

/// Descriptions that have been added to a world: one, or several whose names refer to each other.
template <Scalar S>
struct AdfScene {
  /// Handles of the bodies, by the names of the description.
  detail::AdfNames<BodyId> bodies;
  /// Handles of the joints, by name.
  detail::AdfNames<JointId> joints;
  /// Handles of the tactile patches, by name.
  detail::AdfNames<PatchId> patches;
  /// Proximity sensors and their bodies, by name.
  detail::AdfNames<AdfProximity<S>> proximity;
  /// Changed or omitted parts, from reading and from building.
  AdfReport report;
  /// Record of these files for those that are added later.
  detail::AdfHistory history{};
};

/// Options for adding a description to a world.
template <Scalar S>
struct AdfBuildDef {
  /// [m] Pose of the model's frame in the world.
  Transform<S> X_WM{};
  /// [-] True if joints with a controller are held where they stand, by a spring of its P and a
  /// damper of its D. Else joints are free until they are given a motor, as in AMBF.
  bool hold_joints = false;
  /// [-] True if the joints of planar loops are fitted to the plane of their loop, where they are
  /// out of it by no more than numbers with three digits after the point explain. Loops of rounded
  /// axes cannot move otherwise.
  bool fit_loops = true;
  /// [s] Step for which the file's damping was chosen. Constants that the format gives per step are
  /// converted with it.
  S authored_step = S(1e-3);
  /// [-] Integration of the patches' forces.
  Integration integration = Integration::automatic;
  /// [-] Options of the law. Each sensor itself says whether friction grows with the normal force.
  LawOptions law{};
  /// [-] True if a mesh that no folder has is no error. A body with it has no shape, and is left
  /// out if it moves and its inertia is not given; a sensor on it is left out. All of it is
  /// reported.
  bool allow_missing_meshes = false;
  /// [-] Limits for meshes and their rays.
  AdfLimits limits{};
};

}  // namespace bristle::inline BRISTLE_ABI
