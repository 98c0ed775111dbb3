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

/// Items by the names of descriptions, in the order of the files.
template <typename T>
class AdfNames {
 public:
  /// An item with its names.
  struct Entry {
    /// Namespace and key.
    std::string qualified;
    /// Key of its block.
    std::string key;
    /// Its own `name`, without blanks.
    std::string name;
    /// The item.
    T value;
  };

  /// Items that a name matches.
  struct Match {
    /// The one item, or null.
    const Entry* entry = nullptr;
    /// True if several match.
    bool is_several = false;
  };

  /// Adds an item under its names.
  void add(const AdfItem& item, T value) {
    add(Entry{item.qualified, item.key, item.name, std::move(value)});
  }

  /// Adds the items of another description.
  void append(const AdfNames& other) {
    for (const Entry& entry : other.entries_) add(entry);
  }

  /// Returns the item of a name: the only one with that qualified name, else with that key, else
  /// with that own name, else the only one whose qualified name contains it. Null if there is none,
  /// or several.
  [[nodiscard]] const T* find(std::string_view name) const {
    std::size_t searched = 0;
    const Match found = match(name, searched);
    return found.entry == nullptr ? nullptr : &found.entry->value;
  }
  /// The same.
  [[nodiscard]] T* find(std::string_view name) {
    return const_cast<T*>(std::as_const(*this).find(name));
  }
  /// The same. Adds to `searched` the bytes of the names that it searched for a part. Whole names
  /// are found without.
  [[nodiscard]] Match match(std::string_view name, std::size_t& searched) const {
    for (const auto* names : {&by_qualified_, &by_key_, &by_name_}) {
      const auto at = names->find(name);
      if (at == names->end()) continue;
      if (at->second.count > 1) return {.is_several = true};
      return {.entry = &entries_[at->second.first]};
    }
    const AdfPart part(name);
    Match found;
    for (const Entry& entry : entries_) {
      searched += entry.qualified.size();
      if (!part.is_in(entry.qualified)) continue;
      if (found.entry != nullptr) return {.is_several = true};
      found.entry = &entry;
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
  /// The same.
  [[nodiscard]] T& at(std::string_view name) {
    return const_cast<T&>(std::as_const(*this).at(name));
  }

  /// [-] Number of items.
  [[nodiscard]] std::size_t size() const noexcept { return entries_.size(); }
  /// The items in order.
  [[nodiscard]] auto begin() const noexcept { return entries_.begin(); }
  /// Their end.
  [[nodiscard]] auto end() const noexcept { return entries_.end(); }

 private:
  /// First item with a name, and the number of such items.
  struct Named {
    std::size_t first;
    std::size_t count;
  };
  using Index = std::map<std::string, Named, std::less<>>;

  void add(Entry entry) {
    const auto count = [this](Index& index, const std::string& name) {
      ++index.emplace(name, Named{entries_.size(), 0}).first->second.count;
    };
    count(by_qualified_, entry.qualified);
    count(by_key_, entry.key);
    count(by_name_, entry.name);
    entries_.push_back(std::move(entry));
  }

  std::vector<Entry> entries_;
  Index by_qualified_;
  Index by_key_;
  Index by_name_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail

namespace bristle::inline BRISTLE_ABI {

// The lists of an AdfScene.
using detail::AdfNames;

}  // namespace bristle::inline BRISTLE_ABI
