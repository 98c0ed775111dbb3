// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/backends/analytic_backend.hpp>

#include <doctest/doctest.h>

#include <backend/conformance.hpp>

using namespace bristle;

TEST_CASE_TEMPLATE("AnalyticBackend: conforms", S, float, double) {
  test::check_conformance<AnalyticBackend, S>({});
}
