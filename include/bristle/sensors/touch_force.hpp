/// @file
/// The force of a sensor on what it touches.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/rotation.hpp>
#include <bristle/sensors/reading.hpp>

#include <cstddef>

namespace bristle::inline BRISTLE_ABI {

/// [N] Force of one sensor on what it touches, in the frame that the direction is given in. The
/// reading itself has the one on the sensor's own body.
/// @param direction  [1] Of the sensor's ray, in the frame of its body.
template <Scalar S>
[[nodiscard]] Vec3<S> touch_force(const PatchReading<S>& reading, std::size_t sensor,
                                  const Vec3<S>& direction) {
  Vec3<S> t1, t2;
  tangent_basis<S>(direction, t1, t2);
  return reading.normal_force[sensor] * direction - reading.shear_1[sensor] * t1 -
         reading.shear_2[sensor] * t2;
}

}  // namespace bristle::inline BRISTLE_ABI
