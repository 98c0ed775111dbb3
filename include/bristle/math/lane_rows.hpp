/// @file
/// Rows of scalars read into lanes and written back. Each lane has a row of its own, anywhere.
///
/// Element by element that takes a load or a store and a shuffle each. Here whole registers are
/// moved, and then transposed in log2(n) rounds of exchanges.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/simd.hpp>

#include <cstddef>
#include <cstdint>
#include <utility>

namespace bristle::inline BRISTLE_ABI::detail {

/// [-] Scalars of a row, with unused ones at its end. These are read and written too.
inline constexpr std::size_t row_stride = 8;

/// Lane i of columns[c] is rows[at[i] + c].
/// @param at  [-] Start of each lane's row.
template <std::size_t count, Scalar S>
BRISTLE_FORCE_INLINE void load_rows(const S* rows, const std::uint32_t* at,
                                    Pack<S> (&columns)[count]);
/// The inverse of `load_rows`. If lanes share a row, the last one stays. Scalars of the row behind
/// `count` may be overwritten.
template <std::size_t count, Scalar S>
BRISTLE_FORCE_INLINE void store_rows(S* rows, const std::uint32_t* at,
                                     const Pack<S> (&columns)[count]);

// Implementation ----------------------------------------------------------------------------------

#if BRISTLE_HAS_SHUFFLE

/// True if rows are transposed. With two lanes that takes more instructions than it saves.
template <Scalar S>
inline constexpr bool are_rows_transposed = has_register<S> && (lanes<S> > 2);

/// [-] Number of registers that are transposed together. Each is a piece of a row, or two rows.
/// These are those of the lanes i and i + row_stride.
template <Scalar S>
inline constexpr std::size_t block_size = lanes<S> < row_stride ? lanes<S> : row_stride;

/// Exchanges lanes of two registers. Lanes of `upper` whose number has the bit d change places with
/// lanes of `lower` that lack it.
template <std::size_t d, Scalar S, std::size_t... lane>
BRISTLE_FORCE_INLINE void exchange(Pack<S>& upper, Pack<S>& lower, std::index_sequence<lane...>) {
  constexpr std::size_t n = lanes<S>;
  const auto a = upper.get();
  const auto b = lower.get();
  upper = Pack<S>(__builtin_shufflevector(a, b, ((lane & d) != 0 ? n + lane - d : lane)...));
  lower = Pack<S>(__builtin_shufflevector(a, b, ((lane & d) != 0 ? n + lane : lane + d)...));
}
/// The same for all registers whose number lacks the bit d, each with the one that has it.
template <std::size_t d, Scalar S, std::size_t... i>
BRISTLE_FORCE_INLINE void exchange_all(Pack<S> (&registers)[block_size<S>],
                                       std::index_sequence<i...>) {
  (exchange<d>(registers[i / d * 2 * d + i % d], registers[i / d * 2 * d + i % d + d],
               std::make_index_sequence<lanes<S>>()),
   ...);
}
template <Scalar S>
BRISTLE_FORCE_INLINE void transpose(Pack<S> (&registers)[block_size<S>]) {
  constexpr std::size_t n = block_size<S>;
  constexpr auto pairs = std::make_index_sequence<n / 2>();
  if constexpr (n > 4) exchange_all<4>(registers, pairs);
  exchange_all<2>(registers, pairs);
  exchange_all<1>(registers, pairs);
}

template <Scalar S, std::size_t... lane>
BRISTLE_FORCE_INLINE Pack<S> load_piece(const S* rows, const std::uint32_t* at,
                                        std::index_sequence<lane...>) {
  if constexpr (lanes<S> <= row_stride) {
    return Pack<S>::load(rows + *at);
  } else {
    typedef S Row __attribute__((vector_size(row_stride * sizeof(S))));
    Row one, other;
    __builtin_memcpy(&one, rows + at[0], sizeof one);
    __builtin_memcpy(&other, rows + at[row_stride], sizeof other);
    return Pack<S>(__builtin_shufflevector(one, other, lane...));
  }
}
/// Writes a register, or one of its two rows. That row starts at lane `first`.
template <std::size_t first, Scalar S, std::size_t... lane>
BRISTLE_FORCE_INLINE void store_piece(const Pack<S>& piece, S* row, std::index_sequence<lane...>) {
  if constexpr (lanes<S> <= row_stride) {
    piece.store(row);
  } else {
    const auto part = __builtin_shufflevector(piece.get(), piece.get(), (first + lane)...);
    __builtin_memcpy(row, &part, sizeof part);
  }
}

#endif

template <std::size_t count, Scalar S>
BRISTLE_FORCE_INLINE void load_rows(const S* rows, const std::uint32_t* at,
                                    Pack<S> (&columns)[count]) {
  static_assert(count <= row_stride);
#if BRISTLE_HAS_SHUFFLE
  if constexpr (are_rows_transposed<S>) {
    constexpr std::size_t n = block_size<S>;
    for (std::size_t first = 0; first < count; first += n) {
      Pack<S> pieces[n];
      for (std::size_t i = 0; i < n; ++i) {
        pieces[i] = load_piece(rows + first, at + i, std::make_index_sequence<lanes<S>>());
      }
      transpose(pieces);
      for (std::size_t i = 0; i < n && first + i < count; ++i) columns[first + i] = pieces[i];
    }
    return;
  }
#endif
  for (std::size_t c = 0; c < count; ++c) columns[c] = Pack<S>::gather(rows + c, at);
}

template <std::size_t count, Scalar S>
BRISTLE_FORCE_INLINE void store_rows(S* rows, const std::uint32_t* at,
                                     const Pack<S> (&columns)[count]) {
  static_assert(count <= row_stride);
#if BRISTLE_HAS_SHUFFLE
  if constexpr (are_rows_transposed<S>) {
    constexpr std::size_t n = block_size<S>;
    for (std::size_t first = 0; first < count; first += n) {
      Pack<S> pieces[n];
      for (std::size_t i = 0; i < n; ++i) {
        pieces[i] = first + i < count ? columns[first + i] : Pack<S>(S(0));
      }
      transpose(pieces);
      // Lane by lane. Of lanes with the same row the last one then stays.
      constexpr auto row = std::make_index_sequence<row_stride>();
      for (std::size_t i = 0; i < n; ++i) {
        store_piece<0>(pieces[i], rows + first + at[i], row);
      }
      for (std::size_t i = n; i < lanes<S>; ++i) {
        store_piece<n>(pieces[i - n], rows + first + at[i], row);
      }
    }
    return;
  }
#endif
  for (std::size_t c = 0; c < count; ++c) columns[c].scatter(rows + c, at);
}

}  // namespace bristle::inline BRISTLE_ABI::detail
