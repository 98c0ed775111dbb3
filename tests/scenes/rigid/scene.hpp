/// @file
/// A scene of rigid bodies that says nothing about the engine that simulates it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/shape_properties.hpp>
#include <bristle/geometry/shapes.hpp>
#include <bristle/math/rotation.hpp>

#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

namespace bristle::scenes {

using Vector = Vec3<double>;
using Rotation = Quat<double>;

/// [m/s^2] Gravity on earth, downwards.
inline constexpr double earth_gravity = 9.81;

/// Which bodies a body touches.
enum class Meets { everything, fixed_bodies, nothing };

/// What a body looks like. A mesh is closed, convex, and has its centroid at the origin; engines
/// take it as the hull of its vertices.
using SceneShape = std::variant<Sphere<double>, Box<double>, Cylinder<double>, HalfSpace<double>,
                                TriangleMesh<double>>;

/// A body with one shape whose centre is its centre of mass. Without mass it stands still.
struct SceneBody {
  SceneShape shape{};
  /// [kg] 0: fixed.
  double mass = 0;
  /// [m], [1] Centre of mass and axes in the world.
  Vector position = Vector::Zero();
  Rotation orientation = Rotation::Identity();
  /// [m/s], [rad/s] World axes.
  Vector velocity = Vector::Zero();
  Vector angular_velocity = Vector::Zero();
  /// [1] Friction coefficient of a pair: the product of these.
  double friction = 0;
  /// [1] The same for engines that take the maximum or the minimum of a pair; unset: the square of
  /// `friction`, which is right among bodies of one kind.
  std::optional<double> friction_if_maximum = std::nullopt;
  std::optional<double> friction_if_minimum = std::nullopt;
  /// [kg m^2] About the body's axes; unset: the shape's.
  std::optional<Vector> principal_inertia = std::nullopt;
  /// [-] Whether all it can do is slide along the x axis of the world.
  bool slides_along_x = false;
  Meets meets = Meets::everything;

  [[nodiscard]] bool moves() const { return mass > 0; }
};

/// A ball joint between two bodies; `a` is -1 for the world. Chains list a body after the one it
/// hangs on, each with one joint.
struct SceneJoint {
  int a = -1;
  int b = 0;
  /// [m] Where it is at the start.
  Vector anchor = Vector::Zero();
};

/// All there is to know to set a scene up.
struct Scene {
  std::vector<SceneBody> bodies;
  std::vector<SceneJoint> joints;
  Vector gravity{0, 0, -earth_gravity};
  /// [1] Restitution of every pair.
  double restitution = 0;
  /// [s] How long it runs.
  double duration = 1;
  /// [-] Whether a run is too long to repeat it for its timing.
  bool is_large = false;

  /// [-] Adds a body and tells its number.
  std::size_t add(SceneBody body) {
    bodies.push_back(std::move(body));
    return bodies.size() - 1;
  }
};

/// Where a body is and how it moves: centre of mass, world axes.
struct BodyState {
  Vector position = Vector::Zero();
  Rotation orientation = Rotation::Identity();
  Vector velocity = Vector::Zero();
  Vector angular_velocity = Vector::Zero();
};

[[nodiscard]] inline BodyState state_at_start(const SceneBody& body) {
  return {body.position, body.orientation, body.velocity, body.angular_velocity};
}

// Makers; `friction` is that of a pair of such bodies
// -----------------------------------------------

[[nodiscard]] inline SceneBody floor_body(double friction, const Vector& normal = Vector::UnitZ()) {
  SceneBody body;
  body.shape = HalfSpace<double>{normal, 0};
  body.friction = std::sqrt(friction);
  return body;
}

[[nodiscard]] inline SceneBody box_body(const Vector& half, double mass, const Vector& position,
                                        double friction) {
  SceneBody body;
  body.shape = Box<double>{half};
  body.mass = mass;
  body.position = position;
  body.friction = std::sqrt(friction);
  return body;
}

[[nodiscard]] inline SceneBody ball_body(double radius, double mass, const Vector& position,
                                         double friction) {
  SceneBody body;
  body.shape = Sphere<double>{radius};
  body.mass = mass;
  body.position = position;
  body.friction = std::sqrt(friction);
  return body;
}

[[nodiscard]] inline Rotation turn_about(const Vector& axis, double angle) {
  return exp_rotation<double>(angle * axis);
}

/// [rad] Angle between two attitudes.
[[nodiscard]] inline double angle_between(const Rotation& a, const Rotation& b) {
  return log_rotation<double>(a.conjugate() * b).norm();
}

/// [kg m^2] Principal moments of a body along its own axes.
[[nodiscard]] inline Vector principal_inertia(const SceneBody& body) {
  if (body.principal_inertia) return *body.principal_inertia;
  if (const auto* ball = std::get_if<Sphere<double>>(&body.shape)) {
    return Vector::Constant(0.4 * body.mass * ball->radius * ball->radius);
  }
  if (const auto* box = std::get_if<Box<double>>(&body.shape)) {
    const Vector square = box->half_extents.cwiseAbs2();
    return body.mass / 3 *
           Vector(square.y() + square.z(), square.x() + square.z(), square.x() + square.y());
  }
  const Shape<double> shape =
      std::visit([](const auto& s) { return Shape<double>(s); }, body.shape);
  const MassProperties<double> solid = unit_mass_properties(shape);
  return body.mass / solid.mass * solid.inertia.diagonal();
}

}  // namespace bristle::scenes
