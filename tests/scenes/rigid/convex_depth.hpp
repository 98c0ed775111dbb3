/// @file
/// How deep two convex bodies are in each other, from how far they reach in each direction.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scenes/rigid/scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace bristle::scenes::detail {

using namespace bristle::detail;

/// A shape where it is.
template <typename Shape>
struct Placed {
  const Shape& shape;
  const BodyState& at;
};

/// [m] How far a shape reaches along a direction of its own frame.
[[nodiscard]] inline double reach(const Sphere<double>& s, const Vector& n) {
  return s.radius * n.norm();
}
[[nodiscard]] inline double reach(const Box<double>& s, const Vector& n) {
  return s.half_extents.dot(n.cwiseAbs());
}
[[nodiscard]] inline double reach(const Capsule<double>& s, const Vector& n) {
  return s.radius * n.norm() + s.half_length * std::abs(n.z());
}
[[nodiscard]] inline double reach(const Cylinder<double>& s, const Vector& n) {
  return s.radius * n.head<2>().norm() + s.half_length * std::abs(n.z());
}
[[nodiscard]] inline double reach(const TriangleMesh<double>& s, const Vector& n) {
  double most = -std::numeric_limits<double>::infinity();
  for (const Vector& v : s.vertices) most = std::max(most, v.dot(n));
  return most;
}

template <typename Shape>
concept Reaching = requires(const Shape& s, const Vector& n) {
  reach(s, n);
};

/// [m] The least way along any direction that parts two convex bodies, < 0 if they are apart.
///
/// Where they are apart some direction separates them, and the search is convex. Where they overlap
/// it starts at all normals that a box would have and takes the least of what it finds from the
/// best three, to about 1e-6 of their size.
template <Reaching A, Reaching B>
[[nodiscard]] double convex_depth(const Placed<A>& a, const Placed<B>& b) {
  const Vector offset = b.at.position - a.at.position;
  const Rotation to_a = a.at.orientation.conjugate();
  const Rotation to_b = b.at.orientation.conjugate();
  const auto overlap = [&](const Vector& n) {
    return reach(a.shape, Vector(to_a * n)) + reach(b.shape, Vector(to_b * Vector(-n))) -
           n.dot(offset);
  };
  struct Start {
    double depth;
    Vector n;
  };
  std::vector<Start> starts;
  const auto add = [&](Vector n) {
    if (!(n.norm() > 1e-6)) return;
    n.normalize();
    if (n.dot(offset) < 0) n = -n;
    starts.push_back({overlap(n), n});
  };
  add(offset);
  const Mat3<double> axes_a = a.at.orientation.toRotationMatrix();
  const Mat3<double> axes_b = b.at.orientation.toRotationMatrix();
  for (int i = 0; i < 3 && starts.back().depth >= 0; ++i) {
    add(axes_a.col(i));
    add(axes_b.col(i));
    for (int j = 0; j < 3; ++j) add(axes_a.col(i).cross(axes_b.col(j)));
  }
  std::ranges::sort(starts, {}, &Start::depth);
  double least = starts.front().depth;
  for (std::size_t k = 0; k < std::min<std::size_t>(3, starts.size()) && least >= 0; ++k) {
    Start best = starts[k];
    for (double step = 0.2; step > 1e-4 && best.depth >= 0;) {
      const Vector u = best.n.unitOrthogonal();
      const Vector v = best.n.cross(u);
      bool is_better = false;
      for (const Vector& way : {u, Vector(-u), v, Vector(-v)}) {
        const Vector n = (best.n + step * way).normalized();
        const double found = overlap(n);
        if (found < best.depth) {
          best = {found, n};
          is_better = true;
          break;
        }
      }
      if (!is_better) step /= 2;
    }
    least = std::min(least, best.depth);
  }
  return least;
}

/// [m] Farthest point of a body from its centre; infinite for a half-space.
[[nodiscard]] inline double outer_radius(const SceneShape& shape) {
  const auto farthest = [](const TriangleMesh<double>& mesh) {
    double most = 0;
    for (const Vector& v : mesh.vertices) most = std::max(most, v.norm());
    return most;
  };
  if (const auto* ball = std::get_if<Sphere<double>>(&shape)) return ball->radius;
  if (const auto* box = std::get_if<Box<double>>(&shape)) return box->half_extents.norm();
  if (const auto* rod = std::get_if<Capsule<double>>(&shape)) return rod->radius + rod->half_length;
  if (const auto* disk = std::get_if<Cylinder<double>>(&shape)) {
    return std::hypot(disk->radius, disk->half_length);
  }
  if (const auto* hull = std::get_if<TriangleMesh<double>>(&shape)) return farthest(*hull);
  if (const auto* surface = std::get_if<Surface>(&shape)) return farthest(surface->mesh);
  return std::numeric_limits<double>::infinity();
}

}  // namespace bristle::scenes::detail
