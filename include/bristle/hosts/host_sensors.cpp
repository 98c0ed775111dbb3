// Host sensors in the scalar BRISTLE_INSTANTIATE, and the choice of their kernels.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/core/kernel_tables.hpp>
#include <bristle/hosts/host_sensors.hpp>

namespace bristle::inline BRISTLE_ABI {

#define BRISTLE_HOSTS(S, Backend, backend)                                    \
  template <>                                                                 \
  const detail::HostKernels<S, Backend>& detail::host_kernels<S, Backend>() { \
    return *static_cast<const detail::HostKernels<S, Backend>*>(              \
        BRISTLE_CHOSEN_KERNELS(S)().backend.host);                            \
  }                                                                           \
  template class HostSensors<S, Backend>;

BRISTLE_HOSTS(BRISTLE_INSTANTIATE, AnalyticBackend, analytic)
#if defined(BRISTLE_WITH_FCL)
BRISTLE_HOSTS(BRISTLE_INSTANTIATE, FclBackend, fcl)
#endif

}  // namespace bristle::inline BRISTLE_ABI
