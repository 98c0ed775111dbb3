/// @file
/// Reads the joints of an AMBF description.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/io/adf/adf_map.hpp>
#include <bristle/io/adf/adf_model.hpp>
#include <bristle/io/text_scanner.hpp>

#include <array>
#include <string>
#include <utility>

namespace bristle::inline BRISTLE_ABI::detail {

[[nodiscard]] inline AdfJointType read_adf_joint_type(AdfMap& map) {
  constexpr std::pair<const char*, AdfJointType> names[] = {
      {"hinge", AdfJointType::revolute},
      {"revolute", AdfJointType::revolute},
      {"continuous", AdfJointType::revolute},
      {"slider", AdfJointType::prismatic},
      {"prismatic", AdfJointType::prismatic},
      {"fixed", AdfJointType::fixed},
      {"spring", AdfJointType::linear_spring},
      {"linear spring", AdfJointType::linear_spring},
      {"torsion spring", AdfJointType::torsion_spring},
      {"torsional spring", AdfJointType::torsion_spring},
      {"angular spring", AdfJointType::torsion_spring},
      {"p2p", AdfJointType::point_to_point},
      {"cone twist", AdfJointType::cone_twist},
      {"six dof", AdfJointType::six_dof},
      {"six dof spring", AdfJointType::six_dof_spring}};
  const std::string word = to_lower(map.text("type"));
  for (const auto& [name, type] : names) {
    if (word == name) return type;
  }
  map.fail("type",
           "must be one of hinge, revolute, continuous, slider, prismatic, fixed, spring, linear "
           "spring, torsion spring, torsional spring, angular spring, p2p, cone twist, six dof, "
           "six dof spring");
}

/// Reads {linear: {x, y, z}, angular: {x, y, z}}.
[[nodiscard]] inline std::array<double, 6> read_adf_six(AdfMap& map, const char* key) {
  std::array<double, 6> result{};
  if (!map.has(key)) return result;
  AdfMap six = map.map(key);
  std::size_t i = 0;
  for (const char* part : {"linear", "angular"}) {
    AdfMap axes = six.map(part);
    for (const char* axis : {"x", "y", "z"}) result[i++] = axes.number(axis, adf_not_negative);
    axes.finish();
  }
  six.finish();
  return result;
}

/// Reads limits, springs and dampers of the one free axis.
inline void read_adf_axis(AdfMap& map, AdfJoint& joint) {
  double middle = 0.0;
  if (map.has("joint limits")) {
    AdfMap limits = map.map("joint limits");
    if (limits.has("low") && limits.has("high")) {
      const AdfRange range{limits.number("low", adf_finite), limits.number("high", adf_finite)};
      middle = range.low + 0.5 * (range.high - range.low);
      if (range.low <= range.high) {
        joint.limits = range;
      } else {
        map.note(AdfNoteKind::changed, "joint limits", "low is above high: free, as in Bullet");
      }
    }
    limits.finish();
  }
  joint.stiffness = map.number("stiffness", 0.0, adf_not_negative);
  joint.damping = map.number("damping", 0.0, adf_not_negative);
  joint.equilibrium = map.number("equilibrium point", middle, adf_finite);
}

/// Skips the springs and dampers of joints without them here.
inline void skip_adf_springs(AdfMap& map) {
  map.skip({"stiffness", "damping", "equilibrium point"}, "joints of this type have no springs");
}

inline void read_adf_controller(AdfMap& map, AdfJoint& joint) {
  if (map.has("controller")) {
    AdfMap gains = map.map("controller");
    joint.controller = AdfGains{.P = gains.number("P", 0.0, adf_not_negative),
                                .I = gains.number("I", 0.0, adf_not_negative),
                                .D = gains.number("D", 0.0, adf_not_negative)};
    if (joint.controller->I > 0.0) {
      gains.note(AdfNoteKind::unsupported, "I", "controllers have no integral part");
    }
    gains.finish();
  }
  joint.max_motor_impulse =
      map.number("max motor impulse", joint.max_motor_impulse, adf_not_negative);
}

/// Reads all of a joint but its names.
inline void read_adf_joint(AdfMap& map, AdfJoint& joint) {
  joint.type = read_adf_joint_type(map);
  joint.parent = map.text("parent");
  joint.child = map.text("child");
  joint.parent_pivot = map.vector("parent pivot");
  joint.child_pivot = map.vector("child pivot");
  joint.parent_axis = map.direction("parent axis");
  joint.child_axis = map.direction("child axis");
  // Two names of one value. The shorter wins.
  const double child_offset = map.number("child offset", 0.0, adf_finite);
  joint.offset = map.number("offset", child_offset, adf_finite);
  joint.frame_offset = map.number("joint offset", 0.0, adf_finite);
  switch (joint.type) {
    case AdfJointType::revolute:
    case AdfJointType::prismatic:
    case AdfJointType::linear_spring:
    case AdfJointType::torsion_spring:
      read_adf_axis(map, joint);
      break;
    case AdfJointType::cone_twist:
      if (map.has("joint limits")) joint.cone_limits = map.vector("joint limits");
      if (!(joint.cone_limits.x() >= 0.0 && joint.cone_limits.tail<2>().minCoeff() > 0.0)) {
        map.fail("joint limits", "must have x >= 0, y and z > 0");
      }
      skip_adf_springs(map);
      break;
    case AdfJointType::six_dof_spring:
      joint.six_stiffness = read_adf_six(map, "stiffness");
      joint.six_damping = read_adf_six(map, "damping");
      map.skip({"equilibrium point"},
               "springs of six degrees of freedom rest where the frames meet");
      map.skip({"joint limits"}, "joints of six degrees of freedom have no stops");
      break;
    case AdfJointType::six_dof:
      map.note(AdfNoteKind::changed, "type",
               "six dof: holds nothing, since its stops are not read");
      map.skip({"joint limits"}, "joints of six degrees of freedom have no stops");
      skip_adf_springs(map);
      break;
    case AdfJointType::point_to_point:
      map.skip({"joint limits"}, "ball joints have no stops");
      skip_adf_springs(map);
      break;
    case AdfJointType::fixed:
      break;
  }
  read_adf_controller(map, joint);
  joint.ignore_inter_collision = map.flag("ignore inter-collision", true);
  map.pass({"joint limits", "stiffness", "damping", "equilibrium point"});
  map.skip({"joint erp", "joint cfm"}, "joints are solved exactly");
  map.skip({"enable motor", "controller output type"}, "a joint is free until it is given a motor");
  map.skip({"enable feedback", "passive", "publish frequency", "plugins"}, "communication");
  map.skip({"detached", "origin", "axis"}, "not used by the format's own reader");
}

}  // namespace bristle::inline BRISTLE_ABI::detail
