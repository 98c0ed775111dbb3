/// @file
/// Manifolds side by side: rounds, and the same results as one after the other.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/contact_island.hpp"
#include "support/relative.hpp"

#include <bristle/dynamics/contacts/contact_target.hpp>
#include <bristle/dynamics/contacts/manifold_sweeps.hpp>
#include <bristle/dynamics/solver/sequential_solver.hpp>

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

using namespace bristle;

using namespace bristle::detail;

namespace {

/// Bodies that touch each other in any way: some that nothing moves, some without an axis they
/// would rather turn about. Manifolds have one to eight points, and every third bounces.
template <typename S>
test::ContactIsland<S> random_heap(test::Random& random, std::uint32_t bodies,
                                   std::uint32_t manifolds,
                                   Integrator integrator = Integrator::trapezoidal) {
  test::ContactIsland<S> heap = test::random_pile<S>(random, bodies, 1, S(0.5), S(10));
  for (std::uint32_t i = 0; i < bodies; i += 5) {
    SolverBody<S>& body = heap.bodies[i];  // Driven: it has a velocity, and keeps it.
    body.moves = false;
    body.inverse_mass.setZero();
    body.inverse_inertia.setZero();
  }
  for (std::uint32_t i = 2; i <= bodies; i += 5) {
    SolverBody<S>& body = heap.bodies[i];
    body.is_isotropic = true;
    body.inverse_inertia = S(30) * Mat3<S>::Identity();
  }
  heap.moving.clear();
  for (std::uint32_t i = 0; i <= bodies; ++i) {
    SolverBody<S>& body = heap.bodies[i];
    body.start = body.free;
    if (body.moves) body.start.linear += random.in_cube(S(0.05));
    body.motion = body.mean_free = mean_free_velocity(body, integrator);
    if (heap.bodies[i].moves) heap.moving.push_back(i);
  }
  heap.contacts.clear();
  heap.constraints.contacts.clear();
  for (std::uint32_t k = 0; k < manifolds; ++k) {
    const auto pick = [&] {
      return static_cast<std::uint32_t>(random.uniform(0.0, 0.999999) * (bodies + 1));
    };
    ContactConstraint<S> c;
    c.body_a = pick();
    do {
      c.body_b = pick();
    } while (c.body_b == c.body_a || !(heap.bodies[c.body_a].moves || heap.bodies[c.body_b].moves));
    c.axes[0] = random.in_cube(S(1)).normalized();
    tangent_basis<S>(c.axes[0], c.axes[1], c.axes[2]);
    c.friction = random.uniform(S(0), S(1));
    c.restitution = k % 3 == 0 ? S(0.5) : S(0);
    for (std::uint32_t i = 0; i <= k % 8; ++i) {
      c.arm_a = random.in_cube(S(0.2));
      c.arm_b = c.arm_a + S(0.1) * c.axes[0];
      c.gap = random.uniform(S(-1e-3), S(1e-3));
      c.impulse[0] = random.uniform(S(0), S(0.3));
      heap.contacts.push_back(static_cast<std::uint32_t>(heap.constraints.contacts.size()));
      heap.constraints.contacts.push_back(c);
    }
  }
  return heap;
}

template <typename S>
SolveContext<S> sweep_context(Integrator integrator = Integrator::trapezoidal) {
  SolveContext<S> c;
  c.integrator = integrator;
  c.dt = S(1) / S(240);
  c.restitution_speed = S(0.01);  // Without one, round-off would decide which contacts part.
  c.speed_change = S(10);
  c.is_swept = true;
  return c;
}

/// The manifolds of an island, each as an island of its own.
template <typename S>
std::vector<std::vector<std::uint32_t>> split(const test::ContactIsland<S>& heap) {
  std::vector<std::vector<std::uint32_t>> result;
  for (const std::uint32_t i : heap.contacts) {
    const auto& contacts = heap.constraints.contacts;
    if (i == 0 || !are_of_one_manifold(contacts[i - 1], contacts[i])) result.emplace_back();
    result.back().push_back(i);
  }
  return result;
}

template <typename S>
void check_same_twist(const Twist<S>& a, const Twist<S>& b) {
  CHECK(a.linear == b.linear);
  CHECK(a.angular == b.angular);
}

}  // namespace

TEST_CASE(
    "ManifoldOrder: nothing that moves is in a round twice, and neighbours keep their order") {
  test::Random random(3);
  auto heap = random_heap<double>(random, 40, 120);
  DynamicArray<ManifoldSpan> manifolds;
  for (const auto& contacts : split(heap)) {
    const auto& c = heap.constraints.contacts[contacts[0]];
    manifolds.push_back({contacts[0], static_cast<std::uint32_t>(contacts.size()), c.body_a,
                         c.body_b, heap.bodies[c.body_a].moves, heap.bodies[c.body_b].moves});
  }
  ManifoldOrder order;
  std::uint32_t rounds = 0;
  for (int twice = 0; twice < 2; ++twice) {
    order.build(manifolds, heap.bodies.size());
    REQUIRE(order.places().size() == manifolds.size());
    std::vector<std::uint32_t> round_of(manifolds.size());
    for (const auto& place : order.places()) round_of[place.manifold] = place.round;
    for (std::size_t i = 0; i < manifolds.size(); ++i) {
      rounds = std::max(rounds, round_of[i] + 1);
      for (std::size_t j = i + 1; j < manifolds.size(); ++j) {
        const ManifoldSpan& m = manifolds[i];
        const ManifoldSpan& o = manifolds[j];
        const bool shares = (m.moves_a && (m.body_a == o.body_a || m.body_a == o.body_b)) ||
                            (m.moves_b && (m.body_b == o.body_a || m.body_b == o.body_b));
        if (shares) CHECK(round_of[i] < round_of[j]);
      }
    }
  }
  CHECK(rounds < manifolds.size() / 3);  // Several stand side by side.
}

TEST_CASE_TEMPLATE("ManifoldSweeps: in lanes as one after the other, to the last bit", S, double,
                   float) {
  test::Random random(7);
  for (int round = 0; round < 5; ++round) {
    auto together = random_heap<S>(random, 40, 120);
    auto apart = together;
    const Island island = together.island();
    ManifoldSweeps<S> sweeps;
    sweeps.start(island, together.constraints, together.bodies, S(1));
    sweeps.target(together.bodies, sweep_context<S>());
    sweeps.load(together.bodies, velocity_of);

    const auto manifolds = split(apart);
    std::vector<ManifoldSweeps<S>> single(manifolds.size());
    const auto alone = [&](std::size_t k) { return Island{apart.moving, manifolds[k], {}, {}}; };
    for (std::size_t k = 0; k < single.size(); ++k) {
      single[k].start(alone(k), apart.constraints, apart.bodies, S(1));
      single[k].target(apart.bodies, sweep_context<S>());
    }
    const auto turn_of_each = [&](bool backwards, const auto& of, const auto& turn) {
      S largest = S(0);
      for (std::size_t n = 0; n < single.size(); ++n) {
        const std::size_t k = backwards ? single.size() - 1 - n : n;
        single[k].load(apart.bodies, of);
        largest = std::max(largest, turn(single[k]));
        single[k].unload(apart.bodies, of);
      }
      return largest;
    };

    for (int n = 0; n < 4; ++n) {
      const bool backwards = n % 2 != 0;
      const S expected =
          turn_of_each(backwards, velocity_of, [&](auto& one) { return one.sweep(backwards); });
      CHECK(sweeps.sweep(backwards) == expected);
      CHECK(expected > S(0));
    }
    sweeps.unload(together.bodies, velocity_of);
    sweeps.spread_friction();
    sweeps.start_positions(together.bodies, sweep_context<S>());
    sweeps.unload(together.bodies, motion_of);
    for (std::size_t k = 0; k < single.size(); ++k) {
      single[k].spread_friction();
      single[k].start_positions(apart.bodies, sweep_context<S>());
      single[k].unload(apart.bodies, motion_of);
    }
    for (int n = 0; n < 4; ++n) {
      const bool backwards = n % 2 != 0;
      const S expected =
          turn_of_each(backwards, motion_of, [&](auto& one) { return one.place(backwards); });
      CHECK(sweeps.place(backwards) == expected);
      CHECK(expected > S(0));
    }
    sweeps.unload(together.bodies, motion_of);
    sweeps.write_back(island, together.constraints);
    for (std::size_t k = 0; k < single.size(); ++k) {
      single[k].write_back(alone(k), apart.constraints);
    }
    for (std::size_t i = 0; i < together.bodies.size(); ++i) {
      check_same_twist(together.bodies[i].twist, apart.bodies[i].twist);
      check_same_twist(together.bodies[i].motion, apart.bodies[i].motion);
    }
    for (const std::uint32_t i : together.contacts) {
      const ContactConstraint<S>& c = together.constraints.contacts[i];
      const ContactConstraint<S>& expected = apart.constraints.contacts[i];
      CHECK(c.impulse == expected.impulse);
      CHECK(c.is_impact == expected.is_impact);
    }
  }
}

TEST_CASE("ManifoldSweeps: velocities of what may be crushed are not extrapolated, positions are") {
  test::Random random(29);
  for (const double most : {infinity<double>, 1e6}) {
    CAPTURE(most);
    auto pile = test::random_pile<double>(random, 30, 4, 0.9, 1);
    for (auto& c : pile.constraints.contacts) c.most_impulse = most;
    ManifoldSweeps<double> sweeps;
    sweeps.start(pile.island(), pile.constraints, pile.bodies, 1.0);
    sweeps.target(pile.bodies, sweep_context<double>());
    const auto gains = [&](SweptProblem problem) {
      bool any = false;
      sweeps.start_extrapolation(problem);
      for (int n = 0; n < 20; ++n) {
        for (const bool backwards : {false, true}) {
          if (problem == SweptProblem::velocities) {
            sweeps.sweep(backwards);
          } else {
            sweeps.place(backwards);
          }
        }
        any = sweeps.extrapolate(problem) || any;
      }
      return any;
    };
    CHECK(gains(SweptProblem::velocities) == (most == infinity<double>));
    sweeps.unload(pile.bodies, velocity_of);
    for (auto& body : pile.bodies) body.motion = body.twist;
    sweeps.start_positions(pile.bodies, sweep_context<double>());
    CHECK(gains(SweptProblem::positions));
  }
}

TEST_CASE("ManifoldSweeps: what slides does not decide how far sweeps are extrapolated") {
  // A disk of four feet slides and spins. Friction can give it mu times its load in all.
  const double load = 9.81e-3;
  test::Random random(37);
  auto disk = test::random_pile<double>(random, 1, 4, 0.5, 1);
  SolverBody<double>& body = disk.bodies[1];
  body.start = {{2, 0, 0}, {0, 0, 200}};
  for (auto& c : disk.constraints.contacts) {
    c.axes = {unit_z<Vec3<double>>(), unit_x<Vec3<double>>(), unit_y<Vec3<double>>()};
    c.arm_a = c.arm_b = {c.arm_b.x(), c.arm_b.y(), -0.02};
    c.impulse = {load / 4, 0, 0};
  }
  body.free = body.twist = body.start - Twist<double>{{0, 0, load}, {0, 0, 0}};
  ManifoldSweeps<double> sweeps;
  sweeps.start(disk.island(), disk.constraints, disk.bodies, 1.0);
  sweeps.target(disk.bodies, sweep_context<double>());
  sweeps.apply();
  sweeps.start_extrapolation(SweptProblem::velocities);
  for (int n = 0; n < 5; ++n) {
    for (const bool backwards : {false, true}) sweeps.sweep(backwards);
    // A sweep finds its normal velocity, and friction gives what it can.
    CHECK_FALSE(sweeps.extrapolate(SweptProblem::velocities));
  }
  sweeps.unload(disk.bodies, velocity_of);
  CHECK(std::abs(body.twist.linear.z()) < 1e-12);
  CHECK(2 - body.twist.linear.x() < 0.5 * load);
}

TEST_CASE("ManifoldSweeps: no point gives more than its bound in a part of a step") {
  test::Random random(31);
  for (const int parts : {1, 3}) {
    CAPTURE(parts);
    // Its four points give 0.2 N s together. To stop it they would have to give 1 N s.
    auto press = test::random_pile<double>(random, 1, 4, 0.5, 1);
    for (auto& c : press.constraints.contacts) c.most_impulse = 0.05;
    ManifoldSweeps<double> sweeps;
    sweeps.start(press.island(), press.constraints, press.bodies, parts);
    for (int part = 0; part < parts; ++part) {
      sweeps.target(press.bodies, sweep_context<double>());
      sweeps.load(press.bodies, velocity_of);
      for (int n = 0; n < 50; ++n) sweeps.sweep(n % 2 != 0);
      sweeps.spread_friction();
    }
    sweeps.write_back(press.island(), press.constraints);
    // The points of a manifold share their friction.
    double x = 0;
    double y = 0;
    for (const auto& c : press.constraints.contacts) {
      CHECK(c.impulse[0] == test::relative(0.05 * parts));
      x += c.impulse[1];
      y += c.impulse[2];
    }
    CHECK(std::hypot(x, y) <= 0.5 * 4 * 0.05 * parts * (1 + 1e-12));
  }
}

// Without friction a manifold is its points, one after the other, whatever is found beforehand of
// what they do to each other. Within round-off: six sweeps, in each of which a body is pushed by
// some thirty points, with up to ten roundings each.
TEST_CASE_TEMPLATE("ManifoldSweeps: without friction, points are solved as contacts are", S, double,
                   float) {
  const S tolerance = 2000 * std::numeric_limits<S>::epsilon();
  for (const Integrator integrator : {Integrator::trapezoidal, Integrator::symplectic_euler}) {
    test::Random random(19);
    auto by_manifold = random_heap<S>(random, 40, 120, integrator);
    for (auto& c : by_manifold.constraints.contacts) c.friction = S(0);
    auto by_point = by_manifold;
    const Island island = by_manifold.island();
    const SolveContext<S> solve = sweep_context<S>(integrator);
    SequentialSolver<S> manifolds, points;
    manifolds.start_manifolds(island, by_manifold.constraints, by_manifold.bodies, S(1));
    manifolds.start_part(island, by_manifold.constraints, by_manifold.bodies, solve);
    for (ContactConstraint<S>& c : by_point.constraints.contacts) {
      target_contact(c, by_point.bodies[c.body_a], by_point.bodies[c.body_b], solve);
    }
    points.start(island, by_point.constraints, by_point.bodies);
    for (int n = 0; n < 6; ++n) {
      // Not backwards: there the points of a manifold keep their order, and contacts do not.
      manifolds.sweep(island, by_manifold.constraints, by_manifold.bodies, false);
      points.sweep(island, by_point.constraints, by_point.bodies, false);
    }
    manifolds.finish(island, by_manifold.bodies);
    manifolds.keep_impulses();
    const auto check = [&](const auto& of) {
      for (std::size_t i = 0; i < by_point.bodies.size(); ++i) {
        CAPTURE(i);
        const Twist<S>& expected = of(by_point.bodies[i]);
        const Twist<S> error = of(by_manifold.bodies[i]) - expected;
        const S size = S(1) + expected.linear.norm() + expected.angular.norm();
        CHECK(error.linear.norm() < tolerance * size);
        CHECK(error.angular.norm() < tolerance * size);
      }
    };
    check(velocity_of);

    manifolds.start_positions(island, by_manifold.bodies, solve);
    manifolds.finish_parts(island, by_manifold.constraints);
    int parting = 0;
    int bouncing = 0;
    for (std::size_t i = 0; i < by_point.constraints.contacts.size(); ++i) {
      ContactConstraint<S>& c = by_point.constraints.contacts[i];
      const S speed =
          c.normal_velocity(by_point.bodies[c.body_a].twist, by_point.bodies[c.body_b].twist);
      set_position_impulse(c, speed, solve);
      if (c.restitution_share >= S(0)) {
        ++bouncing;
        apply_at_contact<S>(c, (c.restitution_share - usual_share<S>(integrator)) * c.impulse_W(),
                            by_point.bodies[c.body_a], by_point.bodies[c.body_b], motion_of);
      }
      parting += c.is_separating ? 1 : 0;
    }
    CHECK(parting > 0);
    CHECK((bouncing > 0) == (integrator == Integrator::trapezoidal));
    for (int n = 0; n < 6; ++n) {
      manifolds.sweep_positions(island, by_manifold.constraints, by_manifold.bodies, solve.dt,
                                false);
      points.sweep_positions(island, by_point.constraints, by_point.bodies, solve.dt, false);
    }
    manifolds.finish_positions(island, by_manifold.constraints, by_manifold.bodies);
    check(motion_of);
  }
}

// Some thirty points push a body, with ten roundings each.
TEST_CASE("ManifoldSweeps: positions of what slides start from what the last step needed") {
  const double tolerance = 1000 * std::numeric_limits<double>::epsilon();
  test::Random random(23);
  auto heap = random_heap<double>(random, 40, 120);
  for (auto& c : heap.constraints.contacts) c.restitution = 0;
  const Island island = heap.island();
  SolveContext<double> solve = sweep_context<double>(Integrator::trapezoidal);
  solve.slides = true;
  const std::vector<SolverBody<double>> start = heap.bodies;
  for (const double parts : {1.0, 4.0}) {
    CAPTURE(parts);
    heap.bodies = start;
    for (auto& c : heap.constraints.contacts) c.position_excess = 0;
    SequentialSolver<double> sweeps;
    sweeps.start_manifolds(island, heap.constraints, heap.bodies, parts);
    sweeps.start_part(island, heap.constraints, heap.bodies, solve);
    sweeps.finish(island, heap.bodies);
    const auto place = [&](int count) {
      for (auto& body : heap.bodies) body.motion = body.twist;
      sweeps.start_positions(island, heap.bodies, solve);
      double left = 0;
      for (int n = 0; n < count; ++n) {
        left = sweeps.sweep_positions(island, heap.constraints, heap.bodies, solve.dt, n % 2 != 0);
      }
      sweeps.finish_positions(island, heap.constraints, heap.bodies);
      return left;
    };
    REQUIRE(place(8) > 1e-3);
    const std::vector<SolverBody<double>> placed = heap.bodies;
    // The next substep has the same velocities. The next step does, too.
    for (int again = 0; again < 2; ++again) {
      CHECK(place(0) == 0);
      for (std::size_t i = 0; i < placed.size(); ++i) {
        const Twist<double> error = heap.bodies[i].motion - placed[i].motion;
        const double size = 1 + placed[i].motion.linear.norm() + placed[i].motion.angular.norm();
        CHECK(error.linear.norm() < tolerance * size);
        CHECK(error.angular.norm() < tolerance * size);
      }
      sweeps.start_manifolds(island, heap.constraints, heap.bodies, parts);
      sweeps.start_part(island, heap.constraints, heap.bodies, solve);
      sweeps.finish(island, heap.bodies);
    }
    // What rests starts anew.
    solve.slides = false;
    CHECK(place(1) > 1e-3);
    solve.slides = true;
  }
}

// Points in one plane, of which all press: what the lanes give the bodies is what the impulses do,
// before friction is spread over the points and after. Some thirty points push a body, with ten
// roundings each.
TEST_CASE_TEMPLATE("ManifoldSweeps: impulses in lanes do what impulses do one by one", S, double,
                   float) {
  const S tolerance = 1000 * std::numeric_limits<S>::epsilon();
  test::Random random(29);
  auto heap = random_heap<S>(random, 40, 120);
  for (ContactConstraint<S>& c : heap.constraints.contacts) {
    const Vec3<S> height = c.arm_a.dot(c.axes[0]) * c.axes[0];
    c.arm_a -= height;
    c.arm_b -= height;
    c.restitution = S(0);
    c.friction = S(1000);  // So that no torsion is beyond it.
    c.impulse = {random.uniform(S(0.1), S(0.3)), random.uniform(S(-0.1), S(0.1)),
                 random.uniform(S(-0.1), S(0.1))};
  }
  const Island island = heap.island();
  auto one_by_one = heap;
  ManifoldSweeps<S> sweeps;
  sweeps.start(island, heap.constraints, heap.bodies, S(1));
  sweeps.target(heap.bodies, sweep_context<S>());
  sweeps.apply();
  sweeps.unload(heap.bodies, velocity_of);
  const auto check = [&] {
    apply_impulses(island, one_by_one.constraints, std::span(one_by_one.bodies));
    for (std::size_t i = 0; i < heap.bodies.size(); ++i) {
      CAPTURE(i);
      const Twist<S> error = heap.bodies[i].twist - one_by_one.bodies[i].twist;
      const S size =
          S(1) + heap.bodies[i].twist.linear.norm() + heap.bodies[i].twist.angular.norm();
      CHECK(error.linear.norm() < tolerance * size);
      CHECK(error.angular.norm() < tolerance * size);
    }
  };
  check();
  sweeps.spread_friction();
  sweeps.write_back(island, one_by_one.constraints);
  check();
}

// Without sweeps each part leaves what it started from, and the parts add up to the step.
TEST_CASE("ManifoldSweeps: impulses are divided among the parts of a step, and add up again") {
  test::Random random(23);
  auto heap = random_heap<double>(random, 40, 120);
  for (ContactConstraint<double>& c : heap.constraints.contacts) c.friction = 0;
  const Constraints<double> before = heap.constraints;
  const Island island = heap.island();
  ManifoldSweeps<double> sweeps;
  sweeps.start(island, heap.constraints, heap.bodies, 4.0);
  for (int part = 0; part < 4; ++part) {
    sweeps.target(heap.bodies, sweep_context<double>());
    sweeps.spread_friction();
  }
  sweeps.write_back(island, heap.constraints);
  for (const std::uint32_t i : heap.contacts) {
    CHECK(heap.constraints.contacts[i].impulse[0] == before.contacts[i].impulse[0]);
    CHECK_FALSE(heap.constraints.contacts[i].is_impact);
  }
}

// A manifold of one point has neither lever nor torsion, and is that contact.
TEST_CASE("ManifoldSweeps: a single point is solved as a contact is") {
  test::Random random(11);
  int sticking = 0;
  for (int round = 0; round < 200; ++round) {
    auto pair = test::random_pile<double>(random, 2, 1, random.uniform(0.05, 5.0), 10.0);
    auto expected = pair;
    pair.contacts.erase(pair.contacts.begin());
    ManifoldSweeps<double> sweeps;
    const Island island = pair.island();
    sweeps.start(island, pair.constraints, pair.bodies, 1.0);
    sweeps.target(pair.bodies, sweep_context<double>());
    sweeps.load(pair.bodies, velocity_of);
    sweeps.sweep(false);
    sweeps.unload(pair.bodies, velocity_of);
    sweeps.spread_friction();
    sweeps.write_back(island, pair.constraints);

    ContactConstraint<double>& c = expected.constraints.contacts[1];
    SolverBody<double>& a = expected.bodies[1];
    SolverBody<double>& b = expected.bodies[2];
    target_contact(c, a, b, sweep_context<double>());
    ContactResponse<double> K = contact_response(c, ContactFrame<double>(c, a, b));
    const auto x = solve_contact(c, K, c.velocity(a.twist, b.twist));
    apply_at_contact<double>(c, x[0] * c.axes[0] + x[1] * c.axes[1] + x[2] * c.axes[2], a, b,
                             velocity_of);
    const ContactConstraint<double>& found = pair.constraints.contacts[1];
    for (std::size_t i = 0; i < 3; ++i) {
      CHECK(found.impulse[i] == test::relative(c.impulse[i]).epsilon(1e-12));
    }
    for (std::size_t i = 1; i <= 2; ++i) {
      CHECK((pair.bodies[i].twist.linear - expected.bodies[i].twist.linear).norm() < 1e-13);
      CHECK((pair.bodies[i].twist.angular - expected.bodies[i].twist.angular).norm() < 1e-11);
    }
    const double friction = std::hypot(c.impulse[1], c.impulse[2]);
    if (c.impulse[0] > 0 && friction < 0.999 * c.friction * c.impulse[0]) ++sticking;
  }
  CHECK(sticking > 10);
  CHECK(sticking < 190);
}
