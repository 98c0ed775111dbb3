/// @file
/// Every macro the library reads. Define one before the first include, or on the command line.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#if (defined(_MSVC_LANG) ? _MSVC_LANG : __cplusplus) < 202002L
#error "bristle needs C++20: compile with -std=c++20 or later"
#endif

/// BRISTLE_COMPILED: headers declare the library and leave its definition to a compiled one; set by
/// the CMake target `bristle::compiled`. All files of a program agree on it.
///
/// BRISTLE_INSTANTIATE=S: with BRISTLE_COMPILED, this file makes the library for the scalar S. For
/// programs that use the single header without CMake; the target needs it of nobody.
///
/// BRISTLE_WITH_DEFINITIONS: with BRISTLE_COMPILED, this file has all definitions, too: for scalars
/// and backends that the compiled library has not got.
///
/// BRISTLE_HAS_DEFINITIONS is 1 where headers define what they declare.
#if defined(BRISTLE_COMPILED) && !defined(BRISTLE_INSTANTIATE) && !defined(BRISTLE_WITH_DEFINITIONS)
#define BRISTLE_HAS_DEFINITIONS 0
#else
#define BRISTLE_HAS_DEFINITIONS 1
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
