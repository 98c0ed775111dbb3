/// @file
/// Several scalars at once: the one place that knows vector registers.
///
/// `Pack<S>` fills one register of the machine the program is compiled for and is written in the
/// vector extensions of GCC and Clang, so that the same code serves every instruction set. Its
/// width is that of a native register and never more: GCC spills wider types to memory, which costs
/// ten times what they save. Elsewhere, for scalars that are not built in, and with BRISTLE_NO_SIMD
/// it is an array of as many lanes in plain C++.
///
/// How many lanes there are depends on how a file is compiled. Nothing that is stored or handed to
/// other files may hold a Pack; arrays of scalars do, and are loaded from.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>
#include <bristle/math/types.hpp>

#include <bit>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <utility>

#if defined(__GNUC__) && !defined(BRISTLE_NO_SIMD)
#define BRISTLE_HAS_SIMD 1
#if defined(__SSE2__)
#include <immintrin.h>
#endif
#else
#define BRISTLE_HAS_SIMD 0
#endif

namespace bristle {

/// [bytes] Of a register.
#if BRISTLE_HAS_SIMD && defined(__AVX512F__)
inline constexpr std::size_t simd_bytes = 64;
#elif BRISTLE_HAS_SIMD && defined(__AVX__)
inline constexpr std::size_t simd_bytes = 32;
#else
inline constexpr std::size_t simd_bytes = 16;
#endif

namespace detail {

/// Whether S comes in registers.
template <Scalar S>
inline constexpr bool has_register = BRISTLE_HAS_SIMD != 0 &&
                                     (std::same_as<S, float> || std::same_as<S, double>);

}  // namespace detail

/// [-] Lanes of a Pack<S>, at most 16.
template <Scalar S>
inline constexpr std::size_t lanes = detail::has_register<S> ? simd_bytes / sizeof(S) : 4;

/// A truth value for each lane.
template <Scalar S>
class Mask;

/// A scalar for each lane. Operators work lane by lane; a scalar stands for itself in all lanes.
template <Scalar S>
class Pack;

// Of a Mask: [-] bit i is lane i; whether it holds in one lane, in all, in none.
template <Scalar S>
[[nodiscard]] std::uint32_t bits(const Mask<S>& m);
template <Scalar S>
[[nodiscard]] bool any(const Mask<S>& m);
template <Scalar S>
[[nodiscard]] bool all(const Mask<S>& m);
template <Scalar S>
[[nodiscard]] bool none(const Mask<S>& m);

/// `yes` where the mask holds, `no` elsewhere.
template <Scalar S>
[[nodiscard]] Pack<S> select(const Mask<S>& m, const Pack<S>& yes, const Pack<S>& no);

/// Of the whole pack, lane by lane in halves: lane i with lane i + n / 2, and so on, so that the
/// rounding of a sum depends on the width and on nothing else.
template <Scalar S>
[[nodiscard]] S sum_of_lanes(const Pack<S>& a);
template <Scalar S>
[[nodiscard]] S min_of_lanes(const Pack<S>& a);
template <Scalar S>
[[nodiscard]] S max_of_lanes(const Pack<S>& a);

// Implementation -----------------------------------------------------------------------------------

// Every function here is a few instructions and is inlined even without optimisation: a register
// passed through memory costs more than what is done with it.
#if defined(__GNUC__)
#define BRISTLE_LANES [[gnu::always_inline]] inline
#else
#define BRISTLE_LANES inline
#endif
// And what a loop over packs needs rarely is not, lest its values take the registers of the rest.
#if defined(__GNUC__)
#define BRISTLE_OUTLINED [[gnu::noinline]]
#else
#define BRISTLE_OUTLINED
#endif

namespace detail {

/// What stands for a register where there is none.
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
    return each([&](int i) { return a.v[i] == b.v[i]; });
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

/// The register of a scalar. Its comparisons give registers of integers, all bits of a lane equal.
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

}  // namespace detail

template <Scalar S>
class Mask {
 public:
  using Register = decltype(typename detail::Register<S>::Type{} <
                            typename detail::Register<S>::Type{});

  Mask() = default;
  BRISTLE_LANES explicit Mask(const Register& r) : r_(r) {}

  /// Holds in the first n lanes.
  [[nodiscard]] BRISTLE_LANES static Mask first(std::size_t n);
  /// Holds in lane i where bit i is set: the inverse of `bits`.
  [[nodiscard]] BRISTLE_LANES static Mask from_bits(std::uint32_t set);

  [[nodiscard]] BRISTLE_LANES const Register& get() const { return r_; }

  [[nodiscard]] BRISTLE_LANES friend Mask operator&(const Mask& a, const Mask& b) {
    return Mask(a.r_ & b.r_);
  }
  [[nodiscard]] BRISTLE_LANES friend Mask operator|(const Mask& a, const Mask& b) {
    return Mask(a.r_ | b.r_);
  }
  [[nodiscard]] BRISTLE_LANES friend Mask operator^(const Mask& a, const Mask& b) {
    return Mask(a.r_ ^ b.r_);
  }
  [[nodiscard]] BRISTLE_LANES friend Mask operator!(const Mask& a) { return Mask(~a.r_); }

 private:
  Register r_;
};

template <Scalar S>
class Pack {
 public:
  using Register = typename detail::Register<S>::Type;
  static constexpr std::size_t size = lanes<S>;

  /// Not set to anything.
  Pack() = default;
  BRISTLE_LANES explicit Pack(const Register& r) : r_(r) {}
  /// The same in all lanes.
  BRISTLE_LANES Pack(S value) {  // NOLINT: a scalar in a formula of packs is one
    if constexpr (detail::has_register<S>) {
      r_ = value - Register{};  // One instruction; a loop over lanes often stays one.
    } else {
      for (std::size_t i = 0; i < size; ++i) r_[i] = value;
    }
  }

  /// Lane i from p[i]; any alignment.
  [[nodiscard]] BRISTLE_LANES static Pack load(const S* p) {
    Pack a;
    if constexpr (detail::has_register<S>) {
      __builtin_memcpy(&a.r_, p, sizeof a.r_);
    } else {
      for (std::size_t i = 0; i < size; ++i) a.r_[i] = p[i];
    }
    return a;
  }
  /// The first n lanes from p; the others are `rest`, and nothing of p behind n is read.
  [[nodiscard]] BRISTLE_LANES static Pack load_first(const S* p, std::size_t n, S rest) {
    Pack a(rest);
    for (std::size_t i = 0; i < n && i < size; ++i) a.r_[i] = p[i];
    return a;
  }
  /// Lane i from p[at[i]].
  template <std::integral Index>
  [[nodiscard]] BRISTLE_LANES static Pack gather(const S* p, const Index* at) {
    Pack a;
    for (std::size_t i = 0; i < size; ++i) a.r_[i] = p[at[i]];
    return a;
  }
  /// 0, 1, 2, ...
  [[nodiscard]] BRISTLE_LANES static Pack numbers() {
    Pack a;
    for (std::size_t i = 0; i < size; ++i) a.r_[i] = S(i);
    return a;
  }

  BRISTLE_LANES void store(S* p) const {
    if constexpr (detail::has_register<S>) {
      __builtin_memcpy(p, &r_, sizeof r_);
    } else {
      for (std::size_t i = 0; i < size; ++i) p[i] = r_[i];
    }
  }
  /// The first n lanes; nothing behind them is written.
  BRISTLE_LANES void store_first(S* p, std::size_t n) const {
    for (std::size_t i = 0; i < n && i < size; ++i) p[i] = r_[i];
  }

  [[nodiscard]] BRISTLE_LANES S operator[](std::size_t i) const { return r_[i]; }
  [[nodiscard]] BRISTLE_LANES const Register& get() const { return r_; }

  [[nodiscard]] BRISTLE_LANES friend Pack operator+(const Pack& a, const Pack& b) {
    return Pack(a.r_ + b.r_);
  }
  [[nodiscard]] BRISTLE_LANES friend Pack operator-(const Pack& a, const Pack& b) {
    return Pack(a.r_ - b.r_);
  }
  [[nodiscard]] BRISTLE_LANES friend Pack operator*(const Pack& a, const Pack& b) {
    return Pack(a.r_ * b.r_);
  }
  [[nodiscard]] BRISTLE_LANES friend Pack operator/(const Pack& a, const Pack& b) {
    return Pack(a.r_ / b.r_);
  }
  [[nodiscard]] BRISTLE_LANES friend Pack operator-(const Pack& a) { return Pack(-a.r_); }
  BRISTLE_LANES Pack& operator+=(const Pack& b) { return *this = *this + b; }
  BRISTLE_LANES Pack& operator-=(const Pack& b) { return *this = *this - b; }
  BRISTLE_LANES Pack& operator*=(const Pack& b) { return *this = *this * b; }
  BRISTLE_LANES Pack& operator/=(const Pack& b) { return *this = *this / b; }

  // False in lanes with a NaN, as between scalars; != is true there.
  [[nodiscard]] BRISTLE_LANES friend Mask<S> operator<(const Pack& a, const Pack& b) {
    return Mask<S>(a.r_ < b.r_);
  }
  [[nodiscard]] BRISTLE_LANES friend Mask<S> operator<=(const Pack& a, const Pack& b) {
    return Mask<S>(a.r_ <= b.r_);
  }
  [[nodiscard]] BRISTLE_LANES friend Mask<S> operator>(const Pack& a, const Pack& b) {
    return b < a;
  }
  [[nodiscard]] BRISTLE_LANES friend Mask<S> operator>=(const Pack& a, const Pack& b) {
    return b <= a;
  }
  [[nodiscard]] BRISTLE_LANES friend Mask<S> operator==(const Pack& a, const Pack& b) {
    return Mask<S>(a.r_ == b.r_);
  }
  [[nodiscard]] BRISTLE_LANES friend Mask<S> operator!=(const Pack& a, const Pack& b) {
    return !(a == b);
  }

  /// The second where one of the two is NaN, as `a < b ? a : b` has it.
  [[nodiscard]] BRISTLE_LANES friend Pack min(const Pack& a, const Pack& b) {
    return select(a < b, a, b);
  }
  /// The second where one of the two is NaN, as `a > b ? a : b` has it.
  [[nodiscard]] BRISTLE_LANES friend Pack max(const Pack& a, const Pack& b) {
    return select(b < a, a, b);
  }
  [[nodiscard]] BRISTLE_LANES friend Pack abs(const Pack& a) {
    if constexpr (detail::has_register<S>) {
      // Everything but the sign.
      using Bits = typename Mask<S>::Register;
      const Bits sign = std::bit_cast<Bits>(Pack(S(-0.0)).r_);
      return Pack(std::bit_cast<Register>(std::bit_cast<Bits>(a.r_) & ~sign));
    } else {
      using std::abs;
      return Pack(Register::each([&](int i) { return S(abs(a.r_.v[i])); }));
    }
  }
  /// Rounded correctly.
  [[nodiscard]] BRISTLE_LANES friend Pack sqrt(const Pack& a) {
#if BRISTLE_HAS_SIMD && defined(__AVX512F__)
    if constexpr (std::same_as<S, float>) return Pack(Register(_mm512_maskz_sqrt_ps(0xffff, a.r_)));
    if constexpr (std::same_as<S, double>) return Pack(Register(_mm512_maskz_sqrt_pd(0xff, a.r_)));
#elif BRISTLE_HAS_SIMD && defined(__AVX__)
    if constexpr (std::same_as<S, float>) return Pack(Register(_mm256_sqrt_ps(a.r_)));
    if constexpr (std::same_as<S, double>) return Pack(Register(_mm256_sqrt_pd(a.r_)));
#elif BRISTLE_HAS_SIMD && defined(__SSE2__)
    if constexpr (std::same_as<S, float>) return Pack(Register(_mm_sqrt_ps(a.r_)));
    if constexpr (std::same_as<S, double>) return Pack(Register(_mm_sqrt_pd(a.r_)));
#endif
    using std::sqrt;
    Pack root;
    for (std::size_t i = 0; i < size; ++i) root.r_[i] = sqrt(a.r_[i]);
    return root;
  }

 private:
  Register r_;
};

template <Scalar S>
BRISTLE_LANES Mask<S> Mask<S>::first(std::size_t n) {
  return Pack<S>::numbers() < Pack<S>(S(n));
}

template <Scalar S>
BRISTLE_LANES Mask<S> Mask<S>::from_bits(std::uint32_t set) {
#if BRISTLE_HAS_SIMD && defined(__AVX512F__)
  if constexpr (std::same_as<S, float>) {
    return Mask(std::bit_cast<Register>(_mm512_maskz_set1_epi32(static_cast<__mmask16>(set), -1)));
  }
  if constexpr (std::same_as<S, double>) {
    return Mask(std::bit_cast<Register>(_mm512_maskz_set1_epi64(static_cast<__mmask8>(set), -1)));
  }
#endif
  if constexpr (detail::has_register<S>) {
    using Integer = std::remove_cvref_t<decltype(Register{}[0])>;
    Register own{};
    for (std::size_t i = 0; i < lanes<S>; ++i) own[i] = Integer(1) << i;
    return Mask(((Register{} + Integer(set)) & own) == own);
  } else {
    return Mask(Register::each([&](int i) { return (set >> i & 1u) != 0; }));
  }
}

template <Scalar S>
BRISTLE_LANES std::uint32_t bits(const Mask<S>& m) {
#if BRISTLE_HAS_SIMD && defined(__AVX512F__)
  if constexpr (std::same_as<S, float>) {
    const auto r = std::bit_cast<__m512i>(m.get());
    return _mm512_test_epi32_mask(r, r);
  }
  if constexpr (std::same_as<S, double>) {
    const auto r = std::bit_cast<__m512i>(m.get());
    return _mm512_test_epi64_mask(r, r);
  }
#elif BRISTLE_HAS_SIMD && defined(__AVX__)
  if constexpr (std::same_as<S, float>) {
    return static_cast<std::uint32_t>(_mm256_movemask_ps(std::bit_cast<__m256>(m.get())));
  }
  if constexpr (std::same_as<S, double>) {
    return static_cast<std::uint32_t>(_mm256_movemask_pd(std::bit_cast<__m256d>(m.get())));
  }
#elif BRISTLE_HAS_SIMD && defined(__SSE2__)
  if constexpr (std::same_as<S, float>) {
    return static_cast<std::uint32_t>(_mm_movemask_ps(std::bit_cast<__m128>(m.get())));
  }
  if constexpr (std::same_as<S, double>) {
    return static_cast<std::uint32_t>(_mm_movemask_pd(std::bit_cast<__m128d>(m.get())));
  }
#endif
  std::uint32_t result = 0;
  for (std::size_t i = 0; i < lanes<S>; ++i) result |= m.get()[i] ? 1u << i : 0u;
  return result;
}

template <Scalar S>
BRISTLE_LANES bool any(const Mask<S>& m) {
  return bits(m) != 0;
}
template <Scalar S>
BRISTLE_LANES bool all(const Mask<S>& m) {
  return bits(m) == (1u << lanes<S>)-1u;
}
template <Scalar S>
BRISTLE_LANES bool none(const Mask<S>& m) {
  return bits(m) == 0;
}

template <Scalar S>
BRISTLE_LANES Pack<S> select(const Mask<S>& m, const Pack<S>& yes, const Pack<S>& no) {
  if constexpr (detail::has_register<S>) {
    return Pack<S>(m.get() ? yes.get() : no.get());
  } else {
    return Pack<S>(detail::LaneArray<S>::each(
        [&](int i) { return m.get().v[i] ? yes.get().v[i] : no.get().v[i]; }));
  }
}

namespace detail {

/// Lane i from lane i + by, around the end.
template <std::size_t by, Scalar S, std::size_t... i>
BRISTLE_LANES Pack<S> rotated(const Pack<S>& a, std::index_sequence<i...>) {
#if BRISTLE_HAS_SIMD
#if __has_builtin(__builtin_shufflevector)
  if constexpr (has_register<S>) {
    return Pack<S>(__builtin_shufflevector(a.get(), a.get(), ((i + by) % lanes<S>)...));
  }
#endif
#endif
  const S values[] = {a[(i + by) % lanes<S>]...};
  return Pack<S>::load(values);
}

/// Joins the lanes of a pack two by two, halving their number each time.
template <std::size_t half, Scalar S, typename Join>
BRISTLE_LANES S join_lanes(const Pack<S>& a, const Join& join) {
  const Pack<S> joined = join(a, rotated<half>(a, std::make_index_sequence<lanes<S>>()));
  if constexpr (half > 1) {
    return join_lanes<half / 2>(joined, join);
  } else {
    return joined[0];
  }
}

}  // namespace detail

template <Scalar S>
BRISTLE_LANES S sum_of_lanes(const Pack<S>& a) {
  return detail::join_lanes<lanes<S> / 2>(a,
                                          [](const Pack<S>& x, const Pack<S>& y) { return x + y; });
}
template <Scalar S>
BRISTLE_LANES S min_of_lanes(const Pack<S>& a) {
  return detail::join_lanes<lanes<S> / 2>(
      a, [](const Pack<S>& x, const Pack<S>& y) { return min(x, y); });
}
template <Scalar S>
BRISTLE_LANES S max_of_lanes(const Pack<S>& a) {
  return detail::join_lanes<lanes<S> / 2>(
      a, [](const Pack<S>& x, const Pack<S>& y) { return max(x, y); });
}

}  // namespace bristle
