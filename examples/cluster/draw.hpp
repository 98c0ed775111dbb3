/// @file
/// Random numbers that depend on the number of a world alone, and not on the rank that owns it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace cluster {

/// Mixes two numbers into one: the output function of splitmix64 (Steele, Lea, Flood 2014).
inline std::uint64_t mixed(std::uint64_t a, std::uint64_t b) {
  std::uint64_t x = a * 0x9e3779b97f4a7c15u + b + 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

/// What is drawn for a world. Motions of the hand follow, one for each round.
enum class Drawn : std::uint64_t { mass, friction, first_motion };

/// Returns a number from 0 up to 1 for a world. It has 24 bits, so a float holds it exactly.
inline float drawn(std::uint64_t world, Drawn what, std::uint64_t round = 0) {
  const std::uint64_t bits = mixed(world, static_cast<std::uint64_t>(what) + round);
  return static_cast<float>(bits >> 40) * 0x1p-24f;
}

}  // namespace cluster
