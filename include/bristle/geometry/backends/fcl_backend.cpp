// The functions of `FclBackend` in the scalar BRISTLE_INSTANTIATE.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/backends/fcl_backend.hpp>

namespace bristle::inline BRISTLE_ABI {

template class FclBackend::Collidable<BRISTLE_INSTANTIATE>;
BRISTLE_BACKEND_FUNCTIONS(template, FclBackend, BRISTLE_INSTANTIATE)

}  // namespace bristle::inline BRISTLE_ABI
