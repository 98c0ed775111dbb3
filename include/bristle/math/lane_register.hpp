/// @file
/// The registers under `Pack` and `Mask` (simd.hpp), their width and their comparisons. An array
/// replaces a register where there is none.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/types.hpp>

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>

#if BRISTLE_REGISTER_BYTES > 0
#define BRISTLE_HAS_SIMD 1
// <immintrin.h> is 36,000 lines for all sets. That is a quarter of what a user's file would
// compile.
#if defined(__AVX__)
#include <immintrin.h>
#elif defined(__SSE2__)
#include <emmintrin.h>
#endif
#else
#define BRISTLE_HAS_SIMD 0
#endif

// 1 if one expression can reorder the lanes of registers (GCC from 12 on). Else 0.
#define BRISTLE_HAS_SHUFFLE 0
#if BRISTLE_HAS_SIMD
#if __has_builtin(__builtin_shufflevector)
#undef BRISTLE_HAS_SHUFFLE
#define BRISTLE_HAS_SHUFFLE 1
#endif
#endif

namespace bristle::inline BRISTLE_ABI::detail {

/// [bytes] Size of a register.
inline constexpr std::size_t simd_bytes = BRISTLE_HAS_SIMD ? BRISTLE_REGISTER_BYTES : 16;

/// True if S has vector registers.
template <Scalar S>
inline constexpr bool has_register = BRISTLE_HAS_SIMD != 0 &&
                                     (std::same_as<S, float> || std::same_as<S, double>);

/// [-] Lanes of a Pack<S>, at most 16.
template <Scalar S>
inline constexpr std::size_t lanes = has_register<S> ? simd_bytes / sizeof(S) : 4;

// Keeps rare parts of a loop over packs out of line. Inlined, they would take its registers.
#if defined(__GNUC__)
#define BRISTLE_NOINLINE [[gnu::noinline]]
#else
#define BRISTLE_NOINLINE
#endif

/// Replaces a register where there is none.
template <typename T>
struct LaneArray {
  T v[4];

  T& operator[](std::size_t i) { return v[i]; }
  const T& operator[](std::size_t i) const { return v[i]; }

  template <typename F>
  static auto each(F&& f) -> LaneArray<decltype(f(0))> {
    return {{f(0), f(1), f(2), f(3)}};
  }
  friend auto operator+(const LaneArray& a, const LaneArray& b) {
    return each([&](int i) { return T(a.v[i] + b.v[i]); });
  }
  friend auto operator-(const LaneArray& a, const LaneArray& b) {
    return each([&](int i) { return T(a.v[i] - b.v[i]); });
  }
  friend auto operator*(const LaneArray& a, const LaneArray& b) {
    return each([&](int i) { return T(a.v[i] * b.v[i]); });
  }
  friend auto operator/(const LaneArray& a, const LaneArray& b) {
    return each([&](int i) { return T(a.v[i] / b.v[i]); });
  }
  friend auto operator-(const LaneArray& a) {
    return each([&](int i) { return T(-a.v[i]); });
  }
  friend auto operator<(const LaneArray& a, const LaneArray& b) {
    return each([&](int i) { return a.v[i] < b.v[i]; });
  }
  friend auto operator<=(const LaneArray& a, const LaneArray& b) {
    return each([&](int i) { return a.v[i] <= b.v[i]; });
  }
  friend auto operator==(const LaneArray& a, const LaneArray& b) {
    return each([&](int i) { return value_of(a.v[i]) == value_of(b.v[i]); });
  }
  friend auto operator&(const LaneArray& a, const LaneArray& b) {
    return each([&](int i) { return bool(a.v[i] & b.v[i]); });
  }
  friend auto operator|(const LaneArray& a, const LaneArray& b) {
    return each([&](int i) { return bool(a.v[i] | b.v[i]); });
  }
  friend auto operator^(const LaneArray& a, const LaneArray& b) {
    return each([&](int i) { return bool(a.v[i] ^ b.v[i]); });
  }
  friend auto operator~(const LaneArray& a) {
    return each([&](int i) { return !a.v[i]; });
  }
};

/// The register of a scalar. Its comparisons give registers of integers, with equal bits in a lane.
template <Scalar S>
struct Register {
  using Type = LaneArray<S>;
};
#if BRISTLE_HAS_SIMD
template <>
struct Register<float> {
  typedef float Type __attribute__((vector_size(simd_bytes)));
};
template <>
struct Register<double> {
  typedef double Type __attribute__((vector_size(simd_bytes)));
};
#endif

/// Comparisons, and operations on their results.
template <Scalar S>
struct Compare {
  using Lanes = typename Register<S>::Type;
  using Truth = decltype(Lanes{} < Lanes{});

  BRISTLE_FORCE_INLINE static Truth less(const Lanes& a, const Lanes& b) { return a < b; }
  BRISTLE_FORCE_INLINE static Truth less_equal(const Lanes& a, const Lanes& b) { return a <= b; }
  BRISTLE_FORCE_INLINE static Truth equal(const Lanes& a, const Lanes& b) { return a == b; }
  BRISTLE_FORCE_INLINE static Lanes select(const Truth& m, const Lanes& yes, const Lanes& no) {
    if constexpr (has_register<S>) {
      return m ? yes : no;
    } else {
      return Lanes::each([&](int i) { return m.v[i] ? yes.v[i] : no.v[i]; });
    }
  }
  BRISTLE_FORCE_INLINE static std::uint32_t bits(const Truth& m) {
#if BRISTLE_HAS_SIMD && defined(__AVX__)
    if constexpr (std::same_as<S, float>)
      return static_cast<std::uint32_t>(_mm256_movemask_ps(std::bit_cast<__m256>(m)));
    if constexpr (std::same_as<S, double>)
      return static_cast<std::uint32_t>(_mm256_movemask_pd(std::bit_cast<__m256d>(m)));
#elif BRISTLE_HAS_SIMD && defined(__SSE2__)
    if constexpr (std::same_as<S, float>)
      return static_cast<std::uint32_t>(_mm_movemask_ps(std::bit_cast<__m128>(m)));
    if constexpr (std::same_as<S, double>)
      return static_cast<std::uint32_t>(_mm_movemask_pd(std::bit_cast<__m128d>(m)));
#endif
    std::uint32_t result = 0;
    for (std::size_t i = 0; i < lanes<S>; ++i) result |= m[i] ? 1u << i : 0u;
    return result;
  }
};

#if BRISTLE_HAS_SIMD && defined(__AVX512F__)
// AVX-512 has mask registers. GCC 12 splits joined comparisons in a `select` lane by lane. So
// intrinsics spell them out.
template <>
struct Compare<float> {
  using Lanes = Register<float>::Type;
  using Truth = std::uint16_t;

  BRISTLE_FORCE_INLINE static Truth less(const Lanes& a, const Lanes& b) {
    return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ);
  }
  BRISTLE_FORCE_INLINE static Truth less_equal(const Lanes& a, const Lanes& b) {
    return _mm512_cmp_ps_mask(a, b, _CMP_LE_OQ);
  }
  BRISTLE_FORCE_INLINE static Truth equal(const Lanes& a, const Lanes& b) {
    return _mm512_cmp_ps_mask(a, b, _CMP_EQ_OQ);
  }
  BRISTLE_FORCE_INLINE static Lanes select(Truth m, const Lanes& yes, const Lanes& no) {
    return Lanes(_mm512_mask_blend_ps(m, no, yes));
  }
  /// The chosen lanes, side by side.
  BRISTLE_FORCE_INLINE static Lanes packed(std::uint32_t chosen, const Lanes& a) {
    return Lanes(_mm512_maskz_compress_ps(static_cast<Truth>(chosen), a));
  }
  BRISTLE_FORCE_INLINE static std::uint32_t bits(Truth m) { return m; }
};
template <>
struct Compare<double> {
  using Lanes = Register<double>::Type;
  using Truth = std::uint8_t;

  BRISTLE_FORCE_INLINE static Truth less(const Lanes& a, const Lanes& b) {
    return _mm512_cmp_pd_mask(a, b, _CMP_LT_OQ);
  }
  BRISTLE_FORCE_INLINE static Truth less_equal(const Lanes& a, const Lanes& b) {
    return _mm512_cmp_pd_mask(a, b, _CMP_LE_OQ);
  }
  BRISTLE_FORCE_INLINE static Truth equal(const Lanes& a, const Lanes& b) {
    return _mm512_cmp_pd_mask(a, b, _CMP_EQ_OQ);
  }
  BRISTLE_FORCE_INLINE static Lanes select(Truth m, const Lanes& yes, const Lanes& no) {
    return Lanes(_mm512_mask_blend_pd(m, no, yes));
  }
  /// The chosen lanes, side by side.
  BRISTLE_FORCE_INLINE static Lanes packed(std::uint32_t chosen, const Lanes& a) {
    return Lanes(_mm512_maskz_compress_pd(static_cast<Truth>(chosen), a));
  }
  BRISTLE_FORCE_INLINE static std::uint32_t bits(Truth m) { return m; }
};
#endif

}  // namespace bristle::inline BRISTLE_ABI::detail
