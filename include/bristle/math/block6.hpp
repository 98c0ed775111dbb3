/// @file
/// Products of 6x6 blocks, for the factorisations of matrices with six unknowns a body.
///
/// Six entries are summed side by side, so that they fill vector registers. Each entry is summed in
/// the same order for registers of every width.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/unrolled.hpp>
#include <bristle/math/simd.hpp>

#include <algorithm>
#include <array>
#include <cstddef>

namespace bristle::inline BRISTLE_ABI::detail {

/// A 6x6 matrix. Its rows are padded to whole registers.
template <Scalar S>
struct Block6 {
  /// [-] Numbers from one row to the next, and packs that hold the six.
  static constexpr std::size_t stride = std::max<std::size_t>(8, lanes<S>);
  static constexpr std::size_t packs = (6 + lanes<S> - 1) / lanes<S>;

  std::array<S, 6 * stride> values{};

  [[nodiscard]] S* row(std::size_t i) { return values.data() + stride * i; }
  [[nodiscard]] const S* row(std::size_t i) const { return values.data() + stride * i; }
};

/// Six numbers side by side, as in a row of a `Block6`.
template <Scalar S>
struct Six {
  static constexpr std::size_t packs = Block6<S>::packs;

  Pack<S> part[packs];

  [[nodiscard]] BRISTLE_FORCE_INLINE static Six load(const S* from) {
    Six six;
    unrolled<packs>([&](auto p) { six.part[p] = Pack<S>::load(from + lanes<S> * p); });
    return six;
  }
  BRISTLE_FORCE_INLINE void store(S* to) const {
    unrolled<packs>([&](auto p) { part[p].store(to + lanes<S> * p); });
  }
  BRISTLE_FORCE_INLINE void add(const S& factor, const Six& other) {
    const Pack<S> all(factor);
    unrolled<packs>([&](auto p) { part[p] += all * other.part[p]; });
  }
  BRISTLE_FORCE_INLINE void scale(const S& factor) {
    const Pack<S> all(factor);
    unrolled<packs>([&](auto p) { part[p] *= all; });
  }
  BRISTLE_FORCE_INLINE void subtract(const S& factor, const Six& other) {
    const Pack<S> all(factor);
    unrolled<packs>([&](auto p) { part[p] -= all * other.part[p]; });
  }
};

/// out += sign * left right, where `left` has six rows and `count` columns.
/// @param left         Its first entry, and the way to the next row and column.
/// @param right, out   `count` rows and six, padded as those of a `Block6`.
template <int sign, Scalar S>
BRISTLE_FORCE_INLINE void add_product(const S* left, std::size_t next_row, std::size_t next_column,
                                      const S* right, std::size_t count, S* out) {
  constexpr std::size_t stride = Block6<S>::stride;
  // Sums, a row of `right` and a factor have to fit into sixteen registers.
  constexpr std::size_t at_once = Six<S>::packs <= 2 ? 6 : 3;
  for (std::size_t first = 0; first < 6; first += at_once) {
    Six<S> sums[at_once];
    unrolled<at_once>([&](auto a) { sums[a] = Six<S>::load(out + stride * (first + a)); });
    for (std::size_t k = 0; k < count; ++k) {
      const Six<S> row = Six<S>::load(right + stride * k);
      unrolled<at_once>([&](auto a) {
        const S& factor = left[next_row * (first + a) + next_column * k];
        if constexpr (sign > 0) {
          sums[a].add(factor, row);
        } else {
          sums[a].subtract(factor, row);
        }
      });
    }
    unrolled<at_once>([&](auto a) { sums[a].store(out + stride * (first + a)); });
  }
}

/// Sum of six products.
template <Scalar S>
[[nodiscard]] BRISTLE_FORCE_INLINE S dot6(const S* a, const S* b) {
  return (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3]) + (a[4] * b[4] + a[5] * b[5]);
}

}  // namespace bristle::inline BRISTLE_ABI::detail
