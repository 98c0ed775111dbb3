// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/backends/fcl_backend.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <backend/conformance.hpp>

using namespace bristle;

static_assert(ShapeBackend<FclBackend, float> && ShapeBackend<FclBackend, double>);

TEST_CASE_TEMPLATE("FclBackend: conforms", S, float, double) {
  test::ConformanceDef<S> def;
  // FCL's GJK ends a little earlier than the library's own.
  def.contacts.curved_gap = std::max(def.contacts.curved_gap, S(1e-7));
  def.contacts.curved_normal = S(3e-4);
  test::check_conformance<FclBackend, S>(def);
}
