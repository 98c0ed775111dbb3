/// @file
/// Equality to a part of a number.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <doctest/doctest.h>

namespace bristle::test {

/// Equals what differs from x by less than epsilon |x|. doctest's Approx compares with 1 + |x|, so
/// that a few micrometres equal any other few: it is left to what shall be about zero. Zero equals
/// itself here, since the scale, far below all that is measured, is not quite 0.
template <typename T>
[[nodiscard]] doctest::Approx relative(T x) {
  return doctest::Approx(static_cast<double>(x)).scale(1e-300);
}

}  // namespace bristle::test
