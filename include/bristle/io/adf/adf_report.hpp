/// @file
/// Results of reading an AMBF description (ADF): one error with its place, and the list of changed
/// or omitted parts.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/io/utf8.hpp>

#include <algorithm>
#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// Thrown if a value in a description breaks a rule. Its text is "gripper.yaml:12: BODY Tip/mass =
/// -1: must be finite and >= 0".
class AdfError : public IoError {
 public:
  /// @param file   The file as the caller named it.
  /// @param line   1-based line. It is 0 where lines have no meaning.
  /// @param key    The offending key with its parents. May be empty.
  /// @param value  Its value as text. May be empty.
  /// @param rule   The broken rule.
  AdfError(std::string file, std::size_t line, std::string key, std::string value, std::string rule)
      : IoError(std::move(file), line,
                key + (key.empty() || value.empty() ? "" : " = ") + value +
                    (key.empty() && value.empty() ? "" : ": ") + rule),
        key_(std::move(key)),
        value_(std::move(value)),
        rule_(std::move(rule)) {}

  /// The offending key with its parents ("BODY Tip/friction/static"). Empty if the fault is the
  /// whole file's.
  [[nodiscard]] const std::string& key() const noexcept { return key_; }
  /// Value in the file. Empty if there is none, or none with a short text.
  [[nodiscard]] const std::string& value() const noexcept { return value_; }
  /// The broken rule ("must be finite and >= 0").
  [[nodiscard]] const std::string& rule() const noexcept { return rule_; }

 private:
  std::string key_;
  std::string value_;
  std::string rule_;
};

/// Kind of change or omission.
enum class AdfNoteKind {
  /// A key of the format without an equivalent here: looks, communication, soft bodies.
  unsupported,
  /// No key of the format: an anchor's holder, a leftover, a typing error.
  unknown,
  /// Read, but changed.
  changed,
  /// A whole joint, sensor or actuator that was left out.
  left_out
};

/// Word for a kind, as reports print it.
[[nodiscard]] constexpr const char* name_of(AdfNoteKind kind) {
  constexpr const char* names[] = {"unsupported", "unknown", "changed", "left out"};
  return names[static_cast<std::size_t>(kind)];
}

/// One changed or omitted part, however often it occurs.
struct AdfNote {
  /// Kind of change or omission.
  AdfNoteKind kind = AdfNoteKind::unknown;
  /// The key with its kind of block ("body/collision margin"), or the name of the omitted block.
  std::string key;
  /// Reason of the omission, or the replacement.
  std::string reason;
  /// The file, as the caller named it.
  std::string file;
  /// 1-based line of the first occurrence.
  std::size_t line = 0;
  /// [-] Number of occurrences.
  std::size_t count = 1;
};

/// All changed or omitted parts.
class AdfReport {
 public:
  AdfReport() = default;
  /// @param file  The file of the notes that `add` adds.
  explicit AdfReport(std::string file) : file_(std::move(file)) { files_.emplace(file_, 0); }

  /// Adds a note, or counts one more with its kind, key and reason.
  void add(AdfNoteKind kind, std::string key, std::string reason, std::size_t line) {
    add(AdfNote{kind, std::move(key), std::move(reason), file_, line, 1});
  }

  /// Adds the notes of another report, with their files.
  void append(const AdfReport& other) {
    for (const std::string& file : other.in_order()) files_.emplace(file, files_.size());
    for (const AdfNote& note : other.notes_) add(note);
    dropped_ += other.dropped_;
  }

  /// Notes in the order in which they were found.
  [[nodiscard]] const std::vector<AdfNote>& notes() const noexcept { return notes_; }
  /// [-] Notes beyond the capacity: a file full of errors does not fill the memory.
  [[nodiscard]] std::size_t dropped() const noexcept { return dropped_; }

  /// The notes as text, a line each, in the order of the files and in each in that of its lines. If
  /// there are several files each line begins with its own.
  [[nodiscard]] std::string text() const {
    // Notes of one line keep the order in which they were found.
    std::vector<std::tuple<std::size_t, std::size_t, const AdfNote*>> sorted;
    for (const AdfNote& note : notes_) {
      const auto file = files_.find(note.file);
      sorted.emplace_back(file == files_.end() ? 0 : file->second, note.line, &note);
    }
    std::sort(sorted.begin(), sorted.end());
    std::string text;
    for (const auto& [file, line, each] : sorted) {
      const AdfNote& note = *each;
      text += files_.size() > 1 ? note.file + ":" : "line ";
      text += std::to_string(note.line) + ": " + name_of(note.kind) + ": " + note.key;
      if (note.count > 1) text += " (" + std::to_string(note.count) + " times)";
      if (!note.reason.empty()) text += ": " + note.reason;
      text += '\n';
    }
    if (dropped_ > 0) text += "and " + std::to_string(dropped_) + " more\n";
    return text;
  }

 private:
  /// [-] Notes that are kept; the others are counted.
  static constexpr std::size_t max_notes = 1000;
  using Name = std::tuple<AdfNoteKind, std::string, std::string, std::string>;

  void add(AdfNote added) {
    Name name{added.kind, added.key, added.reason, added.file};
    const auto known = places_.find(name);
    if (known != places_.end()) {
      AdfNote& note = notes_[known->second];
      note.count += added.count;
      note.line = std::min(note.line, added.line);
      return;
    }
    if (notes_.size() == max_notes) {
      ++dropped_;
      return;
    }
    places_.emplace(std::move(name), notes_.size());
    notes_.push_back(std::move(added));
  }

  /// The files in the order in which they came.
  [[nodiscard]] std::vector<std::string> in_order() const {
    std::vector<std::string> result(files_.size());
    for (const auto& [file, place] : files_) result[place] = file;
    return result;
  }

  std::string file_;
  std::map<std::string, std::size_t> files_;
  std::vector<AdfNote> notes_;
  std::map<Name, std::size_t> places_;
  std::size_t dropped_ = 0;
};

namespace detail {

/// Text for messages, without control characters. Of scalars that are no names the beginning says
/// enough.
[[nodiscard]] inline std::string printable(std::string_view text, std::size_t longest = 60) {
  std::string result;
  for (const char c : text.substr(0, longest)) result += c < ' ' || c > '~' ? '?' : c;
  if (text.size() > longest) result += "...";
  return result;
}

/// A path for messages, whole. UTF-8 stays as it is, except for control characters.
[[nodiscard]] inline std::string printable_path(std::string_view path) {
  if (first_not_utf8(path) < path.size()) return printable(path, path.size());
  std::string result;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const auto byte = static_cast<unsigned char>(path[i]);
    // U+0080 to U+009F are control characters, too: two bytes, of which the first is this.
    const bool is_high_control = byte == 0xc2 && static_cast<unsigned char>(path[i + 1]) < 0xa0;
    if (is_high_control) ++i;
    result += byte < ' ' || byte == 0x7f || is_high_control ? '?' : path[i];
  }
  return result;
}

}  // namespace detail
}  // namespace bristle::inline BRISTLE_ABI
