// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/fcl_backend.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <backend/conformance.hpp>

using namespace bristle;

static_assert(ShapeBackend<FclBackend, float> && ShapeBackend<FclBackend, double>);

TEST_CASE_TEMPLATE("FclBackend: conforms", S, float, double) {
  test::ConformanceDef<S> def;
  // What GJK leaves on curved shapes (fcl_contact_normal.hpp): 1e-7 of the size, and for the
  // direction, which is flat there, its root.
  def.contact_tolerance = std::max(def.contact_tolerance, S(1e-7));
  def.normal_tolerance = std::max(def.normal_tolerance, S(3e-4));
  test::check_conformance<FclBackend, S>(def);
}
