/// @file
/// Handle of FCL geometry, without FCL's own headers.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <memory>

namespace fcl {
template <typename S>
class CollisionGeometry;
}  // namespace fcl

namespace bristle::inline BRISTLE_ABI::detail {

/// Immutable FCL geometry, shared by its users.
using FclGeometry = std::shared_ptr<const fcl::CollisionGeometry<double>>;

}  // namespace bristle::inline BRISTLE_ABI::detail
