/// @file
/// The law and the placement of sensors with their derivatives, against closed forms and against
/// differences.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/body_motion.hpp"
#include "support/relative.hpp"

#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/math/dual.hpp>
#include <bristle/math/rotation.hpp>
#include <bristle/sensors/law.hpp>
#include <bristle/sensors/placement.hpp>
#include <bristle/sensors/sensor_wrench.hpp>
#include <bristle/sensors/tuning.hpp>

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>

using namespace bristle;

namespace {

/// Inputs of a sensor's force, in the order of its variables.
enum Input : std::size_t { K_N, K_D, mu_S, mu_V, sigma, distance, slip, speed, press, inputs };
using Derived = Dual<double, inputs>;

constexpr double ray_length = 0.01;

/// Force on A of a ray along x that was anchored on a wall, after the wall has moved along -y.
template <typename S>
Vec3<S> force_after_slip(const std::array<S, inputs>& x, SlipReset reset) {
  const SensorParameters<S> p{x[K_N], x[K_D], x[mu_S], x[mu_V], x[sigma]};
  LawOptions options;
  options.reset = reset;
  const Ray<S> ray{Vec3<S>::Zero(), Vec3<S>::UnitX(), S(ray_length)};
  const Vec3<S> normal = -Vec3<S>::UnitX();
  SensorMemory<S> memory;
  test::BodyMotion<S> A, B;
  (void)sensor_wrench<S>(p, options, ray, x[distance], normal, A.pose, A.twist, B.pose, B.twist,
                         S(1e-3), memory);
  A.twist.linear = {x[press], x[speed], S(0)};
  B.pose.translation.y() = -x[slip];
  return sensor_wrench<S>(p, options, ray, x[distance], normal, A.pose, A.twist, B.pose, B.twist,
                          S(1e-3), memory)
      .force;
}

std::array<Derived, inputs> as_variables(const std::array<double, inputs>& x) {
  std::array<Derived, inputs> result;
  for (std::size_t i = 0; i < inputs; ++i) result[i] = Derived::variable(x[i], i);
  return result;
}

}  // namespace

TEST_CASE("sensor_wrench: a bristle that sticks has the derivatives of Eqs. 1, 3 and 5") {
  const std::array<double, inputs> x{20, 0.05, 800, 1.5, 1e-3, 0.004, 4e-4, 0.03, 0.02};
  for (const SlipReset reset : {SlipReset::release, SlipReset::drag}) {
    const Vec3<Derived> f = force_after_slip<Derived>(as_variables(x), reset);
    const double e = 1 - x[distance] / ray_length;
    const double F_N = x[K_N] * e + x[K_D] * x[press] / ray_length;
    const auto near = [](double value) { return test::relative(value).epsilon(1e-12); };
    CHECK(f.x().value() == near(-F_N));
    CHECK(f.y().value() == near(-x[mu_S] * F_N * x[slip] - x[mu_V] * x[speed]));
    // Along the ray, and across it through F_N.
    const double shear_per_load = x[mu_S] * x[slip];
    std::array<double, inputs> by{};
    by[K_N] = e;
    by[K_D] = x[press] / ray_length;
    by[distance] = -x[K_N] / ray_length;
    by[press] = x[K_D] / ray_length;
    for (std::size_t i = 0; i < inputs; ++i) CHECK(f.x().partial(i) == near(-by[i]));
    for (double& slope : by) slope *= shear_per_load;
    by[mu_S] = F_N * x[slip];
    by[slip] = x[mu_S] * F_N;
    by[mu_V] = x[speed];
    by[speed] = x[mu_V];
    for (std::size_t i = 0; i < inputs; ++i) {
      INFO("variable ", i);
      CHECK(f.y().partial(i) == near(-by[i]));
      CHECK(f.z().partial(i) == 0);
    }
  }
}

TEST_CASE("sensor_wrench: a bristle that slips has the derivatives of its reset") {
  // Dragged along at sigma_a, or let go once: what is left of the stretch is slip - sigma_a.
  const std::array<double, inputs> x{20, 0, 800, 0, 1e-3, 0.004, 1.3e-3, 0, 0};
  const double F_N = 20 * 0.6;
  const Vec3<Derived> dragged = force_after_slip<Derived>(as_variables(x), SlipReset::drag);
  CHECK(dragged.y().value() == test::relative(-800 * F_N * 1e-3).epsilon(1e-12));
  CHECK(dragged.y().partial(sigma) == test::relative(-800 * F_N).epsilon(1e-12));
  CHECK(std::abs(dragged.y().partial(slip)) < 1e-9);
  const Vec3<Derived> released = force_after_slip<Derived>(as_variables(x), SlipReset::release);
  CHECK(released.y().value() == test::relative(-800 * F_N * 0.3e-3).epsilon(1e-12));
  CHECK(released.y().partial(sigma) == test::relative(800 * F_N).epsilon(1e-12));
  CHECK(released.y().partial(slip) == test::relative(-800 * F_N).epsilon(1e-12));
}

TEST_CASE("sensor_wrench: without a hit, or unloaded, derivatives are 0 and never NaN") {
  std::array<double, inputs> x{20, 0.05, 800, 1.5, 1e-3, 0.02, 0, 0, 0};
  CHECK(force_after_slip<Derived>(as_variables(x), SlipReset::release).isZero(Derived(0)));
  // Anchored and at rest: stretch and speed have no length, but do grow with what they depend on.
  x[distance] = 0.004;
  const Vec3<Derived> f = force_after_slip<Derived>(as_variables(x), SlipReset::drag);
  for (std::size_t i = 0; i < inputs; ++i) {
    CHECK(std::isfinite(f.x().partial(i)));
    CHECK(std::isfinite(f.y().partial(i)));
  }
  CHECK(f.y().partial(slip) == test::relative(-800 * 20 * 0.6));
}

namespace {

/// Force and torque of an oblique ray between two turned bodies that move, after two steps, by
/// three numbers that enter everywhere.
template <typename S>
std::array<S, 6> oblique(S a, S b, S c, NormalDirection normal) {
  const SensorParameters<S> p{S(30) * a, S(0.1) * b, S(700) * c, S(2) * a * b, S(2e-3) * c};
  LawOptions options;
  options.normal = normal;
  const Vec3<S> direction = Vec3<S>(S(2), a, b * c).normalized();
  const Ray<S> ray{Vec3<S>(S(0.01) * a, S(0.02) * b, S(-0.01) * c), direction, S(0.012) * b};
  const Vec3<S> face = Vec3<S>(S(-2), S(0.3) * b, S(-0.4) * a).normalized();
  SensorMemory<S> memory;
  Wrench<S> wrench;
  for (const S t : {S(0), S(1)}) {
    test::BodyMotion<S> A, B;
    A.pose.rotation = exp_rotation<S>(Vec3<S>(S(0.3) * a, S(0.02) * b * t, S(-0.7)));
    A.pose.translation = Vec3<S>(S(0.4), S(0.1) * c, S(2e-4) * t * b);
    A.twist = {Vec3<S>(S(0.02) * b, S(0.03), S(-0.01) * c), Vec3<S>(S(0.2) * a, S(0.1), S(0.3))};
    B.pose.rotation = exp_rotation<S>(Vec3<S>(S(0.1), S(0.2) * c, S(0.4) * b));
    B.pose.translation = Vec3<S>(S(0.41), S(1e-4) * t * a, S(0));
    B.twist = {Vec3<S>(S(0), S(0.01) * a, S(0)), Vec3<S>(S(0), S(0.5) * b, S(0))};
    const Vec3<S> m_W = A.pose.rotation * face;
    wrench = sensor_wrench<S>(p, options, ray, S(0.005) * a * c, m_W, A.pose, A.twist, B.pose,
                              B.twist, S(1e-3), memory);
  }
  return {wrench.force.x(),  wrench.force.y(),  wrench.force.z(),
          wrench.torque.x(), wrench.torque.y(), wrench.torque.z()};
}

}  // namespace

TEST_CASE("sensor_wrench: derivatives agree with differences between turned and moving bodies") {
  // Central differences: h^2 from the third derivative, 1e-16 / h from rounding; 1e-9 for h = 1e-5.
  using D3 = Dual<double, 3>;
  const double h = 1e-5;
  const std::array<double, 3> x{1.1, 0.9, 1.05};
  for (const NormalDirection normal : {NormalDirection::ray, NormalDirection::gradient}) {
    const auto f =
        oblique<D3>(D3::variable(x[0], 0), D3::variable(x[1], 1), D3::variable(x[2], 2), normal);
    const auto value = oblique<double>(x[0], x[1], x[2], normal);
    // Eigen has registers for products of doubles, which add in another order.
    for (std::size_t k = 0; k < 6; ++k) {
      CHECK(f[k].value() == test::relative(value[k]).epsilon(1e-13));
    }
    REQUIRE(std::abs(value[1]) > 1e-3);
    for (std::size_t i = 0; i < 3; ++i) {
      auto above = x;
      auto below = x;
      above[i] += h;
      below[i] -= h;
      const auto high = oblique<double>(above[0], above[1], above[2], normal);
      const auto low = oblique<double>(below[0], below[1], below[2], normal);
      for (std::size_t k = 0; k < 6; ++k) {
        INFO("variable ", i, ", component ", k);
        const double size = k < 3 ? 10 : 1;
        CHECK(std::abs(f[k].partial(i) - (high[k] - low[k]) / (2 * h)) < 1e-6 * size);
      }
    }
  }
}

TEST_CASE("sensors_from_mesh: sensors move with what places them") {
  // Of a cube that grows by k, at a depth and turned by an angle about z at the origin.
  using D3 = Dual<double, 3>;
  const D3 k = D3::variable(1, 0);
  TriangleMesh<D3> mesh = box_mesh<D3>({k * 0.03, k * 0.02, k * 0.01});
  PlacementDef<D3> def;
  def.depth = D3::variable(0.004, 1);
  def.range = 2 * def.depth;
  def.vertices = def.edges = true;
  def.X_AM.rotation = exp_rotation<D3>({D3(0), D3(0), D3::variable(0.4, 2)});
  const SensorLayout<D3> layout = sensors_from_mesh(mesh, def);
  REQUIRE(layout.size() > 30);
  for (std::size_t i = 0; i < layout.size(); ++i) {
    INFO("sensor ", i);
    const Vec3<double> start = layout.start[i].cast<double>();
    const Vec3<double> n = layout.direction[i].cast<double>();
    const Vec3<double> surface = start + 0.004 * n;
    const Vec3<double> axis = Vec3<double>::UnitZ();
    for (Eigen::Index j = 0; j < 3; ++j) {
      const D3 p = layout.start[i][j];
      CHECK(p.partial(0) == test::relative(surface[j]).epsilon(1e-12));
      CHECK(p.partial(1) == test::relative(-n[j]).epsilon(1e-12));
      CHECK(p.partial(2) == test::relative(axis.cross(start)[j]).epsilon(1e-12));
      const D3 direction = layout.direction[i][j];
      CHECK(std::abs(direction.partial(0)) < 1e-12);
      CHECK(direction.partial(2) == test::relative(axis.cross(n)[j]).epsilon(1e-12));
    }
    CHECK(layout.length[i].partial(1) == 2);
  }
}

TEST_CASE("tuned_for: constants have the derivatives of their closed forms") {
  // K_N = N / (n e), mu_S = mu / creep, mu_V = (2 z / n) sqrt(mu_S N m).
  using D2 = Dual<double, 2>;
  GripSpec<D2> spec;
  spec.friction = D2::variable(0.8, 0);
  spec.load = D2::variable(20, 1);
  spec.mass = 0.5;
  const SensorParameters<D2> p = tuned_for(spec).parameters(25, 0.01);
  CHECK(p.normal_stiffness.partial(1) == test::relative(1 / (25 * 0.3)).epsilon(1e-13));
  CHECK(p.static_friction.partial(0) == test::relative(1e3).epsilon(1e-13));
  const double mu_V = p.sliding_friction.value();
  CHECK(mu_V == test::relative(1.4 / 25 * std::sqrt(800 * 20 * 0.5)).epsilon(1e-13));
  CHECK(p.sliding_friction.partial(0) == test::relative(mu_V / 2 / 0.8).epsilon(1e-13));
  CHECK(p.sliding_friction.partial(1) == test::relative(mu_V / 2 / 20).epsilon(1e-13));
}
