/// @file
/// Sensors take from one body what they give to the other, and their readings are what they gave.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/plate.hpp"
#include "support/momentum.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <random>

using namespace bristle;

using namespace bristle::detail;
using namespace bristle::scenes;
using test::momentum_of;

namespace {

/// How a step is solved.
enum class Way { explicit_, direct, sequential };
constexpr Way ways[] = {Way::explicit_, Way::direct, Way::sequential};

/// A box with sensors on one face flies into another body, off centre and turning, without gravity.
struct Collision {
  World<double> world;
  std::array<BodyId, 2> bodies{};
  PatchId patch{};
};

Collision make_impact(Way way, const Shape<double>& target, const LawOptions& options = {}) {
  WorldDef<double> world_def;
  world_def.gravity.setZero();
  world_def.time_step = 1e-3;
  if (way == Way::sequential) world_def.solver.max_direct_work = 0;
  Collision c{World<double>(world_def), {}, {}};
  // Away from the origin, so that moments about it are a real check.
  const Vec3<double> place(1.5, -0.7, 2.1);
  BodyDef<double> a;
  a.mass = 0.4;
  a.shape = Box<double>{{0.05, 0.04, 0.03}};
  a.filter.mask = 0;  // They touch by sensors only.
  a.position = place;
  a.velocity = {0.05, 0.02, -0.4};
  a.angular_velocity = {0.7, -1.1, 0.5};
  BodyDef<double> b;
  b.mass = 1.3;
  b.shape = target;
  b.filter.mask = 0;
  b.position = place + Vec3<double>(0.004, -0.006, -0.073);
  b.velocity = {-0.2, 0.1, 0.3};
  b.angular_velocity = {-0.4, 0.3, 2.0};
  c.bodies = {c.world.add_body(a), c.world.add_body(b)};
  PatchDef<double> patch;
  for (int i = -2; i <= 2; ++i) {
    for (int j = -2; j <= 2; ++j) {
      // Rays fan out, so that they meet even a plane obliquely.
      const Vec3<double> direction = Vec3<double>(0.1 * i, 0.15 * j, -1).normalized();
      patch.sensors.add({0.015 * i, 0.012 * j, -0.02}, direction, 0.02);
    }
  }
  patch.parameters = {4, 0.02, 3000, 0.3, 1e-3};
  patch.options = options;
  patch.integration = way == Way::explicit_ ? Integration::explicit_ : Integration::implicit;
  c.patch = c.world.add_patch(c.bodies[0], patch);
  return c;
}

const Shape<double> targets[] = {Box<double>{{0.06, 0.06, 0.04}}, Sphere<double>{0.04}};

/// Difference of the change of momenta in a step of a collision from its readings [N s, N m s].
double step_and_compare(Collision& c) {
  const double dt = c.world.time_step();
  const Body<double> a = c.world.body(c.bodies[0]);
  const Body<double> b = c.world.body(c.bodies[1]);
  c.world.step();
  const Body<double>& a1 = c.world.body(c.bodies[0]);
  const Body<double>& b1 = c.world.body(c.bodies[1]);
  const Wrench<double> reading = c.world.reading(c.patch).wrench;
  const Vec3<double> p_BA = a.center_pose.translation - b.center_pose.translation;
  const Wrench<double> on_b = -reading.shifted(Vec3<double>(-p_BA));
  return std::max({(a.mass * (a1.twist.linear - a.twist.linear) - dt * reading.force).norm(),
                   (a1.angular_momentum() - a.angular_momentum() - dt * reading.torque).norm(),
                   (b.mass * (b1.twist.linear - b.twist.linear) - dt * on_b.force).norm(),
                   (b1.angular_momentum() - b.angular_momentum() - dt * on_b.torque).norm()});
}

/// Rays all around a box of 10 cm, oblique by up to a quarter of a radian.
SensorLayout<double> oblique_skin(std::mt19937& random) {
  std::uniform_real_distribution<double> tilt(-0.3, 0.3);
  SensorLayout<double> skin;
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {-1, 1}) {
      for (int i = -2; i <= 2; ++i) {
        for (int j = -2; j <= 2; ++j) {
          Vec3<double> start, along;
          start[axis] = 0.044 * side;
          start[(axis + 1) % 3] = 0.018 * i;
          start[(axis + 2) % 3] = 0.018 * j;
          along[axis] = side;
          along[(axis + 1) % 3] = tilt(random);
          along[(axis + 2) % 3] = tilt(random);
          skin.add(start, along.normalized(), 0.02);
        }
      }
    }
  }
  return skin;
}

/// Two bodies that tumble into each other, one of them with sensors all around.
Collision make_random_impact(std::mt19937& random, double dt, NormalDirection normal) {
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto vector = [&](double size) {
    const double x = unit(random), y = unit(random), z = unit(random);
    return Vec3<double>(size * x, size * y, size * z);
  };
  WorldDef<double> world_def;
  world_def.gravity.setZero();
  world_def.time_step = dt;
  Collision c{World<double>(world_def), {}, {}};
  BodyDef<double> a;
  a.mass = 0.3;
  a.shape = Box<double>{{0.05, 0.05, 0.05}};
  a.filter.mask = 0;
  a.orientation = exp_rotation<double>(vector(3));
  a.velocity = vector(0.2);
  a.angular_velocity = vector(2);
  BodyDef<double> b;
  b.mass = 0.8;
  b.shape = unit(random) < 0 ? targets[0] : targets[1];
  b.filter.mask = 0;
  const Vec3<double> along = vector(1).normalized();
  b.position = 0.135 * along;
  b.velocity = -0.6 * along;
  b.angular_velocity = vector(3);
  c.bodies = {c.world.add_body(a), c.world.add_body(b)};
  PatchDef<double> patch;
  patch.sensors = oblique_skin(random);
  patch.parameters = {4, 0.01, 2000, 0.2, 1e-3};
  patch.options.normal = normal;
  patch.integration = Integration::implicit;
  c.patch = c.world.add_patch(c.bodies[0], patch);
  return c;
}

}  // namespace

TEST_CASE("conservation: sensors keep momentum, also about the world's origin (R17)") {
  for (const Way way : ways) {
    for (const Shape<double>& target : targets) {
      for (const NormalDirection normal : {NormalDirection::ray, NormalDirection::gradient}) {
        for (const SlipReset reset : {SlipReset::release, SlipReset::drag}) {
          LawOptions options;
          options.normal = normal;
          options.reset = reset;
          Collision c = make_impact(way, target, options);
          const std::span<const BodyId> bodies(c.bodies);
          const Wrench<double> before = momentum_of(c.world, bodies);
          double exchanged = 0;
          std::uint64_t slipped = 0;
          for (int i = 0; i < 600; ++i) {
            c.world.step();
            exchanged += c.world.reading(c.patch).wrench.force.norm() * 1e-3;
            slipped += c.world.reading(c.patch).slipping();
          }
          REQUIRE(exchanged > 0.1);
          REQUIRE(slipped > 0);
          const Wrench<double> after = momentum_of(c.world, bodies);
          // Arms about the origin are up to 3 m, so moments are of the same size as impulses.
          CHECK((after.force - before.force).norm() < 1e-12 * exchanged);
          CHECK((after.torque - before.torque).norm() < 3e-12 * exchanged);
        }
      }
    }
  }
}

TEST_CASE("conservation: readings are the change of momentum, in every step") {
  for (const Way way : ways) {
    for (const Shape<double>& target : targets) {
      Collision c = make_impact(way, target);
      double worst = 0;
      double largest = 0;
      for (int i = 0; i < 600; ++i) {
        worst = std::max(worst, step_and_compare(c));
        largest = std::max(largest, 1e-3 * c.world.reading(c.patch).wrench.force.norm());
      }
      REQUIRE(largest > 1e-4);
      // Momenta of 0.4 N s are known to 1e-16, whatever the size of the step's change.
      CHECK(worst < 1e-15);
    }
  }
}

TEST_CASE("conservation: readings are the change of momentum where touches begin and end, too") {
  std::mt19937 random(3);
  int touched = 0;
  for (int trial = 0; trial < 200; ++trial) {
    for (const double dt : {1e-3, 1.0 / 240, 1.0 / 60}) {
      for (const NormalDirection normal : {NormalDirection::ray, NormalDirection::gradient}) {
        Collision c = make_random_impact(random, dt, normal);
        CAPTURE(trial);
        CAPTURE(dt);
        double worst = 0;
        for (int i = 0; i < 12; ++i) {
          worst = std::max(worst, step_and_compare(c));
          touched += c.world.reading(c.patch).touching() > 0 ? 1 : 0;
        }
        // Momenta of half a newton second, and arms of a tenth of a metre.
        CHECK(worst < 1e-15);
      }
    }
  }
  CHECK(touched > 1000);
}

TEST_CASE("conservation: with gravity and hard contact, all that acts adds up") {
  for (const Integration integration : {Integration::explicit_, Integration::implicit}) {
    PlateDef<double> def;
    def.per_side = 2;
    def.has_contact = true;
    def.integration = integration;
    def.drop = 0.003;
    def.incline = 0.6;
    auto scene = make_plate<double>(def);
    scene.world.set_velocity(scene.plate, {{0.1, 0.3, 0}, {0.2, -0.1, 1}});
    double worst = 0;
    for (int i = 0; i < 500; ++i) {
      const Vec3<double> before = scene.world.body(scene.plate).twist.linear;
      scene.world.step();
      Vec3<double> impulse = def.mass * scene.world.def().gravity * def.time_step +
                             scene.world.reading(scene.patch).wrench.force * def.time_step;
      for (const auto& manifold : scene.world.contacts().manifolds()) {
        // From the plane, which was added first, to the plate; no friction here.
        for (std::uint32_t k = 0; k < manifold.count; ++k) {
          impulse +=
              scene.world.contacts().points()[manifold.first + k].impulse[0] * manifold.normal;
        }
      }
      const Vec3<double> change = def.mass * (scene.world.body(scene.plate).twist.linear - before);
      worst = std::max(worst, (change - impulse).norm());
    }
    CHECK(worst < 1e-15);
  }
}

TEST_CASE("conservation: readings of each sensor add up to those of the patch") {
  for (const Way way : ways) {
    Collision c = make_impact(way, targets[1]);
    for (int i = 0; i < 200; ++i) {
      const Transform<double> X = c.world.pose(c.bodies[0]);
      c.world.step();
      const auto r = c.world.reading(c.patch);
      Wrench<double> sum;
      Vec3<double> shear = Vec3<double>::Zero();
      const SensorPatch<double>& patch = c.world.patch(c.patch);
      for (std::size_t k = 0; k < r.size(); ++k) {
        Vec3<double> t1, t2;
        tangent_basis<double>(patch.geometry->direction[k], t1, t2);
        const Vec3<double> across = X.rotate(r.shear_1[k] * t1 + r.shear_2[k] * t2);
        const Vec3<double> force = across - X.rotate(r.normal_force[k] * patch.geometry->direction[k]);
        const Vec3<double> point(r.point_x[k], r.point_y[k], r.point_z[k]);
        shear += across;
        if (r.state[k] != SensorState::free)
          sum += Wrench<double>::at(point - X.translation, force);
      }
      CHECK((sum.force - r.wrench.force).norm() <= 1e-14 * (1 + r.wrench.force.norm()));
      CHECK((sum.torque - r.wrench.torque).norm() <= 1e-14 * (1 + r.wrench.torque.norm()));
      CHECK((shear - r.shear_W).norm() <= 1e-14 * (1 + shear.norm()));
    }
  }
}

TEST_CASE("conservation: dropped on implicit sensors, nothing gains energy (R18)") {
  // The long matrix is in stress/drop_test.cpp; this is its corners.
  for (const double dt : {1e-3, 1.0 / 60}) {
    for (const double stiffness : {1.0, 1e5}) {
      for (const double static_friction : {5e3, 1e6}) {
        for (const NormalDirection normal : {NormalDirection::ray, NormalDirection::gradient}) {
          PlateDef<double> def;
          def.time_step = dt;
          def.drop = 0.03;
          def.parameters.normal_stiffness = stiffness;
          def.parameters.static_friction = static_friction;
          def.options.normal = normal;
          auto scene = make_plate<double>(def);
          Transform<double> X = scene.world.pose(scene.plate);
          X.rotation = exp_rotation<double>({0, 0.1, 0});
          scene.world.set_pose(scene.plate, X);
          scene.world.set_velocity(scene.plate, {{0.3, -0.1, 0}, {0.5, 0.2, 3}});
          const std::array<BodyId, 1> bodies{scene.plate};
          const double initial = test::energy_of(scene.world, std::span<const BodyId>(bodies));
          double highest = 0;
          const int steps = static_cast<int>(std::lround(1 / dt));
          for (int i = 0; i < steps; ++i) {
            scene.world.step();
            highest =
                std::max(highest, test::energy_of(scene.world, std::span<const BodyId>(bodies)));
          }
          INFO("dt = ", dt, ", K_N = ", stiffness, ", mu_S = ", static_friction);
          CHECK(highest <= initial * (1 + 1e-12));
        }
      }
    }
  }
}

TEST_CASE("conservation: sensors feel the same whether they come or the other body does") {
  // Within the first step a gap closes that is wider than the rays reach out of the body, so rays
  // must be lengthened by what both bodies come closer. Without gravity no uniform motion of all
  // changes anything (Galilei).
  const double approach = 2.0;
  const double dt = 1e-2;
  const auto relative_speeds = [&](double velocity_a, double velocity_b) {
    WorldDef<double> world_def;
    world_def.gravity.setZero();
    world_def.time_step = dt;
    World<double> world(world_def);
    BodyDef<double> a;
    a.mass = 0.4;
    a.shape = Box<double>{{0.05, 0.05, 0.02}};
    a.filter.mask = 0;
    a.velocity = {0, 0, velocity_a};
    BodyDef<double> b = a;
    b.mass = 0.7;
    b.position = {0, 0, -0.04 - 0.012};
    b.velocity = {0, 0, velocity_b};
    const BodyId id_a = world.add_body(a);
    const BodyId id_b = world.add_body(b);
    PatchDef<double> patch;
    patch.sensors.add({0, 0, -0.015}, {0, 0, -1}, 0.01);  // Ends 5 mm outside.
    patch.parameters = {4, 0.02, 3000, 0.3, 1e-3};
    patch.integration = Integration::implicit;
    world.add_patch(id_a, patch);
    std::array<double, 3> speeds{};
    for (double& speed : speeds) {
      world.step();
      speed = world.body(id_a).twist.linear.z() - world.body(id_b).twist.linear.z();
    }
    return speeds;
  };
  const auto if_a_comes = relative_speeds(-approach, 0);
  const auto if_b_comes = relative_speeds(0, approach);
  const auto if_both_come = relative_speeds(-approach / 2, approach / 2);
  CHECK(std::abs(if_a_comes[0]) < 0.99 * approach);  // They met in the first step.
  for (std::size_t i = 0; i < if_a_comes.size(); ++i) {
    CAPTURE(i);
    // Positions differ by the motion of all, some cm, which rounds gaps by 1e-17 m.
    CHECK(std::abs(if_a_comes[i] - if_b_comes[i]) <= 1e-11 * approach);
    CHECK(std::abs(if_a_comes[i] - if_both_come[i]) <= 1e-11 * approach);
  }
}
