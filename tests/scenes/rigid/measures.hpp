/// @file
/// Energy of a scene, and how deep its bodies are in each other by geometry alone, whatever the
/// engine believes.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scenes/rigid/convex_depth.hpp"
#include "scenes/rigid/trial.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace bristle::scenes {

using namespace bristle::detail;

/// [J] Kinetic energy.
[[nodiscard]] double kinetic_energy(const SceneBody& body, const BodyState& state);
/// [J] Kinetic and potential energy.
[[nodiscard]] double energy(const Scene& scene, const SceneBody& body, const BodyState& state);
/// [J] Of all moving bodies.
[[nodiscard]] double total_energy(const Scene& scene, const Engine& engine);
[[nodiscard]] double total_kinetic_energy(const Scene& scene, const Engine& engine);

/// [m] How deep two bodies are in each other, < 0 if they are apart. Known for half-spaces and
/// convex shapes; a body and a `Surface` are never deep.
[[nodiscard]] double depth(const SceneBody& a, const BodyState& state_a, const SceneBody& b,
                           const BodyState& state_b);

/// Returns whether two bodies of a scene collide where they meet.
[[nodiscard]] bool may_meet(const Scene& scene, std::size_t i, std::size_t j);

/// [m] Largest distance between the two points that a joint holds together, of all joints.
[[nodiscard]] double largest_joint_gap(const Scene& scene, const Engine& engine);
/// [rad] Largest angle by which a hinge or a swing is beyond its stops.
[[nodiscard]] double largest_limit_excess(const Scene& scene, const Engine& engine);

/// Depths of all pairs of a scene that may meet and overlap.
struct Overlaps {
  /// [m] Largest and mean depth.
  double largest = 0;
  double mean = 0;
  /// [m^2] Sum of squares.
  double sum_of_squares = 0;
};
[[nodiscard]] Overlaps overlaps(const Scene& scene, const Engine& engine);

// Implementation ----------------------------------------------------------------------------------

inline double kinetic_energy(const SceneBody& body, const BodyState& state) {
  const Vector spin = state.orientation.conjugate() * state.angular_velocity;
  return 0.5 * body.mass * state.velocity.squaredNorm() +
         0.5 * principal_inertia(body).dot(spin.cwiseAbs2());
}

inline double energy(const Scene& scene, const SceneBody& body, const BodyState& state) {
  return kinetic_energy(body, state) - body.mass * scene.gravity.dot(state.position);
}

inline double total_energy(const Scene& scene, const Engine& engine) {
  double sum = 0;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (scene.bodies[i].moves()) sum += energy(scene, scene.bodies[i], engine.state(i));
  }
  return sum;
}

inline double total_kinetic_energy(const Scene& scene, const Engine& engine) {
  double sum = 0;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (scene.bodies[i].moves()) sum += kinetic_energy(scene.bodies[i], engine.state(i));
  }
  return sum;
}

namespace detail {

[[nodiscard]] inline double placed_depth(const Placed<Sphere<double>>& a,
                                         const Placed<Sphere<double>>& b) {
  return a.shape.radius + b.shape.radius - (a.at.position - b.at.position).norm();
}

[[nodiscard]] inline double placed_depth(const Placed<Sphere<double>>& ball,
                                         const Placed<Box<double>>& box) {
  const Vector& half = box.shape.half_extents;
  const Vector centre = box.at.orientation.conjugate() * (ball.at.position - box.at.position);
  const double distance = (centre - centre.cwiseMax(-half).cwiseMin(half)).norm();
  if (distance > 0) return ball.shape.radius - distance;
  return ball.shape.radius + (half - centre.cwiseAbs()).minCoeff();
}
[[nodiscard]] inline double placed_depth(const Placed<Box<double>>& box,
                                         const Placed<Sphere<double>>& ball) {
  return placed_depth(ball, box);
}

/// Separating axes: the least overlap along the face normals and the products of edges.
[[nodiscard]] inline double placed_depth(const Placed<Box<double>>& a,
                                         const Placed<Box<double>>& b) {
  const Mat3<double> axes_a = a.at.orientation.toRotationMatrix();
  const Mat3<double> axes_b = b.at.orientation.toRotationMatrix();
  const Vector offset = b.at.position - a.at.position;
  double least = std::numeric_limits<double>::infinity();
  const auto test = [&](const Vector& direction) {
    const double length = direction.norm();
    if (length < 1e-6) return;  // parallel edges: the face normals cover them
    const Vector n = direction / length;
    least = std::min(least, a.shape.half_extents.dot((axes_a.transpose() * n).cwiseAbs()) +
                                b.shape.half_extents.dot((axes_b.transpose() * n).cwiseAbs()) -
                                std::abs(offset.dot(n)));
  };
  for (int i = 0; i < 3; ++i) {
    test(axes_a.col(i));
    test(axes_b.col(i));
    for (int j = 0; j < 3; ++j) test(axes_a.col(i).cross(axes_b.col(j)));
  }
  return least;
}

template <Reaching Shape>
[[nodiscard]] double placed_depth(const Placed<HalfSpace<double>>& ground,
                                  const Placed<Shape>& body) {
  const Vector n = ground.at.orientation * ground.shape.normal;
  const double height = n.dot(body.at.position - ground.at.position) - ground.shape.offset;
  return reach(body.shape, Vector(body.at.orientation.conjugate() * Vector(-n))) - height;
}
template <Reaching Shape>
[[nodiscard]] double placed_depth(const Placed<Shape>& body,
                                  const Placed<HalfSpace<double>>& ground) {
  return placed_depth(ground, body);
}

template <typename A, typename B>
concept KnownDepth = requires(const Placed<A>& a, const Placed<B>& b) {
  placed_depth(a, b);
};

}  // namespace detail

inline double depth(const SceneBody& a, const BodyState& state_a, const SceneBody& b,
                    const BodyState& state_b) {
  return std::visit(
      [&]<typename A, typename B>(const A& shape_a, const B& shape_b) -> double {
        if constexpr (std::is_same_v<A, HalfSpace<double>> &&
                      std::is_same_v<B, HalfSpace<double>>) {
          return -1;
        } else if constexpr (detail::KnownDepth<A, B>) {
          return detail::placed_depth(detail::Placed<A>{shape_a, state_a},
                                      detail::Placed<B>{shape_b, state_b});
        } else if constexpr (detail::Reaching<A> && detail::Reaching<B>) {
          return detail::convex_depth(detail::Placed<A>{shape_a, state_a},
                                      detail::Placed<B>{shape_b, state_b});
        } else {
          return -1;
        }
      },
      a.shape, b.shape);
}

inline bool may_meet(const Scene& scene, std::size_t i, std::size_t j) {
  const SceneBody& a = scene.bodies[i];
  const SceneBody& b = scene.bodies[j];
  if (!a.moves() && !b.moves()) return false;
  if (a.family != 0 && a.family == b.family) return false;
  const auto meets = [](const SceneBody& one, const SceneBody& other) {
    return one.meets == Meets::everything || (one.meets == Meets::fixed_bodies && !other.moves());
  };
  if (!meets(a, b) || !meets(b, a)) return false;
  return std::ranges::none_of(scene.joints, [&](const SceneJoint& joint) {
    const int first = static_cast<int>(i);
    const int second = static_cast<int>(j);
    return (joint.a == first && joint.b == second) || (joint.a == second && joint.b == first);
  });
}

namespace detail {

/// State of a body of a joint; the world's for -1.
[[nodiscard]] inline BodyState joined_state(const Scene& scene, const Engine& engine, int i) {
  if (i < 0) return {};
  const SceneBody& body = scene.bodies[static_cast<std::size_t>(i)];
  const bool is_known = !body.moves() && !body.is_driven();
  return is_known ? state_at_start(body) : engine.state(static_cast<std::size_t>(i));
}
[[nodiscard]] inline BodyState joined_at_start(const Scene& scene, int i) {
  return i < 0 ? BodyState{} : state_at_start(scene.bodies[static_cast<std::size_t>(i)]);
}
/// The turn of a body since the start.
[[nodiscard]] inline Rotation turn_since(const BodyState& start, const BodyState& now) {
  return now.orientation * start.orientation.conjugate();
}

}  // namespace detail

inline double largest_joint_gap(const Scene& scene, const Engine& engine) {
  double largest = 0;
  for (const SceneJoint& joint : scene.joints) {
    const auto end = [&](int i) -> Vector {
      const BodyState start = detail::joined_at_start(scene, i);
      const BodyState now = detail::joined_state(scene, engine, i);
      return now.position + detail::turn_since(start, now) * Vector(joint.anchor - start.position);
    };
    const double gap = (end(joint.a) - end(joint.b)).norm();
    largest = std::isfinite(gap) ? std::max(largest, gap) : std::numeric_limits<double>::infinity();
  }
  return largest;
}

inline double largest_limit_excess(const Scene& scene, const Engine& engine) {
  double largest = 0;
  for (const SceneJoint& joint : scene.joints) {
    if (!joint.has_limits() && !std::isfinite(joint.swing)) continue;
    const auto turn = [&](int i) {
      return detail::turn_since(detail::joined_at_start(scene, i),
                                detail::joined_state(scene, engine, i));
    };
    const Rotation relative = turn(joint.a).conjugate() * turn(joint.b);
    if (joint.kind == SceneJointKind::hinge) {
      const double angle = 2 * std::atan2(relative.vec().dot(joint.axis), relative.w());
      const double wrapped = std::remainder(angle, 2 * std::numbers::pi);
      largest = std::max({largest, joint.lower - wrapped, wrapped - joint.upper});
    } else {
      const double swing =
          std::acos(std::clamp((relative * joint.axis).dot(joint.axis), -1.0, 1.0));
      largest = std::max(largest, swing - joint.swing);
    }
  }
  return largest;
}

inline Overlaps overlaps(const Scene& scene, const Engine& engine) {
  const std::size_t count = scene.bodies.size();
  std::vector<BodyState> states(count);
  std::vector<double> radii(count);
  for (std::size_t i = 0; i < count; ++i) {
    const SceneBody& body = scene.bodies[i];
    states[i] = body.moves() || body.is_driven() ? engine.state(i) : state_at_start(body);
    radii[i] = detail::outer_radius(body.shape);
  }
  Overlaps result;
  long pairs = 0;
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = i + 1; j < count; ++j) {
      if (!scene.bodies[i].moves() && !scene.bodies[j].moves()) continue;
      const double reach = radii[i] + radii[j];
      if ((states[i].position - states[j].position).squaredNorm() > reach * reach) continue;
      if (!may_meet(scene, i, j)) continue;
      const double d = depth(scene.bodies[i], states[i], scene.bodies[j], states[j]);
      if (!(d > 0)) continue;
      result.largest = std::max(result.largest, d);
      result.sum_of_squares += d * d;
      result.mean += d;
      ++pairs;
    }
  }
  if (pairs > 0) result.mean /= static_cast<double>(pairs);
  return result;
}

}  // namespace bristle::scenes
