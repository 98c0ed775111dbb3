// Loaders of scenes in the scalar BRISTLE_INSTANTIATE.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/io/adf.hpp>

namespace bristle::inline BRISTLE_ABI {

BRISTLE_ADF_FUNCTIONS(template, BRISTLE_INSTANTIATE, AnalyticBackend)
#if defined(BRISTLE_WITH_FCL)
BRISTLE_ADF_FUNCTIONS(template, BRISTLE_INSTANTIATE, FclBackend)
#endif

}  // namespace bristle::inline BRISTLE_ABI
