/// @file
/// Rigid bodies: their definition, and their state in a step.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/collision/filter.hpp>
#include <bristle/core/no_index.hpp>
#include <bristle/core/slot_map.hpp>
#include <bristle/dynamics/bodies/material.hpp>
#include <bristle/geometry/shapes/shapes.hpp>
#include <bristle/math/finite.hpp>
#include <bristle/math/mass_properties.hpp>
#include <bristle/math/spatial.hpp>
#include <bristle/math/transform.hpp>

#include <array>
#include <cstdint>
#include <optional>
#include <type_traits>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

namespace detail {
struct BodyTag;
}  // namespace detail
/// Handle of a body of a world.
using BodyId = detail::Id<detail::BodyTag>;

namespace detail {
struct ShapeTag;
}  // namespace detail
/// Handle of a shape of a world.
using ShapeId = detail::Id<detail::ShapeTag>;

/// Cause of a body's motion.
enum class Motion {
  /// Nothing: the body stays where it is put.
  fixed,
  /// Its own velocity. The caller sets it; forces do not change it.
  kinematic,
  /// Forces and impulses.
  dynamic
};

/// Name in messages ("kinematic").
[[nodiscard]] constexpr const char* name_of(Motion motion) {
  switch (motion) {
    case Motion::fixed:
      return "fixed";
    case Motion::kinematic:
      return "kinematic";
    case Motion::dynamic:
      break;
  }
  return "dynamic";
}

/// World axes along and about which a body cannot move. Whatever holds the body there is not
/// simulated: it costs nothing and never yields.
struct LockedAxes {
  /// [-] True for x, y, z along which the centre of mass cannot move.
  std::array<bool, 3> linear{};
  /// [-] True for x, y, z about which the body cannot turn.
  std::array<bool, 3> angular{};

  /// Returns whether any rotation is locked.
  [[nodiscard]] bool any_angular() const { return angular[0] || angular[1] || angular[2]; }
  /// Returns whether the body cannot move at all.
  [[nodiscard]] bool all() const {
    return linear[0] && linear[1] && linear[2] && angular[0] && angular[1] && angular[2];
  }
};

/// Definition of one shape of a body, for `BodyDef::shapes` or `World::add_shape`.
template <Scalar S>
struct ShapeDef {
  /// [m] The shape.
  Shape<S> shape{};
  /// [m] Pose of the shape's frame in the body frame.
  Transform<S> X_BS{};
  /// [1] Material of its surface.
  Material<S> material{};
  /// [-] True for a region that tells what is in it (`World::for_each_contact_event`) when a step
  /// begins, and pushes nothing. One of the two bodies must be dynamic. Filters hold for it, too.
  /// It adds no mass. Sensors do not sense it, and queries do not meet it unless
  /// `QueryFilter::meets_triggers`.
  bool is_trigger = false;
  /// [-] A number of the caller's, such as an index (`World::user_data`).
  std::uint64_t user_data = 0;
};

/// Definition of a body, for `World::add_body`.
template <Scalar S>
struct BodyDef {
  /// [-] Cause of its motion.
  Motion motion = Motion::dynamic;
  /// [kg] Mass, > 0. Unset: volume of the shapes times `density`. Ignored unless dynamic.
  std::optional<S> mass = std::nullopt;
  /// [kg/m^3] Density, > 0. Used if the mass is unset.
  S density = S(1000);
  /// [m] Centre of mass in the body frame. Unset: that of the shapes.
  std::optional<Vec3<S>> center_of_mass = std::nullopt;
  /// [kg m^2] Inertia about the centre of mass along the body's axes. Symmetric, positive definite,
  /// and of a possible body (triangle inequality). Unset: that of the shapes, scaled to the mass.
  /// The parallel-axis theorem moves it if `center_of_mass` is not that of the shapes.
  std::optional<Mat3<S>> inertia = std::nullopt;
  /// [-] Shape; its frame is the body frame. Unset: the body touches nothing until
  /// `World::add_shape` gives it a shape. If it is dynamic, `mass` and `inertia` must then be set.
  detail::OptionalShape<S> shape{};
  /// [1] Surface of `shape`.
  Material<S> material{};
  /// [-] More shapes, each with its own pose and material. Together with `shape` they make up the
  /// body. Volumes add up. They count twice where shapes overlap.
  std::vector<ShapeDef<S>> shapes{};
  /// [-] Filter of the bodies and sensors that may touch and sense it.
  CollisionFilter filter{};
  /// [m] Origin of the body frame in the world.
  Vec3<S> position = detail::zero<Vec3<S>>();
  /// [1] Axes of the body frame in the world, a unit quaternion.
  Quat<S> orientation = Quat<S>::Identity();
  /// [m/s] Velocity of the centre of mass.
  Vec3<S> velocity = detail::zero<Vec3<S>>();
  /// [rad/s] Angular velocity in world axes.
  Vec3<S> angular_velocity = detail::zero<Vec3<S>>();
  /// [1] Factor on the world's gravity.
  S gravity_scale = S(1);
  /// [1/s] Rate at which the velocity of the centre of mass decays in free motion, >= 0: a force of
  /// -rate * mass * velocity. Ignored unless dynamic.
  S linear_damping = S(0);
  /// [1/s] Rate at which the angular momentum decays, >= 0. Ignored unless dynamic.
  S angular_damping = S(0);
  /// [-] Axes along and about which it cannot move. Its velocity there must be zero. Ignored unless
  /// dynamic.
  LockedAxes locked{};
  /// [-] A number of the caller's for the body and for `shape`, such as an index
  /// (`World::user_data`).
  std::uint64_t user_data = 0;
};

namespace detail {

/// Time at rest of a body, and the bodies that it sleeps with. It is apart from the rest of `Body`
/// so that waking resets all of it at once.
template <Scalar S>
struct BodySleep {
  /// [s] Time for which it has been slower than `SleepDef` allows.
  S rest_time = S(0);
  /// [-] Lowest slot of the bodies that sleep with it. It is `no_index` if the body is awake.
  std::uint32_t island = no_index;
  /// [-] True if a caller changed it since the last step. The next step wakes bodies near it.
  bool is_dirty = false;
};

}  // namespace detail

/// State of a body in a step. It is about the centre of mass, in axes of the body frame. It is the
/// one record that lasts from step to step. Solvers copy from it the fields that they need.
template <Scalar S>
struct Body {
  /// [-] Cause of its motion.
  Motion motion = Motion::fixed;
  /// [m] Centre of mass in the body frame.
  Vec3<S> center_B = detail::zero<Vec3<S>>();
  /// [kg] Mass.
  S mass = S(0);
  /// [1/kg] Inverse of the mass. Zero unless dynamic.
  S inverse_mass = S(0);
  /// [kg m^2] Inertia about the centre of mass, along the body's axes. Zero unless dynamic.
  Mat3<S> inertia_B = detail::zero<Mat3<S>>();
  /// [1/(kg m^2)] Inverse of the inertia, along the body's axes. Zero unless dynamic.
  Mat3<S> inverse_inertia_B = detail::zero<Mat3<S>>();
  /// [1] Factor on the world's gravity. One unless dynamic.
  S gravity_scale = S(1);
  /// [1/s] Rate at which its velocity decays. Zero unless dynamic.
  S linear_damping = S(0);
  /// [1/s] Rate at which its angular momentum decays. Zero unless dynamic.
  S angular_damping = S(0);
  /// [-] World axes along and about which it cannot move.
  LockedAxes locked{};
  /// [-] Filter of the bodies and sensors that may touch and sense it.
  CollisionFilter filter{};

  /// [m], [1] Centre of mass in the world, and axes of the body.
  Transform<S> center_pose{};
  /// [m/s, rad/s] Velocity of the centre of mass and angular velocity, world axes.
  Twist<S> twist{};
  /// [N, N m] Wrench that the caller applies during the next step, about the centre of mass.
  Wrench<S> applied{};
  /// [-] Sleep state.
  detail::BodySleep<S> sleep{};
  /// [-] The caller's number.
  std::uint64_t user_data = 0;

  /// Returns whether forces move it where no axis is locked.
  [[nodiscard]] bool is_dynamic() const { return motion == Motion::dynamic; }
  /// Returns whether forces move it along or about any axis.
  [[nodiscard]] bool moves() const { return is_dynamic() && !locked.all(); }
  /// Returns whether it sleeps.
  [[nodiscard]] bool is_asleep() const { return sleep.island != detail::no_index; }

  /// Pose of the body frame in the world.
  [[nodiscard]] Transform<S> pose() const {
    return {center_pose.rotation, center_pose.translation - center_pose.rotation * center_B};
  }
  /// Places the body frame in the world.
  void set_pose(const Transform<S>& X_WB) { center_pose = {X_WB.rotation, X_WB * center_B}; }
  /// [1/kg] Inverse mass along world axes; zero along locked ones.
  [[nodiscard]] Vec3<S> inverse_mass_W() const {
    Vec3<S> result;
    for (std::size_t i = 0; i < 3; ++i) {
      result[static_cast<Eigen::Index>(i)] = locked.linear[i] ? S(0) : inverse_mass;
    }
    return result;
  }
  /// [1/(kg m^2)] Inverse inertia along world axes. Torques turn the body about free axes only.
  /// Entries of locked axes are zero.
  [[nodiscard]] Mat3<S> inverse_inertia_W() const {
    return inverse_inertia_W(center_pose.rotation_matrix());
  }
  /// The same, with the axes R of the body as a matrix.
  [[nodiscard]] Mat3<S> inverse_inertia_W(const Mat3<S>& R) const {
    if (!locked.any_angular() || !is_dynamic()) return detail::rotated<S>(R, inverse_inertia_B);
    return bristle::inverse_inertia<S>(detail::rotated<S>(R, inertia_B), locked.angular);
  }
  /// [kg m^2/s] Angular momentum about the centre of mass, world axes.
  [[nodiscard]] Vec3<S> angular_momentum() const {
    const Mat3<S> R = center_pose.rotation_matrix();
    return R * (inertia_B * (R.transpose() * twist.angular));
  }
  /// [J] Kinetic energy.
  [[nodiscard]] S kinetic_energy() const {
    return S(0.5) * (mass * twist.linear.squaredNorm() + twist.angular.dot(angular_momentum()));
  }
};

namespace detail {

/// Returns whether a step can compute with these velocities.
template <Scalar S>
[[nodiscard]] bool has_finite_square(const Twist<S>& twist) {
  return has_finite_square<S>(twist.linear) && has_finite_square<S>(twist.angular);
}
/// Returns whether a step can start from a pose. Its square must be finite. Its rotation must have
/// length 1.
template <Scalar S>
[[nodiscard]] bool is_pose(const Transform<S>& X) {
  return has_finite_square<S>(X.translation) && is_unit(X.rotation.coeffs());
}

}  // namespace detail

/// Checks a definition and makes a body of it.
/// @param of_shape  Mass properties of its shapes at unit density. Zero mass if there are none.
/// @throws InvalidArgument naming the field.
template <Scalar S>
[[nodiscard]] Body<S> make_body(const BodyDef<S>& def, const MassProperties<S>& of_shape);

/// Checks a definition but for the shape itself, which the backend checks.
/// @throws InvalidArgument naming the field.
template <Scalar S>
void validate(const ShapeDef<S>& def);

// Implementation ----------------------------------------------------------------------------------

namespace detail {

/// Raises InvalidArgument unless a quaternion is finite and has length 1.
template <Scalar S>
void require_unit(std::string_view field, const Quat<S>& q) {
  using std::abs;
  require_all_finite(field, q.coeffs());
  require(abs(q.squaredNorm() - S(1)) <= Tolerance<S>::equal(), field, q.norm(),
          "must have length 1");
}

/// Raises InvalidArgument unless an inertia is possible. It must be symmetric. Each principal
/// moment must be positive. It must be at most the sum of the others. With trace t, both I and
/// t/2 - I are then positive (semi)definite.
template <Scalar S>
void require_possible_inertia(const Mat3<S>& inertia) {
  require_all_finite("BodyDef::inertia", inertia);
  const S trace = inertia.trace();
  require(is_normal(trace) && trace > S(0), "BodyDef::inertia", trace, "must be positive definite");
  require(cwise_abs(inertia - inertia.transpose()).maxCoeff() <= Tolerance<S>::equal() * trace,
          "BodyDef::inertia", cwise_abs(inertia - inertia.transpose()).maxCoeff(),
          "must be symmetric");
  // Scaled to a trace near 1. Determinants are then as far from zero as the matrices from singular.
  const Mat3<S> scaled = inertia / power_of_two_below(trace);
  const S scale = scaled.trace();
  const S slack = Tolerance<S>::equal() * scale;
  const auto is_definite = [](const Mat3<S>& m, S floor) {
    return m(0, 0) > floor && m(0, 0) * m(1, 1) - m(1, 0) * m(0, 1) > floor * m(0, 0) &&
           m.determinant() > floor * m(0, 0) * m(1, 1);
  };
  require(is_definite(scaled, S(0)), "BodyDef::inertia", diagonal_of<S>(inertia).minCoeff(),
          "must be positive definite");
  const Mat3<S> second_moment = (scale / S(2) + slack) * identity<Mat3<S>>() - scaled;
  require(is_definite(second_moment, S(0)), "BodyDef::inertia", diagonal_of<S>(inertia).maxCoeff(),
          "must satisfy the triangle inequality of principal moments");
}

/// Raises InvalidArgument unless mass and inertia of a body have inverses.
/// @param of_mass, of_inertia  Fields that they follow from.
template <Scalar S>
void require_invertible(const Body<S>& body, const char* of_mass, const char* of_inertia) {
  require_positive(of_mass, body.mass);
  const Vec3<S> moments = diagonal_of<S>(body.inertia_B);
  const Vec3<S> inverses = diagonal_of<S>(body.inverse_inertia_B);
  for (Eigen::Index i = 0; i < 3; ++i) {
    const bool is_good =
        is_normal(moments[i]) && is_normal(inverses[i]) && moments[i] > S(0) && inverses[i] > S(0);
    require(is_good, of_inertia, moments[i], "must be > 0, and finite with a finite inverse");
  }
}

/// Raises InvalidArgument for a velocity along a locked axis: no step could keep it.
/// @param of_linear, of_angular  Fields of the velocities.
template <Scalar S>
void require_still(const LockedAxes& locked, const Twist<S>& twist, const char* of_linear,
                   const char* of_angular) {
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    require(!locked.linear[i] || twist.linear[axis] == S(0), of_linear, twist.linear[axis],
            "must be zero along locked axes");
    require(!locked.angular[i] || twist.angular[axis] == S(0), of_angular, twist.angular[axis],
            "must be zero about locked axes");
  }
}

/// Returns whether the motion of a body decays. Derivatives by a rate count.
/// @param body  A `Body` or `MechanismBody`.
template <typename AnyBody>
[[nodiscard]] bool is_damped(const AnyBody& body) {
  using S = std::remove_cvref_t<decltype(body.linear_damping)>;
  return !(body.linear_damping == S(0)) || !(body.angular_damping == S(0));
}

}  // namespace detail

template <Scalar S>
void validate(const ShapeDef<S>& def) {
  validate(def.material);
  detail::require_all_finite("ShapeDef::X_BS.translation", def.X_BS.translation);
  detail::require_unit<S>("ShapeDef::X_BS.rotation", def.X_BS.rotation);
}

template <Scalar S>
Body<S> make_body(const BodyDef<S>& def, const MassProperties<S>& of_shape) {
  detail::require_enumerator("BodyDef::motion", def.motion, Motion::dynamic);
  detail::require_all_finite("BodyDef::position", def.position);
  detail::require_unit<S>("BodyDef::orientation", def.orientation);
  detail::require_all_finite("BodyDef::velocity", def.velocity);
  detail::require_all_finite("BodyDef::angular_velocity", def.angular_velocity);
  detail::require_finite("BodyDef::gravity_scale", def.gravity_scale);
  detail::require_not_negative("BodyDef::linear_damping", def.linear_damping);
  detail::require_not_negative("BodyDef::angular_damping", def.angular_damping);
  validate(def.material);
  if (def.center_of_mass) {
    detail::require_all_finite("BodyDef::center_of_mass", *def.center_of_mass);
  }

  const auto require_set = [](const MassProperties<S>& shape, const char* field) {
    if (shape.mass > S(0)) return;
    detail::raise(InvalidArgument(field, "unset",
                                  "must be set where there is no shape with a finite volume"));
  };
  Body<S> body;
  body.motion = def.motion;
  body.filter = def.filter;
  body.user_data = def.user_data;
  if (def.motion == Motion::dynamic) {
    body.gravity_scale = def.gravity_scale;
    body.linear_damping = def.linear_damping;
    body.angular_damping = def.angular_damping;
    detail::require_still(def.locked, Twist<S>{def.velocity, def.angular_velocity},
                          "BodyDef::velocity", "BodyDef::angular_velocity");
    body.locked = def.locked;
  }
  body.center_B = def.center_of_mass.value_or(of_shape.center);
  detail::require_all_finite("BodyDef::center_of_mass", body.center_B);
  if (def.motion == Motion::dynamic) {
    if (def.mass) {
      detail::require_positive("BodyDef::mass", *def.mass);
    } else {
      detail::require_positive("BodyDef::density", def.density);
      require_set(of_shape, "BodyDef::mass");
    }
    body.mass = def.mass.value_or(def.density * of_shape.mass);
    if (def.inertia) {
      detail::require_possible_inertia<S>(*def.inertia);
      body.inertia_B = S(0.5) * (*def.inertia + def.inertia->transpose());
    } else {
      require_set(of_shape, "BodyDef::inertia");
      body.inertia_B = (body.mass / of_shape.mass) * of_shape.inertia;
      const Vec3<S> shift = body.center_B - of_shape.center;
      body.inertia_B += point_inertia<S>(body.mass, shift);
    }
    body.inverse_mass = S(1) / body.mass;
    body.inverse_inertia_B = inverse_inertia<S>(body.inertia_B);
    detail::require_invertible(
        body, def.mass ? "BodyDef::mass" : "BodyDef::density: mass of the shapes",
        def.inertia ? "BodyDef::inertia" : "BodyDef::shape: moment of inertia");
  }
  if (def.motion != Motion::fixed) body.twist = {def.velocity, def.angular_velocity};
  body.set_pose({def.orientation.normalized(), def.position});
  detail::require_all_finite("BodyDef::position: centre of mass", body.center_pose.translation);
  return body;
}

}  // namespace bristle::inline BRISTLE_ABI
