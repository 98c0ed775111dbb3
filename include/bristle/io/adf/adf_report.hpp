/// @file
/// What reading an AMBF description (ADF) can say: one error with its place, and the list of what
/// was not taken as it stands.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>

#include <algorithm>
#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// Something in a description breaks a rule. Reads
/// "gripper.yaml:12: BODY Tip/mass = -1: must be finite and >= 0".
class AdfError : public IoError {
 public:
  AdfError(std::string file, std::size_t line, std::string key, std::string value, std::string rule)
      : IoError(std::move(file), line,
                key + (key.empty() || value.empty() ? "" : " = ") + value +
                    (key.empty() && value.empty() ? "" : ": ") + rule),
        key_(std::move(key)),
        value_(std::move(value)),
        rule_(std::move(rule)) {}

  /// The offending key with those around it ("BODY Tip/friction/static"); empty where the fault is
  /// the file's.
  [[nodiscard]] const std::string& key() const noexcept { return key_; }
  /// What the file gives for it; empty where it gives nothing, or something without a short text.
  [[nodiscard]] const std::string& value() const noexcept { return value_; }
  /// The rule it breaks ("must be finite and >= 0").
  [[nodiscard]] const std::string& rule() const noexcept { return rule_; }

 private:
  std::string key_;
  std::string value_;
  std::string rule_;
};

/// In what way something was not taken as it stands.
enum class AdfNoteKind {
  /// A key of the format that nothing here answers to: looks, communication, soft bodies.
  unsupported,
  /// No key of the format: an anchor's holder, a leftover, a slip of the pen.
  unknown,
  /// Taken, but not word for word.
  changed,
  /// A whole joint, sensor or actuator that was left out.
  left_out
};

/// Word for a kind, as reports print it.
[[nodiscard]] constexpr const char* name_of(AdfNoteKind kind) {
  constexpr const char* names[] = {"unsupported", "unknown", "changed", "left out"};
  return names[static_cast<std::size_t>(kind)];
}

/// One thing that was not taken as it stands, however often it occurs.
struct AdfNote {
  AdfNoteKind kind = AdfNoteKind::unknown;
  /// The key with the kind of block it stands in ("body/collision margin"), or the name of the
  /// block that was left out.
  std::string key;
  /// Why, or what was made of it.
  std::string reason;
  /// 1-based line of the first occurrence.
  std::size_t line = 0;
  std::size_t count = 1;
};

/// All that was not taken as it stands.
class AdfReport {
 public:
  /// Adds a note, or counts one more of its kind, key and reason.
  void add(AdfNoteKind kind, std::string key, std::string reason, std::size_t line) {
    const auto known = places_.find({kind, key, reason});
    if (known != places_.end()) {
      AdfNote& note = notes_[known->second];
      ++note.count;
      note.line = std::min(note.line, line);
      return;
    }
    if (notes_.size() == max_notes) {
      ++dropped_;
      return;
    }
    places_.emplace(Name{kind, key, reason}, notes_.size());
    notes_.push_back({kind, std::move(key), std::move(reason), line, 1});
  }

  /// In the order in which they were found.
  [[nodiscard]] const std::vector<AdfNote>& notes() const noexcept { return notes_; }
  /// [-] Notes that found no place: a file of nothing but slips does not fill the memory.
  [[nodiscard]] std::size_t dropped() const noexcept { return dropped_; }

  /// The notes as text, a line each, in the order of the file.
  [[nodiscard]] std::string text() const {
    std::vector<const AdfNote*> sorted;
    for (const AdfNote& note : notes_) sorted.push_back(&note);
    // Those of one line in the order in which they were found.
    std::sort(sorted.begin(), sorted.end(), [](const AdfNote* a, const AdfNote* b) {
      return a->line != b->line ? a->line < b->line : a < b;
    });
    std::string text;
    for (const AdfNote* each : sorted) {
      const AdfNote& note = *each;
      text += "line " + std::to_string(note.line) + ": " + name_of(note.kind) + ": " + note.key;
      if (note.count > 1) text += " (" + std::to_string(note.count) + " times)";
      if (!note.reason.empty()) text += ": " + note.reason;
      text += '\n';
    }
    if (dropped_ > 0) text += "and " + std::to_string(dropped_) + " more\n";
    return text;
  }

 private:
  static constexpr std::size_t max_notes = 1000;
  using Name = std::tuple<AdfNoteKind, std::string, std::string>;

  std::vector<AdfNote> notes_;
  std::map<Name, std::size_t> places_;
  std::size_t dropped_ = 0;
};

namespace detail {

/// A scalar as it may stand in a message: short, and without control characters.
[[nodiscard]] inline std::string printable(std::string_view text) {
  std::string result;
  for (const char c : text.substr(0, 60)) result += c < ' ' || c > '~' ? '?' : c;
  if (text.size() > 60) result += "...";
  return result;
}

}  // namespace detail
}  // namespace bristle::inline BRISTLE_ABI
