/// @file
/// Several scalars at once: the only code that uses vector registers.
///
/// `Pack<S>` fills one register of the target machine. It is written in the vector extensions of
/// GCC and Clang. So the same code serves every instruction set. It is never wider than a native
/// register: GCC spills wider types to memory, which costs ten times what they save. With other
/// compilers it is an array of as many lanes in plain C++. The same holds for scalars that are not
/// built in, and with BRISTLE_NO_SIMD.
///
/// The number of lanes depends on how a file is compiled. So do functions over packs, under the
/// same names. **All files of a program that use the library must be compiled for the same
/// instruction set** (-march). They must agree on BRISTLE_NO_SIMD, as with any templates over
/// vector types. Stored data hold arrays of scalars and no Pack. So their layout is the same for
/// all.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/lane_register.hpp>
#include <bristle/math/types.hpp>

#include <bit>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace bristle::inline BRISTLE_ABI::detail {

/// A truth value for each lane.
template <Scalar S>
class Mask;

/// A scalar for each lane. Operators work lane by lane; a scalar operand counts for all lanes.
template <Scalar S>
class Pack;

// Of a Mask: [-] bit i is lane i. True if it holds in any lane, in all, in none.
template <Scalar S>
[[nodiscard]] std::uint32_t bits(const Mask<S>& m);
template <Scalar S>
[[nodiscard]] bool any(const Mask<S>& m);
template <Scalar S>
[[nodiscard]] bool all(const Mask<S>& m);
template <Scalar S>
[[nodiscard]] bool none(const Mask<S>& m);

/// [-] The bits of the first n lanes.
[[nodiscard]] constexpr std::uint32_t first_bits(std::size_t n) {
  return n >= 32 ? ~0u : (1u << n) - 1u;
}

/// `yes` where the mask holds, `no` elsewhere.
template <Scalar S>
[[nodiscard]] Pack<S> select(const Mask<S>& m, const Pack<S>& yes, const Pack<S>& no);

/// Stores the lanes whose bits are set, side by side. Each pack has a row of its own. A whole pack
/// may be written; values behind the chosen lanes have no meaning.
/// @param to      First row.
/// @param stride  [-] From one row to the next.
/// @return [-] Number of chosen lanes.
template <Scalar S, std::size_t n>
std::size_t store_packed(const Pack<S> (&packs)[n], std::uint32_t chosen, S* to,
                         std::size_t stride);

/// Reductions over a pack. Lanes are joined in halves: lane i with lane i + n / 2, and so on. So
/// the rounding of a sum depends only on the width.
template <Scalar S>
[[nodiscard]] S sum_of_lanes(const Pack<S>& a);
template <Scalar S>
[[nodiscard]] S min_of_lanes(const Pack<S>& a);
template <Scalar S>
[[nodiscard]] S max_of_lanes(const Pack<S>& a);

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
class Mask {
 public:
  using Register = typename Compare<S>::Truth;

  Mask() = default;
  BRISTLE_FORCE_INLINE explicit Mask(const Register& r) : r_(r) {}

  /// True in the first n lanes.
  [[nodiscard]] BRISTLE_FORCE_INLINE static Mask first(std::size_t n);
  /// True in lane i if bit i is set: the inverse of `bits`.
  [[nodiscard]] BRISTLE_FORCE_INLINE static Mask from_bits(std::uint32_t set);

  [[nodiscard]] BRISTLE_FORCE_INLINE const Register& get() const { return r_; }

  [[nodiscard]] BRISTLE_FORCE_INLINE friend Mask operator&(const Mask& a, const Mask& b) {
    return Mask(static_cast<Register>(a.r_ & b.r_));
  }
  [[nodiscard]] BRISTLE_FORCE_INLINE friend Mask operator|(const Mask& a, const Mask& b) {
    return Mask(static_cast<Register>(a.r_ | b.r_));
  }
  [[nodiscard]] BRISTLE_FORCE_INLINE friend Mask operator!(const Mask& a) {
    return Mask(static_cast<Register>(~a.r_));
  }
  [[nodiscard]] BRISTLE_FORCE_INLINE friend Mask operator^(const Mask& a, const Mask& b) {
    return Mask(static_cast<Register>(a.r_ ^ b.r_));
  }

 private:
  Register r_;
};

template <Scalar S>
class Pack {
 public:
  using Register = typename Register<S>::Type;
  static constexpr std::size_t size = lanes<S>;

  /// Leaves the lanes uninitialised.
  Pack() = default;
  BRISTLE_FORCE_INLINE explicit Pack(const Register& r) : r_(r) {}
  /// The same value in all lanes.
  BRISTLE_FORCE_INLINE Pack(S value)  // NOLINT: a scalar in a formula of packs is one
      : Pack(make([&](std::size_t) { return value; })) {}

  /// Lane i from p[i]; any alignment.
  [[nodiscard]] BRISTLE_FORCE_INLINE static Pack load(const S* p) {
    Pack a;
    if constexpr (has_register<S>) {
      __builtin_memcpy(&a.r_, p, sizeof a.r_);
    } else {
      for (std::size_t i = 0; i < size; ++i) a.r_[i] = p[i];
    }
    return a;
  }
  /// Lane i from p[at[i]].
  template <std::integral Index>
  [[nodiscard]] BRISTLE_FORCE_INLINE static Pack gather(const S* p, const Index* at) {
    return make([&](std::size_t i) { return p[at[i]]; });
  }
  /// Lane i from the integer p[i], which is below 2^31.
  [[nodiscard]] BRISTLE_FORCE_INLINE static Pack load_integers(const std::uint32_t* p) {
#if BRISTLE_HAS_SIMD
    if constexpr (has_register<S>) {
      // Registers convert signed integers only.
      typedef std::int32_t Integers __attribute__((vector_size(size * sizeof(std::int32_t))));
      Integers integers;
      __builtin_memcpy(&integers, p, sizeof integers);
      return Pack(__builtin_convertvector(integers, Register));
    }
#endif
    return make([&](std::size_t i) { return S(p[i]); });
  }
  /// 0, 1, 2, ...
  [[nodiscard]] BRISTLE_FORCE_INLINE static Pack numbers() {
    return make([](std::size_t i) { return S(i); });
  }

  BRISTLE_FORCE_INLINE void store(S* p) const {
    if constexpr (has_register<S>) {
      __builtin_memcpy(p, &r_, sizeof r_);
    } else {
      for (std::size_t i = 0; i < size; ++i) p[i] = r_[i];
    }
  }
  /// Lane i to p[at[i]], in the order of the lanes.
  template <std::integral Index>
  BRISTLE_FORCE_INLINE void scatter(S* p, const Index* at) const {
    scatter(p, at, std::make_index_sequence<size>());
  }

  [[nodiscard]] BRISTLE_FORCE_INLINE S operator[](std::size_t i) const { return r_[i]; }
  [[nodiscard]] BRISTLE_FORCE_INLINE const Register& get() const { return r_; }

  [[nodiscard]] BRISTLE_FORCE_INLINE friend Pack operator+(const Pack& a, const Pack& b) {
    return Pack(a.r_ + b.r_);
  }
  [[nodiscard]] BRISTLE_FORCE_INLINE friend Pack operator-(const Pack& a, const Pack& b) {
    return Pack(a.r_ - b.r_);
  }
  [[nodiscard]] BRISTLE_FORCE_INLINE friend Pack operator*(const Pack& a, const Pack& b) {
    return Pack(a.r_ * b.r_);
  }
  [[nodiscard]] BRISTLE_FORCE_INLINE friend Pack operator/(const Pack& a, const Pack& b) {
    return Pack(a.r_ / b.r_);
  }
  [[nodiscard]] BRISTLE_FORCE_INLINE friend Pack operator-(const Pack& a) { return Pack(-a.r_); }
  BRISTLE_FORCE_INLINE Pack& operator+=(const Pack& b) { return *this = *this + b; }
  BRISTLE_FORCE_INLINE Pack& operator-=(const Pack& b) { return *this = *this - b; }
  BRISTLE_FORCE_INLINE Pack& operator*=(const Pack& b) { return *this = *this * b; }
  BRISTLE_FORCE_INLINE Pack& operator/=(const Pack& b) { return *this = *this / b; }

  // False in lanes with a NaN, as for scalars; != is true there.
  [[nodiscard]] BRISTLE_FORCE_INLINE friend Mask<S> operator<(const Pack& a, const Pack& b) {
    return Mask<S>(Compare<S>::less(a.r_, b.r_));
  }
  [[nodiscard]] BRISTLE_FORCE_INLINE friend Mask<S> operator<=(const Pack& a, const Pack& b) {
    return Mask<S>(Compare<S>::less_equal(a.r_, b.r_));
  }
  [[nodiscard]] BRISTLE_FORCE_INLINE friend Mask<S> operator>(const Pack& a, const Pack& b) {
    return b < a;
  }
  [[nodiscard]] BRISTLE_FORCE_INLINE friend Mask<S> operator>=(const Pack& a, const Pack& b) {
    return b <= a;
  }
  [[nodiscard]] BRISTLE_FORCE_INLINE friend Mask<S> operator==(const Pack& a, const Pack& b) {
    return Mask<S>(Compare<S>::equal(a.r_, b.r_));
  }
  [[nodiscard]] BRISTLE_FORCE_INLINE friend Mask<S> operator!=(const Pack& a, const Pack& b) {
    return !(a == b);
  }

  /// Returns the second if one of the two is NaN, like `a < b ? a : b`.
  [[nodiscard]] BRISTLE_FORCE_INLINE friend Pack min(const Pack& a, const Pack& b) {
    if constexpr (has_register<S>) return Pack(a.r_ < b.r_ ? a.r_ : b.r_);
    return select(a < b, a, b);
  }
  /// Returns the second if one of the two is NaN, like `a > b ? a : b`.
  [[nodiscard]] BRISTLE_FORCE_INLINE friend Pack max(const Pack& a, const Pack& b) {
    if constexpr (has_register<S>) return Pack(b.r_ < a.r_ ? a.r_ : b.r_);
    return select(b < a, a, b);
  }
  [[nodiscard]] BRISTLE_FORCE_INLINE friend Pack abs(const Pack& a) {
    if constexpr (has_register<S>) {
      // All bits but the sign.
      using Bits = decltype(a.r_ < a.r_);
      const Bits sign = std::bit_cast<Bits>(Pack(S(-0.0)).r_);
      return Pack(std::bit_cast<Register>(std::bit_cast<Bits>(a.r_) & ~sign));
    } else {
      using std::abs;
      return Pack(Register::each([&](int i) { return S(abs(a.r_.v[i])); }));
    }
  }
  /// Rounded correctly.
  [[nodiscard]] BRISTLE_FORCE_INLINE friend Pack sqrt(const Pack& a) {
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
    return make([&](std::size_t i) { return sqrt(a.r_[i]); });
  }

 private:
  // Sets all lanes at once. Set one by one, they would be blended in one by one.
  template <typename F, std::size_t... i>
  BRISTLE_FORCE_INLINE static Pack make(const F& f, std::index_sequence<i...>) {
    return Pack(Register{f(i)...});
  }
  template <typename F>
  BRISTLE_FORCE_INLINE static Pack make(const F& f) {
    return make(f, std::make_index_sequence<size>());
  }
  template <typename Index, std::size_t... i>
  BRISTLE_FORCE_INLINE void scatter(S* p, const Index* at, std::index_sequence<i...>) const {
    ((p[at[i]] = r_[i]), ...);
  }

  Register r_;
};

template <Scalar S>
BRISTLE_FORCE_INLINE Mask<S> Mask<S>::first(std::size_t n) {
  return Pack<S>::numbers() < Pack<S>(S(n));
}

template <Scalar S>
BRISTLE_FORCE_INLINE Mask<S> Mask<S>::from_bits(std::uint32_t set) {
  if constexpr (std::unsigned_integral<Register>) {
    return Mask(static_cast<Register>(set));
  } else if constexpr (has_register<S>) {
    using Integer = std::remove_cvref_t<decltype(Register{}[0])>;
    Register own{};
    for (std::size_t i = 0; i < lanes<S>; ++i) own[i] = Integer(1) << i;
    return Mask(((Register{} + Integer(set)) & own) == own);
  } else {
    return Mask(Register::each([&](int i) { return (set >> i & 1u) != 0; }));
  }
}

template <Scalar S>
BRISTLE_FORCE_INLINE std::uint32_t bits(const Mask<S>& m) {
  return Compare<S>::bits(m.get());
}
template <Scalar S>
BRISTLE_FORCE_INLINE bool any(const Mask<S>& m) {
  return bits(m) != 0;
}
template <Scalar S>
BRISTLE_FORCE_INLINE bool all(const Mask<S>& m) {
  return bits(m) == (1u << lanes<S>)-1u;
}
template <Scalar S>
BRISTLE_FORCE_INLINE bool none(const Mask<S>& m) {
  return bits(m) == 0;
}

template <Scalar S>
BRISTLE_FORCE_INLINE Pack<S> select(const Mask<S>& m, const Pack<S>& yes, const Pack<S>& no) {
  return Pack<S>(Compare<S>::select(m.get(), yes.get(), no.get()));
}

template <Scalar S, std::size_t n>
BRISTLE_FORCE_INLINE std::size_t store_packed(const Pack<S> (&packs)[n], std::uint32_t chosen,
                                              S* to, std::size_t stride) {
#if BRISTLE_HAS_SIMD && defined(__AVX512F__)
  if constexpr (has_register<S>) {
    for (std::size_t k = 0; k < n; ++k) {
      Pack<S>(Compare<S>::packed(chosen, packs[k].get())).store(to + k * stride);
    }
    return static_cast<std::size_t>(std::popcount(chosen));
  }
#endif
  std::size_t count = 0;
  for (; chosen != 0; chosen &= chosen - 1, ++count) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(chosen));
    for (std::size_t k = 0; k < n; ++k) to[k * stride + count] = packs[k][lane];
  }
  return count;
}

/// Lane i is lane i + by of `a`, around the end.
template <std::size_t by, Scalar S, std::size_t... i>
BRISTLE_FORCE_INLINE Pack<S> rotated(const Pack<S>& a, std::index_sequence<i...>) {
#if BRISTLE_HAS_SHUFFLE
  if constexpr (has_register<S>) {
    return Pack<S>(__builtin_shufflevector(a.get(), a.get(), ((i + by) % lanes<S>)...));
  }
#endif
  const S values[] = {a[(i + by) % lanes<S>]...};
  return Pack<S>::load(values);
}

/// Joins the lanes of a pack in pairs, halving their number each time.
template <std::size_t half, Scalar S, typename Join>
BRISTLE_FORCE_INLINE S join_lanes(const Pack<S>& a, const Join& join) {
  const Pack<S> joined = join(a, rotated<half>(a, std::make_index_sequence<lanes<S>>()));
  if constexpr (half > 1) {
    return join_lanes<half / 2>(joined, join);
  } else {
    return joined[0];
  }
}

template <Scalar S>
BRISTLE_FORCE_INLINE S sum_of_lanes(const Pack<S>& a) {
  return join_lanes<lanes<S> / 2>(a, [](const Pack<S>& x, const Pack<S>& y) { return x + y; });
}
template <Scalar S>
BRISTLE_FORCE_INLINE S min_of_lanes(const Pack<S>& a) {
  return join_lanes<lanes<S> / 2>(a, [](const Pack<S>& x, const Pack<S>& y) { return min(x, y); });
}
template <Scalar S>
BRISTLE_FORCE_INLINE S max_of_lanes(const Pack<S>& a) {
  return join_lanes<lanes<S> / 2>(a, [](const Pack<S>& x, const Pack<S>& y) { return max(x, y); });
}

}  // namespace bristle::inline BRISTLE_ABI::detail
