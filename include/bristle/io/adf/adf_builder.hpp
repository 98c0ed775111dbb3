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
#include <bristle/io/adf/adf_scene.hpp>
#include <bristle/io/adf/adf_sensor_builder.hpp>
#include <bristle/io/adf/adf_words.hpp>
#include <bristle/world/world.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI::detail {

/// Adds the parts of a model one after the other.
template <Scalar S, typename Backend>
class AdfBuilder {
 public:
  /// @param before  What is in the world already. Names that the model does not have refer to it.
  AdfBuilder(World<S, Backend>& world, AdfScene<S>& before, const AdfModel& model,
             const AdfBuildDef<S>& def)
      : world_(world), before_(before), model_(model), def_(def), meshes_(model, def.limits) {
    scene_.report = model.report;
    scene_.history.groups = before.history.groups;
  }

  /// Adds the model to the world and to what is in it.
  void build() {
    add_bodies();
    add_joints();
    add_sensors();
    before_.bodies.append(scene_.bodies);
    before_.joints.append(scene_.joints);
    before_.patches.append(scene_.patches);
    before_.proximity.append(scene_.proximity);
    before_.report.append(scene_.report);
    before_.history.groups = scene_.history.groups;
    before_.history.scales.insert(before_.history.scales.end(), scene_.history.scales.begin(),
                                  scene_.history.scales.end());
  }

 private:
  /// The body of a name.
  struct Found {
    BodyId id{};
    double scale = 1.0;
    /// Its block, if it is in this file.
    const AdfBody* body = nullptr;
    /// Why there is none; null if there is one.
    const char* fault = no_body;
  };

  /// Runs an action for a block. If the world refuses it, that becomes an error of the block, with
  /// the value that its author wrote. The value that the world got follows, where it is another.
  template <typename Item, typename Do>
  auto in_block(const Item& item, Do&& action) {
    try {
      return action();
    } catch (const InvalidArgument& error) {
      const AdfField field = adf_field(error.field());
      if (field.key.empty()) {
        raise(AdfError(model_.file.string(), item.line, item.key, "", error.what()));
      }
      // Fields that a description leaves out are unset.
      const std::string came_to = error.value() == "unset" ? "not given" : error.value();
      const std::string written = adf_words(item, field.key);
      std::string rule(field.rule.empty() ? std::string_view(error.rule()) : field.rule);
      const bool is_same = written.empty() || written.find(came_to) != std::string::npos;
      if (field.rule.empty() && !is_same) rule += " (" + came_to + " in the world)";
      raise(AdfError(model_.file.string(), item.line, item.key + "/" + std::string(field.key),
                     written.empty() ? came_to : written, std::move(rule)));
    }
  }

  /// Returns the body that a joint or sensor names under a key: one of this file, else one of those
  /// before. Each name is searched once.
  [[nodiscard]] const Found& body_of(const AdfItem& item, const char* key,
                                     const std::string& name) {
    const auto known = looked_up_.find(name);
    if (known != looked_up_.end()) return known->second;
    Found found = body_in(scene_, name);
    if (found.fault == no_body) found = body_in(before_, name);
    if (searched_ > def_.limits.max_searched_bytes) {
      raise(AdfError(model_.file.string(), item.line, item.key + "/" + key, printable(name),
                     "must be a whole name: parts of names were looked for in more than " +
                         std::to_string(def_.limits.max_searched_bytes) + " bytes"));
    }
    return looked_up_[name] = found;
  }

  [[nodiscard]] Found body_in(const AdfScene<S>& scene, const std::string& name) {
    const auto match = scene.bodies.match(name, searched_);
    Found found;
    if (match.is_several) found.fault = "several bodies by the name ";
    if (match.entry == nullptr || !world_.contains(match.entry->value)) return found;
    const auto place = static_cast<std::size_t>(match.entry - &*scene.bodies.begin());
    found.id = match.entry->value;
    found.scale = scene.history.scales[place];
    if (&scene == &scene_) found.body = in_file_[place];
    found.fault = nullptr;
    return found;
  }

  void add_bodies() {
    AdfBodyBuilder<S> builder(model_, def_, world_.def().gravity, meshes_, scene_.history.groups,
                              scene_.report);
    for (const AdfBody& body : model_.bodies) {
      const std::optional<BodyDef<S>> body_def = builder.body(body);
      if (!body_def) continue;
      const BodyId id = in_block(body, [&] { return world_.add_body(*body_def); });
      scene_.bodies.add(body, id);
      scene_.history.scales.push_back(body.scale);
      in_file_.push_back(&body);
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
      const Found parent = body_of(joint, "parent", joint.parent);
      const Found child = body_of(joint, "child", joint.child);
      if (!is_there(joint, parent, joint.parent) || !is_there(joint, child, joint.child)) continue;
      if (!world_.body(parent.id).is_dynamic() && !world_.body(child.id).is_dynamic()) {
        leave_out(joint, "neither body moves");
        continue;
      }
      planned.push_back({.joint = &joint,
                         .def = builder.joint(joint, parent.scale, child.scale),
                         .X_WA = world_.pose(parent.id),
                         .X_WB = world_.pose(child.id),
                         .node_a = node_of(parent.id),
                         .node_b = node_of(child.id),
                         .scale_a = parent.scale,
                         .scale_b = child.scale});
      planned.back().def.body_a = parent.id;
      planned.back().def.body_b = child.id;
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
    const auto add = [&](const char* subject, double distance, double angle, const char* what) {
      if (distance <= of_round_off) distance = 0;
      if (angle <= of_round_off) angle = 0;
      if (distance == 0 && angle == 0) return;
      // The longest of the texts below has less than 100 characters.
      std::array<char, 160> text{};
      std::snprintf(text.data(), text.size(), "%s %.2g m and %.2g rad %s", subject, distance, angle,
                    what);
      scene_.report.add(AdfNoteKind::changed, printable(plan.joint->key), text.data(),
                        plan.joint->line);
    };
    add("its frames were", plan.out_of_plane.gap, plan.out_of_plane.tilt,
        "out of the plane of its loop: fitted to it");
    const JointReading<S> reading = world_.reading(id);
    add("its frames stand", static_cast<double>(reading.gap), static_cast<double>(reading.tilt),
        "apart; steps close what they can");
  }

  void add_sensors() {
    AdfSensorBuilder<S> builder(model_, def_, meshes_, scene_.report);
    std::vector<BodyId> with_patch;
    for (const AdfSensor& sensor : model_.sensors) {
      const Found carrier = body_of(sensor, "parent", sensor.parent);
      if (!is_there(sensor, carrier, sensor.parent) || !has_mesh(sensor, carrier.body)) continue;
      const AdfBody* const body = carrier.body;
      const BodyId id = carrier.id;
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

  /// Returns whether a name has its one body. Otherwise the block is left out.
  [[nodiscard]] bool is_there(const AdfItem& item, const Found& found, const std::string& name) {
    if (found.fault == nullptr) return true;
    leave_out(item, found.fault + printable(name, name.size()));
    return false;
  }

  /// Returns whether a sensor's mesh is there, or must be. Otherwise the sensor is left out.
  [[nodiscard]] bool has_mesh(const AdfSensor& sensor, const AdfBody* body) {
    if (!def_.allow_missing_meshes || !sensor.array.empty() || sensor.mesh.empty()) return true;
    const std::string places = meshes_.missing_from(sensor.mesh, AdfResolution::high, body);
    if (!places.empty()) leave_out(sensor, "none of these is a file: " + places);
    return places.empty();
  }

  void leave_out(const AdfItem& item, const std::string& reason) {
    scene_.report.add(AdfNoteKind::left_out, printable(item.key), reason, item.line);
  }

  /// Groups up to here are the caller's.
  static constexpr std::int32_t first_exclusion_group = 1'000'000;

  static constexpr const char* no_body = "no body by the name ";

  World<S, Backend>& world_;
  AdfScene<S>& before_;
  const AdfModel& model_;
  const AdfBuildDef<S>& def_;
  AdfMeshes<S> meshes_;
  /// The parts of this file.
  AdfScene<S> scene_;
  std::vector<const AdfBody*> in_file_;
  std::map<std::string, Found> looked_up_;
  std::size_t searched_ = 0;  // [-] Bytes.
};

}  // namespace bristle::inline BRISTLE_ABI::detail
