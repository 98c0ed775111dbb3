// Loaders of meshes in the scalar BRISTLE_INSTANTIATE.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/io/mesh_file.hpp>

namespace bristle::inline BRISTLE_ABI {

template TriangleMesh<BRISTLE_INSTANTIATE> load_mesh<BRISTLE_INSTANTIATE>(
    const std::filesystem::path& path);

}  // namespace bristle::inline BRISTLE_ABI
