/// @file
/// Adds the parts of an AMBF description to a world.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/io/adf/adf_body_builder.hpp>
#include <bristle/io/adf/adf_fields.hpp>
#include <bristle/io/adf/adf_groups.hpp>
#include <bristle/io/adf/adf_joint_builder.hpp>
#include <bristle/io/adf/adf_joint_plan.hpp>
#include <bristle/io/adf/adf_meshes.hpp>
#include <bristle/io/adf/adf_names.hpp>
#include <bristle/io/adf/adf_scene.hpp>
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

namespace bristle::inline BRISTLE_ABI::detail {

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
    std::vector<AdfPlannedJoint<S>> planned;
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
      const double scale_a = parent->first->scale;
      const double scale_b = child->first->scale;
      planned.push_back({.joint = &joint,
                         .def = builder.joint(joint, scale_a, scale_b),
                         .X_WA = world_.pose(parent->second),
                         .X_WB = world_.pose(child->second),
                         .node_a = node_of(parent->second),
                         .node_b = node_of(child->second),
                         .scale_a = scale_a,
                         .scale_b = scale_b});
      planned.back().def.body_a = parent->second;
      planned.back().def.body_b = child->second;
    }
    if (def_.fit_loops) fit_loops(planned);
    for (AdfPlannedJoint<S>& plan : planned) {
      builder.hold(*plan.joint, plan.X_WA, plan.X_WB, plan.def);
      const JointId id = in_block(*plan.joint, [&] { return world_.add_joint(plan.def); });
      scene_.joints.add(*plan.joint, id);
      report_gap(plan, id);
    }
  }

  /// Number of a body in the graph of joints. All that do not move are one.
  [[nodiscard]] std::size_t node_of(BodyId id) const {
    return world_.body(id).is_dynamic() ? id.index + std::size_t{1} : 0;
  }

  /// Reports how far the bodies of a file stand apart at a joint. Files round values, often to
  /// three digits, and axes that close a loop then contradict each other.
  void report_gap(const AdfPlannedJoint<S>& plan, JointId id) {
    const double of_round_off = std::sqrt(static_cast<double>(std::numeric_limits<S>::epsilon()));
    const auto add = [&](const char* format, double distance, double angle) {
      if (distance <= of_round_off) distance = 0;
      if (angle <= of_round_off) angle = 0;
      if (distance == 0 && angle == 0) return;
      std::array<char, 128> text{};
      std::snprintf(text.data(), text.size(), format, distance, angle);
      scene_.report.add(AdfNoteKind::changed, printable(plan.joint->key), text.data(),
                        plan.joint->line);
    };
    add("its frames were %.2g m and %.2g rad out of the plane of its loop: fitted to it",
        plan.out_of_plane.gap, plan.out_of_plane.tilt);
    const JointReading<S> reading = world_.reading(id);
    add("its frames stand %.2g m and %.2g rad apart; steps close what they can",
        static_cast<double>(reading.gap), static_cast<double>(reading.tilt));
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

}  // namespace bristle::inline BRISTLE_ABI::detail
