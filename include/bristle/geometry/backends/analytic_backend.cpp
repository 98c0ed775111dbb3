// The functions of `AnalyticBackend` in the scalar BRISTLE_INSTANTIATE.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/backends/analytic_backend.hpp>

namespace bristle::inline BRISTLE_ABI {

BRISTLE_BACKEND_FUNCTIONS(template, AnalyticBackend, BRISTLE_INSTANTIATE)

}  // namespace bristle::inline BRISTLE_ABI
