/// @file
/// Keys of an AMBF description for the fields of definitions.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <string_view>
#include <utility>

namespace bristle::inline BRISTLE_ABI::detail {

/// Returns the key of a field that the world refuses ("JointDef::swing_limit": "joint limits"). It
/// is empty if no single key gives the field. Fields may end with an index.
[[nodiscard]] constexpr std::string_view adf_key_of(std::string_view field) {
  using Pair = std::pair<std::string_view, std::string_view>;
  constexpr Pair keys[] = {{"BodyDef::mass", "mass"},
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
                           {"JointDef::body_b", "child"},
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
  for (const auto& [name, key] : keys) {
    if (field.substr(0, name.size()) == name) return key;
  }
  return {};
}

}  // namespace bristle::inline BRISTLE_ABI::detail
