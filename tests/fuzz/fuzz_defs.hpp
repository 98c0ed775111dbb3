/// @file
/// Bytes of a fuzzer as definitions of bodies, joints and sensors, with anything in their fields.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "fuzz/fuzz_bytes.hpp"

#include <bristle/bristle.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace bristle::test {

template <typename S>
class FuzzDefs : public FuzzBytes<S> {
 public:
  using FuzzBytes<S>::FuzzBytes;

  Twist<S> twist() {
    const Vec3<S> linear = this->vector(S(3));
    return {linear, this->vector(S(10))};
  }
  CollisionFilter filter() {
    CollisionFilter filter;
    filter.category = this->byte();
    filter.mask = this->byte();
    filter.group = int{this->byte()} - 128;
    return filter;
  }
  Material<S> material() {
    Material<S> material;
    if (this->once_in(2)) return material;
    material.friction = this->positive(S(1.5));
    material.restitution = this->positive(S(1));
    if (this->once_in(8)) material.surface_velocity = this->vector(S(2));
    if (this->once_in(8)) material.rolling_friction = this->positive(S(0.02));
    return material;
  }

  /// A box as a mesh, moved, with one thing about it wrong in one of four.
  TriangleMesh<S> mesh() {
    TriangleMesh<S> mesh = box_mesh<S>(this->positive_vector(S(0.2)));
    if (this->once_in(4))
      mesh =
          sphere_mesh<S>(this->positive(S(0.2)), static_cast<std::uint32_t>(2 + this->choice(4)));
    const Vec3<S> shift = this->vector(S(0.1));
    for (Vec3<S>& v : mesh.vertices) v += shift;
    switch (this->choice(16)) {
      case 0:
        mesh.vertices[this->choice(mesh.vertices.size())] = this->vector(S(0.3));
        break;
      case 1:
        mesh.triangles[this->choice(mesh.triangles.size())][0] = this->byte();
        break;
      case 2:
        mesh.triangles.pop_back();
        break;
      case 3:
        for (Vec3<S>& v : mesh.vertices) v.z() *= S(1e-7);
        break;
      default:
        break;
    }
    return mesh;
  }
  ConvexHull<S> hull() {
    if (this->once_in(2)) return convex_hull<S>(mesh());
    std::vector<Vec3<S>> points(4 + this->choice(10));
    for (Vec3<S>& p : points) p = this->vector(S(0.3));
    if (this->once_in(4)) {
      for (Vec3<S>& p : points) p.x() *= S(1e-8);
    }
    return convex_hull<S>(std::span<const Vec3<S>>(points));
  }
  Shape<S> shape() {
    const S size = S(0.3);
    switch (this->choice(10)) {
      case 0:
        return Sphere<S>{this->positive(size)};
      case 1:
        return Capsule<S>{this->positive(size), this->positive(size)};
      case 2:
        return Cylinder<S>{this->positive(size), this->positive(size)};
      case 3:
        return Cone<S>{this->positive(size), this->positive(size)};
      case 4:
        return Ellipsoid<S>{this->positive_vector(size)};
      case 5: {
        const Vec3<S> normal = this->direction();
        return HalfSpace<S>{normal, this->number(S(0.5))};
      }
      case 6:
        return hull();
      case 7:
        return mesh();
      default:
        return Box<S>{this->positive_vector(size)};
    }
  }
  ShapeDef<S> shape_def() {
    ShapeDef<S> def;
    def.shape = shape();
    def.X_BS = this->pose(S(0.2));
    def.material = material();
    def.is_trigger = this->once_in(8);
    def.user_data = this->choice(4);
    return def;
  }

  BodyDef<S> body_def() {
    BodyDef<S> def;
    const std::size_t motion = this->choice(8);
    def.motion = motion == 0 ? Motion::fixed : motion == 1 ? Motion::kinematic : Motion::dynamic;
    if (this->once_in(2)) def.mass = this->positive(S(2));
    if (!this->once_in(16)) def.shape = shape();
    def.material = material();
    if (this->once_in(8)) {
      for (std::size_t i = this->choice(3); i-- > 0;) def.shapes.push_back(shape_def());
    }
    def.position = this->vector(S(1));
    def.orientation = this->rotation();
    if (this->once_in(2)) {
      def.velocity = this->vector(S(2));
      def.angular_velocity = this->vector(S(5));
    }
    const std::uint8_t more = this->byte();
    if ((more & 3) == 3) def.density = this->positive(S(2000));
    if ((more & 12) == 12) def.center_of_mass = this->vector(S(0.1));
    if ((more & 48) == 48) {
      Mat3<S> inertia = this->positive_vector(S(0.1)).asDiagonal();
      inertia(0, 1) = inertia(1, 0) = this->number(S(0.001));
      def.inertia = inertia;
    }
    if ((more & 192) == 192) {
      def.gravity_scale = this->number(S(2));
      def.linear_damping = this->positive(S(5));
      def.angular_damping = this->positive(S(5));
      def.filter = filter();
      const std::uint8_t locks = this->byte();
      for (std::size_t axis = 0; axis < 3; ++axis) {
        def.locked.linear[axis] = (locks >> axis & 1) != 0;
        def.locked.angular[axis] = (locks >> (axis + 3) & 1) != 0;
      }
    }
    return def;
  }

  JointMotor<S> motor() {
    JointMotor<S> motor;
    motor.mode = static_cast<MotorMode>(this->choice(4));
    motor.target = this->number(S(2));
    motor.max_force = this->positive(S(50));
    if (this->once_in(2)) motor.max_speed = this->positive(S(3));
    motor.stiffness = this->positive(S(500));
    motor.damping = this->positive(S(20));
    return motor;
  }
  SensorLayout<S> layout() {
    if (this->once_in(4)) {
      SensorLayout<S> layout;
      for (std::size_t i = this->choice(6); i-- > 0;) {
        const Vec3<S> start = this->vector(S(0.2));
        const Vec3<S> direction = this->direction();
        layout.add(start, direction, this->positive(S(0.2)));
      }
      return layout;
    }
    SensorGridDef<S> grid;
    grid.center = this->vector(S(0.2));
    grid.side_u = {S(0), this->positive(S(0.3)), S(0)};
    grid.side_v = {this->positive(S(0.3)), S(0), S(0)};
    if (this->once_in(8)) grid.side_v = this->vector(S(0.3));
    grid.count_u = this->choice(8);
    grid.count_v = this->choice(8);
    return sensor_grid<S>(grid);
  }
  SensorParameters<S> parameters() {
    SensorParameters<S> p;
    p.normal_stiffness = this->positive(S(50));
    p.normal_damping = this->positive(S(0.1));
    p.static_friction = this->positive(S(2000));
    p.sliding_friction = this->positive(S(1));
    p.breakaway_distance = this->positive(S(2e-3));
    return p;
  }
  PatchDef<S> patch_def() {
    PatchDef<S> def;
    def.sensors = layout();
    def.parameters = parameters();
    if (this->once_in(8)) {
      const std::size_t count = def.sensors.size() + (this->once_in(4) ? 1 : 0);
      for (std::size_t i = 0; i < count; ++i) def.per_sensor.push_back(parameters());
    }
    def.integration = static_cast<Integration>(this->choice(3));
    def.options.law = this->once_in(8) ? Law::ambf : Law::paper;
    def.options.scaling = static_cast<FrictionScaling>(this->choice(3));
    def.options.reset = static_cast<SlipReset>(this->choice(2));
    def.options.normal = static_cast<NormalDirection>(this->choice(2));
    if (this->once_in(8)) def.explicit_below = this->positive(S(5));
    if (this->once_in(4)) def.cast_every = static_cast<std::uint32_t>(this->choice(6));
    if (this->once_in(16)) def.sense_mask = this->byte();
    return def;
  }
};

}  // namespace bristle::test
