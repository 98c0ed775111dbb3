/// @file
/// A cube to put anywhere.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/bodies/body.hpp>

namespace bristle::scenes {

/// A cube of 0.2 m and 1 kg at the world's origin.
[[nodiscard]] inline BodyDef<double> brick() {
  BodyDef<double> def;
  def.mass = 1;
  def.shape = Box<double>{{0.1, 0.1, 0.1}};
  return def;
}

}  // namespace bristle::scenes
