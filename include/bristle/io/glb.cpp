// Recordings as glTF in the scalar BRISTLE_INSTANTIATE.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/io/glb.hpp>

namespace bristle::inline BRISTLE_ABI {

template std::string glb<BRISTLE_INSTANTIATE>(const Recording<BRISTLE_INSTANTIATE>& recording,
                                              const GlbDef& def);

}  // namespace bristle::inline BRISTLE_ABI
