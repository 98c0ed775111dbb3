/// @file
/// Finds and reads the meshes of an AMBF description.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/mesh_validation.hpp>
#include <bristle/geometry/quickhull.hpp>
#include <bristle/geometry/shapes.hpp>
#include <bristle/geometry/triangle_mesh.hpp>
#include <bristle/io/adf_limits.hpp>
#include <bristle/io/adf_model.hpp>
#include <bristle/io/adf_report.hpp>
#include <bristle/io/mesh_file.hpp>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace bristle::detail {

/// Which folder of meshes is looked at first.
enum class AdfResolution { low, high };

/// Meshes by their files, each read once.
template <Scalar S>
class AdfMeshes {
 public:
  AdfMeshes(const AdfModel& model, const AdfLimits& limits) : model_(model), limits_(limits) {}

  /// The mesh of a body or sensor, in metres and unscaled.
  ///
  /// Shapes collide with the coarse mesh and sensors sit on the fine one, each with the other as a
  /// second choice; the folder of the description itself comes last. Paths of the body, where it
  /// has any, replace the model's.
  ///
  /// @throws AdfError when none of the folders has the file or it is too large, IoError when it
  ///         cannot be understood.
  [[nodiscard]] const TriangleMesh<S>& load(const AdfItem& item, const std::string& file,
                                            AdfResolution first, const AdfBody* body) {
    const std::filesystem::path path = find(item, file, first, body);
    const auto known = meshes_.find(path.string());
    if (known != meshes_.end()) return known->second;
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(path, error);
    if (!error && size > limits_.max_mesh_bytes) {
      fail(item, file,
           "must not be larger than " + std::to_string(limits_.max_mesh_bytes) + " bytes");
    }
    return meshes_.emplace(path.string(), weld(load_mesh<S>(path))).first->second;
  }

 private:
  [[nodiscard]] std::filesystem::path find(const AdfItem& item, const std::string& file,
                                           AdfResolution first, const AdfBody* body) const {
    const std::filesystem::path here = model_.file.parent_path();
    std::string high = model_.high_resolution_path;
    std::string low = model_.low_resolution_path;
    if (body != nullptr && !body->high_resolution_path.empty()) high = body->high_resolution_path;
    if (body != nullptr && !body->low_resolution_path.empty()) low = body->low_resolution_path;
    if (first == AdfResolution::high) std::swap(high, low);
    std::string places;
    for (const std::filesystem::path& folder : {here / low, here / high, here}) {
      std::error_code error;
      if (std::filesystem::is_regular_file(folder / file, error)) return folder / file;
      places += (places.empty() ? "" : ", ") + printable((folder / file).string());
    }
    fail(item, file, "must be a file; none of these is: " + places);
  }

  [[noreturn]] void fail(const AdfItem& item, const std::string& file, std::string rule) const {
    raise(AdfError(model_.file.string(), item.line, item.key + "/mesh", printable(file),
                   std::move(rule)));
  }

  const AdfModel& model_;
  const AdfLimits& limits_;
  std::map<std::string, TriangleMesh<S>> meshes_;
};

/// A mesh as a solid: without triangles that have no area, and turned right side out. None where
/// it does not close.
template <Scalar S>
[[nodiscard]] std::optional<TriangleMesh<S>> closed_solid(const TriangleMesh<S>& mesh) {
  const std::vector<std::uint32_t> flat = degenerate_triangles(mesh);
  TriangleMesh<S> solid = flat.empty() ? mesh : without_triangles<S>(mesh, flat);
  if (solid.triangles.empty()) return std::nullopt;
  if (signed_volume(solid) < S(0)) {
    for (auto& t : solid.triangles) std::swap(t[1], t[2]);
  }
  try {
    validate_solid(solid);
  } catch (const InvalidArgument&) {
    return std::nullopt;
  }
  return solid;
}

}  // namespace bristle::detail
