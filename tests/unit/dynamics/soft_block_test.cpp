// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"

#include <bristle/dynamics/solver/proximal_solver.hpp>
#include <bristle/dynamics/solver/sequential_solver.hpp>

#include <doctest/doctest.h>

#include <vector>

using namespace bristle;

using namespace bristle::detail;

namespace {

/// Two free bodies with a random soft block between them.
struct SoftPair {
  std::vector<SolverBody<double>> bodies{2};
  Constraints<double> constraints;
};

SoftPair random_pair(test::Random& random) {
  SoftPair pair;
  for (SolverBody<double>& body : pair.bodies) {
    body.mass = random.uniform(0.5, 3.0);
    body.inverse_mass.setConstant(1 / body.mass);
    body.moves = true;
    const Mat3<double> R = random.rotation<double>().toRotationMatrix();
    body.inertia = R * Vec3<double>(0.02, 0.03, 0.04).asDiagonal() * R.transpose();
    body.inverse_inertia = body.inertia.inverse();
    body.free = {random.in_cube(1.0), random.in_cube(3.0)};
    body.twist = body.free;
  }
  SoftBlock<double> soft;
  soft.body_a = 0;
  soft.body_b = 1;
  soft.arm_a = random.in_cube(0.1);
  soft.arm_b = random.in_cube(0.1);
  Mat6<double> G;
  for (Eigen::Index i = 0; i < 36; ++i) G(i / 6, i % 6) = random.uniform(-1.0, 1.0);
  soft.matrix = G * G.transpose();
  for (Eigen::Index i = 0; i < 6; ++i) soft.offset[i] = random.uniform(-1.0, 1.0);
  pair.constraints.soft.push_back(soft);
  return pair;
}

const std::uint32_t both[] = {0, 1};
const std::uint32_t only[] = {0};
const Island island{both, {}, {}, only};

SolveContext<double> soft_context() {
  SolveContext<double> c;
  c.dt = 1e-3;
  c.velocity_tolerance = 1e-10;
  return c;
}

/// How far the solution is from p = offset + matrix u, and from M (v - v_free) = J^T p.
double residual(const SoftPair& pair) {
  const SoftBlock<double>& s = pair.constraints.soft[0];
  const Vec6<double> u = relative_motion(s, pair.bodies[0].twist, pair.bodies[1].twist);
  double worst = (s.impulse - s.offset - s.matrix * u).norm();
  const Vec3<double> force = s.impulse.head<3>();
  const Vec3<double> torque = s.impulse.tail<3>();
  for (int k = 0; k < 2; ++k) {
    const SolverBody<double>& b = pair.bodies[static_cast<std::size_t>(k)];
    const double sign = k == 0 ? -1 : 1;
    const Vec3<double> arm = k == 0 ? s.arm_a : s.arm_b;
    worst = std::max(
        {worst, (b.mass * (b.twist.linear - b.free.linear) - sign * force).norm(),
         (b.inertia * (b.twist.angular - b.free.angular) - sign * (torque + arm.cross(force)))
             .norm()});
  }
  return worst;
}

}  // namespace

TEST_CASE("mobility: turns an impulse at a point into the change of motion there") {
  test::Random random(1);
  for (int i = 0; i < 20; ++i) {
    SoftPair pair = random_pair(random);
    SolverBody<double>& b = pair.bodies[0];
    const Vec3<double> arm = random.in_cube(0.2);
    Vec6<double> p;
    p << random.in_cube(1.0), random.in_cube(1.0);
    const Vec6<double> change = mobility(b.inverse_mass, b.inverse_inertia, arm) * p;
    const Twist<double> before = b.twist;
    const Vec3<double> force = p.head<3>();
    b.apply_impulse(b.twist, force, p.tail<3>() + arm.cross(force));
    CHECK((b.twist.at(arm) - before.at(arm) - change.head<3>()).norm() < 1e-12);
    CHECK((b.twist.angular - before.angular - change.tail<3>()).norm() < 1e-12);
  }
}

TEST_CASE("ProximalSolver and SequentialSolver: both solve a soft block exactly, and agree") {
  test::Random random(2);
  for (int i = 0; i < 20; ++i) {
    const SoftPair start = random_pair(random);
    SoftPair direct = start;
    ProximalSolver<double> solver;
    SolveReport<double> report;
    CHECK(solver.solve(island, direct.constraints, direct.bodies, soft_context(), report) < 1e-12);
    apply_impulses<double>(island, direct.constraints, direct.bodies);
    CHECK(residual(direct) < 1e-11);
    SoftPair swept = start;
    SequentialSolver<double> sequential;
    sequential.start(island, swept.constraints, swept.bodies);
    // One block alone is solved by its first sweep.
    sequential.sweep(island, swept.constraints, swept.bodies, false);
    CHECK(sequential.sweep(island, swept.constraints, swept.bodies, true) < 1e-12);
    CHECK(residual(swept) < 1e-12);
    for (std::size_t k = 0; k < 2; ++k) {
      CHECK((direct.bodies[k].twist.linear - swept.bodies[k].twist.linear).norm() < 1e-12);
      CHECK((direct.bodies[k].twist.angular - swept.bodies[k].twist.angular).norm() < 1e-11);
    }
  }
}

TEST_CASE("ProximalSolver: a body that does not move enters with its motion") {
  test::Random random(3);
  SoftPair pair = random_pair(random);
  pair.bodies[1].mass = 0;
  pair.bodies[1].inverse_mass.setZero();
  pair.bodies[1].moves = false;
  pair.bodies[1].inertia.setZero();
  pair.bodies[1].inverse_inertia.setZero();
  const std::uint32_t first[] = {0};
  const Island alone{first, {}, {}, only};
  ProximalSolver<double> solver;
  SolveReport<double> report;
  CHECK(solver.solve(alone, pair.constraints, pair.bodies, soft_context(), report) < 1e-12);
  apply_impulses<double>(alone, pair.constraints, pair.bodies);
  const SoftBlock<double>& s = pair.constraints.soft[0];
  const Vec6<double> u = relative_motion(s, pair.bodies[0].twist, pair.bodies[1].free);
  CHECK((s.impulse - s.offset - s.matrix * u).norm() < 1e-12);
  CHECK((pair.bodies[0].mass * (pair.bodies[0].twist.linear - pair.bodies[0].free.linear) +
         s.impulse.head<3>())
            .norm() < 1e-12);
}

TEST_CASE("ProximalSolver: refuses what is not finite, and changes nothing") {
  test::Random random(4);
  SoftPair pair = random_pair(random);
  pair.constraints.soft[0].matrix(0, 0) = std::numeric_limits<double>::quiet_NaN();
  const Vec6<double> before = pair.constraints.soft[0].impulse;
  ProximalSolver<double> solver;
  SolveReport<double> report;
  CHECK_FALSE(solver.solve(island, pair.constraints, pair.bodies, soft_context(), report) <
              infinity<double>);
  CHECK(pair.constraints.soft[0].impulse == before);
}
