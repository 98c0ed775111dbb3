// Worlds and haptic loops in the scalar BRISTLE_INSTANTIATE, and the choice of their kernels.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/core/kernel_tables.hpp>
#include <bristle/world/world.hpp>

namespace bristle::inline BRISTLE_ABI {

#define BRISTLE_WORLD(S, Backend, backend)                                        \
  template <>                                                                     \
  const detail::WorldKernels<S, Backend>& detail::world_kernels<S, Backend>() {   \
    return *static_cast<const detail::WorldKernels<S, Backend>*>(                 \
        BRISTLE_CHOSEN_KERNELS(S)().backend.world);                               \
  }                                                                               \
  template <>                                                                     \
  const detail::JointKernels<S, Backend>& detail::joint_kernels<S, Backend>() {   \
    return *static_cast<const detail::JointKernels<S, Backend>*>(                 \
        BRISTLE_CHOSEN_KERNELS(S)().backend.joint);                               \
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
