/// @file
/// Pose and twist of a body about its centre of mass, in one.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/spatial.hpp>
#include <bristle/math/transform.hpp>

namespace bristle::test {

template <Scalar S>
struct BodyMotion {
  Transform<S> pose{};
  Twist<S> twist{};
};

}  // namespace bristle::test
