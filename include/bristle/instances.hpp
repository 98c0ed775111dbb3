/// @file
/// Instantiates the declarations of BRISTLE_COMPILED in the scalar BRISTLE_INSTANTIATE. The file's
/// own instruction set is used. One such file is the library of a program that is built without
/// CMake.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#if defined(BRISTLE_INSTANTIATE)
#include <bristle/geometry/meshes/terrain.hpp>
#include <bristle/geometry/shapes/quickhull.hpp>
#include <bristle/hosts/host_stage.hpp>
#include <bristle/sensors/placement.hpp>
#include <bristle/world/kernels_impl.hpp>
#include <bristle/world/world.hpp>
#if defined(BRISTLE_WITH_FILES)
#include <bristle/io/glb.hpp>
#include <bristle/io/mesh_file.hpp>
#endif

namespace bristle::inline BRISTLE_ABI {

/// @param S  float or double.
#define BRISTLE_MAKE_WORLD(S, Backend)                                 \
  BRISTLE_BACKEND_QUERIES(template, Backend, S)                        \
  BRISTLE_BACKEND_MAKERS(template, Backend, S)                         \
  template <>                                                          \
  const detail::WorldKernels<S>& detail::world_kernels<S, Backend>() { \
    return detail::own_world_kernels<S, Backend>();                    \
  }                                                                    \
  template class World<S, Backend>;                                    \
  template class HostSensors<S, Backend>;
template <>
const detail::JointKernels<BRISTLE_INSTANTIATE>& detail::joint_kernels<BRISTLE_INSTANTIATE>() {
  return detail::own_joint_kernels<BRISTLE_INSTANTIATE>();
}
template <>
const detail::HapticKernels<BRISTLE_INSTANTIATE>& detail::haptic_kernels<BRISTLE_INSTANTIATE>() {
  return detail::own_haptic_kernels<BRISTLE_INSTANTIATE>();
}
template <>
const detail::HostKernels<BRISTLE_INSTANTIATE>& detail::host_kernels<BRISTLE_INSTANTIATE>() {
  return detail::own_host_kernels<BRISTLE_INSTANTIATE>();
}
template class HapticLoop<BRISTLE_INSTANTIATE>;
template struct detail::HostStep<BRISTLE_INSTANTIATE>;
BRISTLE_MAKE_WORLD(BRISTLE_INSTANTIATE, AnalyticBackend)
#if defined(BRISTLE_WITH_FCL)
template class FclBackend::Collidable<BRISTLE_INSTANTIATE>;
BRISTLE_MAKE_WORLD(BRISTLE_INSTANTIATE, FclBackend)
#endif
#undef BRISTLE_MAKE_WORLD

BRISTLE_HULL_FUNCTIONS(template, BRISTLE_INSTANTIATE)
BRISTLE_TERRAIN_FUNCTIONS(template, BRISTLE_INSTANTIATE)
template SensorLayout<BRISTLE_INSTANTIATE> sensor_grid<BRISTLE_INSTANTIATE>(
    const SensorGridDef<BRISTLE_INSTANTIATE>& def);
template SensorLayout<BRISTLE_INSTANTIATE> sensors_from_mesh<BRISTLE_INSTANTIATE>(
    const TriangleMesh<BRISTLE_INSTANTIATE>& mesh, const PlacementDef<BRISTLE_INSTANTIATE>& def,
    PlacementReport* report);
#if defined(BRISTLE_WITH_FILES)
template std::string glb<BRISTLE_INSTANTIATE>(const Recording<BRISTLE_INSTANTIATE>& recording,
                                              const GlbDef& def);
template TriangleMesh<BRISTLE_INSTANTIATE> load_mesh<BRISTLE_INSTANTIATE>(const std::string& path);
#endif

}  // namespace bristle::inline BRISTLE_ABI
#endif
