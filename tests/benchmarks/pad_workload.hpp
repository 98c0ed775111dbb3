/// @file
/// The workload of the benchmarks of rays and sensors: a pad over objects that half of its rays
/// hit.
///
/// A pad of 30 x 30 mm with a convex face (radius 150 mm) and n sensors on it meets a box, a ball,
/// a capsule, or a bumpy ball as a mesh of 980, 9680 or 100820 triangles. Rays start 2 mm below the
/// face, are 5 mm long and scatter by 2 degrees; from step to step the object moves by 0.1 mm and
/// turns by 0.1 degrees, and it is as far away as lets about half of the rays hit.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "support/random.hpp"

#include <bristle/geometry/backends/analytic_backend.hpp>
#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/sensors/neighbour_order.hpp>
#include <bristle/sensors/sensor_layout.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

namespace bristle::benchmarks {

using namespace bristle::detail;

/// [m] Of the balls.
inline constexpr double ball_radius = 0.05;
/// [rad]
inline constexpr double degree = std::numbers::pi / 180;

/// A ball with bumps of up to 1.2 mm, 6 to 8 mm long.
[[nodiscard]] inline TriangleMesh<double> bumpy_ball(std::uint32_t frequency) {
  TriangleMesh<double> mesh = sphere_mesh<double>(ball_radius, frequency);
  for (Vec3<double>& v : mesh.vertices) {
    const Vec3<double> waves(std::sin(v.x() * 900), std::sin(v.y() * 1000), std::sin(v.z() * 800));
    v *= 1 + 0.0012 / ball_radius * waves.prod();
  }
  return mesh;
}

/// A shape in another scalar.
template <Scalar S>
[[nodiscard]] Shape<S> shape_as(const Shape<double>& shape) {
  if (const auto* mesh = std::get_if<TriangleMesh<double>>(&shape)) {
    TriangleMesh<S> result;
    for (const Vec3<double>& v : mesh->vertices) result.vertices.push_back(v.template cast<S>());
    result.triangles = mesh->triangles;
    return result;
  }
  return std::visit(detail::ShapeCast<S, double>{}, shape);
}

/// Rays of the pad, in its frame: the face's apex in the origin, its normal along z. As many as a
/// square has that comes nearest to n, row by row or in the order of neighbours.
[[nodiscard]] inline SensorLayout<double> pad_rays(std::size_t n, bool in_rows = true) {
  test::Random random(1);
  const auto side = static_cast<std::size_t>(std::lround(std::sqrt(double(n))));
  const double spacing = 0.03 / double(side);
  const Vec3<double> center(0, 0, -0.15);
  SensorLayout<double> rays;
  for (std::size_t i = 0; i < side * side; ++i) {
    const double x = (double(i % side) + random.uniform(0.2, 0.8)) * spacing - 0.015;
    const double y = (double(i / side) + random.uniform(0.2, 0.8)) * spacing - 0.015;
    const Vec3<double> normal =
        (Vec3<double>(x, y, std::sqrt(0.0225 - x * x - y * y))).normalized();
    const Vec3<double> direction = (normal + 2 * degree * random.in_cube(0.7)).normalized();
    rays.add(center + 0.148 * normal, direction, 0.005);
  }
  return in_rows ? rays : in_order<double>(rays, neighbour_order(rays));
}

/// The same in another scalar.
template <Scalar S>
[[nodiscard]] SensorLayout<S> layout_as(const SensorLayout<double>& rays) {
  SensorLayout<S> result;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    result.add(rays.start[i].template cast<S>(), rays.direction[i].template cast<S>().normalized(),
               S(rays.length[i]));
  }
  return result;
}

/// Body that the pad meets, and its motion.
struct Object {
  std::string name;
  Shape<double> shape;
  /// [m] From its middle to its lowest point, about.
  double half_height = ball_radius;
  bool slides = false;

  /// Where it is in the pad's frame after some steps, its lowest point `gap` above the face.
  [[nodiscard]] Transform<double> pose(int step, double gap) const {
    using Eigen::AngleAxisd;
    Transform<double> X;
    X.translation = {0, 0, half_height + gap};
    if (slides) {
      const double way = std::abs(std::fmod(0.1e-3 * step, 0.08) - 0.04) - 0.02;
      X.translation.x() = way;
      X.rotation = AngleAxisd(way / 0.002 * degree, Vec3<double>::UnitZ());
    } else {
      X.rotation = AngleAxisd(0.1 * degree * step, Vec3<double>::UnitZ()) *
                   AngleAxisd(0.1e-3 / ball_radius * step, Vec3<double>::UnitX());
    }
    return X;
  }
};

/// The objects whose name contains `part`.
[[nodiscard]] inline std::vector<Object> pad_objects(const std::string& part = "") {
  std::vector<Object> objects = {
      {"box", Box<double>{.half_extents = {0.05, 0.05, 0.05}}, 0.05, true},
      {"sphere", Sphere<double>{ball_radius}},
      {"capsule", Capsule<double>{0.02, 0.04}, 0.06},
      {"mesh1k", bumpy_ball(7)},
      {"mesh10k", bumpy_ball(22)},
      {"mesh100k", bumpy_ball(71)},
  };
  std::erase_if(objects, [&](const Object& o) { return o.name.find(part) == std::string::npos; });
  return objects;
}

/// Nearest hits by the tree and the arithmetic that contacts use, in double.
class Reference {
 public:
  explicit Reference(const Shape<double>& shape) : shape_(AnalyticBackend::make(shape)) {}

  /// Of a ray as long as it wants, with the shape at X.
  [[nodiscard]] RayHit<double> hit(const Transform<double>& X, const Ray<double>& ray) const {
    const Transform<double> X_CR = X.inverse();
    const Ray<double> ray_C{X_CR * ray.origin, X_CR.rotate(ray.direction), infinity<double>};
    RayHit<double> hit =
        std::visit([&](const auto& s) { return nearest(s, ray_C); }, shape_->shape());
    hit.normal = X.rotate(hit.normal);
    return hit;
  }

 private:
  template <typename Primitive>
  static RayHit<double> nearest(const Primitive& shape, const Ray<double>& ray) {
    return ray_cast(shape, ray);
  }
  static RayHit<double> nearest(const MeshTree<double>& mesh, const Ray<double>& ray) {
    const TriangleTest<double> test(ray);
    TriangleCrossing<double> nearest;
    Vec3<double> normal = -ray.direction;
    mesh.tree().walk_ray(ray, [&](std::uint32_t i, double reach) {
      const auto [a, b, c] = mesh.corners(i);
      const TriangleCrossing<double> crossing = test(a, b, c);
      if (!(crossing.distance >= 0 && crossing.distance < nearest.distance)) return reach;
      nearest = crossing;
      normal = (b - a).cross(c - a).normalized();
      return nearest.distance;
    });
    if (nearest.distance == infinity<double>) return {};
    if (!nearest.is_front) return {0, -ray.direction};
    return {nearest.distance, normal};
  }

  AnalyticBackend::Collidable<double> shape_;
};

/// [m] The gap with which about 47 % of the rays hit, over a motion.
[[nodiscard]] inline double gap_for_half(const Object& object, const Reference& reference,
                                         const SensorLayout<double>& rays) {
  double low = -0.002;
  double high = 0.005;
  for (int i = 0; i < 12; ++i) {
    const double gap = (low + high) / 2;
    std::size_t hits = 0;
    std::size_t all = 0;
    for (int step = 0; step < 300; step += 37) {
      for (std::size_t k = 0; k < rays.size(); k += 1 + rays.size() / 200, ++all) {
        const Ray<double> ray{rays.start[k], rays.direction[k], rays.length[k]};
        hits += reference.hit(object.pose(step, gap), ray).distance <= ray.length ? 1u : 0u;
      }
    }
    (double(hits) > 0.47 * double(all) ? low : high) = gap;
  }
  return (low + high) / 2;
}

/// Returns whether a distance is right within 2 um (float) or 2 pm (double). That is the rounding
/// of coordinates and of a distance along a slanting surface. `expected` may lie beyond the ray's
/// end.
template <Scalar S>
[[nodiscard]] bool is_right(S found, double expected, double length) {
  const double tolerance = std::is_same_v<S, float> ? 2e-6 : 2e-12;
  return found < infinity<S> ? std::abs(double(found) - expected) <= tolerance
                             : expected >= length - tolerance;
}

}  // namespace bristle::benchmarks
