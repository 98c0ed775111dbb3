/// @file
/// How the FCL backend hands its geometry around, without FCL's own headers.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <memory>

namespace fcl {
template <typename S>
class CollisionGeometry;
}  // namespace fcl

namespace bristle::inline BRISTLE_ABI {

/// FCL geometry that nobody changes any more, shared by all who use it.
using FclGeometry = std::shared_ptr<const fcl::CollisionGeometry<double>>;

}  // namespace bristle::inline BRISTLE_ABI
