/// @file
/// A recording as binary glTF 2.0: a scene with an animation that Blender and other viewers open.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/no_index.hpp>
#include <bristle/io/file.hpp>
#include <bristle/io/io_constants.hpp>
#include <bristle/io/recorder.hpp>

#include <cstddef>
#include <string>

namespace bristle::inline BRISTLE_ABI {

/// How a recording looks as glTF.
struct GlbDef {
  /// [m] Length of the arrow of the largest force of a sensor, > 0. Others are in proportion.
  double longest_arrow = 0.03;
  /// [1/s] Keys of an arrow in a second, > 0; at most the frames that there are. The tracks have
  /// all frames.
  double arrow_rate = 15;
  /// [-] No arrows where more sensors push than that: a viewer would animate them one by one.
  std::size_t most_arrows = 1000;
};

/// The bytes of a .glb file (Khronos, glTF 2.0 specification, section 4.4).
///
/// Bodies are nodes with a mesh, joints nodes without one. Each sensor that ever pushed is an arrow
/// on its body, from the end of its ray along the force on what it touches, whose extras say
/// `newton_per_metre` of its length. A moving node has keys in the only animation: linear between
/// frames; where two frames and the one between are the same, that one has no key. The world's z
/// points up, as glTF's y does. Bodies that move are translucent, so that arrows in what is touched
/// are seen.
///
/// Core glTF animates poses only. Depths and states of sensors, contacts, joints and named numbers
/// are tracks in accessors that the file's `extras` name (io/glb_extras.hpp); viewers that do not
/// know them show the rest.
///
/// @throws InvalidArgument when there is no frame, times do not ascend, sizes do not fit together,
///         numbers are not finite in float, names are not UTF-8, or a field of `def` is not > 0.
template <Scalar S>
[[nodiscard]] std::string glb(const Recording<S>& recording, const GlbDef& def = {});

/// `glb` to a file, replacing one that exists.
/// @throws IoError when it cannot be written in full.
template <Scalar S>
void write_glb(const std::string& path, const Recording<S>& recording, const GlbDef& def = {}) {
  write_file(path, glb(recording, def));
}

}  // namespace bristle::inline BRISTLE_ABI

// Implementation ----------------------------------------------------------------------------------

#if BRISTLE_HAS_DEFINITIONS
#include <bristle/core/error.hpp>
#include <bristle/geometry/meshes/drawn_mesh.hpp>
#include <bristle/io/glb_extras.hpp>
#include <bristle/io/gltf_buffer.hpp>
#include <bristle/io/gltf_json.hpp>
#include <bristle/io/recording_check.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string_view>
#include <type_traits>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

namespace detail {

/// The unit quaternion (x, y, z, w) of the shortest turn from the z axis to the direction of v,
/// about the x axis if that is opposite. Eigen's own for two vectors costs each file that includes
/// it three seconds, since it compiles a singular value decomposition for the opposite one.
/// @param v  Not zero.
template <Scalar S>
[[nodiscard]] std::array<float, 4> shortest_turn_of_z(const Vec3<S>& v) {
  const S length = v.norm();
  const S across2 = v.x() * v.x() + v.y() * v.y();
  // q ~ (z x v, |v| + v.z), whose last number would cancel where v points down.
  const S w = v.z() < S(0) ? across2 / (length - v.z()) : length + v.z();
  const S norm = std::sqrt(across2 + w * w);
  if (!(norm > S(0))) return {1, 0, 0, 0};
  return {static_cast<float>(-v.y() / norm), static_cast<float>(v.x() / norm), 0,
          static_cast<float>(w / norm)};
}

/// Writes one recording.
template <Scalar S>
class GlbWriter {
  using Body = typename Recording<S>::Body;
  using Patch = typename Recording<S>::Patch;
  using Joint = typename Recording<S>::Joint;

 public:
  GlbWriter(const Recording<S>& recording, const GlbDef& def) : recording_(recording) {
    const float longest_arrow = static_cast<float>(def.longest_arrow);
    require_positive("GlbDef::longest_arrow", longest_arrow);
    require_positive("GlbDef::arrow_rate", def.arrow_rate);
    RecordingCheck<S>(recording).run();
    choose_frames(def.arrow_rate);
    float largest = 0;
    for (const Patch& patch : recording.patches) {
      for (const Vec3<S>& force : patch.forces) {
        largest = std::max(largest, static_cast<float>(force.norm()));
      }
    }
    if (largest > 0) metres_per_newton_ = longest_arrow / largest;
    has_arrows_ = loaded_sensors() <= def.most_arrows;
    add_materials();
    for (std::size_t i = 0; i < recording.bodies.size(); ++i) add_body(i);
    extras_ =
        GlbExtras<S>(recording, buffer_).json(accessor_of(frames_), body_nodes_, joint_nodes_);
  }

  [[nodiscard]] std::string bytes() const {
    // glTF's y is up.
    std::string json = joined_text(
        R"({"asset":{"version":"2.0","generator":"bristle"},"scene":0,"scenes":[{"nodes":[)",
        json_number(nodes_.size()), R"(]}],"nodes":)", with_root(), R"(,"materials":)",
        materials_.array());
    const auto add = [&json](const char* key, const JsonList& list) {
      // The specification allows no empty lists.
      if (!list.empty()) json += joined_text(",\"", key, "\":", list.array());
    };
    add("meshes", meshes_);
    add("accessors", buffer_.accessors());
    add("bufferViews", buffer_.views());
    if (!channels_.empty()) {
      json += joined_text(R"(,"animations":[{"name":"motion","samplers":)", samplers_.array(),
                          R"(,"channels":)", channels_.array(), "}]");
    }
    json += joined_text(R"(,"buffers":[{"byteLength":)", json_number(buffer_.bytes().size()),
                        R"(}],"extras":)", extras_, '}');
    json.resize((json.size() + 3) / 4 * 4, ' ');
    std::string binary = buffer_.bytes();
    binary.resize((binary.size() + 3) / 4 * 4);

    std::string out = "glTF";
    const std::size_t size = 12 + 8 + json.size() + 8 + binary.size();
    require(size <= std::numeric_limits<std::uint32_t>::max(), "glb: bytes", size,
            "must be fewer than 2^32: record fewer frames");
    append_little_endian(out, std::uint32_t(2));
    append_little_endian(out, static_cast<std::uint32_t>(size));
    append_little_endian(out, static_cast<std::uint32_t>(json.size()));
    out += "JSON";
    out += json;
    append_little_endian(out, static_cast<std::uint32_t>(binary.size()));
    out += std::string_view("BIN\0", 4);
    out += binary;
    return out;
  }

 private:
  /// Of one body or arrow: a value for each of the frames that it may have keys in.
  template <typename T, std::size_t N>
  using Track = GltfValues<T, N>;

  /// Frames that tracks may have keys in, with the accessor that tracks with all of them share.
  struct Frames {
    std::vector<std::size_t> numbers;
    Track<float, 1> times;
    std::size_t accessor = no_index;
  };

  void choose_frames(double arrow_rate) {
    const std::vector<double>& times = recording_.times;
    // An arrow's frame is the first that is due, to a rounding of the times.
    double due = times.front();
    for (std::size_t i = 0; i < times.size(); ++i) {
      const float time = static_cast<float>(times[i] - times.front());
      frames_.numbers.push_back(i);
      frames_.times.push_back({time});
      const bool is_due = times[i] * (1 + chosen::frame_time_rounding) >= due;
      if (!is_due && i + 1 < times.size()) continue;
      // Instants that frames missed are left out.
      due = std::max(due, times[i] - 1 / arrow_rate) + 1 / arrow_rate;
      arrow_frames_.numbers.push_back(i);
      arrow_frames_.times.push_back({time});
    }
  }
  [[nodiscard]] std::size_t accessor_of(Frames& frames) {
    if (frames.accessor == no_index)
      frames.accessor = buffer_.add(frames.times, {.has_bounds = true});
    return frames.accessor;
  }

  [[nodiscard]] std::size_t loaded_sensors() const {
    std::size_t count = 0;
    for (const Patch& patch : recording_.patches) {
      for (std::size_t i = 0; i < patch.ends.size(); ++i) {
        if (was_loaded(patch, i)) ++count;
      }
    }
    return count;
  }
  [[nodiscard]] bool was_loaded(const Patch& patch, std::size_t sensor) const {
    for (std::size_t i = sensor; i < patch.forces.size(); i += patch.ends.size()) {
      if (metres_per_newton_ * static_cast<float>(patch.forces[i].norm()) > 0) return true;
    }
    return false;
  }

  void add_materials() {
    // Fixed bodies, then colours for those that move, then arrows.
    constexpr const char* colours[] = {"0.55,0.55,0.57,1",   "0.15,0.45,0.75,0.45",
                                       "0.9,0.55,0.1,0.45",  "0.25,0.6,0.3,0.45",
                                       "0.6,0.35,0.65,0.45", "0.8,0.1,0.1,1"};
    for (std::size_t i = 0; i < std::size(colours); ++i) {
      const bool is_translucent = i >= 1 && i < arrow_material;
      (void)materials_.add(
          joined_text(R"({"doubleSided":true,"pbrMetallicRoughness":{"metallicFactor":0,)",
                      R"("roughnessFactor":0.8,"baseColorFactor":[)", colours[i], "]}",
                      is_translucent ? R"(,"alphaMode":"BLEND"})" : "}"));
    }
  }

  /// Without normals: viewers then shade triangles flat, as they are.
  std::size_t add_mesh(const TriangleMesh<S>& mesh, std::size_t material) {
    Track<float, 3> positions;
    for (const Vec3<S>& v : mesh.vertices) positions.push_back(in_float(v));
    Track<std::uint32_t, 1> corners;
    for (const auto& triangle : mesh.triangles) {
      for (const std::uint32_t corner : triangle) corners.push_back({corner});
    }
    const std::size_t position =
        buffer_.add(positions, {.has_bounds = true, .use = GltfUse::vertices});
    const std::size_t index = buffer_.add(corners, {.use = GltfUse::corners});
    return meshes_.add(joined_text(R"({"primitives":[{"attributes":{"POSITION":)",
                                   json_number(position), R"(},"indices":)", json_number(index),
                                   R"(,"material":)", json_number(material), "}]}"));
  }

  /// Gives a property of a node its track: as what it is, where it never changes, or as keys.
  /// @return The property for the node, with a comma before it.
  template <typename T, std::size_t N>
  std::string add_track(std::size_t node, const char* property, Frames& frames,
                        const Track<T, N>& track, bool is_stepped = false) {
    constexpr bool is_integer = std::is_same_v<T, std::int16_t>;
    Track<float, 1> times;
    Track<T, N> keys;
    for (std::size_t i = 0; i < track.size(); ++i) {
      const bool is_inner = i > 0 && i + 1 < track.size();
      if (is_inner && track[i] == track[i - 1] && track[i] == track[i + 1]) continue;
      times.push_back(frames.times[i]);
      keys.push_back(track[i]);
    }
    const bool is_still =
        std::all_of(keys.begin(), keys.end(), [&](const auto& key) { return key == keys.front(); });
    if (!is_still) {
      // Most tracks have a key in every frame, and share their times.
      const std::size_t input = times.size() < frames.times.size()
                                    ? buffer_.add(times, {.has_bounds = true})
                                    : accessor_of(frames);
      const std::size_t output = buffer_.add(keys, {.is_normalized = is_integer});
      const std::size_t sampler = samplers_.add(
          joined_text(R"({"input":)", json_number(input), R"(,"output":)", json_number(output),
                      R"(,"interpolation":")", is_stepped ? "STEP" : "LINEAR", R"("})"));
      (void)channels_.add(joined_text(R"({"sampler":)", json_number(sampler),
                                      R"(,"target":{"node":)", json_number(node), R"(,"path":")",
                                      property, R"("}})"));
    }
    std::array<float, N> first;
    for (std::size_t k = 0; k < N; ++k) {
      first[k] = static_cast<float>(track.front()[k]);
      if (is_integer) first[k] /= normalised_one;
    }
    return joined_text(",\"", property, "\":", json_numbers(first));
  }

  [[nodiscard]] static std::array<float, 4> in_float(const Quat<S>& q) {
    return {static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z()),
            static_cast<float>(q.w())};
  }
  [[nodiscard]] static std::array<float, 3> in_float(const Vec3<S>& v) {
    return detail::in_float<S>(v);
  }

  void add_body(std::size_t number) {
    const Body& body = recording_.bodies[number];
    Track<float, 3> translations, scales;
    Track<float, 4> rotations;
    for (std::size_t i = 0; i < body.poses.size(); ++i) {
      const float scale = body.was_there[i] ? 1.0f : 0.0f;
      translations.push_back(in_float(body.poses[i].translation));
      rotations.push_back(in_float(body.poses[i].rotation.normalized()));
      scales.push_back({scale, scale, scale});
    }
    // Arrows and joints are nodes before the node of their body.
    JsonList children;
    for (const Patch& patch : recording_.patches) {
      if (patch.body != number || !has_arrows_) continue;
      for (std::size_t i = 0; i < patch.ends.size(); ++i) add_arrow(patch, i, children);
    }
    joint_nodes_.resize(recording_.joints.size());
    for (std::size_t k = 0; k < recording_.joints.size(); ++k) {
      if (recording_.joints[k].body == number) add_joint(k, children);
    }
    const std::size_t node = nodes_.size();
    std::string json = joined_text(R"({"name":)", json_text(body.name));
    json += add_track(node, "translation", frames_, translations);
    json += add_track(node, "rotation", frames_, rotations);
    json += add_track(node, "scale", frames_, scales, true);
    if (!body.mesh.triangles.empty()) {
      const std::size_t material = body.moves ? 1 + number % (arrow_material - 1) : 0;
      json += joined_text(R"(,"mesh":)", json_number(add_mesh(body.mesh, material)));
    }
    if (!children.empty()) json += joined_text(R"(,"children":)", children.array());
    json += '}';
    body_nodes_.push_back(node);
    nodes_.push_back(json);
  }

  void add_joint(std::size_t number, JsonList& children) {
    const Joint& joint = recording_.joints[number];
    joint_nodes_[number] = nodes_.size();
    (void)children.add(json_number(nodes_.size()));
    nodes_.push_back(joined_text(R"({"name":)", json_text(joint.name), R"(,"translation":)",
                                 json_numbers(in_float(joint.X_BJ.translation)), R"(,"rotation":)",
                                 json_numbers(in_float(joint.X_BJ.rotation.normalized())), '}'));
  }

  void add_arrow(const Patch& patch, std::size_t sensor, JsonList& children) {
    if (!was_loaded(patch, sensor)) return;
    Track<float, 3> scales;
    Track<std::int16_t, 4> rotations;
    std::array<std::int16_t, 4> turned{0, 0, 0, normalised_one};
    for (const std::size_t frame : arrow_frames_.numbers) {
      const Vec3<S>& force = patch.forces[frame * patch.ends.size() + sensor];
      const float scale = metres_per_newton_ * static_cast<float>(force.norm());
      if (scale > 0) {
        const std::array<float, 4> q = shortest_turn_of_z(force);
        for (std::size_t k = 0; k < 4; ++k) {
          turned[k] = static_cast<std::int16_t>(std::lround(normalised_one * q[k]));
        }
      }
      scales.push_back({scale, scale, scale});
      rotations.push_back(turned);
    }
    if (arrow_mesh_ == no_index) {
      // A shaft of three quarters of the length, and a tip.
      arrow_mesh_ = add_mesh(lathe_mesh<S>({{S(0), S(0)},
                                            {S(0.03), S(0)},
                                            {S(0.03), S(0.75)},
                                            {S(0.08), S(0.75)},
                                            {S(0), S(1)}}),
                             arrow_material);
    }
    const std::size_t node = nodes_.size();
    std::string json =
        joined_text(R"({"name":)", json_text(joined_text(patch.name, ' ', json_number(sensor))),
                    R"(,"translation":)", json_numbers(in_float(patch.ends[sensor])));
    json += add_track(node, "rotation", arrow_frames_, rotations);
    json += add_track(node, "scale", arrow_frames_, scales);
    json +=
        joined_text(R"(,"mesh":)", json_number(arrow_mesh_), R"(,"extras":{"newton_per_metre":)",
                    json_number(1 / metres_per_newton_), "}}");
    nodes_.push_back(json);
    (void)children.add(json_number(node));
  }

  /// All nodes, and last the one that turns z up into y up.
  [[nodiscard]] std::string with_root() const {
    JsonList list;
    for (const std::string& node : nodes_) (void)list.add(node);
    std::string root = R"({"name":"world","rotation":[-0.70710678,0,0,0.70710678])";
    if (!body_nodes_.empty()) root += joined_text(R"(,"children":)", json_numbers(body_nodes_));
    root += '}';
    (void)list.add(root);
    return list.array();
  }

  static constexpr std::size_t arrow_material = 5;
  /// glTF's 1 in normalised integers of 16 bits.
  static constexpr std::int16_t normalised_one = std::numeric_limits<std::int16_t>::max();

  const Recording<S>& recording_;
  Frames frames_, arrow_frames_;
  float metres_per_newton_ = 0;
  bool has_arrows_ = false;
  GltfBuffer buffer_;
  JsonList materials_, meshes_, samplers_, channels_;
  std::vector<std::string> nodes_;
  std::vector<std::size_t> body_nodes_, joint_nodes_;
  std::size_t arrow_mesh_ = no_index;
  std::string extras_;
};

}  // namespace detail

template <Scalar S>
std::string glb(const Recording<S>& recording, const GlbDef& def) {
  return detail::GlbWriter<S>(recording, def).bytes();
}

}  // namespace bristle::inline BRISTLE_ABI
#endif

#if defined(BRISTLE_COMPILED) && BRISTLE_HAS_DEFINITIONS
namespace bristle::inline BRISTLE_ABI {

extern template std::string glb<float>(const Recording<float>& recording, const GlbDef& def);
extern template std::string glb<double>(const Recording<double>& recording, const GlbDef& def);

}  // namespace bristle::inline BRISTLE_ABI
#endif
