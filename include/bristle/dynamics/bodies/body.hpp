/// @file
/// Rigid bodies: what describes one, and the state the step works on.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/collision/filter.hpp>
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
#include <vector>

namespace bristle::inline BRISTLE_ABI {

struct BodyTag;
/// Names a body of a world.
using BodyId = Id<BodyTag>;

struct ShapeTag;
/// Names a shape of a world.
using ShapeId = Id<ShapeTag>;

/// What makes a body move.
enum class Motion {
  /// Nothing: it stays where it is put.
  fixed,
  /// Its velocity, which the caller sets; forces do not change it.
  kinematic,
  /// Forces and impulses.
  dynamic
};

/// Name of it as it stands in messages ("kinematic").
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

/// Axes of the world along and about which a body cannot move. Whatever holds it there is not
/// simulated: it costs nothing and never gives way.
struct LockedAxes {
  /// [-] Whether the centre of mass keeps its x, y, z.
  std::array<bool, 3> linear{};
  /// [-] Whether the body cannot turn about x, y, z.
  std::array<bool, 3> angular{};

  [[nodiscard]] bool any_angular() const { return angular[0] || angular[1] || angular[2]; }
  [[nodiscard]] bool all() const {
    return linear[0] && linear[1] && linear[2] && angular[0] && angular[1] && angular[2];
  }
};

/// Describes one shape of a body to `BodyDef::shapes` or `World::add_shape`.
template <Scalar S>
struct ShapeDef {
  /// [m] The shape.
  Shape<S> shape{};
  /// [m] Pose of the shape's frame in the body frame.
  Transform<S> X_BS{};
  /// [1] Its surface.
  Material<S> material{};
};

/// Describes a body to `World::add_body`.
template <Scalar S>
struct BodyDef {
  /// [-] What makes it move.
  Motion motion = Motion::dynamic;
  /// [kg] Mass, > 0; unset: volume of the shapes times `density`. Ignored unless dynamic.
  std::optional<S> mass = std::nullopt;
  /// [kg/m^3] Density, > 0; used when the mass is unset.
  S density = S(1000);
  /// [m] Centre of mass in the body frame; unset: the shapes'.
  std::optional<Vec3<S>> center_of_mass = std::nullopt;
  /// [kg m^2] Inertia about the centre of mass along the body's axes; symmetric, positive definite,
  /// of a possible body (triangle inequality); unset: the shapes', scaled to the mass, and moved by
  /// the parallel-axis theorem where `center_of_mass` is not the shapes' own.
  std::optional<Mat3<S>> inertia = std::nullopt;
  /// [-] Shape, its frame equal to the body frame; unset: the body touches nothing until
  /// `World::add_shape` gives it a shape, and `mass` and `inertia` must be set if it is dynamic.
  OptionalShape<S> shape{};
  /// [1] Surface of `shape`.
  Material<S> material{};
  /// [-] More shapes, each with a place and a surface of its own. Together with `shape` they are
  /// the body: volumes add up, and count twice where shapes overlap.
  std::vector<ShapeDef<S>> shapes{};
  /// [-] Who may touch and sense it.
  CollisionFilter filter{};
  /// [m] Origin of the body frame in the world.
  Vec3<S> position = Vec3<S>::Zero();
  /// [1] Axes of the body frame in the world, a unit quaternion.
  Quat<S> orientation = Quat<S>::Identity();
  /// [m/s] Velocity of the centre of mass.
  Vec3<S> velocity = Vec3<S>::Zero();
  /// [rad/s] Angular velocity in world axes.
  Vec3<S> angular_velocity = Vec3<S>::Zero();
  /// [1] Factor on the world's gravity.
  S gravity_scale = S(1);
  /// [-] Axes along and about which it cannot move; its velocity there must be zero. Ignored unless
  /// dynamic.
  LockedAxes locked{};
};

/// Since when a body has been at rest, and with whom it sleeps.
template <Scalar S>
struct BodySleep {
  static constexpr std::uint32_t awake = 0xffffffffu;

  /// [s] For how long it has been slower than `SleepDef` allows.
  S rest_time = S(0);
  /// [-] Lowest slot among the bodies it sleeps with; `awake` while it does not.
  std::uint32_t island = awake;
  /// [-] Whether a caller changed it since the last step, so that whom it reaches is woken.
  bool is_stirred = false;
};

/// A body as the step sees it: everything about its centre of mass, axes of the body frame.
template <Scalar S>
struct Body {
  Motion motion = Motion::fixed;
  /// [m] Centre of mass in the body frame.
  Vec3<S> center_B = Vec3<S>::Zero();
  /// [kg], [1/kg] Mass and its inverse; the inverse is zero unless dynamic.
  S mass = S(0);
  S inverse_mass = S(0);
  /// [kg m^2], [1/(kg m^2)] Inertia along the body's axes and its inverse, zero unless dynamic.
  Mat3<S> inertia_B = Mat3<S>::Zero();
  Mat3<S> inverse_inertia_B = Mat3<S>::Zero();
  S gravity_scale = S(1);
  LockedAxes locked{};
  CollisionFilter filter{};

  /// [m] Centre of mass in the world; [1] axes of the body.
  Transform<S> center_pose{};
  /// [m/s, rad/s] Velocity of the centre of mass and angular velocity, world axes.
  Twist<S> twist{};
  /// [N, N m] What the caller applies during the next step, about the centre of mass.
  Wrench<S> applied{};
  BodySleep<S> sleep{};

  [[nodiscard]] bool is_dynamic() const { return motion == Motion::dynamic; }
  /// Whether forces move it along or about any axis.
  [[nodiscard]] bool moves() const { return is_dynamic() && !locked.all(); }
  [[nodiscard]] bool is_asleep() const { return sleep.island != BodySleep<S>::awake; }

  /// Pose of the body frame in the world.
  [[nodiscard]] Transform<S> pose() const {
    return {center_pose.rotation, center_pose.translation - center_pose.rotation * center_B};
  }
  void set_pose(const Transform<S>& X_WB) { center_pose = {X_WB.rotation, X_WB * center_B}; }
  /// [1/kg] Inverse mass along the axes of the world, zero for locked ones.
  [[nodiscard]] Vec3<S> inverse_mass_W() const {
    Vec3<S> result;
    for (std::size_t i = 0; i < 3; ++i) {
      result[static_cast<Eigen::Index>(i)] = locked.linear[i] ? S(0) : inverse_mass;
    }
    return result;
  }
  /// [1/(kg m^2)] Inverse inertia along world axes: that of the axes that are free, among which
  /// alone torques turn the body.
  [[nodiscard]] Mat3<S> inverse_inertia_W() const {
    return inverse_inertia_W(center_pose.rotation_matrix());
  }
  /// The same where the axes of the body are known as a matrix.
  [[nodiscard]] Mat3<S> inverse_inertia_W(const Mat3<S>& R) const {
    if (!locked.any_angular() || !is_dynamic()) return rotated<S>(R, inverse_inertia_B);
    return bristle::inverse_inertia<S>(rotated<S>(R, inertia_B), locked.angular);
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

/// Whether velocities are numbers that a step can compute with.
template <Scalar S>
[[nodiscard]] bool has_finite_square(const Twist<S>& twist) {
  return has_finite_square<S>(twist.linear) && has_finite_square<S>(twist.angular);
}
/// Whether a step can start from a pose: one with a finite square, and a rotation.
template <Scalar S>
[[nodiscard]] bool is_pose(const Transform<S>& X) {
  return has_finite_square<S>(X.translation) && is_unit(X.rotation.coeffs());
}

/// Checks a definition and turns it into a body.
/// @param of_shape  Unit-density mass properties of its shapes; zero mass where there is none.
/// @throws InvalidArgument naming the field.
template <Scalar S>
[[nodiscard]] Body<S> make_body(const BodyDef<S>& def, const MassProperties<S>& of_shape);

/// @throws InvalidArgument naming the field; the shape itself is checked by the backend.
template <Scalar S>
void validate(const ShapeDef<S>& def);

// Implementation -----------------------------------------------------------------------------------

namespace detail {

template <Scalar S>
void require_unit(std::string_view field, const Quat<S>& q) {
  using std::abs;
  require_all_finite(field, q.coeffs());
  require(abs(q.squaredNorm() - S(1)) <= Tolerance<S>::equal(), field, q.norm(),
          "must have length 1");
}

/// Inertia must be symmetric and every principal moment positive and at most the sum of the others:
/// with trace t, both I and t/2 - I are then positive (semi)definite.
template <Scalar S>
void require_possible_inertia(const Mat3<S>& inertia) {
  require_all_finite("BodyDef::inertia", inertia);
  const S trace = inertia.trace();
  require(is_normal(trace) && trace > S(0), "BodyDef::inertia", trace, "must be positive definite");
  require((inertia - inertia.transpose()).cwiseAbs().maxCoeff() <= Tolerance<S>::equal() * trace,
          "BodyDef::inertia", (inertia - inertia.transpose()).cwiseAbs().maxCoeff(),
          "must be symmetric");
  // Of a trace near 1, so that determinants are as far from zero as the matrices are from singular.
  const Mat3<S> scaled = inertia / power_of_two_below(trace);
  const S scale = scaled.trace();
  const S slack = Tolerance<S>::equal() * scale;
  const auto is_definite = [](const Mat3<S>& m, S floor) {
    return m(0, 0) > floor && m.template topLeftCorner<2, 2>().determinant() > floor * m(0, 0) &&
           m.determinant() > floor * m(0, 0) * m(1, 1);
  };
  require(is_definite(scaled, S(0)), "BodyDef::inertia", inertia.diagonal().minCoeff(),
          "must be positive definite");
  const Mat3<S> second_moment = (scale / S(2) + slack) * Mat3<S>::Identity() - scaled;
  require(is_definite(second_moment, S(0)), "BodyDef::inertia", inertia.diagonal().maxCoeff(),
          "must satisfy the triangle inequality of principal moments");
}

/// Raises InvalidArgument, by the fields they follow from, unless the mass of a body and its
/// inertia have inverses.
template <Scalar S>
void require_invertible(const Body<S>& body, const char* of_mass, const char* of_inertia) {
  require_positive(of_mass, body.mass);
  const Vec3<S> moments = body.inertia_B.diagonal();
  const Vec3<S> inverses = body.inverse_inertia_B.diagonal();
  for (Eigen::Index i = 0; i < 3; ++i) {
    const bool is_good =
        is_normal(moments[i]) && is_normal(inverses[i]) && moments[i] > S(0) && inverses[i] > S(0);
    require(is_good, of_inertia, moments[i], "must be > 0, and finite with a finite inverse");
  }
}

/// A velocity along a locked axis would have to be taken away: better to say so.
template <Scalar S>
void require_still(const LockedAxes& locked, const Twist<S>& twist) {
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    require(!locked.linear[i] || twist.linear[axis] == S(0), "velocity", twist.linear[axis],
            "must be zero along locked axes");
    require(!locked.angular[i] || twist.angular[axis] == S(0), "angular_velocity",
            twist.angular[axis], "must be zero about locked axes");
  }
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
  detail::require_all_finite("BodyDef::position", def.position);
  detail::require_unit<S>("BodyDef::orientation", def.orientation);
  detail::require_all_finite("BodyDef::velocity", def.velocity);
  detail::require_all_finite("BodyDef::angular_velocity", def.angular_velocity);
  detail::require_finite("BodyDef::gravity_scale", def.gravity_scale);
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
  body.gravity_scale = def.gravity_scale;
  if (def.motion == Motion::dynamic) {
    detail::require_still(def.locked, Twist<S>{def.velocity, def.angular_velocity});
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
