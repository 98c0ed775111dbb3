// Queries of the backends in a step. Both are in one file, since they share most of their geometry.
// So are both scalars: narrow phases of float search in double. This file is compiled for the
// instruction set BRISTLE_KERNELS.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/backends/analytic_backend.hpp>
#if defined(BRISTLE_WITH_FCL)
#include <bristle/geometry/backends/fcl_backend.hpp>
#endif

namespace bristle::inline BRISTLE_ABI {

BRISTLE_BACKEND_QUERIES(template, AnalyticBackend, float)
BRISTLE_BACKEND_QUERIES(template, AnalyticBackend, double)
#if defined(BRISTLE_WITH_FCL)
BRISTLE_BACKEND_QUERIES(template, FclBackend, float)
BRISTLE_BACKEND_QUERIES(template, FclBackend, double)
#endif

}  // namespace bristle::inline BRISTLE_ABI
