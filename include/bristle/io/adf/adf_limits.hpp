/// @file
/// Limits on the resources that an AMBF description may ask for.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <cstddef>

namespace bristle::inline BRISTLE_ABI {

/// Limits on the resources that a description may ask for. The defaults are far above any real
/// scene and far below the memory of a machine. Lower them to read untrusted files on a small one.
struct AdfLimits {
  /// [-] Bytes of the file. A scene of seventy bodies has 75 000. yaml-cpp's scanner keeps an open
  /// flow list whole, at worst some 270 bytes for each byte of the file (docs/adf.md).
  std::size_t max_bytes = std::size_t{1} << 20;
  /// [-] Nesting depth of maps and lists.
  std::size_t max_depth = 32;
  /// [-] Maps, lists and scalars, and keys that maps merge from others.
  std::size_t max_nodes = 200'000;
  /// [-] Bodies, joints, sensors and actuators, and shapes of all bodies.
  std::size_t max_items = 20'000;
  /// [-] Rays of all sensors.
  std::size_t max_rays = 1'000'000;
  /// [-] Bytes of one mesh file.
  std::size_t max_mesh_bytes = std::size_t{64} << 20;
  /// [-] Triangles that bodies collide with. Each body's solid counts, and each mesh once for each
  /// scale at which it becomes a solid.
  std::size_t max_triangles = 1'000'000;
  /// [-] Bytes of names that partial names are searched in.
  std::size_t max_searched_bytes = std::size_t{1} << 28;
};

}  // namespace bristle::inline BRISTLE_ABI
