/// @file
/// A scene of rigid bodies that says nothing about the engine that simulates it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/shapes/shape_properties.hpp>
#include <bristle/geometry/shapes/shapes.hpp>
#include <bristle/math/rotation.hpp>

#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace bristle::scenes {

using namespace bristle::detail;

using Vector = Vec3<double>;
using Rotation = Quat<double>;

/// [m/s^2] Gravity on earth, downwards.
inline constexpr double earth_gravity = 9.81;

/// Which bodies a body touches.
enum class Meets { everything, fixed_bodies, nothing };

/// A closed mesh that need not be convex: engines take it triangle by triangle. Its centroid is the
/// origin, and the axes of the body are its principal ones.
struct Surface {
  TriangleMesh<double> mesh;
};

/// Shape of a body. A mesh that is not a `Surface` is closed, convex, and has its centroid at the
/// origin; engines take it as the hull of its vertices.
using SceneShape = std::variant<Sphere<double>, Box<double>, Cylinder<double>, HalfSpace<double>,
                                TriangleMesh<double>, Capsule<double>, Surface>;

/// Where a body is and how it moves: centre of mass, world axes.
struct BodyState {
  Vector position = Vector::Zero();
  Rotation orientation = Rotation::Identity();
  Vector velocity = Vector::Zero();
  Vector angular_velocity = Vector::Zero();
};

/// Where a driven body is at a time [s].
struct Place {
  Vector position = Vector::Zero();
  Rotation orientation = Rotation::Identity();
};
using Path = std::function<Place(double)>;

/// A body with one shape whose centre is its centre of mass. Without mass it stands still, or goes
/// where its path says.
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
  /// [-] True if it can only slide along the x axis of the world.
  bool slides_along_x = false;
  Meets meets = Meets::everything;
  /// [-] Bodies of the same family do not meet each other; 0 is none.
  int family = 0;
  /// [-] Where a body without mass goes, whatever is in its way: a kinematic body. Its `position`,
  /// `orientation` and velocities are those of the path at time 0.
  Path path{};

  [[nodiscard]] bool moves() const { return mass > 0; }
  [[nodiscard]] bool is_driven() const { return !moves() && path != nullptr; }
};

/// Free motion of a joint.
enum class SceneJointKind { ball, hinge };

/// A spring and damper towards an angle (a PD controller).
struct SceneMotor {
  /// [rad] Angle that is wanted.
  double target = 0;
  /// [N m/rad], [N m s/rad] Gains.
  double stiffness = 0;
  double damping = 0;
  /// [N m] Largest torque.
  double max_torque = std::numeric_limits<double>::infinity();

  /// Returns whether it can do nothing.
  [[nodiscard]] bool is_inert() const { return max_torque == 0; }
};

/// A joint between two bodies that do not meet each other; `a` is -1 for the world. Chains list a
/// body after the one it hangs on, each with one joint.
struct SceneJoint {
  int a = -1;
  int b = 0;
  /// [m] Where it is at the start.
  Vector anchor = Vector::Zero();
  SceneJointKind kind = SceneJointKind::ball;
  /// [1] World axis of a hinge at the start, where its angle is 0; and the one that the swing of a
  /// ball joint is counted from.
  Vector axis = Vector::UnitX();
  /// [rad] Smallest and largest angle of a hinge.
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  /// [rad] Largest angle by which `axis`, as each of the two bodies carries it, may part in a ball
  /// joint.
  double swing = std::numeric_limits<double>::infinity();
  /// [-] Motor of a hinge.
  std::optional<SceneMotor> motor = std::nullopt;

  [[nodiscard]] bool has_limits() const { return std::isfinite(lower) || std::isfinite(upper); }
};

/// A rectangle of resistive sensors on a body, in its axes; they look along side_u x side_v.
struct SceneSensors {
  std::size_t body = 0;
  /// [m] Middle and whole sides.
  Vector centre = Vector::Zero();
  Vector side_u = Vector::Zero();
  Vector side_v = Vector::Zero();
  std::size_t count_u = 1;
  std::size_t count_v = 1;
  /// [m] How far they reach beyond the rectangle.
  double reach = 0.005;
  /// [1] Friction; [m] creep; [N] load and [kg] mass they are tuned for. Without load their
  /// constants are 0 and they give no force.
  double friction = 0.8;
  double creep = 5e-4;
  double load = 0;
  double mass = 0;
};

/// All there is to know to set a scene up.
struct Scene {
  std::vector<SceneBody> bodies{};
  std::vector<SceneJoint> joints{};
  std::vector<SceneSensors> sensors{};
  Vector gravity{0, 0, -earth_gravity};
  /// [1] Restitution of every pair.
  double restitution = 0;
  /// [s] How long it runs.
  double duration = 1;
  /// [-] True if a run is too long to repeat it for its timing.
  bool is_large = false;

  /// [-] Adds a body and tells its number.
  std::size_t add(SceneBody body) {
    bodies.push_back(std::move(body));
    return bodies.size() - 1;
  }
};

[[nodiscard]] inline BodyState state_at_start(const SceneBody& body) {
  return {body.position, body.orientation, body.velocity, body.angular_velocity};
}

// Makers; `friction` is that of a pair of such bodies ---------------------------------------------

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

/// The shortest turn that takes the direction of `from` to that of `to`; of the half turns between
/// opposite ones, any.
[[nodiscard]] inline Rotation turn_between(const Vector& from, const Vector& to) {
  const Vector a = from.normalized();
  const Vector b = to.normalized();
  if ((a + b).squaredNorm() < Tolerance<double>::round_off()) {
    return turn_about(a.unitOrthogonal(), std::numbers::pi);
  }
  return exp_rotation<double>(shortest_turn<double>(a, b));
}

/// [rad] Angle between two attitudes.
[[nodiscard]] inline double angle_between(const Rotation& a, const Rotation& b) {
  return log_rotation<double>(a.conjugate() * b).norm();
}

/// A capsule along its z axis.
[[nodiscard]] inline SceneBody capsule_body(const Capsule<double>& shape, double mass,
                                            const Vector& position, double friction) {
  SceneBody body;
  body.shape = shape;
  body.mass = mass;
  body.position = position;
  body.friction = std::sqrt(friction);
  return body;
}

/// A body without mass that follows a path; its velocities at the start are the path's.
[[nodiscard]] inline SceneBody driven_body(SceneShape shape, double friction, Path path) {
  constexpr double little = 1e-6;
  SceneBody body;
  body.shape = std::move(shape);
  body.friction = std::sqrt(friction);
  const Place start = path(0);
  const Place next = path(little);
  body.position = start.position;
  body.orientation = start.orientation;
  body.velocity = (next.position - start.position) / little;
  body.angular_velocity =
      log_rotation<double>(next.orientation * start.orientation.conjugate()) / little;
  body.path = std::move(path);
  return body;
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
  const Shape<double> shape = std::visit(
      []<typename T>(const T& s) {
        if constexpr (std::is_same_v<T, Surface>) {
          return Shape<double>(s.mesh);
        } else {
          return Shape<double>(s);
        }
      },
      body.shape);
  const MassProperties<double> solid = unit_mass_properties(shape);
  return body.mass / solid.mass * solid.inertia.diagonal();
}

}  // namespace bristle::scenes
