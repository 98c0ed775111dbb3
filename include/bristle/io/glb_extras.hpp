/// @file
/// The tracks of a recording that glTF has no word for, as accessors that `extras` name.
///
///     "extras": {"bristle": {
///       "version": 1,
///       "times":    accessor                [s] of the frames, float
///       "patches":  [{"name", "node",       node of its body
///                     "ends", "directions"  accessors: [m], [1] sensor by sensor, body's frame
///                     "first"               accessor: first row of each sensor, and one behind all
///                     "frame"               accessor: frame from which a row holds
///                     "force"               accessor: 3 int16 a row, body's frame
///                     "newton"              [N] of a step of `force`
///                     "depth"               accessor: uint8 a row, 255 is a depth of 1
///                     "state"}]             accessor: uint8 a row; 0 free, 1 stuck, 2 slipping
///       "contacts": {"first"                accessor: first of each frame, and one behind all
///                    "node", "point", "force"}  accessors: pressed body, [m], [N], world axes
///       "joints":   [{"name", "node"        node of its frame, whose x is the axis
///                     "kind"                "turns", "slides" or "other"
///                     "position", "motor_force"}]  accessors: [rad; m], [N m; N] frame by frame
///       "channels": [{"name", "unit", "first_frame", "values"}]  accessor: from that frame on
///     }}
///
/// A sensor has a row for each frame in which its numbers are others than in the one before; before
/// its first row it is free. Keys whose accessor would be empty are left out. World axes are those
/// of the simulation, z up: the node "world" turns them into glTF's.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/io/gltf_buffer.hpp>
#include <bristle/io/gltf_json.hpp>
#include <bristle/io/recording.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace bristle::inline BRISTLE_ABI::detail {

/// Writes the extras of one recording, whose sizes were checked.
template <Scalar S>
class GlbExtras {
  using Patch = typename Recording<S>::Patch;
  using Contact = typename Recording<S>::Contact;
  using Joint = typename Recording<S>::Joint;
  using Channel = typename Recording<S>::Channel;
  template <typename T>
  using Column = GltfValues<T, 1>;

 public:
  GlbExtras(const Recording<S>& recording, GltfBuffer& buffer)
      : recording_(recording), buffer_(buffer) {}

  /// @param times        Number of the accessor of all times.
  /// @param body_nodes   Nodes of the bodies.
  /// @param joint_nodes  Nodes of the joints.
  [[nodiscard]] std::string json(std::size_t times, const std::vector<std::size_t>& body_nodes,
                                 const std::vector<std::size_t>& joint_nodes) {
    std::string json =
        joined_text(R"({"bristle":{"version":1,"times":)", json_number(times), R"(,"patches":)");
    JsonList patches;
    for (const Patch& patch : recording_.patches) {
      (void)patches.add(patch_json(patch, body_nodes[patch.body]));
    }
    json += patches.array();
    if (!recording_.contacts.empty()) {
      json += joined_text(R"(,"contacts":)", contacts_json(body_nodes));
    }
    JsonList joints, channels;
    for (std::size_t k = 0; k < recording_.joints.size(); ++k) {
      (void)joints.add(joint_json(recording_.joints[k], joint_nodes[k]));
    }
    for (const Channel& channel : recording_.channels) (void)channels.add(channel_json(channel));
    return joined_text(json, R"(,"joints":)", joints.array(), R"(,"channels":)", channels.array(),
                       "}}");
  }

 private:
  /// Numbers of a sensor in a frame, in the steps of the file.
  struct Row {
    std::array<std::int16_t, 3> force{};
    std::uint8_t depth = 0;
    std::uint8_t state = 0;
    friend bool operator==(const Row&, const Row&) = default;
  };

  /// A key with the accessor of values; nothing where there are none.
  template <typename T, std::size_t N>
  [[nodiscard]] std::string track(const char* key, const GltfValues<T, N>& values) {
    if (values.empty()) return {};
    return joined_text(",\"", key, "\":", json_number(buffer_.add(values)));
  }
  /// The same for whole numbers, in two bytes each where all fit.
  [[nodiscard]] std::string whole_track(const char* key, const Column<std::uint32_t>& values) {
    const bool is_small = std::all_of(values.begin(), values.end(), [](const auto& value) {
      return value[0] <= std::numeric_limits<std::uint16_t>::max();
    });
    if (!is_small) return track(key, values);
    Column<std::uint16_t> small;
    for (const auto& value : values) small.push_back({static_cast<std::uint16_t>(value[0])});
    return track(key, small);
  }

  [[nodiscard]] std::string patch_json(const Patch& patch, std::size_t node) {
    const std::size_t sensors = patch.ends.size();
    float largest = 0;
    for (const Vec3<S>& force : patch.forces) {
      largest = std::max(largest, static_cast<float>(cwise_abs(force).maxCoeff()));
    }
    constexpr float steps = std::numeric_limits<std::int16_t>::max();
    const float newton = largest > 0 ? largest / steps : 1;
    GltfValues<float, 3> ends, directions;
    for (const Vec3<S>& end : patch.ends) ends.push_back(in_float(end));
    for (const Vec3<S>& direction : patch.directions) directions.push_back(in_float(direction));
    Column<std::uint32_t> first{{0}}, frames;
    GltfValues<std::int16_t, 3> forces;
    Column<std::uint8_t> depths, states;
    for (std::size_t i = 0; i < sensors; ++i) {
      Row last;
      for (std::size_t frame = 0; frame < recording_.times.size(); ++frame) {
        const Row row = row_of(patch, frame * sensors + i, newton);
        if (row == last) continue;
        last = row;
        frames.push_back({static_cast<std::uint32_t>(frame)});
        forces.push_back(row.force);
        depths.push_back({row.depth});
        states.push_back({row.state});
      }
      first.push_back({static_cast<std::uint32_t>(frames.size())});
    }
    return joined_text(R"({"name":)", json_text(patch.name), R"(,"node":)", json_number(node),
                       R"(,"newton":)", json_number(newton), track("ends", ends),
                       track("directions", directions), track("first", first),
                       whole_track("frame", frames), track("force", forces), track("depth", depths),
                       track("state", states), '}');
  }
  [[nodiscard]] static Row row_of(const Patch& patch, std::size_t at, float newton) {
    Row row;
    const std::array<float, 3> force = in_float(patch.forces[at]);
    for (std::size_t k = 0; k < 3; ++k) {
      row.force[k] = static_cast<std::int16_t>(std::lround(force[k] / newton));
    }
    row.depth = static_cast<std::uint8_t>(std::lround(255 * patch.depths[at]));
    row.state = static_cast<std::uint8_t>(patch.states[at]);
    return row;
  }

  [[nodiscard]] std::string contacts_json(const std::vector<std::size_t>& body_nodes) {
    Column<std::uint32_t> first{{0}}, nodes;
    GltfValues<float, 3> points, forces;
    for (const std::vector<Contact>& frame : recording_.contacts) {
      for (const Contact& contact : frame) {
        nodes.push_back({static_cast<std::uint32_t>(body_nodes[contact.body])});
        points.push_back(in_float(contact.point));
        forces.push_back(in_float(contact.force));
      }
      first.push_back({static_cast<std::uint32_t>(nodes.size())});
    }
    return joined_text(R"({"first":)", json_number(buffer_.add(first)), whole_track("node", nodes),
                       track("point", points), track("force", forces), '}');
  }

  template <typename Values>
  [[nodiscard]] static Column<float> column(const Values& values) {
    Column<float> floats;
    for (const auto x : values) floats.push_back({static_cast<float>(x)});
    return floats;
  }
  [[nodiscard]] std::string joint_json(const Joint& joint, std::size_t node) {
    const bool has_axis = joint.turns || joint.slides;
    std::string json = joined_text(
        R"({"name":)", json_text(joint.name), R"(,"node":)", json_number(node), R"(,"kind":")",
        joint.turns ? "turns" : (joint.slides ? "slides" : "other"), '"');
    if (has_axis) {
      json += track("position", column(joint.positions));
      json += track("motor_force", column(joint.motor_forces));
    }
    return json + '}';
  }
  [[nodiscard]] std::string channel_json(const Channel& channel) {
    return joined_text(R"({"name":)", json_text(channel.name), R"(,"unit":)",
                       json_text(channel.unit), R"(,"first_frame":)",
                       json_number(channel.first_frame), track("values", column(channel.values)),
                       '}');
  }

  const Recording<S>& recording_;
  GltfBuffer& buffer_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
