// Sensors on meshes and rectangles in float and double.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/sensors/placement.hpp>

namespace bristle::inline BRISTLE_ABI {

template SensorLayout<float> sensor_grid<float>(const SensorGridDef<float>& def);
template SensorLayout<float> sensors_from_mesh<float>(const TriangleMesh<float>& mesh,
                                                      const PlacementDef<float>& def,
                                                      PlacementReport* report);
template SensorLayout<double> sensor_grid<double>(const SensorGridDef<double>& def);
template SensorLayout<double> sensors_from_mesh<double>(const TriangleMesh<double>& mesh,
                                                        const PlacementDef<double>& def,
                                                        PlacementReport* report);

}  // namespace bristle::inline BRISTLE_ABI
