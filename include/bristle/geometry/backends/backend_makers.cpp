// How the backends make collidables, in float and double.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/backends/analytic_backend.hpp>
#if defined(BRISTLE_WITH_FCL)
#include <bristle/geometry/backends/fcl_backend.hpp>
#endif

namespace bristle::inline BRISTLE_ABI {

BRISTLE_BACKEND_MAKERS(template, AnalyticBackend, float)
BRISTLE_BACKEND_MAKERS(template, AnalyticBackend, double)
#if defined(BRISTLE_WITH_FCL)
template class FclBackend::Collidable<float>;
template class FclBackend::Collidable<double>;
BRISTLE_BACKEND_MAKERS(template, FclBackend, float)
BRISTLE_BACKEND_MAKERS(template, FclBackend, double)
#endif

}  // namespace bristle::inline BRISTLE_ABI
