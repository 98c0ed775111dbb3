/// @file
/// Fig. 8 (a): two hands pick a screwdriver up, insert it and turn it with the cast below.
// SPDX-License-Identifier: BSD-3-Clause
#include "fig8_screwdriver/task.hpp"
#include "support/relative.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

using bristle::Integration;
using fig8::Task;

namespace {

const fig8::Phase& phase_of(const Task& task, const std::string& name) {
  const auto found = std::find_if(task.phases().begin(), task.phases().end(),
                                  [&](const fig8::Phase& phase) { return phase.name == name; });
  REQUIRE(found != task.phases().end());
  return *found;
}

/// [m] Slip when a phase ends.
double slip_after(const Task& task, const fig8::Phase& phase, double time_step) {
  return task.samples()[static_cast<std::size_t>(std::lround(phase.end / time_step)) - 1].slip;
}

/// Picked up, carried, inserted, turned, and gripped anew without a drop.
void check_course(const Task& task, double dt) {
  CHECK(task.lost_in() == "");
  CHECK(task.phases().back().name == "rest");

  // In the air it hangs by its weight over the stiffness of the bristles of both pads.
  const fig8::Phase& carry = phase_of(task, "carry");
  CHECK(carry.height == bristle::test::relative(fig8::clear_height).epsilon(1e-3));
  const double sag =
      fig8::driver_mass * 9.81 / (2 * Task::firm * fig8::table_constants.static_friction);
  CHECK(slip_after(task, carry, dt) == bristle::test::relative(sag).epsilon(0.01));

  CHECK(std::abs(phase_of(task, "insert").height - fig8::seated_height) < 1e-4);
  CHECK(phase_of(task, "soften 1").squeeze_minor ==
        bristle::test::relative(Task::soft).epsilon(0.1));
  CHECK(phase_of(task, "turn 1").squeeze_minor == bristle::test::relative(Task::soft).epsilon(0.1));
  const fig8::Phase& turn = phase_of(task, "turn 1");
  CHECK(turn.driver_turn > Task::wanted_turn);
  CHECK(turn.cast_turn > Task::wanted_turn);
  CHECK(turn.driver_turn < Task::stroke);
  // While the major hand is away the minor one keeps what was turned, up to what bristles give.
  const fig8::Phase& release = phase_of(task, "release 1");
  CHECK(release.holder == "minor");
  CHECK(release.squeeze_major == 0);
  CHECK(std::abs(release.driver_turn) * fig8::shaft_radius < Task::slip_bound);
  CHECK(std::abs(release.cast_turn) < 1e-6);

  CHECK(task.slip() < Task::slip_bound);
  CHECK(task.released() == 0);
  CHECK(task.is_right());
}

/// Momentum and energy are accounted for.
void check_account(const Task& task, double dt) {
  const fig8::Account& sum = task.account();
  // Of 6 mN s and more that the weight gives in a step.
  CHECK(sum.lost_momentum < 1e-14);
  CHECK(sum.lost_angular < 1e-14);
  CHECK(std::abs(sum.error()) < (dt < 2e-3 ? 0.003 : 0.01) * sum.drives);
  CHECK(sum.sensors < 0);
  CHECK(sum.contacts < 0);
  // The joint takes its friction over the way, and its damping at no more than the greatest speed.
  const fig8::Phase& turn = phase_of(task, "turn 1");
  double fastest = 0;
  for (std::size_t i = 1; i < task.samples().size(); ++i) {
    fastest =
        std::max(fastest, (task.samples()[i].cast_turn - task.samples()[i - 1].cast_turn) / dt);
  }
  CHECK(-sum.cast > fig8::cast_friction * turn.cast_turn);
  CHECK(-sum.cast < (fig8::cast_friction + fig8::cast_damping * fastest) * turn.cast_turn);
}

}  // namespace

TEST_CASE("fig8_screwdriver: two hands pick up, insert, turn and grip anew; budgets close") {
  for (const double dt : {1e-3, 1.0 / 240}) {
    CAPTURE(dt);
    Task task({.turns = 1, .time_step = dt});
    task.run();
    check_course(task, dt);
    check_account(task, dt);
  }
}

TEST_CASE("fig8_screwdriver: explicit steps hold at 1 ms, and lose the driver at 1/240 s") {
  Task task({.turns = 1, .integration = Integration::explicit_});
  task.run();
  CHECK(task.is_right());
  Task too_long({.turns = 1, .time_step = 1.0 / 240, .integration = Integration::explicit_});
  too_long.run();
  CHECK_FALSE(too_long.lost_in().empty());
  CHECK_FALSE(too_long.is_right());
}

TEST_CASE("fig8_screwdriver: the number of sensors does not change what a pad does") {
  Task coarse({.turns = 1, .time_step = 1.0 / 240, .grid = {5, 5}});
  coarse.run();
  Task fine({.turns = 1, .time_step = 1.0 / 240, .grid = {10, 25}});
  fine.run();
  CHECK(coarse.is_right());
  CHECK(fine.is_right());
  CHECK(coarse.least_turn() == bristle::test::relative(fine.least_turn()).epsilon(0.01));
}
