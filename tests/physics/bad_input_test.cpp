/// @file
/// A caller's mistakes: named at the call, without a trace in the world.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/brick.hpp"
#include "scenes/grasp.hpp"
#include "scenes/medley.hpp"
#include "support/numbers.hpp"
#include "support/relative.hpp"

#include <doctest/doctest.h>

#include <functional>
#include <limits>
#include <string>
#include <vector>

using namespace bristle;
using bristle::test::nan_;
using namespace bristle::scenes;

namespace {

PatchDef<double> one_sensor() {
  PatchDef<double> def;
  def.sensors.add({0, 0, 0}, {0, 0, -1}, 0.01);
  def.may_point_inwards = true;  // In bodies of any size.
  return def;
}

JointDef<double> weld(BodyId a, BodyId b) {
  JointDef<double> def;
  def.body_a = a;
  def.body_b = b;
  return def;
}

/// A call on a world that must throw, and the field that the error must name.
struct Mistake {
  std::string field;
  std::function<void(World<double>&)> call;
};

/// Runs mistakes on a lively world: each names its field, and the world does not notice.
void check(Medley<double>& m, const std::vector<Mistake>& mistakes) {
  const std::uint64_t before = m.world.state_hash();
  for (const Mistake& mistake : mistakes) {
    INFO("expected: ", mistake.field);
    std::string field = "nothing thrown";
    try {
      mistake.call(m.world);
    } catch (const InvalidArgument& error) {
      field = error.field();
      CHECK(std::string(error.what()).find(error.rule()) != std::string::npos);
    }
    CHECK(field.substr(0, mistake.field.size()) == mistake.field);
    CHECK(m.world.state_hash() == before);
  }
  // And it steps on as a world does in which nobody erred.
  auto other = make_medley<double>();
  for (int i = 0; i < 20; ++i) other.world.step();
  for (int i = 0; i < 10; ++i) m.world.step();
  CHECK(m.world.state_hash() == other.world.state_hash());
}

Medley<double> lively() {
  auto m = make_medley<double>();
  for (int i = 0; i < 10; ++i) m.world.step();
  return m;
}

/// A mistake in one field of a body.
template <typename Change>
Mistake bad_body(const std::string& field, Change change) {
  return {field, [change](World<double>& world) {
            BodyDef<double> def = brick();
            change(def);
            world.add_body(def);
          }};
}

}  // namespace

TEST_CASE("bad_input: bodies") {
  auto m = lively();
  check(m,
        {
            bad_body("BodyDef::mass", [](auto& d) { d.mass = -1; }),
            bad_body("BodyDef::mass", [](auto& d) { d.mass = 0; }),
            bad_body("BodyDef::mass", [](auto& d) { d.mass = nan_; }),
            bad_body("BodyDef::mass", [](auto& d) { d.mass = infinity<double>; }),
            bad_body("BodyDef::mass",
                     [](auto& d) {
                       d.mass.reset();
                       d.shape = {};
                     }),
            bad_body("BodyDef::density",
                     [](auto& d) {
                       d.mass.reset();
                       d.density = 0;
                     }),
            bad_body("BodyDef::position", [](auto& d) { d.position.y() = nan_; }),
            bad_body("BodyDef::velocity", [](auto& d) { d.velocity.x() = infinity<double>; }),
            bad_body("BodyDef::angular_velocity", [](auto& d) { d.angular_velocity.z() = nan_; }),
            bad_body("BodyDef::orientation", [](auto& d) { d.orientation.w() = 2; }),
            bad_body("BodyDef::orientation", [](auto& d) { d.orientation.w() = nan_; }),
            bad_body("BodyDef::center_of_mass",
                     [](auto& d) {
                       d.center_of_mass = {nan_, 0, 0};
                     }),
            bad_body("BodyDef::gravity_scale", [](auto& d) { d.gravity_scale = nan_; }),
            bad_body("BodyDef::inertia", [](auto& d) { d.inertia = Mat3<double>::Zero(); }),
            bad_body("BodyDef::inertia",
                     [](auto& d) { d.inertia = Vec3<double>(1, 1, 3).asDiagonal(); }),
            bad_body("BodyDef::inertia",
                     [](auto& d) { d.inertia = Vec3<double>(1, -1, 1).asDiagonal(); }),
            bad_body("BodyDef::inertia",
                     [](auto& d) {
                       d.inertia = Mat3<double>::Identity();
                       (*d.inertia)(0, 1) = 0.5;
                     }),
            bad_body("BodyDef::inertia", [](auto& d) { d.shape = {}; }),
            bad_body("BodyDef::motion", [](auto& d) { d.shape = HalfSpace<double>{}; }),
            bad_body("Box::half_extents",
                     [](auto& d) {
                       d.shape = Box<double>{{1, 0, 1}};
                     }),
            bad_body("Sphere::radius", [](auto& d) { d.shape = Sphere<double>{-1}; }),
            bad_body("Sphere::radius", [](auto& d) { d.shape = Sphere<double>{nan_}; }),
            bad_body("HalfSpace::normal",
                     [](auto& d) {
                       d.motion = Motion::fixed;
                       d.shape = HalfSpace<double>{{0, 0, 2}, 0};
                     }),
            bad_body("Material::friction", [](auto& d) { d.material.friction = -0.1; }),
            bad_body("Material::restitution", [](auto& d) { d.material.restitution = 1.5; }),
        });
}

TEST_CASE("bad_input: patches") {
  auto m = lively();
  const BodyId body = m.bodies[0];
  const auto bad = [&](const std::string& field, auto change) {
    return Mistake{field, [body, change](World<double>& world) {
                     PatchDef<double> def = one_sensor();
                     change(def);
                     world.add_patch(body, def);
                   }};
  };
  check(m, {
               bad("PatchDef::sensors", [](auto& d) { d.sensors = {}; }),
               bad("SensorLayout::start",
                   [](auto& d) {
                     d.sensors.add({nan_, 0, 0}, {0, 0, 1}, 1);
                   }),
               bad("SensorLayout::length",
                   [](auto& d) {
                     d.sensors.add({0, 0, 0}, {0, 0, 0});
                   }),
               bad("SensorLayout::length",
                   [](auto& d) {
                     d.sensors.add({0, 0, 0}, {0, 0, 1}, -1);
                   }),
               bad("SensorLayout::direction",
                   [](auto& d) {
                     d.sensors.add({0, 0, 0}, {0, 0, 2}, 1);
                   }),
               bad("SensorLayout", [](auto& d) { d.sensors.length.push_back(1); }),
               bad("SensorParameters::normal_stiffness",
                   [](auto& d) { d.parameters.normal_stiffness = -1; }),
               bad("SensorParameters::normal_damping",
                   [](auto& d) { d.parameters.normal_damping = nan_; }),
               bad("SensorParameters::static_friction",
                   [](auto& d) { d.parameters.static_friction = infinity<double>; }),
               bad("SensorParameters::sliding_friction",
                   [](auto& d) { d.parameters.sliding_friction = -1; }),
               bad("SensorParameters::breakaway_distance",
                   [](auto& d) { d.parameters.breakaway_distance = 0; }),
               bad("PatchDef::per_sensor", [](auto& d) { d.per_sensor.resize(2); }),
               bad("SensorParameters::normal_damping",
                   [](auto& d) {
                     d.per_sensor.resize(1);
                     d.per_sensor[0].normal_damping = -1;
                   }),
               bad("PatchDef::explicit_below", [](auto& d) { d.explicit_below = -1; }),
               bad("PatchDef::integration",
                   [](auto& d) {
                     d.options.law = Law::ambf;
                     d.integration = Integration::implicit;
                   }),
           });
}

TEST_CASE("bad_input: joints") {
  auto m = lively();
  const BodyId a = m.bodies[0];
  const BodyId b = m.bodies[1];
  const BodyId floor{0, 0};
  const auto bad = [&](const std::string& field, auto change) {
    return Mistake{field, [a, b, change](World<double>& world) {
                     JointDef<double> def = weld(a, b);
                     change(def);
                     world.add_joint(def);
                   }};
  };
  check(m, {
               bad("JointDef::body_a",
                   [](auto& d) {
                     d.body_a = {77, 1};
                   }),
               // Both are the world.
               bad("JointDef::body_b", [](auto& d) { d.body_a = d.body_b = {}; }),
               bad("JointDef::body_b",
                   [](auto& d) {
                     d.body_b = {1000, 0};
                   }),
               bad("JointDef::body_b", [a](auto& d) { d.body_b = a; }),
               bad("JointDef::body_a",
                   [floor](auto& d) {
                     d.body_a = floor;
                     d.body_b = {7, 0};
                   }),
               bad("JointDef::X_AJ.translation", [](auto& d) { d.X_AJ.translation.x() = nan_; }),
               bad("JointDef::X_BJ.rotation", [](auto& d) { d.X_BJ.rotation.w() = 3; }),
               bad("JointDef::lower_limit",
                   [](auto& d) {
                     d.lower_limit = 1;
                     d.upper_limit = 0;
                   }),
               bad("JointDef::lower_limit", [](auto& d) { d.lower_limit = nan_; }),
               bad("JointMotor::target", [](auto& d) { d.motor.target = nan_; }),
               bad("JointMotor::max_force", [](auto& d) { d.motor.max_force = -1; }),
               bad("JointMotor::max_speed", [](auto& d) { d.motor.max_speed = 0; }),
           });
}

TEST_CASE("bad_input: every call with a handle that names nothing, or nothing any more") {
  auto m = lively();
  // Handles that were good once.
  auto& world = m.world;
  const BodyId body = world.add_body(brick());
  const ShapeId shape = world.add_shape(body, {Sphere<double>{0.1}, {}, {}});
  const PatchId patch = world.add_patch(body, one_sensor());
  const JointId joint = world.add_joint(weld(body, m.bodies[0]));
  world.remove_joint(joint);
  world.remove_patch(patch);
  world.remove_shape(shape);
  world.remove_body(body);
  CHECK_FALSE(world.contains(body));
  std::vector<Mistake> mistakes;
  for (const BodyId id : {body, BodyId{}, BodyId{77, 0}}) {
    const auto add = [&](auto call) {
      mistakes.push_back({"BodyId", [id, call](World<double>& w) { call(w, id); }});
    };
    add([](auto& w, BodyId i) { w.add_shape(i, {Sphere<double>{0.1}, {}, {}}); });
    add([](auto& w, BodyId i) { w.remove_body(i); });
    add([](auto& w, BodyId i) { (void)w.body(i); });
    add([](auto& w, BodyId i) { (void)w.pose(i); });
    add([](auto& w, BodyId i) { w.set_pose(i, {}); });
    add([](auto& w, BodyId i) { w.set_velocity(i, {}); });
    add([](auto& w, BodyId i) { w.move_to(i, {}); });
    add([](auto& w, BodyId i) { w.apply_wrench(i, {}); });
    add([](auto& w, BodyId i) { w.apply_force(i, {0, 0, 0}, {0, 0, 0}); });
    add([](auto& w, BodyId i) { w.set_filter(i, {}); });
    add([](auto& w, BodyId i) { w.add_patch(i, one_sensor()); });
  }
  for (const ShapeId id : {shape, ShapeId{}}) {
    mistakes.push_back({"ShapeId", [id](World<double>& w) { w.remove_shape(id); }});
  }
  for (const JointId id : {joint, JointId{}}) {
    mistakes.push_back({"JointId", [id](World<double>& w) { w.remove_joint(id); }});
    mistakes.push_back({"JointId", [id](World<double>& w) { w.set_motor(id, {}); }});
    mistakes.push_back({"JointId", [id](World<double>& w) { (void)w.reading(id); }});
  }
  for (const PatchId id : {patch, PatchId{}}) {
    mistakes.push_back({"PatchId", [id](World<double>& w) { w.remove_patch(id); }});
    mistakes.push_back({"PatchId", [id](World<double>& w) { w.set_parameters(id, {}); }});
    mistakes.push_back({"PatchId", [id](World<double>& w) { (void)w.reading(id); }});
    mistakes.push_back({"PatchId", [id](World<double>& w) { (void)w.patch(id); }});
    mistakes.push_back({"PatchId", [id](World<double>& w) { (void)w.largest_stable_step(id); }});
  }
  check(m, mistakes);
}

TEST_CASE("bad_input: numbers given to calls") {
  auto m = lively();
  const BodyId body = m.bodies[0];
  const BodyId floor{0, 0};
  const Quat<double> twice(2, 0, 0, 0);
  check(m,
        {
            {"X_WB.translation",
             [=](auto& w) {
               w.set_pose(body, {Quat<double>::Identity(), {nan_, 0, 0}});
             }},
            {"X_WB.rotation",
             [=](auto& w) {
               w.set_pose(body, {twice, {0, 0, 0}});
             }},
            {"twist.linear",
             [=](auto& w) {
               w.set_velocity(body, {{infinity<double>, 0, 0}, {0, 0, 0}});
             }},
            {"twist.angular",
             [=](auto& w) {
               w.set_velocity(body, {{0, 0, 0}, {0, nan_, 0}});
             }},
            {"BodyId", [=](auto& w) { w.set_velocity(floor, {}); }},
            {"BodyId", [=](auto& w) { w.move_to(body, {}); }},
            {"wrench.force",
             [=](auto& w) {
               w.apply_wrench(body, {{nan_, 0, 0}, {0, 0, 0}});
             }},
            {"wrench.torque",
             [=](auto& w) {
               w.apply_wrench(body, {{0, 0, 0}, {0, infinity<double>, 0}});
             }},
            {"point",
             [=](auto& w) {
               w.apply_force(body, {1, 0, 0}, {0, nan_, 0});
             }},
            {"force",
             [=](auto& w) {
               w.apply_force(body, {nan_, 0, 0}, {0, 0, 0});
             }},
            {"dt", [](auto& w) { w.set_time_step(0); }},
            {"dt", [](auto& w) { w.set_time_step(-1); }},
            {"dt", [](auto& w) { w.set_time_step(nan_); }},
            {"gravity",
             [](auto& w) {
               w.set_gravity({0, 0, nan_});
             }},
            {"SensorParameters::static_friction",
             [&](auto& w) {
               w.set_parameters(m.patches[0], {1, 0, -1, 0, 1e-3});
             }},
            {"ShapeDef::shape",
             [=](auto& w) {
               w.add_shape(body, {HalfSpace<double>{}, {}, {}});
             }},
            {"ShapeDef::X_BS",
             [=](auto& w) {
               w.add_shape(body, {Sphere<double>{1}, {Quat<double>::Identity(), {nan_, 0, 0}}, {}});
             }},
            {"Ray::origin",
             [](auto& w) {
               (void)w.cast_ray({{nan_, 0, 0}, {0, 0, 1}, 1});
             }},
            {"Ray::direction",
             [](auto& w) {
               (void)w.cast_ray({{0, 0, 0}, {0, 0, 2}, 1});
             }},
            {"Ray::direction",
             [](auto& w) {
               (void)w.cast_ray({{0, 0, 0}, {0, 0, 0}, 1});
             }},
            {"Ray::length",
             [](auto& w) {
               (void)w.cast_ray({{0, 0, 0}, {0, 0, 1}, 0});
             }},
            {"Ray::length",
             [](auto& w) {
               (void)w.cast_ray({{0, 0, 0}, {0, 0, 1}, nan_});
             }},
            {"hits.size()",
             [](auto& w) {
               const std::vector<Ray<double>> rays(2, Ray<double>{{0, 0, 0}, {0, 0, 1}, 1});
               std::vector<WorldHit<double>> hits(1);
               w.cast_rays(rays, {}, hits);
             }},
        });
}

TEST_CASE("bad_input: definitions of a world") {
  // One part a step, and any tolerance that is a number.
  WorldDef<double> coarse;
  coarse.solver.longest_substep = infinity<double>;
  coarse.solver.max_direct_work = 0;
  coarse.solver.tolerance = std::numeric_limits<double>::min();
  World<double> world(coarse);
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
  BodyDef<double> falling = brick();
  falling.position = {0, 0, 0.1};
  const BodyId id = world.add_body(falling);
  for (int i = 0; i < 50; ++i) world.step();
  CHECK(world.pose(id).translation.z() == test::relative(0.1).epsilon(1e-3));
  const auto field_of = [](auto change) {
    WorldDef<double> def;
    change(def);
    try {
      World<double> refused(def);
    } catch (const InvalidArgument& error) {
      return error.field();
    }
    return std::string("nothing thrown");
  };
  CHECK(field_of([](auto& d) { d.gravity.x() = nan_; }).starts_with("WorldDef::gravity"));
  CHECK(field_of([](auto& d) { d.time_step = 0; }) == "WorldDef::time_step");
  CHECK(field_of([](auto& d) { d.restitution_speed = -1; }) == "WorldDef::restitution_speed");
  CHECK(field_of([](auto& d) { d.sleep.time = 0; }) == "SleepDef::time");
  CHECK(field_of([](auto& d) { d.sleep.time = nan_; }) == "SleepDef::time");
  CHECK(field_of([](auto& d) { d.sleep.linear_speed = -1; }) == "SleepDef::linear_speed");
  CHECK(field_of([](auto& d) { d.sleep.angular_speed = nan_; }) == "SleepDef::angular_speed");
  CHECK(field_of([](auto& d) { d.solver.tolerance = 0; }) == "SolverDef::tolerance");
  CHECK(field_of([](auto& d) { d.solver.max_sweeps = 0; }) == "SolverDef::max_sweeps");
  CHECK(field_of([](auto& d) { d.solver.max_passes = 0; }) == "SolverDef::max_passes");
  CHECK(field_of([](auto& d) { d.solver.max_position_sweeps = -1; }) ==
        "SolverDef::max_position_sweeps");
  CHECK(field_of([](auto& d) { d.solver.position_tolerance = 0; }) ==
        "SolverDef::position_tolerance");
  CHECK(field_of([](auto& d) { d.solver.max_newton_steps = 0; }) == "SolverDef::max_newton_steps");
  CHECK(field_of([](auto& d) { d.solver.large_sweeps = 0; }) == "SolverDef::large_sweeps");
  CHECK(field_of([](auto& d) { d.solver.large_position_sweeps = -1; }) ==
        "SolverDef::large_position_sweeps");
  CHECK(field_of([](auto& d) { d.solver.longest_substep = 0; }) == "SolverDef::longest_substep");
  CHECK(field_of([](auto& d) { d.parallel_for = nullptr; }) == "WorldDef::parallel_for");
}

TEST_CASE("bad_input: a world outlives the removal of whatever it holds") {
  auto scene = make_grasp<double>([] {
    GraspDef<double> def;
    def.finger_mass = 0.5;
    return def;
  }());
  scene.run(0.1);
  scene.world.remove_body(scene.fingers[0]);
  CHECK_THROWS_AS((void)scene.world.reading(scene.pads[0]), InvalidArgument);
  CHECK_THROWS_AS((void)scene.world.reading(scene.drives[0]), InvalidArgument);
  scene.run(0.1);
  scene.world.remove_body(scene.part);
  CHECK(scene.world.largest_stable_step(scene.pads[1]) == infinity<double>);
  scene.run(0.1);
  CHECK(scene.world.reading(scene.pads[1]).touching() == 0);
  scene.world.remove_body(scene.fingers[1]);
  scene.run(0.1);
  CHECK(scene.world.body_count() == 1);
  CHECK(scene.world.report().patches == 0);
}
