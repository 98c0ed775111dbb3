/// @file
/// A recording as binary glTF 2.0: a scene with an animation that Blender and other viewers open.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/io/file.hpp>
#include <bristle/io/recorder.hpp>

#include <filesystem>
#include <string>

namespace bristle::inline BRISTLE_ABI {

/// How a recording looks as glTF.
struct GlbDef {
  /// [m] Length of the arrow of the largest force of a sensor, > 0. Others are in proportion.
  double longest_arrow = 0.03;
};

/// The bytes of a .glb file (Khronos, glTF 2.0 specification, section 4.4).
///
/// Bodies are nodes with a mesh. Each sensor that ever pushed is an arrow on its body, from the end
/// of its ray along the force on what it touches, whose extras say `newton_per_metre` of its
/// length. What moves has keys in the only animation: linear between frames; where two frames and
/// the one between are the same, that one has no key. The world's z points up, as glTF's y does.
/// Bodies that move are translucent, so that arrows in what is touched are seen.
///
/// @throws InvalidArgument when there is no frame, times do not ascend, sizes do not fit together,
///         numbers are not finite in float, or `longest_arrow` is not > 0.
template <Scalar S>
[[nodiscard]] std::string glb(const Recording<S>& recording, const GlbDef& def = {});

/// `glb` to a file, replacing one that exists.
/// @throws IoError when it cannot be written in full.
template <Scalar S>
void write_glb(const std::filesystem::path& path, const Recording<S>& recording,
               const GlbDef& def = {}) {
  write_file(path, glb(recording, def));
}

}  // namespace bristle::inline BRISTLE_ABI

// Implementation -----------------------------------------------------------------------------------

#if BRISTLE_HAS_DEFINITIONS
#include <bristle/core/error.hpp>
#include <bristle/geometry/meshes/drawn_mesh.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>
#include <type_traits>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

namespace detail {

/// All of the parts, one after another.
template <typename... Parts>
[[nodiscard]] std::string joined_text(const Parts&... parts) {
  std::string out;
  ((out += parts), ...);
  return out;
}

/// A comma-separated list of JSON values.
class JsonList {
 public:
  /// Appends a value and returns its number.
  std::size_t add(std::string_view value) {
    if (count_ > 0) text_ += ',';
    text_ += value;
    return count_++;
  }
  [[nodiscard]] bool empty() const { return count_ == 0; }
  [[nodiscard]] std::string array() const { return joined_text('[', text_, ']'); }

 private:
  std::string text_;
  std::size_t count_ = 0;
};

[[nodiscard]] inline std::string json_text(std::string_view text) {
  std::string json = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') json += '\\';
    if (static_cast<unsigned char>(c) < 0x20) {
      constexpr char digits[] = "0123456789abcdef";
      json += joined_text("\\u00", digits[c >> 4], digits[c & 15]);
    } else {
      json += c;
    }
  }
  json += '"';
  return json;
}

template <std::integral T>
[[nodiscard]] std::string json_number(T x) {
  return std::to_string(x);
}
[[nodiscard]] inline std::string json_number(float x) {
  char digits[32];
  return {digits, std::to_chars(digits, digits + sizeof digits, x).ptr};
}

template <typename Values>
[[nodiscard]] std::string json_numbers(const Values& values) {
  JsonList list;
  for (const auto x : values) (void)list.add(json_number(x));
  return list.array();
}

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

 public:
  GlbWriter(const Recording<S>& recording, const GlbDef& def) : recording_(recording) {
    const float longest_arrow = static_cast<float>(def.longest_arrow);
    require_positive("GlbDef::longest_arrow", longest_arrow);
    take_times();
    check_bodies();
    check_patches();
    float largest = 0;
    for (const Patch& patch : recording.patches) {
      for (const Vec3<S>& force : patch.forces) {
        largest = std::max(largest, static_cast<float>(force.norm()));
      }
    }
    if (largest > 0) metres_per_newton_ = longest_arrow / largest;
    add_materials();
    for (std::size_t i = 0; i < recording.bodies.size(); ++i) add_body(i);
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
    add("accessors", accessors_);
    add("bufferViews", views_);
    if (!channels_.empty()) {
      json += joined_text(R"(,"animations":[{"name":"motion","samplers":)", samplers_.array(),
                          R"(,"channels":)", channels_.array(), "}]");
    }
    if (!binary_.empty()) {
      json += joined_text(R"(,"buffers":[{"byteLength":)", json_number(binary_.size()), "}]");
    }
    json += '}';
    json.resize((json.size() + 3) / 4 * 4, ' ');

    std::string out = "glTF";
    const std::size_t chunks = 8 + json.size() + (binary_.empty() ? 0 : 8 + binary_.size());
    require(12 + chunks <= std::numeric_limits<std::uint32_t>::max(), "glb: bytes", 12 + chunks,
            "must be fewer than 2^32: record fewer frames");
    append(out, std::uint32_t(2));
    append(out, static_cast<std::uint32_t>(12 + chunks));
    append(out, static_cast<std::uint32_t>(json.size()));
    out += "JSON";
    out += json;
    if (!binary_.empty()) {
      append(out, static_cast<std::uint32_t>(binary_.size()));
      out += std::string_view("BIN\0", 4);
      out += binary_;
    }
    return out;
  }

 private:
  [[nodiscard]] static std::array<float, 3> in_float(const Vec3<S>& v) {
    return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
  }
  [[nodiscard]] static bool is_finite(const Vec3<S>& v) {
    return std::ranges::all_of(in_float(v), [](float x) { return std::isfinite(x); });
  }

  void take_times() {
    require(!recording_.times.empty(), "glb: Recording::times.size()", 0, "must not be 0");
    for (const double t : recording_.times) {
      const float time = static_cast<float>(t - recording_.times.front());
      require(std::isfinite(time) && (times_.empty() || time > times_.back()[0]),
              "glb: Recording::times", t, "must ascend, in float and from the first");
      times_.push_back({time});
    }
  }
  void check_bodies() const {
    for (const Body& body : recording_.bodies) {
      require(body.poses.size() == times_.size() && body.was_there.size() == times_.size(),
              "glb: Recording::Body::poses.size()", body.poses.size(), "must be that of the times");
      for (const Transform<S>& pose : body.poses) {
        require(is_finite(pose.translation) && pose.rotation.coeffs().allFinite(),
                "glb: Recording::Body::poses", body.name.c_str(), "must be finite in float");
      }
      for (const Vec3<S>& v : body.mesh.vertices) {
        require(is_finite(v), "glb: Recording::Body::mesh", body.name.c_str(),
                "must be finite in float");
      }
    }
  }
  void check_patches() const {
    for (const Patch& patch : recording_.patches) {
      require(patch.body < recording_.bodies.size(), "glb: Recording::Patch::body", patch.body,
              "must be the number of a body");
      require(patch.forces.size() == times_.size() * patch.ends.size(),
              "glb: Recording::Patch::forces.size()", patch.forces.size(),
              "must be that of the times times that of the ends");
      for (const std::vector<Vec3<S>>* values : {&patch.ends, &patch.forces}) {
        for (const Vec3<S>& v : *values) {
          require(std::isfinite(static_cast<float>(v.squaredNorm())), "glb: Recording::Patch",
                  patch.name.c_str(), "must have finite forces and ends in float");
        }
      }
    }
  }

  /// What glTF calls types of components.
  enum class Component { int16 = 5122, uint32 = 5125, float32 = 5126 };
  /// Of one body or arrow: one value of N numbers a frame.
  template <typename T, std::size_t N>
  using Track = std::vector<std::array<T, N>>;

  /// Appends a number with its lowest byte first.
  template <typename T>
  static void append(std::string& out, T x) {
    std::uint64_t bits = 0;
    if constexpr (std::is_same_v<T, float>) {
      bits = std::bit_cast<std::uint32_t>(x);
    } else {
      bits = static_cast<std::uint64_t>(x);
    }
    for (std::size_t i = 0; i < sizeof(T); ++i) out += static_cast<char>(bits >> 8 * i & 0xff);
  }

  /// Appends values to the buffer, and returns the number of their accessor.
  /// @param target  [-] What a mesh uses them for, 0 for an animation's.
  template <typename T, std::size_t N>
  std::size_t add_accessor(const Track<T, N>& values, bool has_bounds, int target = 0) {
    constexpr const char* types[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    constexpr Component component = std::is_same_v<T, float>          ? Component::float32
                                    : std::is_same_v<T, std::int16_t> ? Component::int16
                                                                      : Component::uint32;
    const std::size_t start = binary_.size();
    std::array<T, N> low, high;
    low.fill(std::numeric_limits<T>::max());
    high.fill(std::numeric_limits<T>::lowest());
    for (const std::array<T, N>& value : values) {
      for (std::size_t k = 0; k < N; ++k) {
        append(binary_, value[k]);
        low[k] = std::min(low[k], value[k]);
        high[k] = std::max(high[k], value[k]);
      }
    }
    // Offsets must be multiples of 4, and so all values are.
    static_assert(sizeof(T) * N % 4 == 0);
    const std::string use =
        target == 0 ? std::string() : joined_text(R"(,"target":)", json_number(target));
    const std::size_t view =
        views_.add(joined_text(R"({"buffer":0,"byteOffset":)", json_number(start),
                               R"(,"byteLength":)", json_number(binary_.size() - start), use, '}'));
    std::string accessor =
        joined_text(R"({"bufferView":)", json_number(view), R"(,"componentType":)",
                    json_number(static_cast<int>(component)), R"(,"count":)",
                    json_number(values.size()), R"(,"type":")", types[N], '"');
    if (component == Component::int16) accessor += R"(,"normalized":true)";
    if (has_bounds) {
      accessor += joined_text(R"(,"min":)", json_numbers(low), R"(,"max":)", json_numbers(high));
    }
    accessor += '}';
    return accessors_.add(accessor);
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
    constexpr int array_buffer = 34962, element_array_buffer = 34963;
    const std::size_t position = add_accessor(positions, true, array_buffer);
    const std::size_t index = add_accessor(corners, false, element_array_buffer);
    return meshes_.add(joined_text(R"({"primitives":[{"attributes":{"POSITION":)",
                                   json_number(position), R"(},"indices":)", json_number(index),
                                   R"(,"material":)", json_number(material), "}]}"));
  }

  /// Gives a property of a node its track: as what it is, where it never changes, or as keys.
  /// @return The property for the node, with a comma before it.
  template <typename T, std::size_t N>
  std::string add_track(std::size_t node, const char* property, const Track<T, N>& track,
                        bool is_stepped = false) {
    Track<float, 1> times;
    Track<T, N> keys;
    for (std::size_t i = 0; i < track.size(); ++i) {
      const bool is_inner = i > 0 && i + 1 < track.size();
      if (is_inner && track[i] == track[i - 1] && track[i] == track[i + 1]) continue;
      times.push_back(times_[i]);
      keys.push_back(track[i]);
    }
    const bool is_still =
        std::all_of(keys.begin(), keys.end(), [&](const auto& key) { return key == keys.front(); });
    if (!is_still) {
      const std::size_t input = add_times(times);
      const std::size_t output = add_accessor(keys, false);
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
      if (std::is_same_v<T, std::int16_t>) first[k] /= 32767;
    }
    return joined_text(",\"", property, "\":", json_numbers(first));
  }
  /// Most tracks have a key in every frame, and share their times.
  std::size_t add_times(const Track<float, 1>& times) {
    if (times.size() < times_.size()) return add_accessor(times, true);
    if (all_times_ == none) all_times_ = add_accessor(times_, true);
    return all_times_;
  }

  void add_body(std::size_t number) {
    const Body& body = recording_.bodies[number];
    Track<float, 3> translations, scales;
    Track<float, 4> rotations;
    for (std::size_t i = 0; i < body.poses.size(); ++i) {
      const Quat<S> q = body.poses[i].rotation.normalized();
      const float scale = body.was_there[i] ? 1.0f : 0.0f;
      translations.push_back(in_float(body.poses[i].translation));
      const std::array<float, 3> turn = in_float(q.vec());
      rotations.push_back({turn[0], turn[1], turn[2], static_cast<float>(q.w())});
      scales.push_back({scale, scale, scale});
    }
    // Arrows are nodes before the node of their body.
    JsonList children;
    for (const Patch& patch : recording_.patches) {
      if (patch.body != number) continue;
      for (std::size_t i = 0; i < patch.ends.size(); ++i) add_arrow(patch, i, children);
    }
    const std::size_t node = nodes_.size();
    std::string json = joined_text(R"({"name":)", json_text(body.name));
    json += add_track(node, "translation", translations);
    json += add_track(node, "rotation", rotations);
    json += add_track(node, "scale", scales, true);
    if (!body.mesh.triangles.empty()) {
      const std::size_t material = body.moves ? 1 + number % (arrow_material - 1) : 0;
      json += joined_text(R"(,"mesh":)", json_number(add_mesh(body.mesh, material)));
    }
    if (!children.empty()) json += joined_text(R"(,"children":)", children.array());
    json += '}';
    roots_.push_back(node);
    nodes_.push_back(json);
  }

  void add_arrow(const Patch& patch, std::size_t sensor, JsonList& children) {
    Track<float, 3> scales;
    Track<std::int16_t, 4> rotations;
    std::array<std::int16_t, 4> turned{0, 0, 0, 32767};
    bool has_pushed = false;
    for (std::size_t i = sensor; i < patch.forces.size(); i += patch.ends.size()) {
      const Vec3<S>& force = patch.forces[i];
      const float scale = metres_per_newton_ * static_cast<float>(force.norm());
      if (scale > 0) {
        const std::array<float, 4> q = shortest_turn_of_z(force);
        for (std::size_t k = 0; k < 4; ++k) {
          turned[k] = static_cast<std::int16_t>(std::lround(32767 * q[k]));
        }
        has_pushed = true;
      }
      scales.push_back({scale, scale, scale});
      rotations.push_back(turned);
    }
    if (!has_pushed) return;
    if (arrow_mesh_ == none) {
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
    json += add_track(node, "rotation", rotations);
    json += add_track(node, "scale", scales);
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
    if (!roots_.empty()) root += joined_text(R"(,"children":)", json_numbers(roots_));
    root += '}';
    (void)list.add(root);
    return list.array();
  }

  static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
  static constexpr std::size_t arrow_material = 5;

  const Recording<S>& recording_;
  Track<float, 1> times_;
  float metres_per_newton_ = 0;
  std::string binary_;
  JsonList materials_, meshes_, accessors_, views_, samplers_, channels_;
  std::vector<std::string> nodes_;
  std::vector<std::size_t> roots_;
  std::size_t all_times_ = none;
  std::size_t arrow_mesh_ = none;
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
