/// @file
/// Content of an AMBF description (ADF): plain structs, defaults filled in, before any world.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/shapes/shapes.hpp>
#include <bristle/io/adf/adf_report.hpp>
#include <bristle/math/transform.hpp>

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace bristle::inline BRISTLE_ABI::detail {

/// Fields common to bodies, joints, sensors and actuators.
struct AdfItem {
  /// Key of its block ("BODY Tip").
  std::string key;
  /// Namespace and key, by which other items name it ("/ambf/env/gripper/BODY Tip").
  std::string qualified;
  /// Its own `name`, without blanks. The key if it has none.
  std::string name;
  /// 1-based line of its block.
  std::size_t line = 0;
};

/// A primitive of a body's collision geometry.
struct AdfShape {
  /// [m] The primitive, unscaled.
  Shape<double> shape{};
  /// [m] Its pose in the body frame, unscaled. The primitive's axis is along z of this frame.
  Transform<double> X_BS{};
};

/// Collision geometry of a mesh.
enum class AdfMeshType { convex_hull, concave };

/// A body. Lengths are those of the file, before `scale`.
struct AdfBody : AdfItem {
  /// [m] Pose of the body frame in the model.
  Transform<double> location{};
  /// [1] Factor on shapes, meshes, their positions, the centre of mass and the pivots of joints.
  double scale = 1.0;
  /// [kg] Mass; 0 for a body that does not move.
  double mass = 1.0;
  /// [kg m^2] Principal moments along the axes of `inertial_offset`; unset: those of the shapes.
  std::optional<Vec3<double>> inertia{};
  /// [m] Centre of mass and principal axes in the body frame; unset: a mesh's own, or the origin.
  std::optional<Transform<double>> inertial_offset{};
  /// [-] Primitives of the collision geometry. If there are any, no mesh collides.
  std::vector<AdfShape> shapes{};
  /// [-] File of the collision mesh. Empty for none.
  std::string collision_mesh{};
  AdfMeshType mesh_type = AdfMeshType::concave;
  /// [-] File of the visual mesh. Empty for none.
  std::string visual_mesh{};
  /// [-] Folders of meshes, in place of the model's; empty: the model's.
  std::string high_resolution_path{};
  std::string low_resolution_path{};
  /// [1] Coefficients as in Bullet: those of a pair are the product.
  double friction = 0.5;
  double restitution = 0.1;
  /// [1] Part of the linear and the angular velocity that is lost in a second, at most 1.
  double linear_damping = 0.04;
  double angular_damping = 0.1;
  /// [-] Bodies with groups collide if they share one; a body without collides with all.
  std::vector<std::size_t> collision_groups{};
  /// [m/s^2] Gravity of this body, in place of the world's.
  std::optional<Vec3<double>> gravity{};
};

/// Free motion of a joint, under the names of the format.
enum class AdfJointType {
  fixed,
  revolute,
  prismatic,
  linear_spring,
  torsion_spring,
  point_to_point,
  cone_twist,
  six_dof,
  six_dof_spring
};

/// Gains of a joint's controller.
struct AdfGains {
  /// [N/m, N m/rad], [N/(m s), ...], [N s/m, ...] Gains of the error, its integral and its rate.
  double P = 0.0;
  double I = 0.0;
  double D = 0.0;
};

/// Largest and smallest coordinate.
struct AdfRange {
  double low = 0.0;
  double high = 0.0;
};

/// A joint. Its zero: the child's axis is turned to the parent's by the shortest way, then the
/// child by `offset` about it. Its frame is that of the parent, turned so that z (of a slide x) is
/// along the axis, and by `frame_offset` about it.
struct AdfJoint : AdfItem {
  AdfJointType type = AdfJointType::fixed;
  /// [-] Names of the two bodies.
  std::string parent;
  std::string child;
  /// [m] Point of the joint in the frame of either body, unscaled.
  Vec3<double> parent_pivot = zero<Vec3<double>>();
  Vec3<double> child_pivot = zero<Vec3<double>>();
  /// [1] Unit axis of the joint in those frames.
  Vec3<double> parent_axis = unit_z<Vec3<double>>();
  Vec3<double> child_axis = unit_z<Vec3<double>>();
  /// [rad] As above: `offset` of the format, or `child offset`, and `joint offset`.
  double offset = 0.0;
  double frame_offset = 0.0;
  /// [m or rad] Limits of the free axis; unset: none, or the lower one was above the upper.
  std::optional<AdfRange> limits{};
  /// [N/m or N m/rad], [N s/m or N m s/rad], [m or rad] Passive spring and damper, and rest
  /// position of the spring.
  double stiffness = 0.0;
  double damping = 0.0;
  double equilibrium = 0.0;
  /// [rad] Limits of a cone twist: largest turn about x of the joint's frame, and tilts of x.
  Vec3<double> cone_limits = filled<Vec3<double>>(0.7);
  /// Constants of a six-degree spring: along and about x, y, z.
  std::array<double, 6> six_stiffness{};
  std::array<double, 6> six_damping{};
  std::optional<AdfGains> controller{};
  /// [N s or N m s] Largest impulse a step of the motor of a joint without a controller.
  double max_motor_impulse = 0.1;
  /// [-] True if the two bodies pass through each other.
  bool ignore_inter_collision = true;
};

/// A ray of a sensor, in the sensor's frame.
struct AdfRay {
  /// [m] Start.
  Vec3<double> offset = zero<Vec3<double>>();
  /// [1] Unit direction.
  Vec3<double> direction = unit_x<Vec3<double>>();
};

/// A fan of `resolution` x `resolution` rays about x.
struct AdfFan {
  /// [-] Rays in a row, and rows, >= 2.
  std::size_t resolution = 2;
  /// [rad] Angles between the first and the last ray.
  double horizontal_angle = 0.0;
  double vertical_angle = 0.0;
  /// [m] Distance of the starts from the origin.
  double start_offset = 0.0;
};

enum class AdfSensorType { proximity, resistance };

/// A sensor: rays with common constants. Of array, mesh and fan the first given one counts.
struct AdfSensor : AdfItem {
  AdfSensorType type = AdfSensorType::proximity;
  /// [-] Name of the body that carries it.
  std::string parent;
  /// [m] Pose of the sensor's frame in the frame of that body.
  Transform<double> location{};
  /// [m] Length of the rays.
  double range = 0.5;
  std::vector<AdfRay> array{};
  /// [-] File of the mesh with a ray on each face. Empty for none.
  std::string mesh{};
  std::optional<AdfFan> fan{};
  /// [m] Depth of the rays' starts below the mesh.
  double depth = 0.0;
  /// [1/m] (or [N/m] unless `variable`) mu_S.
  double static_friction = 0.0;
  /// [N s/m] mu_V.
  double dynamic_friction = 0.0;
  /// [N/m a step] Damping of the bristle.
  double friction_damping = 0.1;
  /// [-] True if friction grows with the normal force.
  bool variable_friction = false;
  /// [m] sigma_a.
  double contact_area = 0.1;
  /// [N] K_N.
  double contact_stiffness = 0.0;
  /// [-] True if it was nested in its body, as a block `resistive surface` of 2019.
  bool is_legacy_surface = false;
  /// [N s a step] K_D.
  double contact_damping = 0.0;
};

/// A whole description.
struct AdfModel {
  /// [-] Source file, for error messages and to find meshes beside it.
  std::filesystem::path file{};
  std::string name_space{};
  /// [-] Folders of meshes, relative to the file's.
  std::string high_resolution_path{};
  std::string low_resolution_path{};
  /// [-] True if no two of its bodies collide.
  bool ignore_inter_collision = false;
  /// [m/s^2] Gravity of its bodies, in place of the world's.
  std::optional<Vec3<double>> gravity{};
  std::vector<AdfBody> bodies{};
  std::vector<AdfJoint> joints{};
  std::vector<AdfSensor> sensors{};
  /// Parts of the file that are not in this model.
  AdfReport report{};
};

}  // namespace bristle::inline BRISTLE_ABI::detail

namespace bristle::inline BRISTLE_ABI {

// For programs that read a file without a world, or change a model before it is added.
using detail::AdfModel;

}  // namespace bristle::inline BRISTLE_ABI
