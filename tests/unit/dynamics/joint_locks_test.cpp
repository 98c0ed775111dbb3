// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"

#include <bristle/dynamics/solver/joint_locks.hpp>

#include <Eigen/Dense>
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

using namespace bristle;

using namespace bristle::detail;

namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;

JointLocks locks_of(std::size_t bodies, const std::vector<Edge>& joints,
                    const std::vector<std::uint32_t>& held = {}) {
  JointLocks locks;
  locks.reset(bodies);
  for (const auto& [a, b] : joints) locks.join(a, b);
  for (const std::uint32_t body : held) locks.hold(body);
  locks.finish();
  return locks;
}

/// A hinge between two bodies, or one and the world (`world`): five rows that it locks, and the one
/// that it leaves free.
struct Hinge {
  std::uint32_t a, b;
  Eigen::Vector3d at, axis;
};

/// Bodies of unit mass and inertia in three dimensions, and the space that hinges leave them.
class Mobility {
 public:
  Mobility(std::size_t bodies, const std::vector<Hinge>& hinges,
           const std::vector<Eigen::Vector3d>& places)
      : bodies_(bodies), places_(places) {
    Eigen::MatrixXd locked(5 * hinges.size(), 6 * bodies);
    for (std::size_t k = 0; k < hinges.size(); ++k) {
      const Hinge& h = hinges[k];
      Eigen::Index row = static_cast<Eigen::Index>(5 * k);
      for (int axis = 0; axis < 3; ++axis) {
        locked.row(row++) = point_row(h.a, h.b, h.at, Eigen::Vector3d::Unit(axis));
      }
      const Eigen::Vector3d u = h.axis.unitOrthogonal();
      locked.row(row++) = turn_row(h.a, h.b, u);
      locked.row(row) = turn_row(h.a, h.b, h.axis.cross(u));
    }
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(locked, Eigen::ComputeFullV);
    const double least = 1e-9 * (svd.singularValues().size() ? svd.singularValues()[0] : 1.0);
    Eigen::Index rank = 0;
    for (const double value : svd.singularValues()) rank += value > least ? 1 : 0;
    free_ = svd.matrixV().rightCols(svd.matrixV().cols() - rank);
  }

  /// Velocity of B against A along a direction, at a point in the world.
  [[nodiscard]] Eigen::RowVectorXd point_row(std::uint32_t a, std::uint32_t b,
                                             const Eigen::Vector3d& at,
                                             const Eigen::Vector3d& direction) const {
    Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(static_cast<Eigen::Index>(6 * bodies_));
    const auto add = [&](std::uint32_t body, double sign) {
      if (body >= bodies_) return;
      row.segment<3>(6 * body) = sign * direction.transpose();
      row.segment<3>(6 * body + 3) = sign * (at - places_[body]).cross(direction).transpose();
    };
    add(a, -1);
    add(b, 1);
    return row;
  }
  /// Rate of turn of B against A about an axis.
  [[nodiscard]] Eigen::RowVectorXd turn_row(std::uint32_t a, std::uint32_t b,
                                            const Eigen::Vector3d& axis) const {
    Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(static_cast<Eigen::Index>(6 * bodies_));
    if (a < bodies_) row.segment<3>(6 * a + 3) = -axis.transpose();
    if (b < bodies_) row.segment<3>(6 * b + 3) = axis.transpose();
    return row;
  }
  /// Response of a row that hinges leave, as a part of its own.
  [[nodiscard]] double share(const Eigen::RowVectorXd& row) const {
    return (row * free_).squaredNorm() / row.squaredNorm();
  }

 private:
  std::size_t bodies_;
  std::vector<Eigen::Vector3d> places_;
  Eigen::MatrixXd free_;
};

}  // namespace

TEST_CASE("JointLocks: joints lock contacts within a set, and motors within a loop") {
  // 0 - 1 - 2 float, 3 - 4 hang on the ground, 5 is alone; 6 is the ground.
  JointLocks tree = locks_of(6, {{0, 1}, {1, 2}, {6, 3}, {3, 4}});
  CHECK(tree.may_lock_contact(0, 2));
  CHECK(tree.may_lock_contact(4, tree.ground()));  // A finger that is pushed across its slide.
  CHECK_FALSE(tree.may_lock_contact(2, tree.ground()));
  CHECK_FALSE(tree.may_lock_contact(2, 4));
  CHECK_FALSE(tree.may_lock_contact(5, tree.ground()));
  CHECK_FALSE(tree.may_lock_joint(0, 1));
  CHECK_FALSE(tree.may_lock_joint(3, 4));

  // Loops: through bodies, through the ground, two joints of one pair, and a body with locked axes.
  CHECK(locks_of(3, {{0, 1}, {1, 2}, {2, 0}}).may_lock_joint(0, 1));
  CHECK(locks_of(2, {{2, 0}, {0, 1}, {1, 2}}).may_lock_joint(0, 1));
  CHECK(locks_of(2, {{0, 1}, {0, 1}}).may_lock_joint(0, 1));
  JointLocks held = locks_of(3, {{0, 1}}, {0});
  CHECK(held.may_lock_joint(0, 1));
  CHECK(held.may_lock_contact(1, held.ground()));
  CHECK_FALSE(held.may_lock_contact(1, 2));
}

TEST_CASE("JointLocks: what it calls safe moves, in random mechanisms of hinges") {
  test::Random random(5);
  constexpr std::size_t bodies = 5;
  int safe = 0, locked = 0;
  for (int run = 0; run < 200; ++run) {
    const auto vector = [&] {
      return Eigen::Vector3d(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0),
                             random.uniform(-1.0, 1.0));
    };
    std::vector<Eigen::Vector3d> places(bodies);
    for (Eigen::Vector3d& place : places) place = vector();
    std::vector<Hinge> hinges;
    JointLocks locks;
    locks.reset(bodies);
    const int count = 1 + run % 6;
    for (int k = 0; k < count; ++k) {
      const auto a = static_cast<std::uint32_t>(random.uniform(0.0, 6.0));  // 5 is the ground.
      const auto b = static_cast<std::uint32_t>(random.uniform(0.0, 5.0));
      if (a == b) continue;
      hinges.push_back({a, b, vector(), vector().normalized()});
      locks.join(a, b);
    }
    locks.finish();
    if (hinges.empty()) continue;
    const Mobility mobility(bodies, hinges, places);
    const auto check = [&](bool may_lock, const Eigen::RowVectorXd& row) {
      const double share = mobility.share(row);
      if (!may_lock) CHECK(share > 1e-6);
      ++(may_lock ? locked : safe);
    };
    for (std::uint32_t b = 0; b < bodies; ++b) {
      for (std::uint32_t a = 0; a < b; ++a) {
        check(locks.may_lock_contact(a, b), mobility.point_row(a, b, vector(), vector()));
      }
      check(locks.may_lock_contact(b, locks.ground()),
            mobility.point_row(b, locks.ground(), vector(), vector()));
    }
    for (const Hinge& h : hinges) {
      check(locks.may_lock_joint(h.a, h.b), mobility.turn_row(h.a, h.b, h.axis));
    }
  }
  // Both kinds occur often.
  CHECK(safe > 1000);
  CHECK(locked > 300);
}
