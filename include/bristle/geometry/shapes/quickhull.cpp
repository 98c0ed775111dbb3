// Convex hulls in float and double.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/shapes/quickhull.hpp>

namespace bristle::inline BRISTLE_ABI {

BRISTLE_HULL_FUNCTIONS(template, float)
BRISTLE_HULL_FUNCTIONS(template, double)

}  // namespace bristle::inline BRISTLE_ABI
