// Patches of hosts in the scalar BRISTLE_INSTANTIATE, and the choice of their kernels.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/core/kernel_tables.hpp>
#include <bristle/hosts/sensor_host.hpp>

namespace bristle::inline BRISTLE_ABI {

template <>
const HostKernels<BRISTLE_INSTANTIATE>& host_kernels<BRISTLE_INSTANTIATE>() {
  return *static_cast<const HostKernels<BRISTLE_INSTANTIATE>*>(
      BRISTLE_CHOSEN_KERNELS(BRISTLE_INSTANTIATE)().host);
}
template class HostPatch<BRISTLE_INSTANTIATE>;

}  // namespace bristle::inline BRISTLE_ABI
