// The backends of compiled_backends.hpp.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/compiled_backends.hpp"

namespace bristle {

BRISTLE_TEST_BACKEND(template, AnalyticBackend, float)
BRISTLE_TEST_BACKEND(template, AnalyticBackend, double)
#if defined(BRISTLE_WITH_FCL)
BRISTLE_TEST_BACKEND(template, FclBackend, float)
BRISTLE_TEST_BACKEND(template, FclBackend, double)
#endif

}  // namespace bristle
