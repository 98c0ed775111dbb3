// Loaders of meshes in float and double.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/io/mesh_file.hpp>

namespace bristle::inline BRISTLE_ABI {

template TriangleMesh<float> load_mesh<float>(const std::string& path);
template TriangleMesh<double> load_mesh<double>(const std::string& path);

}  // namespace bristle::inline BRISTLE_ABI
