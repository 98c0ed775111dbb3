// Worlds and haptic loops in the scalar BRISTLE_INSTANTIATE, and the choice of their kernels.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/core/kernel_tables.hpp>
#include <bristle/world/world.hpp>

namespace bristle::inline BRISTLE_ABI {
namespace {

template <typename Backend>
using Kernels = WorldKernels<BRISTLE_INSTANTIATE, Backend>;

}  // namespace

template <>
const Kernels<AnalyticBackend>& world_kernels<BRISTLE_INSTANTIATE, AnalyticBackend>() {
  return *static_cast<const Kernels<AnalyticBackend>*>(
      BRISTLE_CHOSEN_KERNELS(BRISTLE_INSTANTIATE)().analytic);
}
template class World<BRISTLE_INSTANTIATE, AnalyticBackend>;
template class HapticLoop<BRISTLE_INSTANTIATE, AnalyticBackend>;

#if defined(BRISTLE_WITH_FCL)
template <>
const Kernels<FclBackend>& world_kernels<BRISTLE_INSTANTIATE, FclBackend>() {
  return *static_cast<const Kernels<FclBackend>*>(
      BRISTLE_CHOSEN_KERNELS(BRISTLE_INSTANTIATE)().fcl);
}
template class World<BRISTLE_INSTANTIATE, FclBackend>;
template class HapticLoop<BRISTLE_INSTANTIATE, FclBackend>;
#endif

}  // namespace bristle::inline BRISTLE_ABI
