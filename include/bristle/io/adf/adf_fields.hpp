/// @file
/// Keys of an AMBF description for the fields of definitions, and their rules.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <string_view>

namespace bristle::inline BRISTLE_ABI::detail {

/// A field of a definition as a description has it.
struct AdfField {
  /// Beginning of the field's name. Fields may end with an index.
  std::string_view name;
  /// Key that gives it.
  std::string_view key;
  /// Its rule in words of the format. Empty if that of the world says as much.
  std::string_view rule{};
};

/// Returns what a field is that the world refuses ("JointDef::swing_limit": "joint limits"). Its
/// key is empty if no single key gives the field.
[[nodiscard]] constexpr AdfField adf_field(std::string_view field) {
  constexpr AdfField fields[] = {{"BodyDef::mass", "mass"},
                                 {"BodyDef::shape: moment of inertia", "collision geometry",
                                  "must have moments of inertia that are > 0, and finite with a "
                                  "finite inverse, unless inertia is given"},
                                 {"BodyDef::inertia", "inertia"},
                                 {"BodyDef::center_of_mass", "inertial offset"},
                                 {"BodyDef::position", "location"},
                                 {"BodyDef::gravity_scale", "gravity"},
                                 {"ShapeDef::shape", "collision shape"},
                                 {"ShapeDef::X_BS", "collision offset"},
                                 {"Material::friction", "friction"},
                                 {"Material::restitution", "restitution"},
                                 {"Sphere::", "collision geometry"},
                                 {"Box::", "collision geometry"},
                                 {"Capsule::", "collision geometry"},
                                 {"Cylinder::", "collision geometry"},
                                 {"Cone::", "collision geometry"},
                                 {"HalfSpace::", "collision geometry"},
                                 {"JointDef::body_b", "child", "must not be the parent as well"},
                                 {"JointDef::X_AJ.translation", "parent pivot"},
                                 {"JointDef::X_BJ.translation", "child pivot"},
                                 {"JointDef::lower_limit", "joint limits"},
                                 {"JointDef::upper_limit", "joint limits"},
                                 {"JointDef::swing_limit", "joint limits"},
                                 {"JointSpring::stiffness", "stiffness"},
                                 {"JointSpring::damping", "damping"},
                                 {"JointSpring::rest", "equilibrium point"},
                                 {"JointBushing::stiffness", "stiffness"},
                                 {"JointBushing::damping", "damping"},
                                 {"JointMotor::max_force", "max motor impulse"},
                                 {"SensorParameters::normal_stiffness", "contact stiffness"},
                                 {"SensorParameters::normal_damping", "contact damping"},
                                 {"SensorParameters::static_friction", "friction/static"},
                                 {"SensorParameters::sliding_friction", "friction/dynamic"},
                                 {"SensorParameters::breakaway_distance", "contact area"},
                                 {"SensorLayout::start", "location"},
                                 {"SensorLayout::length", "range"},
                                 {"PlacementDef::depth", "depth"},
                                 {"PlacementDef::range", "range"},
                                 {"PlacementDef::X_AM", "location"}};
  for (const AdfField& each : fields) {
    if (field.substr(0, each.name.size()) == each.name) return each;
  }
  return {};
}

}  // namespace bristle::inline BRISTLE_ABI::detail
