/// @file
/// The scalars and backends that tests of geometry-dependent physics run on.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/world/world.hpp>

namespace bristle::test {

/// One combination, as a type for TEST_CASE_TEMPLATE.
template <typename S, typename B>
struct Setup {
  using Scalar = S;
  using Backend = B;
};

using AnalyticDouble = Setup<double, AnalyticBackend>;
using AnalyticFloat = Setup<float, AnalyticBackend>;
#if defined(BRISTLE_WITH_FCL)
using FclDouble = Setup<double, FclBackend>;
using FclFloat = Setup<float, FclBackend>;
#endif

}  // namespace bristle::test

#if defined(BRISTLE_WITH_FCL)
/// All of them, as the last arguments of TEST_CASE_TEMPLATE.
#define BRISTLE_TEST_SETUPS                                                              \
  bristle::test::AnalyticDouble, bristle::test::AnalyticFloat, bristle::test::FclDouble, \
      bristle::test::FclFloat
#else
#define BRISTLE_TEST_SETUPS bristle::test::AnalyticDouble, bristle::test::AnalyticFloat
#endif
