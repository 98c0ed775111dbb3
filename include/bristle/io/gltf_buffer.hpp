/// @file
/// The numbers of a glTF file: its only buffer, with the accessors that say how to read it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/io/gltf_json.hpp>
#include <bristle/math/types.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace bristle::inline BRISTLE_ABI::detail {

/// Values of N numbers each.
template <typename T, std::size_t N>
using GltfValues = std::vector<std::array<T, N>>;

template <Scalar S>
[[nodiscard]] std::array<float, 3> in_float(const Vec3<S>& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}
template <Scalar S>
[[nodiscard]] bool is_finite_in_float(const Vec3<S>& v) {
  return std::ranges::all_of(in_float(v), [](float x) { return std::isfinite(x); });
}

/// Appends a number with its lowest byte first.
template <typename T>
void append_little_endian(std::string& out, T x) {
  std::uint64_t bits = 0;
  if constexpr (std::is_same_v<T, float>) {
    bits = std::bit_cast<std::uint32_t>(x);
  } else {
    bits = static_cast<std::uint64_t>(x);
  }
  for (std::size_t i = 0; i < sizeof(T); ++i) out += static_cast<char>(bits >> 8 * i & 0xff);
}

/// Use of values by a mesh (`bufferView.target`).
enum class GltfUse { none = 0, vertices = 34962, corners = 34963 };

/// How a file describes values.
struct GltfAccessorDef {
  /// [-] The file says the least and the largest value.
  bool has_bounds = false;
  /// [-] Reader of the values.
  GltfUse use = GltfUse::none;
  /// [-] Integers stand for numbers in [-1, 1].
  bool is_normalized = false;
};

/// A buffer that values are appended to.
class GltfBuffer {
 public:
  /// Appends values, at least one, and returns the number of their accessor.
  template <typename T, std::size_t N>
  std::size_t add(const GltfValues<T, N>& values, const GltfAccessorDef& def = {}) {
    constexpr const char* types[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    // Accessors may begin at multiples of the size of a number.
    bytes_.resize((bytes_.size() + 3) / 4 * 4);
    const std::size_t start = bytes_.size();
    std::array<T, N> low, high;
    low.fill(std::numeric_limits<T>::max());
    high.fill(std::numeric_limits<T>::lowest());
    for (const std::array<T, N>& value : values) {
      for (std::size_t k = 0; k < N; ++k) {
        append_little_endian(bytes_, value[k]);
        low[k] = std::min(low[k], value[k]);
        high[k] = std::max(high[k], value[k]);
      }
    }
    const std::string use =
        def.use == GltfUse::none
            ? std::string()
            : joined_text(R"(,"target":)", json_number(static_cast<int>(def.use)));
    const std::size_t view =
        views_.add(joined_text(R"({"buffer":0,"byteOffset":)", json_number(start),
                               R"(,"byteLength":)", json_number(bytes_.size() - start), use, '}'));
    std::string accessor = joined_text(
        R"({"bufferView":)", json_number(view), R"(,"componentType":)", json_number(component<T>()),
        R"(,"count":)", json_number(values.size()), R"(,"type":")", types[N], '"');
    if (def.is_normalized) accessor += R"(,"normalized":true)";
    if (def.has_bounds) {
      accessor += joined_text(R"(,"min":)", json_numbers(low), R"(,"max":)", json_numbers(high));
    }
    accessor += '}';
    return accessors_.add(accessor);
  }

  [[nodiscard]] const std::string& bytes() const { return bytes_; }
  [[nodiscard]] const JsonList& accessors() const { return accessors_; }
  [[nodiscard]] const JsonList& views() const { return views_; }

 private:
  /// The name of glTF for the type of a number (`accessor.componentType`).
  template <typename T>
  [[nodiscard]] static constexpr int component() {
    if constexpr (std::is_same_v<T, std::uint8_t>) return 5121;
    if constexpr (std::is_same_v<T, std::int16_t>) return 5122;
    if constexpr (std::is_same_v<T, std::uint16_t>) return 5123;
    if constexpr (std::is_same_v<T, std::uint32_t>) return 5125;
    if constexpr (std::is_same_v<T, float>) return 5126;
  }

  std::string bytes_;
  JsonList views_, accessors_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
