/// @file
/// Every macro the library reads. Define one before the first include, or on the command line.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#if (defined(_MSVC_LANG) ? _MSVC_LANG : __cplusplus) < 202002L
#error "bristle needs C++20: compile with -std=c++20 or later"
#endif

/// BRISTLE_COMPILED: headers only declare the library; the compiled library defines it. The CMake
/// target `bristle::compiled` sets it. All files of a program must agree on it.
///
/// BRISTLE_INSTANTIATE=S: with BRISTLE_COMPILED, this file instantiates the library for the scalar
/// S. For programs that use the single header without CMake. Programs with the target do not need
/// it.
///
/// BRISTLE_WITH_DEFINITIONS: with BRISTLE_COMPILED, this file also has all definitions. For scalars
/// and backends that the compiled library lacks.
///
/// BRISTLE_HAS_DEFINITIONS is 1 where headers define what they declare.
#if defined(BRISTLE_COMPILED) && !defined(BRISTLE_INSTANTIATE) && !defined(BRISTLE_WITH_DEFINITIONS)
#define BRISTLE_HAS_DEFINITIONS 0
#else
#define BRISTLE_HAS_DEFINITIONS 1
#endif

/// [bytes] Size of the vector registers that this file is compiled for. It is 0 where lanes are
/// plain arrays.
#if !defined(__GNUC__) || defined(BRISTLE_NO_SIMD)
#define BRISTLE_REGISTER_BYTES 0
#elif defined(__AVX512F__)
#define BRISTLE_REGISTER_BYTES 64
#elif defined(__AVX__)
#define BRISTLE_REGISTER_BYTES 32
#else
#define BRISTLE_REGISTER_BYTES 16
#endif

/// BRISTLE_ABI: the inline namespace of the whole library. Files that must not be mixed get
/// different names for everything. So they do not link. These are header-only files and those of
/// the compiled library. Files for registers of two widths must not be mixed either. The width
/// decides how Eigen aligns objects on the stack. The linker keeps one copy of Eigen's functions
/// for all files.
#define BRISTLE_ABI BRISTLE_ABI_OF(BRISTLE_WAY, BRISTLE_REGISTER_BYTES)
/// Expands its arguments, then joins them.
#define BRISTLE_ABI_OF(way, bytes) BRISTLE_ABI_OF_(way, bytes)
/// Joins its arguments as they stand: `way_bytes`.
#define BRISTLE_ABI_OF_(way, bytes) way##_##bytes
/// BRISTLE_WAY: first part of the namespace's name, `compiled` or `header_only`.
#if defined(BRISTLE_COMPILED)
#define BRISTLE_WAY compiled
#else
#define BRISTLE_WAY header_only
#endif

/// BRISTLE_ASSERT(condition): checks for errors of the library itself. A caller's data is checked
/// by `InvalidArgument`, in every build type. Debug builds abort; release builds skip it.
#if !defined(BRISTLE_ASSERT)
#include <cassert>
#define BRISTLE_ASSERT(condition) assert(condition)
#endif

/// BRISTLE_WITH_FCL: defined by the CMake target `bristle::fcl`. The umbrella header then also
/// includes the FCL backend.

/// BRISTLE_NO_SIMD: makes lanes plain arrays, for compilers and machines without vector registers
/// (math/simd.hpp).

/// BRISTLE_FATAL(message): replaces a throw where exceptions are compiled away (-fno-exceptions).
/// Must not return.
#if !defined(BRISTLE_FATAL)
#include <cstdio>
#include <cstdlib>
#define BRISTLE_FATAL(message) (std::fprintf(stderr, "bristle: %s\n", (message)), std::abort())
#endif

/// BRISTLE_FORCE_INLINE: inlines functions of a few instructions even without optimisation. There,
/// passing their arguments through memory costs more than the functions do.
#if defined(__GNUC__)
#define BRISTLE_FORCE_INLINE [[gnu::always_inline]] inline
#else
#define BRISTLE_FORCE_INLINE inline
#endif

/// BRISTLE_FORCE_INLINE_LAMBDA: the same, behind the parameters of a lambda.
#if defined(__GNUC__)
#define BRISTLE_FORCE_INLINE_LAMBDA __attribute__((always_inline))
#else
#define BRISTLE_FORCE_INLINE_LAMBDA
#endif

/// BRISTLE_COLD: compiles a function that is hardly ever called for size, and never inlines it.
#if defined(__GNUC__)
#define BRISTLE_COLD [[gnu::cold, gnu::noinline]]
#else
#define BRISTLE_COLD
#endif

/// BRISTLE_UNROLL: unrolls the loop behind it, of a few turns whose number is a constant. g++ does
/// that by itself only from -O3 on, clang at each level that optimises.
#if defined(__GNUC__) && !defined(__clang__)
#define BRISTLE_UNROLL _Pragma("GCC unroll 9")
#else
#define BRISTLE_UNROLL
#endif
