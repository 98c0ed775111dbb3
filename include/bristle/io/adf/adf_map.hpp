/// @file
/// Typed reading of one map of an AMBF description. Each value has its rule, and each error its
/// place. Unread keys go on the report.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/io/adf/adf_report.hpp>
#include <bristle/io/adf/adf_tree.hpp>
#include <bristle/math/transform.hpp>

#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI::detail {

/// Rule that a number must satisfy.
struct AdfRule {
  const char* text;
  bool (*holds)(double);
};
inline constexpr AdfRule adf_finite{"must be a finite number", [](double) { return true; }};
inline constexpr AdfRule adf_positive{"must be finite and > 0", [](double x) { return x > 0; }};
inline constexpr AdfRule adf_not_negative{"must be finite and >= 0",
                                          [](double x) { return x >= 0; }};

/// R = Rz(yaw) Ry(pitch) Rx(roll), about the fixed axes.
[[nodiscard]] inline Quat<double> from_roll_pitch_yaw(double roll, double pitch, double yaw) {
  using AngleAxis = Eigen::AngleAxis<double>;
  return Quat<double>(AngleAxis(yaw, Vec3<double>::UnitZ()) *
                      AngleAxis(pitch, Vec3<double>::UnitY()) *
                      AngleAxis(roll, Vec3<double>::UnitX()))
      .normalized();
}

/// A map under its name. Each key is read once; `finish` reports the unread ones.
class AdfMap {
 public:
  /// @param path   Names of the maps around it and its own, for errors ("BODY Tip/friction").
  /// @param block  Kind of the map, for the report ("body/friction").
  AdfMap(AdfTree& tree, std::uint32_t node, std::string path, std::string block)
      : tree_(&tree), node_(node), path_(std::move(path)), block_(std::move(block)) {
    if (self().kind == AdfNode::Kind::null) return;  // `joint limits:` without a value
    if (self().kind != AdfNode::Kind::map) {
      tree_->fail(self().line, path_, printable(self().text), "must be a map of keys");
    }
  }

  [[nodiscard]] std::size_t line() const { return self().line; }
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] AdfTree& tree() const { return *tree_; }

  /// Returns whether the key is present with a value.
  [[nodiscard]] bool has(std::string_view key) const {
    const AdfNode* node = find(key);
    return node != nullptr && node->kind != AdfNode::Kind::null;
  }

  /// Returns whether the key is present with a list.
  [[nodiscard]] bool has_list(std::string_view key) const {
    const AdfNode* node = find(key);
    return node != nullptr && node->kind == AdfNode::Kind::list;
  }

  [[nodiscard]] double number(std::string_view key, const AdfRule& rule) {
    return to_number(key, require(key), rule);
  }
  [[nodiscard]] double number(std::string_view key, double otherwise, const AdfRule& rule) {
    return has(key) ? number(key, rule) : otherwise;
  }

  /// Reads a whole number in [low, high].
  [[nodiscard]] std::size_t count(std::string_view key, std::size_t low, std::size_t high) {
    return to_count(key, require(key), low, high);
  }

  [[nodiscard]] bool flag(std::string_view key, bool otherwise) {
    if (!has(key)) return otherwise;
    const AdfNode& node = require_scalar(key);
    for (const char* word : {"true", "True", "TRUE", "yes", "Yes", "YES", "on", "On", "ON"}) {
      if (node.text == word) return true;
    }
    for (const char* word : {"false", "False", "FALSE", "no", "No", "NO", "off", "Off", "OFF"}) {
      if (node.text == word) return false;
    }
    fail_value(key, node, "must be true or false");
  }

  [[nodiscard]] std::string text(std::string_view key) {
    const AdfNode& node = require_scalar(key);
    if (node.text.find('\0') != std::string::npos) fail_value(key, node, "must be text");
    return node.text;
  }
  [[nodiscard]] std::string text(std::string_view key, std::string otherwise) {
    return has(key) ? text(key) : otherwise;
  }

  /// Reads {x, y, z}, all three.
  [[nodiscard]] Vec3<double> vector(std::string_view key) {
    AdfMap m = map(key);
    const Vec3<double> v(m.number("x", adf_finite), m.number("y", adf_finite),
                         m.number("z", adf_finite));
    m.finish();
    return v;
  }
  /// Reads the same as a direction: any length but zero.
  [[nodiscard]] Vec3<double> direction(std::string_view key) {
    const Vec3<double> v = vector(key);
    const Vec3<double> unit = v.stableNormalized();
    // Its squared norm is 1, or 0 for the zero vector.
    if (!(unit.squaredNorm() > 0.5)) fail(key, "must not be zero");
    return unit;
  }
  /// Reads {position: {x, y, z}, orientation: {r, p, y}}, either of which may be missing.
  [[nodiscard]] Transform<double> pose(std::string_view key) {
    Transform<double> X;
    if (!has(key)) return X;
    AdfMap m = map(key);
    if (m.has("position")) X.translation = m.vector("position");
    if (m.has("orientation")) {
      AdfMap angles = m.map("orientation");
      const double roll = angles.number("r", adf_finite);
      const double pitch = angles.number("p", adf_finite);
      const double yaw = angles.number("y", adf_finite);
      X.rotation = from_roll_pitch_yaw(roll, pitch, yaw);
      angles.finish();
    }
    m.finish();
    return X;
  }

  /// Returns the map of a key. @throws AdfError if the key is missing.
  [[nodiscard]] AdfMap map(std::string_view key) {
    read_.emplace(key);
    const auto at = self().entries.find(key);
    if (at == self().entries.end()) fail(key, "must be given");
    return AdfMap(*tree_, at->second, join(path_, key), join(block_, key));
  }
  /// Returns the maps of a list. None if the key is missing.
  [[nodiscard]] std::vector<AdfMap> maps(std::string_view key) {
    std::vector<AdfMap> result;
    const std::vector<std::uint32_t> list = items(key);
    result.reserve(list.size());
    for (const std::uint32_t item : list) {
      result.emplace_back(*tree_, item, element(key, result.size()), join(block_, key));
    }
    return result;
  }
  /// Returns the scalars of a list, with their lines. None if the key is missing.
  [[nodiscard]] std::vector<std::pair<std::string, std::size_t>> texts(std::string_view key) {
    std::vector<std::pair<std::string, std::size_t>> result;
    for (const std::uint32_t item : items(key)) {
      const AdfNode& node = tree_->nodes[item];
      if (node.kind != AdfNode::Kind::scalar) {
        tree_->fail(node.line, element(key, result.size()), "", "must be a name");
      }
      result.emplace_back(node.text, node.line);
    }
    return result;
  }
  /// Returns the whole numbers of a list, each in [0, high]. There may be no more of them than
  /// different ones, since many blocks may name one list by aliases.
  [[nodiscard]] std::vector<std::size_t> counts(std::string_view key, std::size_t high) {
    std::vector<std::size_t> result;
    const std::vector<std::uint32_t> list = items(key);
    if (list.size() > high + 1) {
      fail(key, "must have at most " + std::to_string(high + 1) + " entries");
    }
    for (const std::uint32_t item : list) {
      result.push_back(to_count(element_name(key, result.size()), tree_->nodes[item], 0, high));
    }
    return result;
  }

  /// Skips keys of the format. Each goes on the report if it is given.
  void skip(std::initializer_list<const char*> keys, const char* reason) {
    for (const char* key : keys) {
      if (self().entries.count(key) == 0) continue;
      note(AdfNoteKind::unsupported, key, reason);
      read_.emplace(key);
    }
  }
  /// Skips keys without effect, and without a note.
  void pass(std::initializer_list<const char*> keys) {
    for (const char* key : keys) read_.emplace(key);
  }

  void note(AdfNoteKind kind, std::string_view key, std::string reason) const {
    const AdfNode* node = find(key);
    tree_->report.add(kind, join(block_, key), std::move(reason),
                      node != nullptr ? node->line : line());
  }

  /// Returns the same map as a block of another kind.
  [[nodiscard]] AdfMap renamed(std::string block) const {
    return AdfMap(*tree_, node_, path_, std::move(block));
  }
  /// Skips all keys.
  void pass_all() {
    for (const auto& [key, node] : self().entries) read_.insert(key);
  }

  /// Skips keys whose values are used elsewhere, by aliases.
  void pass_aliased() {
    for (const auto& [key, node] : self().entries) {
      if (tree_->nodes[node].is_aliased) read_.insert(key);
    }
  }

  /// Reports the unread keys.
  void finish() const {
    for (const auto& [key, node] : self().entries) {
      if (read_.find(key) == read_.end()) {
        tree_->report.add(AdfNoteKind::unknown, join(block_, printable(key)),
                          "no key of this place", tree_->nodes[node].line);
      }
    }
  }

  [[noreturn]] void fail(std::string_view key, std::string rule) const {
    const AdfNode* node = find(key);
    tree_->fail(node != nullptr ? node->line : line(), join(path_, key),
                node != nullptr ? printable(node->text) : std::string(), std::move(rule));
  }

 private:
  [[nodiscard]] const AdfNode& self() const { return tree_->nodes[node_]; }
  [[nodiscard]] const AdfNode* find(std::string_view key) const {
    const auto at = self().entries.find(key);
    return at == self().entries.end() ? nullptr : &tree_->nodes[at->second];
  }
  [[nodiscard]] static std::string join(const std::string& path, std::string_view key) {
    return path.empty() ? std::string(key) : path + "/" + std::string(key);
  }
  [[nodiscard]] static std::string element_name(std::string_view key, std::size_t i) {
    return std::string(key) + "[" + std::to_string(i) + "]";
  }
  [[nodiscard]] std::string element(std::string_view key, std::size_t i) const {
    return join(path_, element_name(key, i));
  }
  [[noreturn]] void fail_value(std::string_view key, const AdfNode& node, std::string rule) const {
    tree_->fail(node.line, join(path_, key), printable(node.text), std::move(rule));
  }

  [[nodiscard]] const AdfNode& require(std::string_view key) {
    read_.emplace(key);
    const AdfNode* node = find(key);
    if (node == nullptr) fail(key, "must be given");
    return *node;
  }
  [[nodiscard]] const AdfNode& require_scalar(std::string_view key) {
    const AdfNode& node = require(key);
    if (node.kind != AdfNode::Kind::scalar) fail_value(key, node, "must be a single value");
    return node;
  }
  [[nodiscard]] std::vector<std::uint32_t> items(std::string_view key) {
    read_.emplace(key);
    if (!has(key)) return {};
    const AdfNode& node = *find(key);
    if (node.kind != AdfNode::Kind::list) fail_value(key, node, "must be a list");
    return node.items;
  }

  [[nodiscard]] double to_number(std::string_view key, const AdfNode& node,
                                 const AdfRule& rule) const {
    std::string_view digits = node.text;
    // from_chars rejects a leading plus; "+-1" stays an error.
    if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-') digits.remove_prefix(1);
    double value = 0.0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    const bool is_read = node.kind == AdfNode::Kind::scalar && error == std::errc{} &&
                         end == digits.data() + digits.size();
    if (!is_read || !std::isfinite(value) || !rule.holds(value)) fail_value(key, node, rule.text);
    return value;
  }
  [[nodiscard]] std::size_t to_count(std::string_view key, const AdfNode& node, std::size_t low,
                                     std::size_t high) const {
    std::size_t value = 0;
    const char* const last = node.text.data() + node.text.size();
    const auto [end, error] = std::from_chars(node.text.data(), last, value);
    const bool is_read = node.kind == AdfNode::Kind::scalar && error == std::errc{} && end == last;
    if (!is_read || value < low || value > high) {
      fail_value(
          key, node,
          "must be a whole number from " + std::to_string(low) + " to " + std::to_string(high));
    }
    return value;
  }

  AdfTree* tree_;
  std::uint32_t node_;
  std::string path_;
  std::string block_;
  std::set<std::string, std::less<>> read_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
