/// @file
/// Where the links of a chain over a cylinder lie.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include <cmath>
#include <numbers>
#include <vector>

namespace bristle::scenes {

/// Ends of the links of a chain that lies over a cylinder about the y axis and hangs down on both
/// sides, in the plane y = 0. Links are chords of that curve.
/// @param count  [-] Links.
/// @param pitch  [m] Length of a link.
/// @param round  [m] Radius of the curve.
/// @param shift  [m] Length that hangs further down on the side of positive x.
[[nodiscard]] inline std::vector<Eigen::Vector3d> chain_links(int count, double pitch, double round,
                                                              double shift) {
  // From the top to each side along the cylinder, then straight down.
  const auto along = [&](double s) -> Eigen::Vector3d {
    const double quarter = round * std::numbers::pi / 2;
    const double side = s < 0 ? -1 : 1;
    const double length = std::abs(s);
    if (length > quarter) return {side * round, 0, quarter - length};
    return {side * round * std::sin(length / round), 0, round * std::cos(length / round)};
  };
  double s = shift - pitch * count / 2;
  std::vector<Eigen::Vector3d> ends{along(s)};
  for (int i = 0; i < count; ++i) {
    double low = s;
    double high = s + 2 * pitch;
    for (int k = 0; k < 60; ++k) {
      const double middle = (low + high) / 2;
      ((along(middle) - ends.back()).norm() < pitch ? low : high) = middle;
    }
    s = high;
    ends.push_back(along(s));
  }
  return ends;
}

}  // namespace bristle::scenes
