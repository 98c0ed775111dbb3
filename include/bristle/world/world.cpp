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
template <>
const detail::HapticKernels<BRISTLE_INSTANTIATE>& detail::haptic_kernels<BRISTLE_INSTANTIATE>() {
  return *static_cast<const detail::HapticKernels<BRISTLE_INSTANTIATE>*>(
      BRISTLE_CHOSEN_KERNELS(BRISTLE_INSTANTIATE)().haptic);
}
template class HapticLoop<BRISTLE_INSTANTIATE>;

#define BRISTLE_WORLD(S, Backend, backend)                             \
  template <>                                                          \
  const detail::WorldKernels<S>& detail::world_kernels<S, Backend>() { \
    return *static_cast<const detail::WorldKernels<S>*>(               \
        BRISTLE_CHOSEN_KERNELS(S)().backend##_world);                  \
  }                                                                    \
  template class World<S, Backend>;

BRISTLE_WORLD(BRISTLE_INSTANTIATE, AnalyticBackend, analytic)
#if defined(BRISTLE_WITH_FCL)
BRISTLE_WORLD(BRISTLE_INSTANTIATE, FclBackend, fcl)
#endif

}  // namespace bristle::inline BRISTLE_ABI
