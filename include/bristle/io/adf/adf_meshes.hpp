/// @file
/// Finds and reads the meshes of an AMBF description.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/geometry/meshes/triangle_mesh.hpp>
#include <bristle/io/adf/adf_limits.hpp>
#include <bristle/io/adf/adf_model.hpp>
#include <bristle/io/adf/adf_report.hpp>
#include <bristle/io/mesh_file.hpp>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <string>
#include <system_error>
#include <utility>

namespace bristle::inline BRISTLE_ABI::detail {

/// Folder of meshes that is searched first.
enum class AdfResolution { low, high };

/// Meshes by their files, each read once.
template <Scalar S>
class AdfMeshes {
 public:
  AdfMeshes(const AdfModel& model, const AdfLimits& limits) : model_(model), limits_(limits) {}

  /// Returns the mesh of a body or sensor, in metres and unscaled.
  ///
  /// Shapes collide with the coarse mesh and sensors are on the fine one. Each has the other as a
  /// second choice. The folder of the description itself comes last. Paths of the body replace the
  /// model's.
  ///
  /// @param key   Key of the item that names the file.
  /// @throws AdfError if no folder has the file, it is too large, or it is no valid mesh.
  [[nodiscard]] const TriangleMesh<S>& load(const AdfItem& item, const char* key,
                                            const std::string& file, AdfResolution first,
                                            const AdfBody* body) {
    const Search search = find(file, first, body);
    if (search.found.empty()) {
      fail(item, key, file, "must be a file; none of these is: " + search.places);
    }
    const std::filesystem::path& path = search.found;
    std::error_code error;
    // A file has many names: "a.stl", "./a.stl".
    const std::string one_name = std::filesystem::canonical(path, error).string();
    const auto known = meshes_.find(one_name);
    if (known != meshes_.end()) return known->second;
    const std::uintmax_t size = std::filesystem::file_size(path, error);
    if (!error && size > limits_.max_mesh_bytes) {
      fail(item, key, file,
           "must not be larger than " + std::to_string(limits_.max_mesh_bytes) + " bytes");
    }
    try {
      return meshes_.emplace(one_name, weld(load_mesh<S>(path.string()))).first->second;
    } catch (const IoError& fault) {
      fail(item, key, file, std::string("must be a mesh that can be read: ") + fault.what());
    } catch (const InvalidArgument& fault) {
      fail(item, key, file, std::string("must be a mesh that can be read: ") + fault.what());
    }
  }

  /// Where a mesh was looked for, for reports. Empty if it was found.
  [[nodiscard]] std::string missing_from(const std::string& file, AdfResolution first,
                                         const AdfBody* body) const {
    const Search search = find(file, first, body);
    return search.found.empty() ? search.places : std::string();
  }

 private:
  /// The file of a mesh, or empty, and the places where it is not.
  struct Search {
    std::filesystem::path found;
    std::string places;
  };

  [[nodiscard]] Search find(const std::string& file, AdfResolution first,
                            const AdfBody* body) const {
    const std::filesystem::path here = model_.file.parent_path();
    std::string high = model_.high_resolution_path;
    std::string low = model_.low_resolution_path;
    if (body != nullptr && !body->high_resolution_path.empty()) high = body->high_resolution_path;
    if (body != nullptr && !body->low_resolution_path.empty()) low = body->low_resolution_path;
    if (first == AdfResolution::high) std::swap(high, low);
    Search search;
    for (const std::filesystem::path& folder : {here / low, here / high, here}) {
      std::error_code error;
      if (std::filesystem::is_regular_file(folder / file, error)) {
        search.found = folder / file;
        break;
      }
      search.places +=
          (search.places.empty() ? "" : ", ") + printable_path((folder / file).string());
    }
    return search;
  }

  [[noreturn]] void fail(const AdfItem& item, const char* key, const std::string& file,
                         std::string rule) const {
    raise(AdfError(model_.file.string(), item.line, item.key + "/" + key, printable(file),
                   std::move(rule)));
  }

  const AdfModel& model_;
  const AdfLimits& limits_;
  std::map<std::string, TriangleMesh<S>> meshes_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
