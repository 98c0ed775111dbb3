// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/core/version.hpp>

#include <doctest/doctest.h>

#include <cstdio>

// A preprocessor can compare it, which a cast or a literal with a suffix in it would prevent.
#if BRISTLE_VERSION < 100 || BRISTLE_VERSION >= 1000000
#error "BRISTLE_VERSION is no version"
#endif

TEST_CASE("version: the number and the text are made of the three parts") {
  CHECK(BRISTLE_VERSION / 10000 == BRISTLE_VERSION_MAJOR);
  CHECK(BRISTLE_VERSION / 100 % 100 == BRISTLE_VERSION_MINOR);
  CHECK(BRISTLE_VERSION % 100 == BRISTLE_VERSION_PATCH);
  // Both parts that have two digits in the number.
  CHECK(BRISTLE_VERSION_MINOR < 100);
  CHECK(BRISTLE_VERSION_PATCH < 100);

  int major = -1;
  int minor = -1;
  int patch = -1;
  char rest = 0;
  CHECK(std::sscanf(BRISTLE_VERSION_STRING, "%d.%d.%d%c", &major, &minor, &patch, &rest) == 3);
  CHECK(major == BRISTLE_VERSION_MAJOR);
  CHECK(minor == BRISTLE_VERSION_MINOR);
  CHECK(patch == BRISTLE_VERSION_PATCH);
}
