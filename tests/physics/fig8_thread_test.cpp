/// @file
/// Fig. 8 (b): hands wrap a thread of links around a post, pull it over the post, and hand it over.
// SPDX-License-Identifier: BSD-3-Clause
#include "fig8_thread/task.hpp"
#include "support/relative.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

using fig8b::Measured;
using fig8b::Phase;

namespace {

/// Runs a phase and checks what has to hold in each.
Measured checked(fig8b::Task& task, Phase phase) {
  const Measured m = task.run(phase);
  CAPTURE(fig8b::name_of(phase));
  CAPTURE(m.slip[0]);
  CAPTURE(m.slip[1]);
  CAPTURE(m.tension[0]);
  CAPTURE(m.tension[1]);
  CAPTURE(m.energy.rest());
  CHECK_FALSE(m.is_lost);
  CHECK(m.length_error < 0.01);
  CHECK(m.gap < 1e-4);
  CHECK(m.is_right());
  return m;
}

}  // namespace

TEST_CASE("fig8_thread: a thread is wrapped, pulled over a post and handed over") {
  fig8b::Task task({.time_step = 1.0 / 240});
  checked(task, Phase::grip);
  checked(task, Phase::wrap);
  const Measured pulled = checked(task, Phase::pull);
  // The hand that is pulled along feels the force of its motor.
  CHECK(pulled.pull[0] == bristle::test::relative(fig8b::trailing_force).epsilon(0.01));
  CHECK(pulled.pull[1] > 2 * pulled.pull[0]);
  checked(task, Phase::travel);
  CHECK_FALSE(task.hand(0).touches(task.world()));
  CHECK(task.hand(1).touches(task.world()));
  checked(task, Phase::hand_over);
  CHECK(task.hand(0).touches(task.world()));
  CHECK_FALSE(task.hand(1).touches(task.world()));
  const Measured carried = checked(task, Phase::carry);
  CHECK(carried.pull[0] > 0.5);
  CHECK(carried.pull[1] == 0);
}

// examples.fig8_thread runs the whole task at 1 ms, and has the same verdicts.
TEST_CASE("fig8_thread: the same at 1 ms until the thread has been pulled") {
  fig8b::Task task({});
  for (const Phase phase : {Phase::grip, Phase::wrap, Phase::pull}) checked(task, phase);
}

TEST_CASE("fig8_thread: explicit steps lose the thread") {
  for (const double dt : {1e-3, 1.0 / 240}) {
    fig8b::Task task({.time_step = dt, .integration = bristle::Integration::explicit_});
    CHECK_FALSE((task.run(Phase::grip).is_held() && task.run(Phase::wrap).is_held()));
  }
}

TEST_CASE("fig8_thread: the capstan's tension is Euler's for a thread without weight") {
  const double factor =
      std::exp(fig8b::post_friction * fig8b::post_radius / fig8b::lever * std::numbers::pi);
  CHECK(fig8b::capstan(1e6) / 1e6 == bristle::test::relative(factor).epsilon(1e-5));
  CHECK(factor < std::exp(fig8b::post_friction * std::numbers::pi));
}
