// What a step asks of the backends, in the scalar BRISTLE_INSTANTIATE. Both are in one file, since
// they share most of their geometry. This file is compiled for the instruction set BRISTLE_KERNELS.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/backends/analytic_backend.hpp>
#if defined(BRISTLE_WITH_FCL)
#include <bristle/geometry/backends/fcl_backend.hpp>
#endif

namespace bristle::inline BRISTLE_ABI {

BRISTLE_BACKEND_QUERIES(template, AnalyticBackend, BRISTLE_INSTANTIATE)
#if defined(BRISTLE_WITH_FCL)
BRISTLE_BACKEND_QUERIES(template, FclBackend, BRISTLE_INSTANTIATE)
#endif

}  // namespace bristle::inline BRISTLE_ABI
