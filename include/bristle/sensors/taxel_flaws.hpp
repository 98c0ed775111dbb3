/// @file
/// Flaws of real taxels, applied to a true reading: gain, hysteresis, noise and dead taxels.
///
/// Flaws follow the physics and never feed back. Forces stay as applied.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/error.hpp>
#include <bristle/math/types.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <string>

namespace bristle::inline BRISTLE_ABI {

/// Deviations of an array of taxels from perfect ones. The defaults are perfect.
template <Scalar S>
struct TaxelFlawsDef {
  /// [1] Standard deviation of the taxels' gains around 1. Finite, >= 0.
  S gain_spread = S(0);
  /// [1] Share of dead taxels, in [0, 1]; they read 0. The seed selects them.
  S dead_share = S(0);
  /// [unit of the channel] Half the width of the play between true value and reading (Prandtl's
  /// play operator). The reading follows only once the input has moved on by it. It stays behind by
  /// it, on the way up and on the way down. Finite, >= 0.
  S hysteresis = S(0);
  /// [unit of the channel] Standard deviation of the noise of each sample. Finite, >= 0. It may
  /// take a reading below 0.
  S noise = S(0);
  /// [-] Seed of the flaws. Equal seeds and channels give equal bits.
  std::uint64_t seed = 1;
  /// [-] Channel of an array with this seed. The same taxels are dead in all channels. Gains and
  /// noise are each channel's own.
  std::uint64_t channel = 0;
};

/// Flaws of one array of taxels in one channel. Stores the state of each taxel's play.
template <Scalar S>
class TaxelFlaws {
 public:
  /// @throws InvalidArgument naming the field, or when there are no taxels.
  TaxelFlaws(std::size_t taxels, const TaxelFlawsDef<S>& def);

  /// Turns true values into readings; `in` and `out` may be the same. Each call is one sample.
  /// @throws InvalidArgument when a span is not of the number of taxels.
  void apply(std::span<const S> in, std::span<S> out);

  /// Returns to the first sample, at rest.
  void reset() {
    sample_ = 0;
    std::fill(play_.begin(), play_.end(), S(0));
  }

  /// [-] Number of taxels.
  [[nodiscard]] std::size_t size() const { return gain_.size(); }
  /// [1] Gain of a taxel; 0 where it is dead.
  [[nodiscard]] S gain(std::size_t taxel) const { return gain_[taxel]; }

 private:
  S hysteresis_, noise_;
  std::uint64_t seed_;
  std::uint64_t sample_ = 0;
  detail::DynamicArray<S> gain_;
  detail::DynamicArray<S> play_;
};

// Implementation ----------------------------------------------------------------------------------

namespace detail {

/// Random bits for each (seed, stream, index), without state: the finaliser of SplitMix64 (Steele,
/// Lea and Flood 2014) over a running sum.
[[nodiscard]] inline std::uint64_t random_bits(std::uint64_t seed, std::uint64_t stream,
                                               std::uint64_t index) {
  const auto mix = [](std::uint64_t z) {
    z += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  };
  return mix(mix(mix(seed) ^ stream) ^ index);
}

/// Uniform in (0, 1).
[[nodiscard]] inline double random_uniform(std::uint64_t seed, std::uint64_t stream,
                                           std::uint64_t index) {
  return (static_cast<double>(random_bits(seed, stream, index) >> 11) + 0.5) * 0x1p-53;
}

/// Normal with mean 0 and deviation 1 (Box and Muller); `index` must be below 2^63.
[[nodiscard]] inline double random_normal(std::uint64_t seed, std::uint64_t stream,
                                          std::uint64_t index) {
  const double radius = std::sqrt(-2 * std::log(random_uniform(seed, stream, 2 * index)));
  const double turn = random_uniform(seed, stream, 2 * index + 1);
  return radius * std::cos(2 * std::numbers::pi * turn);
}

}  // namespace detail

template <Scalar S>
TaxelFlaws<S>::TaxelFlaws(std::size_t taxels, const TaxelFlawsDef<S>& def)
    : hysteresis_(def.hysteresis),
      noise_(def.noise),
      seed_(def.seed ^ def.channel * 0x9e3779b97f4a7c15u) {
  detail::require(taxels > 0, "TaxelFlaws: taxels", taxels, "must be > 0");
  detail::require_not_negative("TaxelFlawsDef::gain_spread", def.gain_spread);
  detail::require_not_negative("TaxelFlawsDef::dead_share", def.dead_share);
  detail::require(def.dead_share <= S(1), "TaxelFlawsDef::dead_share", def.dead_share,
                  "must be <= 1");
  detail::require_not_negative("TaxelFlawsDef::hysteresis", def.hysteresis);
  detail::require_not_negative("TaxelFlawsDef::noise", def.noise);
  gain_.resize(taxels);
  play_.resize(taxels);
  // Streams 0 and 1 hold the fixed flaws. Samples have the streams from 2 on. Channels are seeds
  // far apart (a step of SplitMix64).
  for (std::size_t i = 0; i < taxels; ++i) {
    const bool is_dead =
        detail::random_uniform(def.seed, 0, i) < static_cast<double>(def.dead_share);
    gain_[i] = is_dead
                   ? S(0)
                   : S(1) + def.gain_spread * static_cast<S>(detail::random_normal(seed_, 1, i));
  }
}

template <Scalar S>
void TaxelFlaws<S>::apply(std::span<const S> in, std::span<S> out) {
  for (const std::size_t n : {in.size(), out.size()}) {
    detail::require(n == size(), "TaxelFlaws::apply: size of a span", n,
                    "must be " + std::to_string(size()));
  }
  for (std::size_t i = 0; i < size(); ++i) {
    play_[i] = std::clamp(play_[i], in[i] - hysteresis_, in[i] + hysteresis_);
    out[i] = gain_[i] * play_[i];
    if (noise_ > S(0) && gain_[i] != S(0)) {
      out[i] += noise_ * static_cast<S>(detail::random_normal(seed_, 2 + sample_, i));
    }
  }
  ++sample_;
}

}  // namespace bristle::inline BRISTLE_ABI
