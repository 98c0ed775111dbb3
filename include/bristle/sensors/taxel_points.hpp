/// @file
/// Readings of a patch as a set of points: how each taxel gives way, and the force on it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/rotation.hpp>
#include <bristle/sensors/law.hpp>
#include <bristle/sensors/patch.hpp>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// [-] Numbers of a taxel in a set of points: dx, dy, dz, Fx, Fy, Fz.
inline constexpr std::size_t taxel_point_size = 6;

/// Writes for each sensor its displacement dx, dy, dz [m] and the force Fx, Fy, Fz [N] on it, in
/// the axes of the patch's body. Both are of the last step, the displacement as the step began:
/// along the ray the depth, across it the stretch of the bristle, towards where the other body took
/// it. In a hold the force pulls the same way as the displacement across the ray, and along the ray
/// both point inwards. Zeros without a contact.
template <Scalar S>
void write_taxel_points(const SensorPatch<S>& patch, S* out) {
  std::fill_n(out, taxel_point_size * patch.size(), S(0));
  for (std::size_t k = 0; k < patch.active_lanes.size(); ++k) {
    const RayPacket<S>& rays = patch.geometry->packets[k];
    const BristlePacket<S>& bristles = patch.bristles[k];
    for (std::uint32_t rest = patch.active_lanes[k]; rest != 0; rest &= rest - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(rest));
      const std::size_t i = k * packet_size + lane;
      const BodyId body = patch.readings.body[i];
      const Vec3<S> n = rays.direction[lane];
      const Vec3<S> t1 = rays.tangent[lane];
      Vec3<S> displacement = (-patch.readings.depth[i] * patch.geometry->length[i]) * n;
      const auto other = std::find_if(patch.sensed.begin(), patch.sensed.end(),
                                      [&](const auto& met) { return met.body == body.index; });
      if (other != patch.sensed.end() && (patch.is_anchored[k] >> lane & 1u) != 0) {
        displacement -=
            anchor_stretch<S>({bristles.anchor_a[lane], bristles.anchor_b[lane]}, other->pose, n);
      }
      const Vec3<S> force = patch.readings.shear_1[i] * t1 +
                            patch.readings.shear_2[i] * n.cross(t1) -
                            patch.readings.normal_force[i] * n;
      S* const to = out + taxel_point_size * i;
      std::copy_n(force.data(), 3, std::copy_n(displacement.data(), 3, to));
    }
  }
}

}  // namespace bristle::inline BRISTLE_ABI::detail
