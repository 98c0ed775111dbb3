/// @file
/// The state of a world as bytes or one number.
///
/// A snapshot is a head and the values of `for_each_state` in order. The head names the writer, in
/// the byte order of the machine. It ends with a hash of the rest, so a damaged snapshot is refused
/// whole. Reading passes over the bytes twice. The first pass changes nothing.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/bit_hash.hpp>
#include <bristle/world/state_visitor.hpp>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI::detail {

/// Head of a snapshot. The version changes with `for_each_state`.
struct SnapshotHead {
  static constexpr std::uint64_t expected_magic = 0x6c7473697262'0001u;  // "brist", and a number.

  std::uint64_t magic = expected_magic;
  std::uint64_t version = 12;
  /// [-] Bytes of a scalar, and of all bytes after the head.
  std::uint64_t scalar_size = 0;
  std::uint64_t payload_size = 0;
  /// [-] Hash of the bytes after the head.
  std::uint64_t payload_hash = 0;
};

/// Splits composed values into numbers. Common base of all visitors of the state.
/// @tparam Derived  Has `number(x)` for a PlainValue.
template <typename Derived>
class ValueVisitor {
 public:
  template <PlainValue T>
  void value(T& x) {
    static_cast<Derived&>(*this).number(x);
  }
  template <typename M>
  requires std::derived_from<std::remove_const_t<M>, Eigen::MatrixBase<std::remove_const_t<M>>>
  void value(M& matrix) {
    for (Eigen::Index i = 0; i < matrix.size(); ++i) value(matrix.coeffRef(i));
  }
  template <typename Handle>
  requires requires(Handle& id) { id.generation; }
  void value(Handle& id) {
    value(id.index);
    value(id.generation);
  }
  template <typename T, std::size_t n>
  void value(std::span<T, n> items) {
    for (T& item : items) value(item);
  }
  template <typename T>
  void any(T&& x) {
    value(x);
  }
};

/// Base of visitors that read a state made by the library itself.
template <typename Derived>
class TrustingVisitor : public ValueVisitor<Derived> {
 public:
  static constexpr bool is_checking = false;

  template <typename T, typename Each, typename Holds>
  void item(const char*, const T& x, Each&& each, Holds&& holds) {
    each(x);
    BRISTLE_ASSERT(holds(x));
    (void)holds;
  }
  void require(const char*, bool holds) {
    BRISTLE_ASSERT(holds);
    (void)holds;
  }
};

/// Mixes the state into one number.
class StateHasher : public TrustingVisitor<StateHasher> {
 public:
  template <PlainValue T>
  void number(const T& x) {
    hash_.add(x);
  }
  template <PlainValue T>
  void same(const char*, const T& x) {
    hash_.add(x);
  }
  template <typename Array, typename Each>
  std::size_t list(const char*, const Array& items, Each&& each) {
    hash_.add(items.size());
    for (const auto& item : items) each(item);
    return items.size();
  }
  [[nodiscard]] std::uint64_t result() const { return hash_.value(); }

 private:
  BitHash hash_;
};

/// Appends the state to a block of bytes.
class StateWriter : public TrustingVisitor<StateWriter> {
 public:
  explicit StateWriter(std::vector<std::byte>& out) : out_(out) {}

  template <PlainValue T>
  void number(const T& x) {
    const std::size_t at = out_.size();
    out_.resize(at + sizeof(T));
    std::memcpy(out_.data() + at, &x, sizeof(T));
  }
  template <PlainValue T>
  void same(const char*, const T& x) {
    number(x);
  }
  template <typename Array, typename Each>
  std::size_t list(const char*, const Array& items, Each&& each) {
    number(std::uint64_t{items.size()});
    for (const auto& item : items) each(item);
    return items.size();
  }

 private:
  std::vector<std::byte>& out_;
};

/// Reads the state from a block of bytes. It never reads beyond the end, for any bytes.
class StateReader : public ValueVisitor<StateReader> {
 public:
  static constexpr bool is_checking = true;

  /// @param is_trial  True to check everything and change nothing.
  StateReader(std::span<const std::byte> bytes, bool is_trial)
      : bytes_(bytes), is_trial_(is_trial) {}

  template <PlainValue T>
  void number(T& x) {
    if (bytes_.size() < sizeof(T)) refuse("size", "too small", "must not end before the state");
    if constexpr (std::is_same_v<T, bool>) {
      const int byte = std::to_integer<int>(bytes_.front());
      if (byte > 1) refuse("truth value", text_of(byte), "must be 0 or 1");
    }
    T read;
    std::memcpy(&read, bytes_.data(), sizeof(T));
    if constexpr (is_scalar<T>) {
      if (!takes_any_ && !(read * T(0) == T(0))) {
        refuse("number", text_of(read), "must be finite");
      }
    }
    if (!is_trial_) x = read;
    bytes_ = bytes_.subspan(sizeof(T));
  }
  template <typename T>
  void any(T&& x) {
    takes_any_ = true;
    value(x);
    takes_any_ = false;
  }
  template <typename T, typename Each, typename Holds>
  void item(const char* name, T& x, Each&& each, Holds&& holds) {
    T read = x;
    const bool was_trial = std::exchange(is_trial_, false);
    each(read);
    is_trial_ = was_trial;
    require(name, holds(std::as_const(read)));
    if (!is_trial_) x = std::move(read);
  }
  template <PlainValue T>
  void same(const char* name, const T& x) {
    T other{};
    into(other);
    if (bits_of(other) == bits_of(x)) return;
    refuse(name, text_of(other), "must be " + text_of(x) + ", as in this world");
  }
  template <typename Array, typename Each>
  std::size_t list(const char* name, Array& items, Each&& each) {
    std::uint64_t count = 0;
    into(count);
    if (count > bytes_.size()) refuse(name, text_of(count), "must fit into the snapshot");
    if (!is_trial_) {
      items.resize(static_cast<std::size_t>(count));
      for (auto& item : items) each(item);
    } else {
      // Checks that rely on values need them, so a trial reads items but keeps none.
      is_trial_ = false;
      for (std::uint64_t i = 0; i < count; ++i) {
        typename Array::value_type item{};
        each(item);
      }
      is_trial_ = true;
    }
    return static_cast<std::size_t>(count);
  }
  void require(const char* name, bool holds) {
    if (!holds) refuse(name, "a number", "must be within its bounds");
  }
  /// Refuses surplus bytes.
  void finish() {
    if (!bytes_.empty()) refuse("size", "too large", "must end where the state does");
  }

  [[noreturn]] static void refuse(const char* what, std::string value, std::string rule) {
    raise(InvalidArgument(std::string("snapshot: ") + what, std::move(value), std::move(rule)));
  }
  template <PlainValue T>
  [[nodiscard]] static std::string text_of(const T& x) {
    return to_text(static_cast<double>(x));
  }

 private:
  /// Reads any number, even in a trial.
  template <PlainValue T>
  void into(T& x) {
    const bool was_trial = std::exchange(is_trial_, false);
    any(x);
    is_trial_ = was_trial;
  }

  std::span<const std::byte> bytes_;
  bool is_trial_;
  /// True if numbers need not be finite.
  bool takes_any_ = false;
};

template <typename State>
[[nodiscard]] std::uint64_t state_hash(const State& state) {
  StateHasher hasher;
  for_each_state(state, hasher);
  return hasher.result();
}

template <Scalar S>
[[nodiscard]] std::vector<std::byte> take_snapshot(const WorldState<S>& state) {
  std::vector<std::byte> bytes(sizeof(SnapshotHead));
  StateWriter writer(bytes);
  for_each_state(state, writer);
  const std::span<const std::byte> payload(bytes.data() + sizeof(SnapshotHead),
                                           bytes.size() - sizeof(SnapshotHead));
  SnapshotHead head;
  head.scalar_size = sizeof(S);
  head.payload_size = payload.size();
  head.payload_hash = hash_of(payload);
  std::memcpy(bytes.data(), &head, sizeof head);
  return bytes;
}

/// Puts a world into the state of a snapshot. The caller updates the boxes in the broad phase.
/// @throws InvalidArgument naming the difference, with the state unchanged.
template <Scalar S>
void restore_snapshot(std::span<const std::byte> bytes, WorldState<S>& state) {
  SnapshotHead head;
  const auto refuse_unless = [](bool holds, const char* what, std::uint64_t value,
                                const char* rule) {
    if (!holds) StateReader::refuse(what, StateReader::text_of(value), rule);
  };
  refuse_unless(bytes.size() >= sizeof head, "size", bytes.size(), "must be that of a snapshot");
  std::memcpy(&head, bytes.data(), sizeof head);
  const std::span<const std::byte> payload = bytes.subspan(sizeof head);
  const SnapshotHead own;
  refuse_unless(head.magic == own.magic, "magic", head.magic, "must come from World::snapshot");
  refuse_unless(head.version == own.version, "version", head.version, "must be that of this code");
  refuse_unless(head.scalar_size == sizeof(S), "bytes of a scalar", head.scalar_size,
                "must be those of this world");
  refuse_unless(head.payload_size == payload.size(), "size", bytes.size(),
                "must be what World::snapshot returned");
  refuse_unless(head.payload_hash == hash_of(payload), "hash", head.payload_hash,
                "must be that of undamaged bytes");
  StateReader trial(payload, true);
  for_each_state(state, trial);
  trial.finish();
  StateReader reader(payload, false);
  for_each_state(state, reader);
}

}  // namespace bristle::inline BRISTLE_ABI::detail
