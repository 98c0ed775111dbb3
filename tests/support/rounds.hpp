/// @file
/// How often a seeded random test repeats.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdlib>

namespace bristle::test {

/// `base`, times BRISTLE_ROUNDS_FACTOR where that is set in the environment: the long runs of a
/// fuzz test are the short ones, continued with the same seed.
inline int rounds(int base) {
  const char* factor = std::getenv("BRISTLE_ROUNDS_FACTOR");
  const int times = factor != nullptr ? std::atoi(factor) : 1;
  return times > 1 ? base * times : base;
}

}  // namespace bristle::test
