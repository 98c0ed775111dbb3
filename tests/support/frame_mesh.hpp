/// @file
/// A frame whose flat faces cannot be one plate each.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/meshes/triangle_mesh.hpp>

#include <array>
#include <cstddef>
#include <cstdint>

namespace bristle::test {

/// Eight squares of 0.1 m around a hole, from the origin along x and y, 0.1 m thick, top at z = 0.
[[nodiscard]] inline TriangleMesh<double> frame_mesh() {
  TriangleMesh<double> frame;
  for (const double z : {0.0, -0.1}) {
    for (int y = 0; y < 4; ++y) {
      for (int x = 0; x < 4; ++x) frame.vertices.push_back({0.1 * x, 0.1 * y, z});
    }
  }
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    frame.triangles.push_back({a, b, c});
    frame.triangles.push_back({a, c, d});
  };
  const auto is_square = [](int x, int y) {
    return x >= 0 && x < 3 && y >= 0 && y < 3 && (x != 1 || y != 1);
  };
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 3; ++x) {
      if (!is_square(x, y)) continue;
      const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(4 * (y + j) + x + i); };
      const std::array<std::uint32_t, 4> ring{at(0, 0), at(1, 0), at(1, 1), at(0, 1)};
      add(ring[0], ring[1], ring[2], ring[3]);
      add(16 + ring[3], 16 + ring[2], 16 + ring[1], 16 + ring[0]);
      const std::array<std::array<int, 2>, 4> across{{{0, -1}, {1, 0}, {0, 1}, {-1, 0}}};
      for (std::size_t k = 0; k < 4; ++k) {
        if (is_square(x + across[k][0], y + across[k][1])) continue;
        const std::uint32_t from = ring[k];
        const std::uint32_t to = ring[(k + 1) % 4];
        add(16 + from, 16 + to, to, from);
      }
    }
  }
  return frame;
}

}  // namespace bristle::test
