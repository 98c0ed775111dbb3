/// @file
/// Reads a description in AMBF's format (ADF) into plain structs. Needs yaml-cpp.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/io/adf/adf_body_reader.hpp>
#include <bristle/io/adf/adf_joint_reader.hpp>
#include <bristle/io/adf/adf_limits.hpp>
#include <bristle/io/adf/adf_map.hpp>
#include <bristle/io/adf/adf_model.hpp>
#include <bristle/io/adf/adf_sensor_reader.hpp>
#include <bristle/io/adf/adf_tree.hpp>
#include <bristle/io/file.hpp>

#include <cstddef>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI::detail {

/// Reads a description from the text of an ADF file. Meshes are not read.
///
/// Missing values get the format's default. Keys that are not read are on the model's report, each
/// once, and so are blocks that no list names, and documents after the first.
///
/// @param file    Source of the text: for messages, and to find meshes beside it.
/// @throws AdfError that names line, key and rule, if the text is no YAML, a value is missing or
///         breaks a rule, or a limit is exceeded. No input throws anything else.
[[nodiscard]] AdfModel read_adf(std::string_view text, const std::filesystem::path& file,
                                const AdfLimits& limits = {});

/// Reads each document of a text, at least one. The limits hold for all together.
/// @throws AdfError as `read_adf`.
[[nodiscard]] std::vector<AdfModel> read_adf_documents(std::string_view text,
                                                       const std::filesystem::path& file,
                                                       const AdfLimits& limits = {});

/// Reads a description from a file.
/// @throws IoError if the file cannot be read, AdfError as `read_adf`.
[[nodiscard]] AdfModel load_adf(const std::filesystem::path& path, const AdfLimits& limits = {});

/// Reads each document of a file, at least one.
/// @throws IoError if the file cannot be read, AdfError as `read_adf`.
[[nodiscard]] std::vector<AdfModel> load_adf_documents(const std::filesystem::path& path,
                                                       const AdfLimits& limits = {});

// Implementation ----------------------------------------------------------------------------------

/// [-] Items and rays that the documents of a text have used so far.
struct AdfUsage {
  std::size_t items = 0;
  std::size_t rays = 0;
};

/// Reads the blocks that the lists of a model name.
class AdfReader {
 public:
  AdfReader(AdfTree& tree, const AdfLimits& limits, AdfUsage& usage)
      : limits_(limits), usage_(usage), root_(tree, 0, "", "") {}

  [[nodiscard]] AdfModel read(const std::filesystem::path& file) {
    if (root_.has("multibody configs")) {
      root_.fail("multibody configs", "must not be given: load_adf_launch reads launch files");
    }
    AdfModel model;
    model.file = file;
    model.name_space = root_.text("namespace", "");
    model.high_resolution_path = root_.text("high resolution path", "");
    model.low_resolution_path = root_.text("low resolution path", "");
    model.ignore_inter_collision = root_.flag("ignore inter-collision", false);
    if (root_.has("gravity")) model.gravity = root_.vector("gravity");

    std::vector<AdfSensor> surfaces;
    for_each("bodies", "body", [&](AdfMap& map, const AdfItem& item) {
      AdfBody& body = model.bodies.emplace_back();
      static_cast<AdfItem&>(body) = item;
      if (std::optional<AdfSensor> surface = read_adf_body(map, body)) {
        surfaces.push_back(std::move(*surface));
      }
      count(body.shapes.size(), map);
    });
    for_each("joints", "joint", [&](AdfMap& map, const AdfItem& item) {
      AdfJoint& joint = model.joints.emplace_back();
      static_cast<AdfItem&>(joint) = item;
      read_adf_joint(map, joint);
    });
    for_each("sensors", "sensor", [&](AdfMap& map, const AdfItem& item) {
      AdfSensor& sensor = model.sensors.emplace_back();
      static_cast<AdfItem&>(sensor) = item;
      read_adf_sensor(map, sensor);
      count_rays(sensor, map);
    });
    for_each("actuators", "actuator", [&](AdfMap& map, const AdfItem& item) {
      leave_out(map, item, "nothing is glued to a hand here");
    });
    for (AdfSensor& surface : surfaces) model.sensors.push_back(std::move(surface));
    leave_out_the_rest();
    root_.pass_aliased();
    root_.finish();
    model.report = std::move(root_.tree().report);
    return model;
  }

 private:
  /// Calls read(map, names) for each block that a list names.
  template <typename Read>
  void for_each(const char* list, const char* block, Read&& read) {
    std::set<std::string> seen;
    for (const auto& [key, line] : root_.texts(list)) {
      if (!seen.insert(key).second) {
        root_.tree().fail(line, list, printable(key), "must be named once");
      }
      if (!root_.has(key)) {
        root_.tree().fail(line, list, printable(key), "must be a key of this file");
      }
      AdfMap named = root_.map(key);
      AdfMap map = named.renamed(block);
      count(1, map);
      AdfItem item;
      item.key = key;
      item.line = map.line();
      item.qualified = map.text("namespace", name_space()) + key;
      for (const char c : map.text("name", key)) {
        if (c != ' ') item.name += c;
      }
      read(map, std::as_const(item));
      map.finish();
    }
  }

  [[nodiscard]] std::string name_space() { return root_.text("namespace", ""); }

  void leave_out(AdfMap& map, const AdfItem& item, const char* reason) {
    root_.tree().report.add(AdfNoteKind::left_out, printable(item.key), reason, item.line);
    map.pass_all();
  }

  /// Reports the kinds of objects that the world lacks.
  void leave_out_the_rest() {
    for (const char* list :
         {"soft bodies", "ghost objects", "vehicles", "volumes", "cameras", "lights"}) {
      // The Blender add-on writes `cameras: 'CAMERA '` if there is none.
      if (!root_.has_list(list)) {
        root_.skip({list}, "one of the kinds that are not read");
        continue;
      }
      for_each(list, list, [&](AdfMap& map, const AdfItem& item) {
        leave_out(map, item, "one of the kinds that are not read");
      });
    }
    root_.skip({"shaders"}, "looks");
    root_.skip({"plugins", "enable communication", "version"}, "communication");
    root_.skip({"joint erp", "joint cfm"}, "joints are solved exactly");
  }

  void count(std::size_t more, const AdfMap& map) {
    usage_.items += more;
    if (usage_.items > limits_.max_items) {
      root_.tree().fail(map.line(), map.path(), "",
                        "more than " + std::to_string(limits_.max_items) +
                            " bodies, shapes, joints, sensors and actuators");
    }
  }
  void count_rays(const AdfSensor& sensor, const AdfMap& map) {
    usage_.rays += sensor.array.size();
    if (sensor.fan) usage_.rays += sensor.fan->resolution * sensor.fan->resolution;
    if (usage_.rays > limits_.max_rays) {
      root_.tree().fail(map.line(), map.path(), "",
                        "more than " + std::to_string(limits_.max_rays) + " rays");
    }
  }

  const AdfLimits& limits_;
  AdfUsage& usage_;
  AdfMap root_;
};

inline AdfModel read_adf(std::string_view text, const std::filesystem::path& file,
                         const AdfLimits& limits) {
  std::vector<AdfTree> trees = read_adf_trees(text, file.string(), limits);
  for (std::size_t i = 1; i < trees.size(); ++i) {
    trees[0].report.add(AdfNoteKind::left_out, "document " + std::to_string(i + 1),
                        "load_adf_documents and read_adf_documents read it",
                        trees[i].nodes[0].line);
  }
  AdfUsage usage;
  return AdfReader(trees[0], limits, usage).read(file);
}

inline std::vector<AdfModel> read_adf_documents(std::string_view text,
                                                const std::filesystem::path& file,
                                                const AdfLimits& limits) {
  std::vector<AdfModel> models;
  AdfUsage usage;
  for (AdfTree& tree : read_adf_trees(text, file.string(), limits)) {
    models.push_back(AdfReader(tree, limits, usage).read(file));
  }
  return models;
}

/// Returns the text of a file.
/// @throws IoError if it cannot be read, AdfError if it is larger than the limit.
[[nodiscard]] inline std::string adf_text(const std::filesystem::path& path,
                                          const AdfLimits& limits) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (!error && size > limits.max_bytes) {
    raise(AdfError(path.string(), 0, "", "",
                   "larger than " + std::to_string(limits.max_bytes) + " bytes"));
  }
  return read_file(path.string());
}

inline AdfModel load_adf(const std::filesystem::path& path, const AdfLimits& limits) {
  return read_adf(adf_text(path, limits), path, limits);
}

inline std::vector<AdfModel> load_adf_documents(const std::filesystem::path& path,
                                                const AdfLimits& limits) {
  return read_adf_documents(adf_text(path, limits), path, limits);
}

}  // namespace bristle::inline BRISTLE_ABI::detail

namespace bristle::inline BRISTLE_ABI {

// For programs that read a file without a world, or change a model before it is added.
using detail::load_adf;
using detail::load_adf_documents;
using detail::read_adf;
using detail::read_adf_documents;

}  // namespace bristle::inline BRISTLE_ABI
