/// @file
/// Version of the library. CMake reads these three numbers; nothing else repeats them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// First number of the version.
#define BRISTLE_VERSION_MAJOR 0
/// Second number of the version.
#define BRISTLE_VERSION_MINOR 1
/// Third number of the version.
#define BRISTLE_VERSION_PATCH 0

/// One number to compare in an `#if`. It counts 10000 for a major version, 100 for a minor one, 1
/// for a patch.
#define BRISTLE_VERSION \
  (BRISTLE_VERSION_MAJOR * 10000 + BRISTLE_VERSION_MINOR * 100 + BRISTLE_VERSION_PATCH)

/// Text for logs: "major.minor.patch".
#define BRISTLE_VERSION_STRING           \
  BRISTLE_TEXT_OF(BRISTLE_VERSION_MAJOR) \
  "." BRISTLE_TEXT_OF(BRISTLE_VERSION_MINOR) "." BRISTLE_TEXT_OF(BRISTLE_VERSION_PATCH)
/// Expands a macro, then quotes it.
#define BRISTLE_TEXT_OF(number) BRISTLE_TEXT_OF_(number)
/// Quotes its argument as it stands.
#define BRISTLE_TEXT_OF_(number) #number
