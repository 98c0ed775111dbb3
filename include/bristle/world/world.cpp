// Worlds and haptic loops in the scalar BRISTLE_INSTANTIATE, and the choice of their kernels.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/core/kernel_tables.hpp>
#include <bristle/world/world.hpp>

namespace bristle::inline BRISTLE_ABI {

template <>
const detail::JointKernels<BRISTLE_INSTANTIATE>& detail::joint_kernels<BRISTLE_INSTANTIATE>() {
  return *static_cast<const detail::JointKernels<BRISTLE_INSTANTIATE>*>(
      BRISTLE_CHOSEN_KERNELS(BRISTLE_INSTANTIATE)().joint);
}

#define BRISTLE_WORLD(S, Backend, backend)                                        \
  template <>                                                                     \
  const detail::WorldKernels<S>& detail::world_kernels<S, Backend>() {            \
    return *static_cast<const detail::WorldKernels<S>*>(                          \
        BRISTLE_CHOSEN_KERNELS(S)().backend.world);                               \
  }                                                                               \
  template <>                                                                     \
  const detail::HapticKernels<S, Backend>& detail::haptic_kernels<S, Backend>() { \
    return *static_cast<const detail::HapticKernels<S, Backend>*>(                \
        BRISTLE_CHOSEN_KERNELS(S)().backend.haptic);                              \
  }                                                                               \
  template class World<S, Backend>;                                               \
  template class HapticLoop<S, Backend>;

BRISTLE_WORLD(BRISTLE_INSTANTIATE, AnalyticBackend, analytic)
#if defined(BRISTLE_WITH_FCL)
BRISTLE_WORLD(BRISTLE_INSTANTIATE, FclBackend, fcl)
#endif

}  // namespace bristle::inline BRISTLE_ABI
