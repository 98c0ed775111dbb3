/// @file
/// A thick box in place of a half-space, for engines that have none or that do not let boxes touch
/// one well.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scenes/rigid/scene.hpp"

#include <algorithm>
#include <variant>

namespace bristle::work_precision {

/// A box of 60 x 60 x 2 m whose upper face lies in the surface of the half-space.
struct Slab {
  scenes::Vector half{30, 30, 1};
  scenes::Vector position = scenes::Vector::Zero();
  scenes::Rotation orientation = scenes::Rotation::Identity();
};

[[nodiscard]] inline Slab slab_of(const HalfSpace<double>& ground) {
  Slab slab;
  slab.position = (ground.offset - slab.half.z()) * ground.normal;
  slab.orientation = scenes::turn_between(scenes::Vector::UnitZ(), ground.normal);
  return slab;
}

template <typename ShapeType>
[[nodiscard]] bool has_shape(const scenes::Scene& scene) {
  return std::ranges::any_of(scene.bodies, [](const scenes::SceneBody& body) {
    return std::holds_alternative<ShapeType>(body.shape);
  });
}

}  // namespace bristle::work_precision
