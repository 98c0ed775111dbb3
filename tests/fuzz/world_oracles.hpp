/// @file
/// Invariants of a world after any calls.
///
///   1. A call throws what its docstring names, and a step throws nothing.
///   2. A call that has thrown has changed nothing: `state_hash` is as before.
///   3. After a step no pose, velocity or reading is infinite or NaN.
///   4. A world that is restored, and a copy, step on with the same bits.
///   5. A world that was emptied has nothing left, and is as a new one.
///   6. A step costs no more than `SolverDef` lets it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/bristle.hpp>

#include <cmath>
#include <cstddef>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

namespace bristle::test {

using namespace bristle::detail;

/// One of these does not hold.
class Finding : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

inline void demand(bool holds, const std::string& what) {
  if (!holds) throw Finding(what);
}

template <typename Matrix>
bool is_finite(const Matrix& m) {
  for (Eigen::Index i = 0; i < m.size(); ++i) {
    if (!std::isfinite(m.coeff(i))) return false;
  }
  return true;
}
template <typename S>
bool is_finite(const Wrench<S>& w) {
  return is_finite(w.force) && is_finite(w.torque);
}
template <typename S>
bool is_finite(const Twist<S>& v) {
  return is_finite(v.linear) && is_finite(v.angular);
}

/// 1 and 2, of one call.
/// @return  Whether it was accepted.
template <typename World, typename Call>
bool accepts(const World& world, const std::string& name, const Call& make) {
  const auto before = world.state_hash();
  const std::size_t bodies = world.body_count();
  try {
    make();
    return true;
  } catch (const InvalidArgument& error) {
    demand(!error.field().empty() && !error.rule().empty(),
           name + ": an error without a name: " + error.what());
    demand(world.state_hash() == before && world.body_count() == bodies,
           name + " changed the world and threw " + error.what());
  } catch (const Finding&) {
    throw;
  } catch (const std::exception& error) {
    throw Finding(name + " threw what is not documented: " + error.what());
  }
  return false;
}

/// 3. All handles are of the world.
template <typename S, typename Backend>
void look_at_state(const World<S, Backend>& world, const std::vector<BodyId>& bodies,
                   const std::vector<PatchId>& patches, const std::vector<JointId>& joints) {
  for (const BodyId id : bodies) {
    const Body<S>& body = world.body(id);
    demand(is_finite(body.center_pose.translation) &&
               is_finite(body.center_pose.rotation.coeffs()) && is_finite(body.twist),
           "the state of a body is not finite");
  }
  for (const PatchId id : patches) {
    const PatchReading<S> reading = world.reading(id);
    bool all = is_finite(reading.wrench);
    for (std::size_t i = 0; i < reading.size(); ++i) {
      all = all && std::isfinite(reading.depth[i]) && std::isfinite(reading.normal_force[i]) &&
            std::isfinite(reading.shear_1[i]) && std::isfinite(reading.shear_2[i]);
    }
    demand(all, "the reading of a patch is not finite");
  }
  for (const JointId id : joints) {
    const JointReading<S> reading = world.reading(id);
    demand(std::isfinite(reading.position) && std::isfinite(reading.velocity) &&
               std::isfinite(reading.motor_force) && is_finite(reading.reaction),
           "the reading of a joint is not finite");
  }
  world.for_each_contact([&](const ContactReading<S>& contact) {
    demand(world.contains(contact.body_a) && world.contains(contact.body_b),
           "a contact of a body that is gone");
    demand(is_finite(contact.impulse_on_b()), "the impulse of a contact is not finite");
  });
}

/// 4. Steps copies of a world, one of them there and back.
/// @param start  Snapshot of the world.
template <typename S, typename Backend>
void look_at_copies(const World<S, Backend>& world, const std::vector<std::byte>& start,
                    std::size_t steps) {
  const auto end_of = [steps](World<S, Backend>& copy) {
    for (std::size_t i = 0; i < steps; ++i) copy.step();
    return copy.state_hash();
  };
  World<S, Backend> there_and_back = world;
  const auto end = end_of(there_and_back);
  try {
    there_and_back.restore(start);
  } catch (const InvalidArgument& error) {
    throw Finding(std::string("a world refused its own snapshot: ") + error.what());
  }
  demand(there_and_back.state_hash() == world.state_hash(), "a restored world has another hash");
  demand(end_of(there_and_back) == end, "a restored world steps differently");
  World<S, Backend> copy = world;
  demand(end_of(copy) == end, "a copy steps differently");
}

/// 6. Each island is solved in parts, each part in passes over its sensors, each pass by sweeps or
/// by Newton's steps, and what bounces is solved once more.
template <typename S, typename Backend>
void look_at_cost(const World<S, Backend>& world) {
  const StepReport<S>& report = world.report();
  const SolverDef<S>& solver = world.def().solver;
  const double parts = 1.0 + std::ceil(static_cast<double>(world.time_step()) /
                                       static_cast<double>(solver.longest_substep));
  const double most = 2.0 * static_cast<double>(report.islands) * parts *
                      (1.0 + solver.max_passes) *
                      (solver.max_sweeps + solver.large_sweeps + 2.0 * solver.max_newton_steps);
  demand(static_cast<double>(report.sweeps) <= most &&
             static_cast<double>(report.factorisations) <= most,
         "a step took " + std::to_string(report.sweeps) + " sweeps and " +
             std::to_string(report.factorisations) + " factorisations of " +
             std::to_string(report.islands) + " islands");
}

/// Where a turning box is that was dropped on a floor a moment ago.
template <typename S, typename Backend>
Transform<S> pose_of_dropped_box(World<S, Backend>& world) {
  (void)world.add_body({.motion = Motion::fixed, .shape = HalfSpace<S>{}});
  BodyDef<S> box;
  box.shape = Box<S>{{S(0.1), S(0.2), S(0.1)}};
  box.position = {S(0), S(0), S(0.11)};
  box.angular_velocity = {S(1), S(2), S(0)};
  const BodyId id = world.add_body(box);
  for (int i = 0; i < 3; ++i) world.step();
  return world.pose(id);
}

/// 5, of a world without bodies.
template <typename S, typename Backend>
void look_at_emptied(World<S, Backend>& world) {
  demand(world.body_count() == 0, "an emptied world has bodies");
  world.step();
  world.for_each_contact(
      [](const ContactReading<S>&) { throw Finding("an emptied world has contacts"); });
  const StepReport<S>& report = world.report();
  demand(report.rows == 0 && report.awake_bodies == 0 && report.pairs_tested == 0 &&
             report.patches == 0,
         "an emptied world has work to do");
  demand(!world.cast_ray({{S(0), S(0), S(0)}, {S(0), S(0), S(1)}}).is_hit(),
         "an emptied world has shapes");
  world.set_time_step(S(1) / S(240));
  world.set_gravity({S(0), S(0), S(-9.81)});
  World<S, Backend> fresh(world.def());
  const Transform<S> there = pose_of_dropped_box(world);
  const Transform<S> expected = pose_of_dropped_box(fresh);
  // Slots have other numbers, so contacts are seen from their other side: equal but for rounding.
  const S tolerance = S(100) * Tolerance<S>::round_off();
  demand((there.translation - expected.translation).norm() <= tolerance &&
             (there.rotation.coeffs() - expected.rotation.coeffs()).norm() <= tolerance,
         "an emptied world is not as a new one");
}

}  // namespace bristle::test
