/// @file
/// Engines in a million random states: nothing that is no number is ever applied, and nothing is
/// thrown but what the docstring names.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/random_host.hpp"

#include <doctest/doctest.h>

#include <cstddef>

using namespace bristle;
using namespace bristle::scenes;

TEST_CASE_TEMPLATE("random_hosts: 500,000 states in each scalar", S, float, double) {
  RandomHost<S> host(17);
  int wrong = 0;
  for (int i = 0; i < 500000; ++i) wrong += host.step() ? 0 : 1;
  CHECK(wrong == 0);
  CHECK(host.bad == 0);
  CHECK(host.given > 100000);
}
