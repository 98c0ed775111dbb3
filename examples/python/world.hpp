/// @file
/// Worlds and readings in Python.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "arrays.hpp"
#include "contacts.hpp"
#include "events.hpp"
#include "rays.hpp"

#include <bristle/bristle.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

namespace bristle_python {

/// Readings of a patch, copied: they stay as they are when the world goes on.
template <typename S>
struct Reading {
  Array<S> depth, normal_force, shear_1, shear_2, point, force, torque;
  Array<bool> touches, slips;
  S total_normal, total_shear;
  std::size_t touching, slipping, bottomed_out;

  explicit Reading(const PatchReading<S>& r)
      : depth(copied(r.depth)),
        normal_force(copied(r.normal_force)),
        shear_1(copied(r.shear_1)),
        shear_2(copied(r.shear_2)),
        point({r.size(), std::size_t(3)}),
        force(3, r.wrench.force.data()),
        torque(3, r.wrench.torque.data()),
        touches(static_cast<py::ssize_t>(r.size())),
        slips(static_cast<py::ssize_t>(r.size())),
        total_normal(r.total_normal()),
        total_shear(r.total_shear()),
        touching(r.touching()),
        slipping(r.slipping()),
        bottomed_out(r.bottomed_out()) {
    for (std::size_t i = 0; i < r.size(); ++i) {
      const auto k = static_cast<py::ssize_t>(i);
      point.mutable_at(k, 0) = r.point_x[i];
      point.mutable_at(k, 1) = r.point_y[i];
      point.mutable_at(k, 2) = r.point_z[i];
      touches.mutable_at(k) = r.state[i] != SensorState::free;
      slips.mutable_at(k) = r.state[i] == SensorState::slipping;
    }
  }
};

/// A shape of a body, and where its frame is in the body's [m]: position and x, y, z, w.
template <typename S>
using PlacedShape = std::tuple<Shape<S>, Vec3<S>, Eigen::Matrix<S, 4, 1>>;

template <typename S>
void bind_reading(py::module_& m) {
  py::class_<Reading<S>>(m, "Reading", "What a patch felt in a step: copies, an entry a sensor.")
      .def_readonly("depth", &Reading<S>::depth,
                    "[sensor]: depth [1] from 0 to 1 as a part of the ray, 0 without a touch.")
      .def_readonly("normal_force", &Reading<S>::normal_force, "[sensor]: force [N] along the ray.")
      .def_readonly("shear_1", &Reading<S>::shear_1,
                    "[sensor]: force [N] across the ray, along t1.")
      .def_readonly("shear_2", &Reading<S>::shear_2,
                    "[sensor]: force [N] across the ray, along t2.")
      .def_readonly("point", &Reading<S>::point,
                    "[sensor, 3]: point of touch [m], world axes; valid where `touches`.")
      .def_readonly("touches", &Reading<S>::touches, "[sensor]: which touch something.")
      .def_readonly("slips", &Reading<S>::slips, "[sensor]: which let go in this step.")
      .def_readonly("force", &Reading<S>::force,
                    "[3]: sum of the forces [N] on the patch's body, world axes.")
      .def_readonly("torque", &Reading<S>::torque,
                    "[3]: their torque [N m] about its centre of mass, world axes.")
      .def_readonly("total_normal", &Reading<S>::total_normal, "Sum of the normal forces [N].")
      .def_readonly("total_shear", &Reading<S>::total_shear,
                    "Size [N] of the sum of the shear forces.")
      .def_readonly("touching", &Reading<S>::touching, "Number of sensors that touch something.")
      .def_readonly("slipping", &Reading<S>::slipping, "Number of sensors that let go.")
      .def_readonly("bottomed_out", &Reading<S>::bottomed_out,
                    "Number of sensors that are pressed in over their whole length.");
}

template <typename S>
void bind_world(py::module_& m) {
  using World = bristle::World<S>;
  using Vec4 = Eigen::Matrix<S, 4, 1>;
  py::class_<World> c(m, "World", "A rigid-body world whose hands can hold things.");
  c.def(py::init([](const Vec3<S>& gravity, S time_step, bool keeps_contact_events, S sleep_time,
                    S sleep_linear_speed, S sleep_angular_speed) {
          return std::make_unique<World>(WorldDef<S>{.gravity = gravity,
                                                     .time_step = time_step,
                                                     .sleep = {.linear_speed = sleep_linear_speed,
                                                               .angular_speed = sleep_angular_speed,
                                                               .time = sleep_time},
                                                     .keeps_contact_events = keeps_contact_events});
        }),
        py::kw_only(), "gravity"_a = Vec3<S>(0, 0, S(-9.81)), "time_step"_a = S(1) / S(240),
        "keeps_contact_events"_a = false, "sleep_time"_a = SleepDef<S>{}.time,
        "sleep_linear_speed"_a = SleepDef<S>{}.linear_speed,
        "sleep_angular_speed"_a = SleepDef<S>{}.angular_speed,
        "An empty world of a gravity [m/s^2] that steps by `time_step` [s]. With "
        "`keeps_contact_events` it keeps `contact_events` until they are cleared. What touches "
        "or is joined sleeps together after `sleep_time` [s] below both speeds [m/s, rad/s]; as it "
        "is, never.")
      .def(
          "__copy__", [](const World& world) { return std::make_unique<World>(world); },
          "A copy, which steps on as the original would.")
      .def(
          "copy", [](const World& world) { return std::make_unique<World>(world); },
          "A copy, which steps on as the original would.")
      .def(
          "add_body",
          [](World& world, Motion motion, std::optional<Shape<S>> shape, std::optional<S> mass,
             const Vec3<S>& position, const Vec4& orientation, const Vec3<S>& velocity,
             const Vec3<S>& angular_velocity, S friction, S restitution, S rolling_friction,
             const Vec3<S>& surface_velocity, S linear_damping, S angular_damping, S gravity_scale,
             std::vector<PlacedShape<S>> shapes, bool is_trigger, const CollisionFilter& filter) {
            BodyDef<S> def;
            def.motion = motion;
            def.mass = mass;
            def.material = {.friction = friction,
                            .restitution = restitution,
                            .surface_velocity = surface_velocity,
                            .rolling_friction = rolling_friction};
            def.linear_damping = linear_damping;
            def.angular_damping = angular_damping;
            def.gravity_scale = gravity_scale;
            def.filter = filter;
            const auto add = [&](Shape<S> part, const Transform<S>& pose) {
              def.shapes.push_back({std::move(part), pose, def.material, is_trigger});
            };
            // Only shapes of the list can be triggers.
            if (shape && is_trigger) {
              add(*std::move(shape), {});
            } else if (shape) {
              def.shape = *std::move(shape);
            }
            for (auto& [part, place, turn] : shapes) {
              add(std::move(part), {rotation_of<S>(turn), place});
            }
            def.position = position;
            def.orientation = rotation_of<S>(orientation);
            def.velocity = velocity;
            def.angular_velocity = angular_velocity;
            return world.add_body(def);
          },
          py::kw_only(), "motion"_a = Motion::dynamic, "shape"_a = py::none(),
          "mass"_a = py::none(), "position"_a = Vec3<S>(0, 0, 0),
          "orientation"_a = Vec4(0, 0, 0, 1), "velocity"_a = Vec3<S>(0, 0, 0),
          "angular_velocity"_a = Vec3<S>(0, 0, 0), "friction"_a = Material<S>{}.friction,
          "restitution"_a = Material<S>{}.restitution,
          "rolling_friction"_a = Material<S>{}.rolling_friction,
          "surface_velocity"_a = Vec3<S>(0, 0, 0), "linear_damping"_a = S(0),
          "angular_damping"_a = S(0), "gravity_scale"_a = S(1),
          "shapes"_a = std::vector<PlacedShape<S>>{}, "is_trigger"_a = false,
          "filter"_a = CollisionFilter{},
          "Adds a body of a mass [kg] at a position [m] with an orientation x, y, z, w, a velocity "
          "[m/s] and an angular velocity [rad/s]. A dynamic body has a shape; without a mass it "
          "is as dense as water. rolling_friction is a lever [m]. Like a belt the surface moves by "
          "surface_velocity [m/s] in the axes of the shape. Velocity and angular momentum decay at "
          "linear_damping and angular_damping [1/s], and gravity pulls gravity_scale [1] times. "
          "More `shapes` are a list of (shape, position, orientation) in the body's frame. With "
          "is_trigger the shapes push nothing and no sensor senses them: `contact_events` tells "
          "what is in them. They have no mass, so that such a body is fixed or kinematic. A "
          "`filter` says which bodies it meets.")
      .def("remove_body", &World::remove_body, "body"_a,
           "Removes a body with its patches and joints.")
      .def(
          "add_joint",
          [](World& world, JointKind kind, std::optional<BodyId> a, std::optional<BodyId> b,
             const Vec3<S>& anchor_a, const Vec4& rotation_a, const Vec3<S>& anchor_b,
             const Vec4& rotation_b, S lower, S upper, MotorMode mode, S target, S max_force,
             S max_speed, S stiffness, S damping, S swing_limit, const Vec6<S>& bushing_stiffness,
             const Vec6<S>& bushing_damping) {
            JointDef<S> def;
            def.kind = kind;
            def.body_a = a.value_or(BodyId{});
            def.body_b = b.value_or(BodyId{});
            def.X_AJ = {rotation_of<S>(rotation_a), anchor_a};
            def.X_BJ = {rotation_of<S>(rotation_b), anchor_b};
            def.lower_limit = lower;
            def.upper_limit = upper;
            def.swing_limit = swing_limit;
            def.bushing = {bushing_stiffness, bushing_damping};
            def.motor = {mode, target, max_force, max_speed, stiffness, damping};
            return world.add_joint(def);
          },
          "kind"_a, "body_a"_a, "body_b"_a, py::kw_only(), "anchor_a"_a = Vec3<S>(0, 0, 0),
          "rotation_a"_a = Vec4(0, 0, 0, 1), "anchor_b"_a = Vec3<S>(0, 0, 0),
          "rotation_b"_a = Vec4(0, 0, 0, 1), "lower"_a = -infinity<S>, "upper"_a = infinity<S>,
          "mode"_a = MotorMode::none, "target"_a = S(0), "max_force"_a = S(0),
          "max_speed"_a = infinity<S>, "stiffness"_a = S(0), "damping"_a = S(0),
          "swing_limit"_a = infinity<S>, "bushing_stiffness"_a = Vec6<S>(Vec6<S>::Zero()),
          "bushing_damping"_a = Vec6<S>(Vec6<S>::Zero()),
          "Adds a joint about or along the x axis of a frame in both bodies: `anchor` [m] and "
          "`rotation` x, y, z, w, in the body's axes. A body that is None is the world. Limits are "
          "in m or rad, of a cone_twist those of its twist, and the x axes are at most "
          "`swing_limit` [rad] apart. For the motor see `set_motor`. A six_dof is held by springs "
          "and dampers alone, six numbers each: along x, y, z [N/m, N s/m] and about x, y, z "
          "[N m/rad, N m s/rad] of A's frame.")
      .def("remove_joint", &World::remove_joint, "joint"_a, "Removes a joint.")
      .def(
          "set_motor",
          [](World& world, JointId id, MotorMode mode, S target, S max_force, S max_speed,
             S stiffness, S damping) {
            world.set_motor(id, {mode, target, max_force, max_speed, stiffness, damping});
          },
          "joint"_a, py::kw_only(), "mode"_a, "target"_a = S(0), "max_force"_a = S(0),
          "max_speed"_a = infinity<S>, "stiffness"_a = S(0), "damping"_a = S(0),
          "Drives a joint to a velocity [m/s] or position [m], with a largest force [N] and, to a "
          "position, speed [m/s]; or as a spring [N/m] with damping [N s/m]. Of joints that turn: "
          "rad and N m.")
      .def("set_limits", &World::set_limits, "joint"_a, "lower"_a = -infinity<S>,
           "upper"_a = infinity<S>, "Gives a joint other limits [m or rad], into which it moves.")
      .def(
          "set_spring",
          [](World& world, JointId id, S stiffness, S damping, S rest) {
            world.set_spring(id, {stiffness, damping, rest});
          },
          "joint"_a, py::kw_only(), "stiffness"_a = S(0), "damping"_a = S(0), "rest"_a = S(0),
          "Gives a joint a passive spring [N/m] with damping [N s/m] and the position `rest` [m] "
          "without force. Of joints that turn: rad and N m.")
      .def(
          "joint_state",
          [](const World& world, JointId id) {
            const JointReading<S> r = world.reading(id);
            return std::pair(r.position, r.velocity);
          },
          "joint"_a, "Position [m or rad] and velocity [m/s or rad/s] of its free axis.")
      .def(
          "add_patch",
          [](World& world, BodyId body, const SensorLayout<S>& sensors,
             const SensorParameters<S>& parameters, Integration integration, SlipReset reset,
             NormalDirection normal, std::uint32_t cast_every) {
            PatchDef<S> def;
            def.sensors = sensors;
            def.parameters = parameters;
            def.integration = integration;
            def.options = {.reset = reset, .normal = normal};
            def.cast_every = cast_every;
            return world.add_patch(body, std::move(def));
          },
          "body"_a, "sensors"_a, "parameters"_a, py::kw_only(),
          "integration"_a = Integration::automatic, "reset"_a = SlipReset::release,
          "normal"_a = LawOptions{}.normal, "cast_every"_a = 1u,
          "Adds sensors, in the body's frame, that share constants. Rays are cast in every "
          "`cast_every`-th step.")
      .def("remove_patch", &World::remove_patch, "patch"_a,
           "Removes a patch. It lets go of what it touches.")
      .def("set_active", &World::set_active, "patch"_a, "is_active"_a,
           "Switches a patch on or off. One that is off lets go and costs nothing.")
      .def(
          "is_active", [](const World& world, PatchId id) { return world.patch(id).is_active; },
          "patch"_a, "Whether a patch is on.")
      .def("set_parameters", &World::set_parameters, "patch"_a, "parameters"_a,
           "Gives all sensors of a patch other constants.")
      .def("set_mass", &World::set_mass, "body"_a, "mass"_a,
           "Gives a body another mass [kg]; its inertia follows in proportion.")
      .def("set_damping", &World::set_damping, "body"_a, "linear"_a, "angular"_a = S(0),
           "Sets the rates [1/s] at which velocity and angular momentum of a dynamic body decay.")
      .def("set_gravity_scale", &World::set_gravity_scale, "body"_a, "scale"_a,
           "Sets the factor [1] of a dynamic body on the world's gravity.")
      .def(
          "set_material",
          [](World& world, BodyId body, S friction, S restitution, S rolling_friction,
             const Vec3<S>& surface_velocity) {
            world.set_material(body, {.friction = friction,
                                      .restitution = restitution,
                                      .surface_velocity = surface_velocity,
                                      .rolling_friction = rolling_friction});
          },
          "body"_a, "friction"_a, "restitution"_a = S(0), "rolling_friction"_a = S(0),
          "surface_velocity"_a = Vec3<S>(0, 0, 0),
          "Gives all shapes of a body a friction [1], a restitution [1], a lever of rolling "
          "friction [m] and, as of a belt, a velocity of the surface [m/s] in a shape's axes.")
      .def("set_gravity", &World::set_gravity, "gravity"_a, "Sets gravity [m/s^2].")
      .def("set_time_step", &World::set_time_step, "time_step"_a,
           "Sets the length [s] of the steps to come.")
      .def(
          "set_pose",
          [](World& world, BodyId id, const Vec3<S>& position, const Vec4& orientation) {
            world.set_pose(id, {rotation_of<S>(orientation), position});
          },
          "body"_a, "position"_a, "orientation"_a = Vec4(0, 0, 0, 1),
          "Puts a body somewhere else [m] at once; its velocity stays.")
      .def(
          "set_velocity",
          [](World& world, BodyId id, const Vec3<S>& linear, const Vec3<S>& angular) {
            world.set_velocity(id, {linear, angular});
          },
          "body"_a, "linear"_a, "angular"_a = Vec3<S>(0, 0, 0),
          "Sets the velocity of the centre of mass [m/s] and the angular velocity [rad/s], world "
          "axes.")
      .def(
          "move_to",
          [](World& world, BodyId id, const Vec3<S>& position, const Vec4& orientation) {
            world.move_to(id, {rotation_of<S>(orientation), position});
          },
          "body"_a, "position"_a, "orientation"_a = Vec4(0, 0, 0, 1),
          "Where a kinematic body is to be [m] after the next step; it keeps that velocity.")
      .def("apply_force", &World::apply_force, "body"_a, "force"_a, "point"_a,
           "Adds a force [N] at a point [m] of the world that acts during the next step.")
      .def(
          "apply_wrench",
          [](World& world, BodyId id, const Vec3<S>& force, const Vec3<S>& torque) {
            world.apply_wrench(id, {force, torque});
          },
          "body"_a, "force"_a, "torque"_a,
          "Adds a force [N] at the centre of mass and a torque [N m] that act during the next "
          "step, world axes.")
      .def("apply_impulse", &World::apply_impulse, "body"_a, "impulse"_a, "point"_a,
           "Changes the velocity of a dynamic body at once by an impulse [N s] at a point [m] of "
           "the world.")
      .def("is_asleep", &World::is_asleep, "body"_a, "Whether a body sleeps.")
      .def("wake", &World::wake, "body"_a,
           "Wakes a body with its island: all that touches or is joined.")
      .def(
          "contains",
          [](const World& world, const std::variant<BodyId, JointId, PatchId, ShapeId>& handle) {
            return std::visit([&](auto id) { return world.contains(id); }, handle);
          },
          "handle"_a, "Whether there still is what a handle names.")
      .def(
          "position",
          [](const World& world, BodyId id) { return Vec3<S>(world.pose(id).translation); },
          "body"_a, "Origin [m] of the body frame.")
      .def(
          "orientation",
          [](const World& world, BodyId id) { return Vec4(world.pose(id).rotation.coeffs()); },
          "body"_a, "Orientation x, y, z, w of the body frame.")
      .def(
          "velocity",
          [](const World& world, BodyId id) {
            const Twist<S>& twist = world.body(id).twist;
            return std::pair(Vec3<S>(twist.linear), Vec3<S>(twist.angular));
          },
          "body"_a,
          "Velocity [m/s] of the centre of mass and angular velocity [rad/s], world axes.")
      .def(
          "reading", [](const World& world, PatchId id) { return Reading<S>(world.reading(id)); },
          "patch"_a, "What a patch felt in the last step, copied.")
      .def(
          "taxel_points",
          [](const World& world, PatchId id) {
            Array<S> points({world.patch(id).size(), std::size_t(6)});
            world.taxel_points(id, span_of(points));
            return points;
          },
          "patch"_a,
          "[sensor, 6]: how far the skin is displaced at a sensor, dx, dy, dz [m], and the force "
          "on it, Fx, Fy, Fz [N], in the axes of the patch's body. Zeros without a touch.")
      .def(
          "patch_warnings",
          [](const World& world, PatchId id) { return world.patch_report(id).warnings(); },
          "patch"_a,
          "What is valid and still looks wrong: buried rays, constants for other loads than the "
          "bodies have, sensors that are pressed in over their whole length.")
      .def(
          "step",
          [](World& world, std::size_t steps) {
            for (std::size_t i = 0; i < steps; ++i) world.step();
          },
          "steps"_a = 1, py::call_guard<py::gil_scoped_release>(),
          "Advances the world by some steps. Other Python threads run meanwhile.")
      .def(
          "snapshot",
          [](const World& world) {
            const std::vector<std::byte> bytes = world.snapshot();
            return py::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
          },
          "All that changes from step to step, as bytes for `restore` of the same build.")
      .def(
          "restore",
          [](World& world, const py::bytes& bytes) {
            const std::string_view view = bytes;
            world.restore(std::as_bytes(std::span(view.data(), view.size())));
          },
          "bytes"_a, "Puts the world into the state of a snapshot of it or of a copy.")
      .def("state_hash", &World::state_hash, "One number for all that a snapshot holds.")
      .def_property_readonly("time_step", &World::time_step, "Length of the next step [s].");
  bind_world_queries<S>(c);
  bind_world_contacts<S>(c);
  bind_world_events<S>(c);
}

}  // namespace bristle_python
