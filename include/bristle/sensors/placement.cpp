// Instantiates sensors on meshes and rectangles for the scalar BRISTLE_INSTANTIATE.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/sensors/placement.hpp>

namespace bristle::inline BRISTLE_ABI {

template SensorLayout<BRISTLE_INSTANTIATE> sensor_grid<BRISTLE_INSTANTIATE>(
    const SensorGridDef<BRISTLE_INSTANTIATE>& def);
template SensorLayout<BRISTLE_INSTANTIATE> sensors_from_mesh<BRISTLE_INSTANTIATE>(
    const TriangleMesh<BRISTLE_INSTANTIATE>& mesh, const PlacementDef<BRISTLE_INSTANTIATE>& def,
    PlacementReport* report);

}  // namespace bristle::inline BRISTLE_ABI
