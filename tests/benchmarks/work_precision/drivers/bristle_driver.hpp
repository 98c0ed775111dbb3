/// @file
/// Runs scenes in a world of this library.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "benchmarks/work_precision/engines.hpp"

#include <bristle/geometry/shapes/quickhull.hpp>
#include <bristle/sensors/placement.hpp>
#include <bristle/world/world.hpp>

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

namespace bristle::work_precision {

using namespace bristle::detail;

/// [-] Settings of a world by name, the defaults first.
[[nodiscard]] inline std::vector<std::string> bristle_settings() { return {"def", "paper"}; }

/// The world of a setting; the one place that knows what the names mean.
template <Scalar S>
[[nodiscard]] WorldDef<S> world_def(const std::string& setting) {
  WorldDef<S> def;
  if (setting == "paper") {
    def.integrator = Integrator::symplectic_euler;
    def.solver.max_direct_work = 0;
    def.solver.longest_substep = S(1);  // One part a step.
    def.solver.large_sweeps = 50;
  }
  return def;
}

/// A world with a scene in it.
template <Scalar S>
class BristleEngine : public scenes::Engine {
 public:
  BristleEngine(const scenes::Scene& scene, double dt, const std::string& setting)
      : world_(def_of(scene, dt, setting)) {
    try {
      for (const scenes::SceneBody& body : scene.bodies) {
        bodies_.push_back(world_.add_body(body_def(scene, body)));
      }
    } catch (const InvalidArgument& e) {
      throw scenes::Unsupported(e.what());
    }
    add_joints(scene);
    for (const scenes::SceneSensors& sensors : scene.sensors) add(sensors);
  }

  void step() override { world_.step(); }

  [[nodiscard]] scenes::BodyState state(std::size_t i) const override {
    const Body<S>& body = world_.body(bodies_[i]);
    // The pose of the centre of mass as it is kept; scenes put the body frame there.
    return {body.center_pose.translation.template cast<double>(),
            Quat<double>(body.center_pose.rotation.template cast<double>()),
            body.twist.linear.template cast<double>(), body.twist.angular.template cast<double>()};
  }
  void push(std::size_t i, const scenes::Vector& force) override {
    world_.apply_wrench(bodies_[i], {.force = force.template cast<S>(), .torque = Vec3<S>::Zero()});
  }
  void move_to(std::size_t i, const scenes::Place& place, double) override {
    world_.move_to(bodies_[i], {Quat<S>(place.orientation.template cast<S>()).normalized(),
                                place.position.template cast<S>()});
  }
  void set_gravity(const scenes::Vector& gravity) override {
    world_.set_gravity(gravity.template cast<S>());
  }
  [[nodiscard]] scenes::StepCounters counters() const override {
    return {world_.report().sweeps, world_.report().factorisations};
  }

 private:
  static WorldDef<S> def_of(const scenes::Scene& scene, double dt, const std::string& setting) {
    WorldDef<S> def = world_def<S>(setting);
    def.time_step = S(dt);
    def.gravity = scene.gravity.template cast<S>();
    return def;
  }

  static BodyDef<S> body_def(const scenes::Scene& scene, const scenes::SceneBody& body) {
    BodyDef<S> def;
    def.motion = body.moves()       ? Motion::dynamic
                 : body.is_driven() ? Motion::kinematic
                                    : Motion::fixed;
    if (body.moves()) {
      def.mass = S(body.mass);
      def.center_of_mass = Vec3<S>::Zero();
      def.inertia = Mat3<S>(scenes::principal_inertia(body).template cast<S>().asDiagonal());
    }
    def.shape = std::visit([](const auto& shape) { return shape_of(shape); }, body.shape);
    // A pair has the geometric mean here and the product in the scene.
    def.material = {S(body.friction * body.friction), S(scene.restitution)};
    def.position = body.position.template cast<S>();
    def.orientation = Quat<S>(body.orientation.template cast<S>()).normalized();
    def.velocity = body.velocity.template cast<S>();
    def.angular_velocity = body.angular_velocity.template cast<S>();
    if (body.slides_along_x) def.locked = {{false, true, true}, {true, true, true}};
    constexpr std::uint32_t moving = 2;
    def.filter.category = body.moves() ? moving : 1u;
    if (body.meets == scenes::Meets::fixed_bodies) def.filter.mask = ~moving;
    if (body.meets == scenes::Meets::nothing) def.filter.mask = 0;
    def.filter.group = -body.family;
    return def;
  }

  void add_joints(const scenes::Scene& scene) {
    if (scene.joints.empty()) return;
    const BodyId ground = world_.add_body({.motion = Motion::fixed});
    for (const scenes::SceneJoint& joint : scene.joints) {
      JointDef<S> def;
      def.kind = joint.kind == scenes::SceneJointKind::hinge ? JointKind::revolute
                 : std::isfinite(joint.swing)                ? JointKind::cone_twist
                                                             : JointKind::ball;
      def.body_a = joint.a < 0 ? ground : bodies_[static_cast<std::size_t>(joint.a)];
      def.body_b = bodies_[static_cast<std::size_t>(joint.b)];
      const bool has_axis = def.kind != JointKind::ball;
      scenes::Rotation turn = scenes::Rotation::Identity();
      if (has_axis) turn = scenes::turn_between(scenes::Vector::UnitX(), joint.axis);
      const Transform<double> anchor{turn, joint.anchor};
      const auto placed = [&](int i) {
        if (i < 0) return anchor;
        const scenes::SceneBody& body = scene.bodies[static_cast<std::size_t>(i)];
        return Transform<double>{body.orientation, body.position}.inverse() * anchor;
      };
      def.X_AJ = placed(joint.a).template cast<S>();
      def.X_BJ = placed(joint.b).template cast<S>();
      if (joint.kind == scenes::SceneJointKind::hinge) {
        def.lower_limit = S(joint.lower);
        def.upper_limit = S(joint.upper);
      }
      def.swing_limit = S(joint.swing);
      if (joint.motor) {
        // One without gains is a motor, if one without torque.
        def.motor = {.mode = joint.motor->is_inert() ? MotorMode::velocity : MotorMode::spring,
                     .target = S(joint.motor->target),
                     .max_force = S(std::min(joint.motor->max_torque, 1e6)),
                     .stiffness = S(joint.motor->stiffness),
                     .damping = S(joint.motor->damping)};
      }
      world_.add_joint(def);
    }
  }

  void add(const scenes::SceneSensors& sensors) {
    constexpr double depth = 0.005;
    SensorLayout<S> layout = sensor_grid<S>({.center = sensors.centre.template cast<S>(),
                                             .side_u = sensors.side_u.template cast<S>(),
                                             .side_v = sensors.side_v.template cast<S>(),
                                             .count_u = sensors.count_u,
                                             .count_v = sensors.count_v,
                                             .depth = S(depth),
                                             .range = S(depth + sensors.reach)});
    const BodyId carrier = bodies_[sensors.body];
    if (sensors.load > 0) {
      world_.add_patch(carrier, std::move(layout),
                       tuned_for<S>({.friction = S(sensors.friction),
                                     .creep = S(sensors.creep),
                                     .load = S(sensors.load),
                                     .mass = S(sensors.mass)}));
    } else {
      world_.add_patch(carrier, std::move(layout), SensorParameters<S>{});
    }
  }

  static Shape<S> shape_of(const Sphere<double>& s) { return Sphere<S>{S(s.radius)}; }
  static Shape<S> shape_of(const Box<double>& s) {
    return Box<S>{s.half_extents.template cast<S>()};
  }
  static Shape<S> shape_of(const Cylinder<double>& s) {
    return Cylinder<S>{S(s.radius), S(s.half_length)};
  }
  static Shape<S> shape_of(const Capsule<double>& s) {
    return Capsule<S>{S(s.radius), S(s.half_length)};
  }
  static Shape<S> shape_of(const scenes::Surface& s) {
    TriangleMesh<S> mesh;
    for (const scenes::Vector& v : s.mesh.vertices) {
      mesh.vertices.push_back(v.template cast<S>());
    }
    mesh.triangles = s.mesh.triangles;
    return mesh;
  }
  static Shape<S> shape_of(const HalfSpace<double>& s) {
    return HalfSpace<S>{s.normal.template cast<S>().normalized(), S(s.offset)};
  }
  static Shape<S> shape_of(const TriangleMesh<double>& s) {
    std::vector<Vec3<S>> points;
    for (const scenes::Vector& v : s.vertices) points.push_back(v.template cast<S>());
    return convex_hull<S>(std::span<const Vec3<S>>(points));
  }

  World<S> world_;
  std::vector<BodyId> bodies_;
};

/// The library in one scalar, as an engine of the benchmark.
template <Scalar S>
[[nodiscard]] EngineFamily bristle_family(std::string name) {
  return {std::move(name), bristle_settings(),
          [](const scenes::Scene& scene, double dt,
             const std::string& setting) -> std::unique_ptr<scenes::Engine> {
            return std::make_unique<BristleEngine<S>>(scene, dt, setting);
          }};
}

}  // namespace bristle::work_precision
