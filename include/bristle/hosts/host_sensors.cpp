// Host sensors in float and double, and the choice of their kernels.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/core/kernel_tables.hpp>
#include <bristle/hosts/host_sensors.hpp>

namespace bristle::inline BRISTLE_ABI {

#define BRISTLE_HOSTS(S)                                                                  \
  template <>                                                                             \
  const detail::HostKernels<S>& detail::host_kernels<S>() {                               \
    return *static_cast<const detail::HostKernels<S>*>(BRISTLE_CHOSEN_KERNELS(S)().host); \
  }                                                                                       \
  template struct detail::HostStep<S>;                                                    \
  template class HostSensors<S, AnalyticBackend>;
BRISTLE_HOSTS(float)
BRISTLE_HOSTS(double)
#if defined(BRISTLE_WITH_FCL)
template class HostSensors<float, FclBackend>;
template class HostSensors<double, FclBackend>;
#endif

}  // namespace bristle::inline BRISTLE_ABI
