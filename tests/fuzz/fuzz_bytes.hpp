/// @file
/// Bytes of a fuzzer as numbers, vectors and choices. Bytes past the end are zero, so that any
/// bytes are a whole script.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/transform.hpp>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <span>

namespace bristle::test {

template <typename S>
class FuzzBytes {
 public:
  explicit FuzzBytes(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  [[nodiscard]] bool at_end() const { return at_ >= bytes_.size(); }
  std::uint8_t byte() { return at_end() ? std::uint8_t{0} : bytes_[at_++]; }
  /// One of `count` choices.
  std::size_t choice(std::size_t count) { return byte() % count; }
  /// True once in `times` for bytes that are evenly spread, and where they have ended.
  bool once_in(unsigned times) { return byte() % times == 0; }

  /// From here on all numbers are within their scale.
  void be_tame() { is_tame_ = true; }
  /// Within +-`scale`; where not tame, one in 42 is of any size, or what breaks sums.
  S number(S scale) {
    const std::uint8_t kind = byte();
    if (!is_tame_ && kind >= 253) return extreme();
    if (!is_tame_ && kind >= 250) return any_size();
    return scale * (S(byte()) / S(128) + S(byte()) / S(32768) - S(1));
  }
  /// The same from 0 up, but for the extremes.
  S positive(S scale) {
    const S x = number(scale);
    return std::abs(x) <= scale ? std::abs(x) : x;
  }
  Vec3<S> vector(S scale) {
    const S x = number(scale);
    const S y = number(scale);
    return {x, y, number(scale)};
  }
  Vec3<S> positive_vector(S scale) {
    const S x = positive(scale);
    const S y = positive(scale);
    return {x, y, positive(scale)};
  }
  /// Of length 1; where not tame, one in sixteen of any other.
  Vec3<S> direction() {
    const Vec3<S> v = vector(S(1));
    return once_in(16) && !is_tame_ ? v : Vec3<S>(v.normalized());
  }
  Quat<S> rotation() {
    const std::uint8_t kind = byte();
    if (kind < 96) return Quat<S>::Identity();
    const Vec3<S> v = vector(S(1));
    const Quat<S> q(number(S(1)), v.x(), v.y(), v.z());
    return is_tame_ || kind < 250 ? Quat<S>(q.normalized()) : q;
  }
  Transform<S> pose(S scale) {
    const Quat<S> rotation = this->rotation();
    return {rotation, vector(scale)};
  }

 private:
  S extreme() {
    using Limits = std::numeric_limits<S>;
    static constexpr S all[] = {S(0),
                                -S(0),
                                Limits::quiet_NaN(),
                                Limits::infinity(),
                                -Limits::infinity(),
                                Limits::max(),
                                Limits::lowest(),
                                Limits::min(),
                                Limits::denorm_min(),
                                Limits::epsilon(),
                                S(-1),
                                S(1e-15),
                                S(1e-9),
                                S(1e6),
                                S(1e15),
                                S(1e30)};
    return all[choice(std::size(all))];
  }
  S any_size() {
    const int exponent = (int{byte()} - 128) * std::numeric_limits<S>::max_exponent / 128;
    const S x = std::ldexp(S(1) + S(byte()) / S(256), exponent);
    return once_in(2) ? -x : x;
  }

  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
  bool is_tame_ = false;
};

}  // namespace bristle::test
