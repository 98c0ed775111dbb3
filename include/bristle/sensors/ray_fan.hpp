/// @file
/// Rays that spread from one point, row by row: scanners, range finders, whisker fans.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/sensors/sensor_layout.hpp>

#include <cmath>
#include <cstddef>
#include <numbers>

namespace bristle::inline BRISTLE_ABI {

/// Fan in the frame A of its carrier. Rays lie in the middles of equal cells of azimuth and
/// elevation. So a fan of one row and a width of 2 pi goes round without a duplicate ray.
template <Scalar S>
struct RayFanDef {
  /// [m] Point from which the rays spread.
  Vec3<S> origin = detail::zero<Vec3<S>>();
  /// [1] Direction of the middle of the fan; any length but 0.
  Vec3<S> forward = detail::unit_x<Vec3<S>>();
  /// [1] Axis of the azimuth, made perpendicular to `forward`; must not be along it.
  Vec3<S> up = detail::unit_z<Vec3<S>>();
  /// [rad] Whole angle of the columns, around `up`, in [0, 2 pi].
  S width = S(std::numbers::pi) / S(2);
  /// [rad] Whole angle of the rows, in [0, pi].
  S height = S(0);
  /// [-] Rays in a row, from the right (negative azimuth) to the left; >= 1.
  std::size_t columns = 1;
  /// [-] Rows, from below to above; >= 1.
  std::size_t rows = 1;
  /// [m] Distance of the rays' starts from the origin. Finite, >= 0.
  S start = S(0);
  /// [m] Length of the rays from there. Finite, > 0.
  S range = S(1);
};

/// The rays of a fan, row by row.
/// @throws InvalidArgument when the definition breaks a rule.
template <Scalar S>
[[nodiscard]] SensorLayout<S> ray_fan(const RayFanDef<S>& def);

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
SensorLayout<S> ray_fan(const RayFanDef<S>& def) {
  using std::cos;
  using std::sin;
  detail::require_all_finite("RayFanDef::origin", def.origin);
  detail::require_all_finite("RayFanDef::forward", def.forward);
  detail::require_all_finite("RayFanDef::up", def.up);
  const S pi = S(std::numbers::pi);
  detail::require(
      def.width >= S(0) && def.width <= S(2) * pi * (S(1) + detail::Tolerance<S>::equal()),
      "RayFanDef::width", def.width, "must be in [0, 2 pi]");
  detail::require(def.height >= S(0) && def.height <= pi * (S(1) + detail::Tolerance<S>::equal()),
                  "RayFanDef::height", def.height, "must be in [0, pi]");
  detail::require(def.columns > 0, "RayFanDef::columns", def.columns, "must be >= 1");
  detail::require(def.rows > 0, "RayFanDef::rows", def.rows, "must be >= 1");
  detail::require_not_negative("RayFanDef::start", def.start);
  detail::require_positive("RayFanDef::range", def.range);
  detail::require(def.forward.stableNorm() > S(0), "RayFanDef::forward", S(0), "must not be 0");
  const Vec3<S> forward = def.forward.stableNormalized();
  const Vec3<S> left_of = def.up.stableNormalized().cross(forward);
  detail::require(left_of.norm() > detail::Tolerance<S>::equal(), "RayFanDef::up", left_of.norm(),
                  "must not be along forward");
  const Vec3<S> left = left_of.normalized();
  const Vec3<S> up = forward.cross(left);

  const auto middle = [](std::size_t i, std::size_t count, S whole) {
    return ((static_cast<S>(i) + S(0.5)) / static_cast<S>(count) - S(0.5)) * whole;
  };
  SensorLayout<S> layout;
  for (std::size_t row = 0; row < def.rows; ++row) {
    const S elevation = middle(row, def.rows, def.height);
    for (std::size_t column = 0; column < def.columns; ++column) {
      const S azimuth = middle(column, def.columns, def.width);
      const Vec3<S> direction =
          cos(elevation) * (cos(azimuth) * forward + sin(azimuth) * left) + sin(elevation) * up;
      layout.add(Vec3<S>(def.origin + def.start * direction), direction.normalized(), def.range);
    }
  }
  return layout;
}

}  // namespace bristle::inline BRISTLE_ABI
