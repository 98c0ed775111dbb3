/// @file
/// Lookup of items by the names of an AMBF description.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/io/adf/adf_model.hpp>

#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI::detail {

/// Search for one text in many. Each is read once, whatever the two repeat (Knuth, Morris and Pratt
/// 1977).
class AdfPart {
 public:
  explicit AdfPart(std::string_view part) : part_(part), border_(part.size(), 0) {
    for (std::size_t i = 1, met = 0; i < part.size(); ++i) {
      met = after(met, part[i]);
      border_[i] = met;
    }
  }

  [[nodiscard]] bool is_in(std::string_view text) const {
    if (part_.empty()) return true;
    std::size_t met = 0;
    for (const char c : text) {
      met = after(met, c);
      if (met == part_.size()) return true;
    }
    return false;
  }

 private:
  /// Length of the match after one more character, given the length `met` before.
  [[nodiscard]] std::size_t after(std::size_t met, char c) const {
    while (met > 0 && part_[met] != c) met = border_[met - 1];
    return part_[met] == c ? met + 1 : 0;
  }

  std::string_view part_;
  // Length of the longest proper prefix that ends the first i + 1 characters.
  std::vector<std::size_t> border_;
};

/// Items by the names of a description, in the order of the file.
template <typename T>
class AdfNames {
 public:
  struct Entry {
    std::string qualified;
    std::string key;
    std::string name;
    T value;
  };

  void add(const AdfItem& item, T value) {
    by_qualified_.emplace(item.qualified, entries_.size());
    by_key_.emplace(item.key, entries_.size());
    ++by_name_.emplace(item.name, Named{entries_.size(), 0}).first->second.count;
    entries_.push_back({item.qualified, item.key, item.name, std::move(value)});
  }

  /// Returns the item of a name: the one of that qualified name or key, else the only one with that
  /// own name, else the only one whose qualified name contains it. Null if there is none, or
  /// several.
  [[nodiscard]] const T* find(std::string_view name) const {
    std::size_t searched = 0;
    return find(name, searched);
  }
  [[nodiscard]] T* find(std::string_view name) {
    return const_cast<T*>(std::as_const(*this).find(name));
  }
  /// The same. Adds to `searched` the bytes of the names that it searched for a part. Whole names
  /// are found without.
  [[nodiscard]] const T* find(std::string_view name, std::size_t& searched) const {
    for (const auto* names : {&by_qualified_, &by_key_}) {
      const auto at = names->find(name);
      if (at != names->end()) return &entries_[at->second].value;
    }
    const auto named = by_name_.find(name);
    if (named != by_name_.end()) {
      return named->second.count == 1 ? &entries_[named->second.first].value : nullptr;
    }
    const AdfPart part(name);
    const T* found = nullptr;
    for (const Entry& entry : entries_) {
      searched += entry.qualified.size();
      if (!part.is_in(entry.qualified)) continue;
      if (found != nullptr) return nullptr;
      found = &entry.value;
    }
    return found;
  }

  /// The same as `find`, for names that must exist.
  /// @throws InvalidArgument if the name matches no item, or several.
  [[nodiscard]] const T& at(std::string_view name) const {
    const T* found = find(name);
    if (found == nullptr) {
      raise(InvalidArgument("AdfNames::at: name", std::string(name),
                            "must be a name of the description, or a part of just one"));
    }
    return *found;
  }
  [[nodiscard]] T& at(std::string_view name) {
    return const_cast<T&>(std::as_const(*this).at(name));
  }

  [[nodiscard]] std::size_t size() const noexcept { return entries_.size(); }
  [[nodiscard]] auto begin() const noexcept { return entries_.begin(); }
  [[nodiscard]] auto end() const noexcept { return entries_.end(); }

 private:
  /// First item with an own name, and the number of such items.
  struct Named {
    std::size_t first;
    std::size_t count;
  };

  std::vector<Entry> entries_;
  std::map<std::string, std::size_t, std::less<>> by_qualified_;
  std::map<std::string, std::size_t, std::less<>> by_key_;
  std::map<std::string, Named, std::less<>> by_name_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail

namespace bristle::inline BRISTLE_ABI {

// The lists of an AdfScene.
using detail::AdfNames;

}  // namespace bristle::inline BRISTLE_ABI
