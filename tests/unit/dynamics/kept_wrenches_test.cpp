// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"

#include <bristle/dynamics/contacts/kept_wrenches.hpp>

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

using namespace bristle;

using namespace bristle::detail;

namespace {

constexpr double wrench_step = 1.0 / 240;

/// Two bodies, and one manifold of four points with load and friction.
class Manifold {
 public:
  explicit Manifold(test::Random& random) : bodies_(2) {
    for (SolverBody<double>& body : bodies_) {
      body.moves = true;
      body.start.angular = random.in_cube(0.1);
    }
    const Vec3<double> normal = random.direction<double>();
    const Vec3<double> center_b = random.in_cube(1.0);
    island_.bodies = slots_;
    island_.contacts = slots_;
    for (std::uint32_t i = 0; i < 4; ++i) {
      ContactConstraint<double> c;
      c.body_a = 0;
      c.body_b = 1;
      c.point = i;
      c.axes[0] = normal;
      tangent_basis<double>(normal, c.axes[1], c.axes[2]);
      const double u = i == 0 || i == 3 ? -0.1 : 0.1;
      const double v = i < 2 ? -0.15 : 0.15;
      c.arm_a = 0.2 * normal + (u + random.uniform(-0.02, 0.02)) * c.axes[1] + v * c.axes[2];
      c.arm_b = c.arm_a - center_b;
      c.friction = 0.5;
      c.impulse = {random.uniform(1.0, 2.0), random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3)};
      constraints_.contacts.push_back(c);
      CachedPoint<double> point;
      point.mid_offset_a = 0.5 * wrench_step * bodies_[0].start.angular.cross(c.arm_a);
      point.mid_offset_b = 0.5 * wrench_step * bodies_[1].start.angular.cross(c.arm_b);
      points_.push_back(point);
    }
  }

  /// Says that a point moved along its bodies in the last step.
  void move(std::size_t i, const Vec3<double>& by_a, const Vec3<double>& by_b) {
    points_[i].mid_offset_a += 0.5 * by_a;
    points_[i].mid_offset_b += 0.5 * by_b;
  }
  void keep() { keep_wrenches<double>(island_, constraints_, points_, bodies_, wrench_step); }

  /// [N s, N m s] Force and torque about the centre of A that the points gave at their places of
  /// the last step, but for its rotation.
  [[nodiscard]] std::array<Vec3<double>, 2> wrench(bool at_last_places) const {
    std::array<Vec3<double>, 2> sum{Vec3<double>::Zero(), Vec3<double>::Zero()};
    for (std::size_t i = 0; i < 4; ++i) {
      const ContactConstraint<double>& c = constraints_.contacts[i];
      Vec3<double> arm = c.arm_a;
      if (at_last_places) {
        arm -= 2 * points_[i].mid_offset_a - wrench_step * bodies_[0].start.angular.cross(c.arm_a);
      }
      sum[0] += c.impulse_W();
      sum[1] += arm.cross(c.impulse_W());
    }
    return sum;
  }
  [[nodiscard]] const ContactConstraint<double>& contact(std::size_t i) const {
    return constraints_.contacts[i];
  }
  [[nodiscard]] ContactConstraint<double>& contact(std::size_t i) {
    return constraints_.contacts[i];
  }

 private:
  std::vector<SolverBody<double>> bodies_;
  std::array<std::uint32_t, 4> slots_{0, 1, 2, 3};
  Island island_;
  Constraints<double> constraints_;
  std::vector<CachedPoint<double>> points_;
};

}  // namespace

TEST_CASE(
    "kept_wrenches: points that move along their bodies leave force and torque as they were") {
  test::Random random(1);
  for (int n = 0; n < 100; ++n) {
    Manifold manifold(random);
    for (const std::size_t i : {1u, 2u}) {
      const Vec3<double> shift = random.uniform(-0.03, 0.03) * manifold.contact(i).axes[1] +
                                 random.uniform(-0.03, 0.03) * manifold.contact(i).axes[2];
      manifold.move(i, shift, shift);
    }
    const auto before = manifold.wrench(true);
    manifold.keep();
    const auto after = manifold.wrench(false);
    CHECK((after[0] - before[0]).norm() < 1e-14);
    // Friction lies in the plane of the points, so its torque has the part about the normal and
    // what the plane's distance from the centre makes of its force.
    CHECK((after[1] - before[1]).norm() < 1e-14);
  }
}

TEST_CASE("kept_wrenches: points that stay on one body keep their impulses") {
  test::Random random(2);
  for (int n = 0; n < 100; ++n) {
    Manifold manifold(random);
    const bool slides_on_a = n % 2 == 0;
    std::array<std::array<double, 3>, 4> before{};
    for (std::size_t i = 0; i < 4; ++i) {
      // A slide of 1 m/s.
      const Vec3<double> shift = wrench_step * manifold.contact(i).axes[1];
      manifold.move(i, slides_on_a ? shift : Vec3<double>::Zero(),
                    slides_on_a ? Vec3<double>::Zero() : shift);
      before[i] = manifold.contact(i).impulse;
    }
    manifold.keep();
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        CHECK(std::abs(manifold.contact(i).impulse[k] - before[i][k]) < 1e-15);
      }
    }
  }
}

TEST_CASE("kept_wrenches: loads do not become negative, and points on a line keep theirs") {
  test::Random random(3);
  Manifold manifold(random);
  manifold.contact(0).impulse = {1e-6, 0, 0};
  const Vec3<double> shift = -0.05 * manifold.contact(1).axes[1];
  manifold.move(1, shift, shift);
  manifold.keep();
  for (std::size_t i = 0; i < 4; ++i) CHECK(manifold.contact(i).impulse[0] >= 0);

  Manifold line(random);
  for (const std::size_t i : {0u, 1u}) line.contact(i).impulse = {0, 0, 0};
  const auto before = line.contact(2).impulse;
  line.move(2, shift, shift);
  line.keep();
  CHECK(line.contact(2).impulse == before);
  CHECK(line.contact(0).impulse[0] == 0);
}
