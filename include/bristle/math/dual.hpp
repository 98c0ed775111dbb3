/// @file
/// Numbers that carry their derivatives: results computed in them are differentiated on the way
/// (forward mode; Griewank and Walther 2008, "Evaluating Derivatives", chapter 3).
///
/// `Dual<double, n>` is a `Scalar`. Every template over a scalar, the world included, then computes
/// derivatives. They are by the n numbers that were marked as variables. The page docs/gradients.md
/// tells which questions this answers. It tells what derivatives mean where surfaces meet, part and
/// slip.
///
/// Rules that hold for all of it:
///
/// - **Values are those of S**: operations on them are the same. Only sums that run in registers
///   for S (of Eigen's products, over lanes) may add in another order.
/// - **<, <=, > and >= compare values**, so a program takes the same branches as without
///   derivatives. **== and != compare derivatives too**: code that skips work because a number is
///   exactly zero must not skip its derivatives. Where the number alone decides, code uses
///   `value_of`.
/// - **Derivatives are finite**, as long as they do not overflow. They count as 0 where a function
///   has none. Its slope may be infinite, or its value no number. Examples are sqrt and hypot at 0
///   (so the length of a vector of no length stands still), abs at 0, and a quotient by 0. Of max,
///   min and clamp they are those of the argument that is returned.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/bit_hash.hpp>
#include <bristle/math/types.hpp>

#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <type_traits>

namespace bristle::inline BRISTLE_ABI {

/// A value and its derivatives by n variables. It is a plain value of n + 1 numbers.
template <std::floating_point S, std::size_t n>
class Dual {
 public:
  /// Derivatives by the n variables, in their order.
  using Partials = std::array<S, n>;

  /// Leaves the number uninitialised, like an S.
  Dual() = default;
  /// A constant.
  template <typename T>
  requires std::is_arithmetic_v<T>
  constexpr Dual(T value)  // NOLINT: a number in a formula of duals is a constant
      : value_(static_cast<S>(value)), partials_{} {}
  /// A number with all its derivatives.
  constexpr Dual(S value, const Partials& partials) : value_(value), partials_(partials) {}

  /// Variable number i < n with a value: its derivative by itself is 1.
  [[nodiscard]] static constexpr Dual variable(S value, std::size_t i = 0) {
    Dual x(value);
    x.partials_[i] = S(1);
    return x;
  }

  /// The number without derivatives.
  [[nodiscard]] constexpr S value() const { return value_; }
  /// Derivative by variable i.
  [[nodiscard]] constexpr S partial(std::size_t i = 0) const { return partials_[i]; }
  /// All n derivatives.
  [[nodiscard]] constexpr const Partials& partials() const { return partials_; }

  /// The value, without derivatives.
  template <typename T>
  requires std::is_arithmetic_v<T>
  [[nodiscard]] constexpr explicit operator T() const { return static_cast<T>(value_); }

  /// Returns f(*this), given the value of f and its slope there.
  [[nodiscard]] constexpr Dual mapped(S value, S slope) const {
    Dual y(value);
    if (!is_number(value) || !is_number(slope)) return y;
    for (std::size_t i = 0; i < n; ++i) y.partials_[i] = slope * partials_[i];
    return y;
  }

  [[nodiscard]] friend constexpr Dual operator+(const Dual& a, const Dual& b) {
    Dual sum(a.value_ + b.value_);
    for (std::size_t i = 0; i < n; ++i) sum.partials_[i] = a.partials_[i] + b.partials_[i];
    return sum;
  }
  [[nodiscard]] friend constexpr Dual operator-(const Dual& a, const Dual& b) {
    Dual difference(a.value_ - b.value_);
    for (std::size_t i = 0; i < n; ++i) difference.partials_[i] = a.partials_[i] - b.partials_[i];
    return difference;
  }
  [[nodiscard]] friend constexpr Dual operator*(const Dual& a, const Dual& b) {
    // If the product is a number, so are both slopes.
    const S product = a.value_ * b.value_;
    return joined(product, product, a, b.value_, b, a.value_);
  }
  [[nodiscard]] friend constexpr Dual operator/(const Dual& a, const Dual& b) {
    const S ratio = a.value_ / b.value_;
    const S inverse = S(1) / b.value_;
    return joined(ratio, ratio * inverse, a, inverse, b, -ratio * inverse);
  }
  [[nodiscard]] friend constexpr Dual operator+(const Dual& a) { return a; }
  [[nodiscard]] friend constexpr Dual operator-(const Dual& a) {
    Dual negative(-a.value_);
    for (std::size_t i = 0; i < n; ++i) negative.partials_[i] = -a.partials_[i];
    return negative;
  }
  /// Replaces the number by the result of the operator on it and b.
  /// @{
  constexpr Dual& operator+=(const Dual& b) { return *this = *this + b; }
  constexpr Dual& operator-=(const Dual& b) { return *this = *this - b; }
  constexpr Dual& operator*=(const Dual& b) { return *this = *this * b; }
  constexpr Dual& operator/=(const Dual& b) { return *this = *this / b; }
  /// @}

  [[nodiscard]] friend constexpr bool operator==(const Dual& a, const Dual& b) = default;
  [[nodiscard]] friend constexpr bool operator<(const Dual& a, const Dual& b) {
    return a.value_ < b.value_;
  }
  [[nodiscard]] friend constexpr bool operator<=(const Dual& a, const Dual& b) {
    return a.value_ <= b.value_;
  }
  [[nodiscard]] friend constexpr bool operator>(const Dual& a, const Dual& b) {
    return a.value_ > b.value_;
  }
  [[nodiscard]] friend constexpr bool operator>=(const Dual& a, const Dual& b) {
    return a.value_ >= b.value_;
  }

  // Functions as in <cmath>, found by the argument's type.
  [[nodiscard]] friend Dual sqrt(const Dual& a) {
    const S root = std::sqrt(a.value_);
    return a.mapped(root, S(0.5) / root);
  }
  [[nodiscard]] friend Dual hypot(const Dual& a, const Dual& b) {
    const S length = std::hypot(a.value_, b.value_);
    return joined(length, S(1) / length, a, a.value_ / length, b, b.value_ / length);
  }
  [[nodiscard]] friend Dual abs(const Dual& a) {
    return a.mapped(std::abs(a.value_), sign_of(a.value_));
  }
  [[nodiscard]] friend Dual copysign(const Dual& a, const Dual& b) {
    const S value = std::copysign(a.value_, b.value_);
    return a.mapped(value, sign_of(a.value_) * sign_of(value));
  }
  [[nodiscard]] friend Dual sin(const Dual& a) {
    return a.mapped(std::sin(a.value_), std::cos(a.value_));
  }
  [[nodiscard]] friend Dual cos(const Dual& a) {
    return a.mapped(std::cos(a.value_), -std::sin(a.value_));
  }
  [[nodiscard]] friend Dual acos(const Dual& a) {
    return a.mapped(std::acos(a.value_), S(-1) / std::sqrt(S(1) - a.value_ * a.value_));
  }
  [[nodiscard]] friend Dual atan2(const Dual& y, const Dual& x) {
    const S length2 = y.value_ * y.value_ + x.value_ * x.value_;
    return joined(std::atan2(y.value_, x.value_), S(1) / length2, y, x.value_ / length2, x,
                  -y.value_ / length2);
  }
  [[nodiscard]] friend Dual exp(const Dual& a) {
    const S value = std::exp(a.value_);
    return a.mapped(value, value);
  }
  [[nodiscard]] friend Dual expm1(const Dual& a) {
    return a.mapped(std::expm1(a.value_), std::exp(a.value_));
  }
  [[nodiscard]] friend Dual log(const Dual& a) {
    return a.mapped(std::log(a.value_), S(1) / a.value_);
  }
  [[nodiscard]] friend Dual pow(const Dual& a, const Dual& exponent) {
    const S b = exponent.value_;
    const S value = std::pow(a.value_, b);
    // A constant exponent needs no logarithm; the base may then be negative.
    const S by_exponent = exponent.partials_ == Partials{} ? S(0) : value * std::log(a.value_);
    const S by_base = b * std::pow(a.value_, b - S(1));
    return joined(value, by_base + by_exponent, a, by_base, exponent, by_exponent);
  }
  /// a - q b with the whole number q = trunc(a / b). Small changes leave q as it is.
  [[nodiscard]] friend Dual fmod(const Dual& a, const Dual& b) {
    const S rest = std::fmod(a.value_, b.value_);
    const S whole = std::round((a.value_ - rest) / b.value_);
    return joined(rest, whole, a, S(1), b, -whole);
  }
  [[nodiscard]] friend Dual floor(const Dual& a) { return Dual(std::floor(a.value_)); }
  [[nodiscard]] friend Dual ceil(const Dual& a) { return Dual(std::ceil(a.value_)); }

  /// Tests of the value alone.
  [[nodiscard]] friend bool isfinite(const Dual& a) { return std::isfinite(a.value_); }
  [[nodiscard]] friend bool isnan(const Dual& a) { return std::isnan(a.value_); }
  [[nodiscard]] friend bool isinf(const Dual& a) { return std::isinf(a.value_); }

 private:
  /// Returns f(a, b), given its value and its two slopes.
  /// @param judge  Is a number only if the value and both slopes are.
  [[nodiscard]] static constexpr Dual joined(S value, S judge, const Dual& a, S by_a, const Dual& b,
                                             S by_b) {
    Dual y(value);
    if (!is_number(judge)) return y;
    for (std::size_t i = 0; i < n; ++i) {
      y.partials_[i] = by_a * a.partials_[i] + by_b * b.partials_[i];
    }
    return y;
  }

  [[nodiscard]] static constexpr bool is_number(S x) { return x - x == S(0); }
  [[nodiscard]] static constexpr S sign_of(S x) {
    return x > S(0) ? S(1) : x < S(0) ? S(-1) : S(0);
  }

  S value_;
  Partials partials_;
};

/// In single precision derivatives would lose all digits where solvers divide by 1e-6.
template <std::size_t n>
inline constexpr bool is_scalar<Dual<double, n>> = true;

/// [-] It carries n derivatives.
template <std::floating_point S, std::size_t n>
inline constexpr std::size_t derivatives_of<Dual<S, n>> = n;

/// The number without derivatives, as `Dual::value` returns it.
template <std::floating_point S, std::size_t n>
[[nodiscard]] constexpr S value_of(const Dual<S, n>& x) {
  return x.value();
}

/// Snapshots and hashes treat it as its n + 1 numbers.
template <std::floating_point S, std::size_t n>
inline constexpr bool detail::is_plain_value<Dual<S, n>> = sizeof(Dual<S, n>) ==
                                                           (n + 1) * sizeof(S);

}  // namespace bristle::inline BRISTLE_ABI

/// The limits of S, as constants.
template <std::floating_point S, std::size_t n>
class std::numeric_limits<bristle::Dual<S, n>> : public std::numeric_limits<S> {
  using Dual = bristle::Dual<S, n>;
  using Base = std::numeric_limits<S>;

 public:
  /// The constant that S has under the same name. Its derivatives are 0.
  /// @{
  static constexpr Dual min() noexcept { return Base::min(); }
  static constexpr Dual max() noexcept { return Base::max(); }
  static constexpr Dual lowest() noexcept { return Base::lowest(); }
  static constexpr Dual epsilon() noexcept { return Base::epsilon(); }
  static constexpr Dual round_error() noexcept { return Base::round_error(); }
  static constexpr Dual infinity() noexcept { return Base::infinity(); }
  static constexpr Dual quiet_NaN() noexcept { return Base::quiet_NaN(); }
  static constexpr Dual signaling_NaN() noexcept { return Base::signaling_NaN(); }
  static constexpr Dual denorm_min() noexcept { return Base::denorm_min(); }
  /// @}
};

// Only Eigen reads these traits, and Doxygen finds no scope for them.
/// @cond
/// The properties of a scalar that Eigen needs.
template <std::floating_point S, std::size_t n>
struct Eigen::NumTraits<bristle::Dual<S, n>> : Eigen::GenericNumTraits<bristle::Dual<S, n>> {
  /// Types of real parts, quotients, literals and stored copies: all are the number itself.
  using Real = bristle::Dual<S, n>;
  using NonInteger = Real;
  using Literal = Real;
  using Nested = Real;

  enum {
    IsInteger = 0,
    IsSigned = 1,
    IsComplex = 0,
    RequireInitialization = 0,
    ReadCost = (n + 1) * Eigen::NumTraits<S>::ReadCost,
    AddCost = (n + 1) * Eigen::NumTraits<S>::AddCost,
    MulCost = (2 * n + 1) * Eigen::NumTraits<S>::MulCost
  };

  /// Precision of S, as Eigen has it for S.
  static constexpr Real epsilon() { return Eigen::NumTraits<S>::epsilon(); }
  static constexpr Real dummy_precision() { return Eigen::NumTraits<S>::dummy_precision(); }
  static constexpr int digits10() { return Eigen::NumTraits<S>::digits10(); }
};
/// @endcond
