// Host sensors in float and double, and the choice of their kernels.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/core/kernel_tables.hpp>
#include <bristle/hosts/host_sensors.hpp>

namespace bristle::inline BRISTLE_ABI {

template <>
const detail::HostKernels<float>& detail::host_kernels<float>() {
  return *static_cast<const detail::HostKernels<float>*>(chosen_kernels_float().host);
}
template struct detail::HostStep<float>;
template class HostSensors<float, AnalyticBackend>;
#if defined(BRISTLE_WITH_FCL)
template class HostSensors<float, FclBackend>;
#endif

template <>
const detail::HostKernels<double>& detail::host_kernels<double>() {
  return *static_cast<const detail::HostKernels<double>*>(chosen_kernels_double().host);
}
template struct detail::HostStep<double>;
template class HostSensors<double, AnalyticBackend>;
#if defined(BRISTLE_WITH_FCL)
template class HostSensors<double, FclBackend>;
#endif

}  // namespace bristle::inline BRISTLE_ABI
