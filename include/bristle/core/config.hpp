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

/// [bytes] Of the vector registers that this file is compiled for; 0 where lanes are plain arrays.
#if !defined(__GNUC__) || defined(BRISTLE_NO_SIMD)
#define BRISTLE_REGISTER_BYTES 0
#elif defined(__AVX512F__)
#define BRISTLE_REGISTER_BYTES 64
#elif defined(__AVX__)
#define BRISTLE_REGISTER_BYTES 32
#else
#define BRISTLE_REGISTER_BYTES 16
#endif

/// BRISTLE_ABI: the inline namespace of all of the library. Files that must not be mixed have other
/// names for everything, so that they do not link: header-only ones and those of the compiled
/// library, and files for registers of two widths. Widths decide how Eigen aligns what it has on
/// the stack, and the linker keeps one copy of Eigen's functions for all files.
#define BRISTLE_ABI BRISTLE_ABI_OF(BRISTLE_WAY, BRISTLE_REGISTER_BYTES)
#define BRISTLE_ABI_OF(way, bytes) BRISTLE_ABI_OF_(way, bytes)
#define BRISTLE_ABI_OF_(way, bytes) way##_##bytes
#if defined(BRISTLE_COMPILED)
#define BRISTLE_WAY compiled
#else
#define BRISTLE_WAY header_only
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

/// BRISTLE_INLINE: before functions of a few instructions, which are inlined even without
/// optimisation: what is passed through memory there costs more than what is done with it.
#if defined(__GNUC__)
#define BRISTLE_INLINE [[gnu::always_inline]] inline
#else
#define BRISTLE_INLINE inline
#endif
