/// @file
/// Hash of many values: equal bits give an equal number.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

namespace bristle::inline BRISTLE_ABI::detail {

/// True for types whose bytes are their value, without padding or addresses. Specialise it for
/// numbers that are not built in.
template <typename T>
inline constexpr bool is_plain_value = std::is_arithmetic_v<T> || std::is_enum_v<T>;

/// A number, a truth value or an enumerator.
template <typename T>
concept PlainValue = is_plain_value<std::remove_cv_t<T>>;

/// Unsigned integer of a given size in bytes.
template <std::size_t Size>
struct UnsignedOfSize;
template <>
struct UnsignedOfSize<1> {
  using Type = std::uint8_t;
};
template <>
struct UnsignedOfSize<2> {
  using Type = std::uint16_t;
};
template <>
struct UnsignedOfSize<4> {
  using Type = std::uint32_t;
};
template <>
struct UnsignedOfSize<8> {
  using Type = std::uint64_t;
};

/// Returns the bits of a value. They are the low bits of as many words as it needs.
template <PlainValue T>
[[nodiscard]] constexpr auto bits_of(const T& value) {
  if constexpr (sizeof(T) <= sizeof(std::uint64_t)) {
    return std::array{
        std::uint64_t{std::bit_cast<typename UnsignedOfSize<sizeof(T)>::Type>(value)}};
  } else {
    static_assert(sizeof(T) % sizeof(std::uint64_t) == 0);
    return std::bit_cast<std::array<std::uint64_t, sizeof(T) / sizeof(std::uint64_t)>>(value);
  }
}

/// Mixes values by their bits, in order. Each value is one word w or several. Then h <- (h xor w)
/// k, h <- h xor h >> 32, with the odd k = floor(2^64 / golden ratio). For a given w this maps h
/// one to one. For a given h it maps w one to one. So sequences of one length that differ in one
/// value never have the same hash. Other sequences collide with a chance of 2^-64. It does not
/// protect against deliberate collisions.
class BitHash {
 public:
  template <PlainValue T>
  void add(const T& value) {
    for (const std::uint64_t word : bits_of(value)) {
      value_ = (value_ ^ word) * 0x9e3779b97f4a7c15u;
      value_ ^= value_ >> 32;
    }
  }
  [[nodiscard]] std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0x6a09e667f3bcc909u;  // Any start but 0, which a word 0 would not change.
};

/// Hash of a block of bytes. It mixes the size, then eight bytes at a time, then the rest.
[[nodiscard]] inline std::uint64_t hash_of(std::span<const std::byte> bytes) {
  BitHash hash;
  hash.add(bytes.size());
  const std::byte* at = bytes.data();
  const std::byte* const end = at + bytes.size();
  for (; static_cast<std::size_t>(end - at) >= sizeof(std::uint64_t); at += sizeof(std::uint64_t)) {
    std::uint64_t word = 0;
    std::memcpy(&word, at, sizeof word);
    hash.add(word);
  }
  for (; at != end; ++at) hash.add(*at);
  return hash.value();
}

}  // namespace bristle::inline BRISTLE_ABI::detail
