/// @file
/// Mesh files of any known kind, distinguished by extension.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/meshes/triangle_mesh.hpp>
#include <bristle/math/types.hpp>

#include <string>

namespace bristle::inline BRISTLE_ABI {

/// Reads a mesh from an .stl or .obj file (in either case), as `read_stl` and `read_obj` do. It may
/// be open, inverted or degenerate. Its users check that.
///
/// @throws IoError if the file cannot be read or parsed, or has another extension.
template <Scalar S>
[[nodiscard]] TriangleMesh<S> load_mesh(const std::string& path);

}  // namespace bristle::inline BRISTLE_ABI

// Implementation ----------------------------------------------------------------------------------

#if BRISTLE_HAS_DEFINITIONS
#include <bristle/core/error.hpp>
#include <bristle/io/file.hpp>
#include <bristle/io/obj.hpp>
#include <bristle/io/stl.hpp>
#include <bristle/io/text_scanner.hpp>

#include <cstddef>

namespace bristle::inline BRISTLE_ABI {

template <Scalar S>
TriangleMesh<S> load_mesh(const std::string& path) {
  const std::size_t dot = path.find_last_of("./\\");
  const std::string extension = dot == std::string::npos ? "" : detail::to_lower(path.substr(dot));
  if (extension == ".stl") return read_stl<S>(read_file(path), path);
  if (extension == ".obj") return read_obj<S>(read_file(path), path);
  detail::raise(IoError(path, 0, "unknown kind of mesh file (known: .stl, .obj)"));
}

}  // namespace bristle::inline BRISTLE_ABI
#endif

#if defined(BRISTLE_COMPILED) && BRISTLE_HAS_DEFINITIONS
namespace bristle::inline BRISTLE_ABI {

extern template TriangleMesh<float> load_mesh<float>(const std::string& path);
extern template TriangleMesh<double> load_mesh<double>(const std::string& path);

}  // namespace bristle::inline BRISTLE_ABI
#endif
