// Terrain in float and double.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/meshes/terrain.hpp>

namespace bristle::inline BRISTLE_ABI {

BRISTLE_TERRAIN_FUNCTIONS(template, float)
BRISTLE_TERRAIN_FUNCTIONS(template, double)

}  // namespace bristle::inline BRISTLE_ABI
