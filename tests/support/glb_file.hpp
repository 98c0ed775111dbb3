/// @file
/// A reader of binary glTF, to look into what was written.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "support/json.hpp"

#include <bristle/math/types.hpp>

#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace bristle::test {

/// A .glb file, taken apart.
struct Glb {
  Json json;
  std::string binary;

  explicit Glb(const std::string& bytes) : json(chunk(bytes, 12, "JSON")) {
    REQUIRE(bytes.substr(0, 4) == "glTF");
    REQUIRE(number<std::uint32_t>(bytes, 4) == 2);
    REQUIRE(number<std::uint32_t>(bytes, 8) == bytes.size());
    const std::size_t second = 20 + number<std::uint32_t>(bytes, 12);
    REQUIRE(second % 4 == 0);
    binary = chunk(bytes, second, std::string("BIN\0", 4));
    REQUIRE(second + 8 + binary.size() == bytes.size());
    // The chunk is filled up to whole words, the buffer is not.
    REQUIRE((json["buffers"][0]["byteLength"].index() + 3) / 4 * 4 == binary.size());
  }
  template <typename T>
  static T number(const std::string& bytes, std::size_t at) {
    T value;
    REQUIRE(at + sizeof value <= bytes.size());
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
  }
  static std::string chunk(const std::string& bytes, std::size_t at, const std::string& type) {
    REQUIRE(bytes.substr(at + 4, 4) == type);
    return bytes.substr(at + 8, number<std::uint32_t>(bytes, at));
  }
  /// All numbers of an accessor, one value after another.
  [[nodiscard]] std::vector<double> values(const Json& index) const {
    const Json& accessor = json["accessors"][index.index()];
    const Json& view = json["bufferViews"][accessor["bufferView"].index()];
    const std::string& type = accessor["type"].text();
    const std::size_t width = type == "SCALAR" ? 1 : type == "VEC3" ? 3 : 4;
    const std::size_t start = view["byteOffset"].index();
    const std::size_t kind = accessor["componentType"].index();
    const std::size_t size = kind == 5121 ? 1 : kind == 5122 || kind == 5123 ? 2 : 4;
    const double unit = accessor.has("normalized") ? 1 / 32767.0 : 1;
    const std::size_t count = accessor["count"].index() * width;
    REQUIRE(start % 4 == 0);
    REQUIRE(count * size == view["byteLength"].index());
    std::vector<double> out;
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t at = start + i * size;
      out.push_back(kind == 5126   ? static_cast<double>(number<float>(binary, at))
                    : kind == 5121 ? number<std::uint8_t>(binary, at)
                    : kind == 5122 ? number<std::int16_t>(binary, at) * unit
                    : kind == 5123 ? number<std::uint16_t>(binary, at)
                                   : static_cast<double>(number<std::uint32_t>(binary, at)));
    }
    for (std::size_t k = 0; accessor.has("min") && k < width; ++k) {
      for (std::size_t i = k; i < out.size(); i += width) {
        CHECK(out[i] >= static_cast<double>(static_cast<float>(accessor["min"][k].number())));
        CHECK(out[i] <= static_cast<double>(static_cast<float>(accessor["max"][k].number())));
      }
    }
    return out;
  }
  [[nodiscard]] std::size_t node(const std::string& name) const {
    for (std::size_t i = 0; i < json["nodes"].size(); ++i) {
      if (json["nodes"][i]["name"].text() == name) return i;
    }
    FAIL("no node " << name);
    return 0;
  }
  /// A property of a node at a time [s], as a viewer finds it.
  [[nodiscard]] std::vector<double> at(std::size_t node, const std::string& path, double t) const {
    std::vector<double> out;
    const Json& animation = json["animations"][0];
    for (const Json& channel : animation["channels"].items()) {
      if (channel["target"]["node"].index() != node || channel["target"]["path"].text() != path) {
        continue;
      }
      const Json& sampler = animation["samplers"][channel["sampler"].index()];
      const std::vector<double> times = values(sampler["input"]);
      const std::vector<double> keys = values(sampler["output"]);
      const std::size_t width = keys.size() / times.size();
      std::size_t i = 0;
      while (i + 2 < times.size() && times[i + 1] <= t) ++i;
      REQUIRE(times[i + 1] > times[i]);
      double u = (t - times[i]) / (times[i + 1] - times[i]);
      if (sampler["interpolation"].text() == "STEP") u = u < 1 ? 0 : 1;
      for (std::size_t k = 0; k < width; ++k) {
        out.push_back((1 - u) * keys[i * width + k] + u * keys[(i + 1) * width + k]);
      }
      return out;
    }
    for (const Json& x : json["nodes"][node][path.c_str()].items()) out.push_back(x.number());
    return out;
  }
};

inline Quat<double> quaternion(const std::vector<double>& x) {
  return Quat<double>(x[3], x[0], x[1], x[2]).normalized();
}

}  // namespace bristle::test
