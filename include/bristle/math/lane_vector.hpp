/// @file
/// Long arrays for loads of whole registers.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <cstddef>
#include <new>
#include <vector>

namespace bristle::inline BRISTLE_ABI::detail {

/// Allocates at the beginnings of cache lines. Memory of `std::allocator` begins 16 bytes behind
/// one. Every load of a whole register then crosses lines.
template <typename T>
struct LineAllocator {
  using value_type = T;
  static constexpr std::align_val_t line{64};

  LineAllocator() = default;
  template <typename U>  // NOLINTNEXTLINE(google-explicit-constructor): containers convert.
  LineAllocator(const LineAllocator<U>&) noexcept {}

  /// @param n  [-] Small enough for its bytes to be addressed. Vectors see to that.
  [[nodiscard]] T* allocate(std::size_t n) {
    return static_cast<T*>(::operator new(n * sizeof(T), line));
  }
  void deallocate(T* p, std::size_t) { ::operator delete(p, line); }

  [[nodiscard]] friend bool operator==(const LineAllocator&, const LineAllocator&) noexcept {
    return true;
  }
};

/// A std::vector in which each register is loaded from one cache line.
template <typename T>
using LaneVector = std::vector<T, LineAllocator<T>>;

}  // namespace bristle::inline BRISTLE_ABI::detail
