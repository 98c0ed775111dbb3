/// @file
/// One number for many values: equal bits, equal number.
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

namespace bristle::inline BRISTLE_ABI {

/// Whether values of a type are their bytes: without padding or addresses. Specialise it for
/// numbers that are not built in.
template <typename T>
inline constexpr bool is_plain_value = std::is_arithmetic_v<T> || std::is_enum_v<T>;

/// What is a number, a truth value or an enumerator.
template <typename T>
concept PlainValue = is_plain_value<std::remove_cv_t<T>>;

namespace detail {

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

/// The bits of a value as the low bits of words, as many as it needs.
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

}  // namespace detail

/// Mixes values by their bits, in order. Each value is one word w or several: h <- (h xor w) k, h
/// <- h xor h >> 32, with the odd k = floor(2^64 / golden ratio). For a given w that is a bijection
/// of h, and for a given h one of w: two sequences of one length that differ in one value never
/// have the same number, and others have it with a chance of 2^-64. No protection against those who
/// want it.
class BitHash {
 public:
  template <PlainValue T>
  void add(const T& value) {
    for (const std::uint64_t word : detail::bits_of(value)) {
      value_ = (value_ ^ word) * 0x9e3779b97f4a7c15u;
      value_ ^= value_ >> 32;
    }
  }
  [[nodiscard]] std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0x6a09e667f3bcc909u;  // Any start but 0, which 0 would leave where it is.
};

/// The number of a block of bytes: of its size, then eight at a time, then of what is left.
[[nodiscard]] inline std::uint64_t hash_of(std::span<const std::byte> bytes) {
  BitHash hash;
  hash.add(bytes.size());
  for (; bytes.size() >= sizeof(std::uint64_t); bytes = bytes.subspan(sizeof(std::uint64_t))) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data(), sizeof word);
    hash.add(word);
  }
  for (const std::byte byte : bytes) hash.add(byte);
  return hash.value();
}

}  // namespace bristle::inline BRISTLE_ABI
