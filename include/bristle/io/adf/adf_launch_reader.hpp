/// @file
/// Reads launch files of AMBF: which descriptions make a scene, and in which world. Needs yaml-cpp.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/io/adf/adf_launch.hpp>
#include <bristle/io/adf/adf_limits.hpp>
#include <bristle/io/adf/adf_map.hpp>
#include <bristle/io/adf/adf_model.hpp>
#include <bristle/io/adf/adf_reader.hpp>
#include <bristle/io/adf/adf_report.hpp>
#include <bristle/io/adf/adf_tree.hpp>

#include <cstddef>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// Reads a launch file, its world file, and the models that it lists.
///
/// @param which   Numbers of the models in the launch file, from 0, as AMBF's option `-l` has them.
///                Empty: all.
/// @param limits  Limits of each file.
/// @throws IoError if the launch file cannot be read, AdfError as `load_adf`, if a file that it
///         names is missing, or if it has no model of a number.
[[nodiscard]] AdfLaunch load_adf_launch(const std::filesystem::path& path,
                                        const std::vector<std::size_t>& which = {},
                                        const AdfLimits& limits = {});

// Implementation ----------------------------------------------------------------------------------

namespace detail {

/// The root of the first document of a file. Its models are elsewhere.
class AdfRoot {
 public:
  AdfRoot(const std::filesystem::path& path, const AdfLimits& limits)
      : folder_(path.parent_path()),
        trees_(read_adf_trees(adf_text(path, limits), path.string(), limits)),
        map_(trees_[0], 0, "", "") {}

  [[nodiscard]] AdfMap& map() { return map_; }

  /// Returns the path of a file that a key names. Paths are relative to the file that has them.
  [[nodiscard]] std::filesystem::path path_of(std::string_view key, const std::string& name) const {
    const std::filesystem::path path = folder_ / name;
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) {
      map_.fail(key, "must name files; this is none: " + printable_path(path.string()));
    }
    return path;
  }

  /// Reports what was not read.
  [[nodiscard]] AdfReport finish() {
    for (const char* list : {"lights", "cameras"}) {
      if (!map_.has_list(list)) continue;
      for (const auto& [block, line] : map_.texts(list)) map_.pass({block.c_str()});
    }
    map_.skip({"lights", "cameras", "skybox", "shaders", "color config"}, "looks");
    map_.skip({"enclosure size"}, "walls are not made: a floor is an environment's");
    map_.skip({"input devices config", "plugins", "namespace", "name"}, "communication");
    map_.skip({"max iterations"}, "the caller steps the world");
    map_.finish();
    return std::move(trees_[0].report);
  }

 private:
  std::filesystem::path folder_;
  std::vector<AdfTree> trees_;
  AdfMap map_;
};

/// Adds the models of a file to a launch.
inline void load_models(AdfLaunch& launch, const std::filesystem::path& path,
                        const AdfLimits& limits) {
  for (AdfModel& model : load_adf_documents(path, limits)) {
    if (!model.gravity) model.gravity = launch.gravity;
    launch.models.push_back(std::move(model));
  }
}

}  // namespace detail

inline AdfLaunch load_adf_launch(const std::filesystem::path& path,
                                 const std::vector<std::size_t>& which, const AdfLimits& limits) {
  AdfLaunch launch;
  detail::AdfRoot root(path, limits);
  if (!root.map().has("multibody configs")) root.map().fail("multibody configs", "must be given");
  const auto names = root.map().texts("multibody configs");
  if (root.map().has("world config")) {
    const std::string name = root.map().text("world config");
    detail::AdfRoot world(root.path_of("world config", name), limits);
    if (world.map().has("gravity")) launch.gravity = world.map().vector("gravity");
    if (world.map().has("environment")) {
      const std::string floor = world.map().text("environment");
      detail::load_models(launch, world.path_of("environment", floor), limits);
    }
    launch.report.append(world.finish());
  }
  const auto add = [&](std::size_t i) {
    detail::load_models(launch, root.path_of("multibody configs", names[i].first), limits);
  };
  for (const std::size_t i : which) {
    if (i >= names.size()) {
      root.map().fail("multibody configs", "has " + std::to_string(names.size()) +
                                               " files, and none of number " + std::to_string(i));
    }
    add(i);
  }
  if (which.empty()) {
    for (std::size_t i = 0; i < names.size(); ++i) add(i);
  }
  launch.report.append(root.finish());
  return launch;
}

}  // namespace bristle::inline BRISTLE_ABI
