/// @file
/// Every macro the library reads. Define one before the first include, or on the command line.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#if (defined(_MSVC_LANG) ? _MSVC_LANG : __cplusplus) < 202002L
#error "bristle needs C++20: compile with -std=c++20 or later"
#endif

/// BRISTLE_ASSERT(condition): checks for errors of the library itself, never for a caller's data
/// (that is `InvalidArgument`, in every build type). Debug builds abort; release builds skip it.
#if !defined(BRISTLE_ASSERT)
#include <cassert>
#define BRISTLE_ASSERT(condition) assert(condition)
#endif

/// BRISTLE_WITH_FCL: defined by the CMake target `bristle::fcl`; the umbrella header then includes
/// the FCL backend too.

/// BRISTLE_NO_SIMD: lanes of vectors as plain arrays, for compilers and machines without
/// (math/simd.hpp).

/// BRISTLE_FATAL(message): what replaces a throw where exceptions are compiled away
/// (-fno-exceptions). Must not return.
#if !defined(BRISTLE_FATAL)
#include <cstdio>
#include <cstdlib>
#define BRISTLE_FATAL(message) (std::fprintf(stderr, "bristle: %s\n", (message)), std::abort())
#endif
