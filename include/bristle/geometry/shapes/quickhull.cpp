// Convex hulls in the scalar BRISTLE_INSTANTIATE.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/shapes/quickhull.hpp>

namespace bristle::inline BRISTLE_ABI {

BRISTLE_HULL_FUNCTIONS(template, BRISTLE_INSTANTIATE)

}  // namespace bristle::inline BRISTLE_ABI
