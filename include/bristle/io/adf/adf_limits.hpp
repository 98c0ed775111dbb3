/// @file
/// What an AMBF description may ask for at most.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <cstddef>

namespace bristle::inline BRISTLE_ABI {

/// What a description may ask for at most. The defaults are far above any real scene and far below
/// what a machine has; whoever reads files of strangers on a small one lowers them.
struct AdfLimits {
  /// [-] Bytes of the file. A scene of seventy bodies has 75 000. The scanner of yaml-cpp keeps all
  /// of an open flow list, at worst some 270 bytes for each of the file (docs/adf.md).
  std::size_t max_bytes = std::size_t{1} << 20;
  /// [-] Levels of maps and lists in each other.
  std::size_t max_depth = 32;
  /// [-] Maps, lists and scalars, and keys that maps take from others by merging.
  std::size_t max_nodes = 200'000;
  /// [-] Bodies, joints, sensors and actuators, and shapes of all bodies.
  std::size_t max_items = 20'000;
  /// [-] Rays of all sensors.
  std::size_t max_rays = 1'000'000;
  /// [-] Bytes of one mesh file.
  std::size_t max_mesh_bytes = std::size_t{64} << 20;
  /// [-] Triangles that bodies collide with: those of each body's solid, and of each mesh once for
  /// each scale in which it is made into a solid.
  std::size_t max_triangles = 1'000'000;
  /// [-] Bytes of names in which names that are no whole ones are looked for.
  std::size_t max_searched_bytes = std::size_t{1} << 28;
};

}  // namespace bristle::inline BRISTLE_ABI
