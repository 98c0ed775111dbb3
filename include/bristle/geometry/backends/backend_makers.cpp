// How the backends make collidables in the scalar BRISTLE_INSTANTIATE.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/backends/analytic_backend.hpp>
#if defined(BRISTLE_WITH_FCL)
#include <bristle/geometry/backends/fcl_backend.hpp>
#endif

namespace bristle::inline BRISTLE_ABI {

BRISTLE_BACKEND_MAKERS(template, AnalyticBackend, BRISTLE_INSTANTIATE)
#if defined(BRISTLE_WITH_FCL)
template class FclBackend::Collidable<BRISTLE_INSTANTIATE>;
BRISTLE_BACKEND_MAKERS(template, FclBackend, BRISTLE_INSTANTIATE)
#endif

}  // namespace bristle::inline BRISTLE_ABI
