// Recordings as glTF in float and double.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/io/glb.hpp>

namespace bristle::inline BRISTLE_ABI {

template std::string glb<float>(const Recording<float>& recording, const GlbDef& def);
template std::string glb<double>(const Recording<double>& recording, const GlbDef& def);

}  // namespace bristle::inline BRISTLE_ABI
