/// @file
/// Loads scenes in AMBF's description format (ADF) into a world. Opt-in: it needs yaml-cpp, which
/// the CMake target `bristle::adf` links.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/io/adf/adf_model.hpp>
#include <bristle/io/adf/adf_scene.hpp>
#include <bristle/world/world.hpp>

#include <filesystem>

namespace bristle::inline BRISTLE_ABI {

/// Adds the bodies, joints and sensors of a description to a world. docs/adf.md documents each key.
/// Joints and sensors that name a missing body are left out, and reported.
///
/// @throws AdfError that names line, key and rule, if the world refuses a value, a mesh is missing
///         or invalid, or a limit is exceeded. The world is unchanged then.
template <Scalar S, typename Backend>
AdfScene<S> add_adf(World<S, Backend>& world, const detail::AdfModel& model,
                    const AdfBuildDef<S>& def = {});

/// Reads a file and adds it to a world.
/// @throws IoError and AdfError as `load_adf` and `add_adf`.
template <Scalar S, typename Backend>
AdfScene<S> add_adf(World<S, Backend>& world, const std::filesystem::path& path,
                    const AdfBuildDef<S>& def = {});

}  // namespace bristle::inline BRISTLE_ABI

// Implementation ----------------------------------------------------------------------------------

#if BRISTLE_HAS_DEFINITIONS
#include <bristle/io/adf/adf_body_builder.hpp>
#include <bristle/io/adf/adf_fields.hpp>
#include <bristle/io/adf/adf_groups.hpp>
#include <bristle/io/adf/adf_joint_builder.hpp>
#include <bristle/io/adf/adf_meshes.hpp>
#include <bristle/io/adf/adf_names.hpp>
#include <bristle/io/adf/adf_reader.hpp>
#include <bristle/io/adf/adf_sensor_builder.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI {
namespace detail {

/// Adds the parts of a model one after the other.
template <Scalar S, typename Backend>
class AdfBuilder {
 public:
  AdfBuilder(World<S, Backend>& world, const AdfModel& model, const AdfBuildDef<S>& def)
      : world_(world), model_(model), def_(def), meshes_(model, def.limits) {
    scene_.report = model.report;
  }

  [[nodiscard]] AdfScene<S> build() {
    add_bodies();
    add_joints();
    add_sensors();
    return std::move(scene_);
  }

 private:
  using Found = std::pair<const AdfBody*, BodyId>;

  /// Runs an action for a block. If the world refuses it, that becomes an error of the block.
  template <typename Do>
  auto in_block(const AdfItem& item, Do&& action) {
    try {
      return action();
    } catch (const InvalidArgument& error) {
      const std::string_view key = adf_key_of(error.field());
      if (key.empty()) {
        raise(AdfError(model_.file.string(), item.line, item.key, "", error.what()));
      }
      raise(AdfError(model_.file.string(), item.line, item.key + "/" + std::string(key),
                     error.value(), error.rule()));
    }
  }

  /// Returns the body that a joint or sensor names under a key. Null if none or several match. Each
  /// name is searched once.
  [[nodiscard]] const Found* body_of(const AdfItem& item, const char* key,
                                     const std::string& name) {
    const auto known = looked_up_.find(name);
    if (known != looked_up_.end()) return known->second;
    const Found* const found = found_.find(name, searched_);
    if (searched_ > def_.limits.max_searched_bytes) {
      raise(AdfError(model_.file.string(), item.line, item.key + "/" + key, printable(name),
                     "must be a whole name: parts of names were looked for in more than " +
                         std::to_string(def_.limits.max_searched_bytes) + " bytes"));
    }
    return looked_up_[name] = found;
  }

  void add_bodies() {
    AdfBodyBuilder<S> builder(model_, def_, world_.def().gravity, meshes_, groups_, scene_.report);
    for (const AdfBody& body : model_.bodies) {
      const BodyId id = in_block(body, [&] { return world_.add_body(builder.body(body)); });
      scene_.bodies.add(body, id);
      found_.add(body, {&body, id});
    }
    if (!model_.ignore_inter_collision || scene_.bodies.size() == 0) return;
    // The index of the first body gives a group that no other model of the world has.
    const auto first = static_cast<std::int32_t>(scene_.bodies.begin()->value.index);
    for (const auto& body : scene_.bodies) {
      CollisionFilter filter = world_.body(body.value).filter;
      filter.group = -first_exclusion_group - first;
      world_.set_filter(body.value, filter);
    }
  }

  void add_joints() {
    AdfJointBuilder<S> builder(def_, scene_.report);
    for (const AdfJoint& joint : model_.joints) {
      const Found* const parent = body_of(joint, "parent", joint.parent);
      const Found* const child = body_of(joint, "child", joint.child);
      if (parent == nullptr || child == nullptr) {
        leave_out(joint, "no body, or several, by the name " +
                             printable(parent == nullptr ? joint.parent : joint.child));
        continue;
      }
      if (!world_.body(parent->second).is_dynamic() && !world_.body(child->second).is_dynamic()) {
        leave_out(joint, "neither body moves");
        continue;
      }
      const JointId id = in_block(joint, [&] {
        JointDef<S> joint_def =
            builder.joint(joint, *parent->first, *child->first, world_.pose(parent->second),
                          world_.pose(child->second));
        joint_def.body_a = parent->second;
        joint_def.body_b = child->second;
        return world_.add_joint(joint_def);
      });
      scene_.joints.add(joint, id);
      report_gap(joint, id);
    }
  }

  /// Reports the gap between bodies of a file at a joint. Files round values, often to three
  /// digits, and axes that close a loop then contradict each other.
  void report_gap(const AdfJoint& joint, JointId id) {
    const JointReading<S> reading = world_.reading(id);
    const auto beyond_round_off = [](S value) {
      return value > std::sqrt(std::numeric_limits<S>::epsilon()) ? static_cast<double>(value)
                                                                  : 0.0;
    };
    const double distance = beyond_round_off(reading.gap);
    const double angle = beyond_round_off(reading.tilt);
    if (distance == 0 && angle == 0) return;
    std::array<char, 96> apart{};
    std::snprintf(apart.data(), apart.size(),
                  "its frames stand %.2g m and %.2g rad apart; steps close what they can", distance,
                  angle);
    scene_.report.add(AdfNoteKind::changed, printable(joint.key), apart.data(), joint.line);
  }

  void add_sensors() {
    AdfSensorBuilder<S> builder(model_, def_, meshes_, scene_.report);
    std::vector<BodyId> with_patch;
    for (const AdfSensor& sensor : model_.sensors) {
      const Found* const carrier = body_of(sensor, "parent", sensor.parent);
      if (carrier == nullptr) {
        leave_out(sensor, "no body, or several, by the name " + printable(sensor.parent));
        continue;
      }
      const AdfBody* const body = carrier->first;
      const BodyId id = carrier->second;
      if (sensor.type == AdfSensorType::proximity) {
        scene_.proximity.add(
            sensor, in_block(sensor, [&] {
              return AdfProximity<S>{id, ProximityArray<S>(builder.rays(sensor, body))};
            }));
        continue;
      }
      // Blocks of sensors come first. If a body has one, the older form is a leftover.
      if (sensor.is_legacy_surface &&
          std::find(with_patch.begin(), with_patch.end(), id) != with_patch.end()) {
        leave_out(sensor, "its body has a sensor of today's form");
        continue;
      }
      scene_.patches.add(sensor, in_block(sensor, [&] {
                           return world_.add_patch(id, builder.patch(sensor, body));
                         }));
      with_patch.push_back(id);
    }
  }

  void leave_out(const AdfItem& item, const std::string& reason) {
    scene_.report.add(AdfNoteKind::left_out, printable(item.key), reason, item.line);
  }

  /// Groups up to here are the caller's.
  static constexpr std::int32_t first_exclusion_group = 1'000'000;

  World<S, Backend>& world_;
  const AdfModel& model_;
  const AdfBuildDef<S>& def_;
  AdfMeshes<S> meshes_;
  AdfGroups groups_;
  AdfScene<S> scene_;
  AdfNames<Found> found_;
  std::map<std::string, const Found*> looked_up_;
  std::size_t searched_ = 0;  // [-] Bytes.
};

}  // namespace detail

template <Scalar S, typename Backend>
AdfScene<S> add_adf(World<S, Backend>& world, const detail::AdfModel& model,
                    const AdfBuildDef<S>& def) {
  // Works on a copy, so that an error changes nothing.
  World<S, Backend> with_model = world;
  AdfScene<S> scene = detail::AdfBuilder<S, Backend>(with_model, model, def).build();
  world = std::move(with_model);
  return scene;
}

template <Scalar S, typename Backend>
AdfScene<S> add_adf(World<S, Backend>& world, const std::filesystem::path& path,
                    const AdfBuildDef<S>& def) {
  return add_adf(world, detail::load_adf(path, def.limits), def);
}

}  // namespace bristle::inline BRISTLE_ABI
#endif

/// Declares (`extern template`) or defines (`template`) the loaders of scenes for one kind of
/// world.
#define BRISTLE_ADF_FUNCTIONS(instantiate, S, Backend)                                          \
  instantiate AdfScene<S> add_adf<S, Backend>(World<S, Backend>&, const detail::AdfModel&,      \
                                              const AdfBuildDef<S>&);                           \
  instantiate AdfScene<S> add_adf<S, Backend>(World<S, Backend>&, const std::filesystem::path&, \
                                              const AdfBuildDef<S>&);

#if defined(BRISTLE_COMPILED) && BRISTLE_HAS_DEFINITIONS
namespace bristle::inline BRISTLE_ABI {

BRISTLE_ADF_FUNCTIONS(extern template, float, AnalyticBackend)
BRISTLE_ADF_FUNCTIONS(extern template, double, AnalyticBackend)
#if defined(BRISTLE_WITH_FCL)
BRISTLE_ADF_FUNCTIONS(extern template, float, FclBackend)
BRISTLE_ADF_FUNCTIONS(extern template, double, FclBackend)
#endif

}  // namespace bristle::inline BRISTLE_ABI
#endif
