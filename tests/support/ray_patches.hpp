/// @file
/// Patches of rays against meshes: what they meet by the library and by a search that shares
/// nothing with it but the test of one ray and one triangle, in double.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "support/random.hpp"

#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/geometry/meshes/mesh_tree.hpp>
#include <bristle/geometry/meshes/triangle_mesh.hpp>
#include <bristle/geometry/rays/ray_tree.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace bristle::test {

using namespace bristle::detail;

/// The mesh as rays search it.
template <Scalar S>
RayMesh<S> ray_mesh(const TriangleMesh<S>& mesh) {
  return RayMesh<S>(mesh.triangles.size(), [&](std::uint32_t i) {
    const auto& t = mesh.triangles[i];
    return std::array<Vec3<S>, 3>{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
  });
}

/// A torus about z with circles of 40 and 15 mm: concave, with a hole.
inline TriangleMesh<double> torus_mesh(std::uint32_t around, std::uint32_t across) {
  TriangleMesh<double> mesh;
  for (std::uint32_t i = 0; i < around; ++i) {
    for (std::uint32_t j = 0; j < across; ++j) {
      const double a = 2 * std::numbers::pi * i / around;
      const double b = 2 * std::numbers::pi * j / across;
      const double r = 0.04 + 0.015 * std::cos(b);
      mesh.vertices.push_back({r * std::cos(a), r * std::sin(a), 0.015 * std::sin(b)});
      const std::uint32_t i1 = (i + 1) % around;
      const std::uint32_t j1 = (j + 1) % across;
      mesh.triangles.push_back({i * across + j, i1 * across + j, i1 * across + j1});
      mesh.triangles.push_back({i * across + j, i1 * across + j1, i * across + j1});
    }
  }
  return mesh;
}

/// An angle of 60 x 60 x 40 mm with arms 20 mm thick: concave, with large triangles along the axes.
inline TriangleMesh<double> angle_mesh() {
  const std::array<Vec2<double>, 6> outline{Vec2<double>(0, 0),       Vec2<double>(0.06, 0),
                                            Vec2<double>(0.06, 0.02), Vec2<double>(0.02, 0.02),
                                            Vec2<double>(0.02, 0.06), Vec2<double>(0, 0.06)};
  TriangleMesh<double> mesh;
  for (const double z : {-0.02, 0.02}) {
    for (const Vec2<double>& p : outline) mesh.vertices.push_back({p.x(), p.y(), z});
  }
  for (std::uint32_t i = 0; i < 6; ++i) {
    const std::uint32_t next = (i + 1) % 6;
    mesh.triangles.push_back({i, next, next + 6});
    mesh.triangles.push_back({i, next + 6, i + 6});
  }
  // All corners are seen from the inner one.
  for (const std::array<std::uint32_t, 2>& ends :
       {std::array<std::uint32_t, 2>{4, 5}, {5, 0}, {0, 1}, {1, 2}}) {
    mesh.triangles.push_back({3, ends[1], ends[0]});
    mesh.triangles.push_back({9, ends[0] + 6, ends[1] + 6});
  }
  return mesh;
}

/// A ball of 50 mm with bumps of 1 mm.
inline TriangleMesh<double> bumpy_mesh(std::uint32_t frequency) {
  TriangleMesh<double> mesh = sphere_mesh<double>(0.05, frequency);
  for (Vec3<double>& v : mesh.vertices) {
    v *= 1 + 0.02 * std::sin(900 * v.x()) * std::sin(1000 * v.y()) * std::sin(800 * v.z());
  }
  return mesh;
}

/// Rays in one frame.
template <Scalar S>
struct RayPatch {
  Vec3Array<S> start, direction;
  std::vector<S> length;

  void add(const Vec3<double>& from, const Vec3<double>& along, double reach) {
    const std::size_t i = length.size();
    start.resize(i + 1);
    direction.resize(i + 1);
    start.set(i, from.template cast<S>());
    direction.set(i, along.template cast<S>().normalized());
    length.push_back(S(reach));
  }
  [[nodiscard]] RayBatch<S> batch(const RayTree<S>* ray_tree, S extra = S(0)) const {
    return {start.x,     start.y, start.z, direction.x, direction.y,
            direction.z, length,  extra,   ray_tree};
  }
};

/// How the rays of a patch stand.
enum class PatchKind { pad, convex, scattered, column };

/// A patch at the origin, looking along z.
template <Scalar S>
RayPatch<S> make_rays(PatchKind kind, std::size_t n, double scale, Random& random) {
  RayPatch<S> rays;
  const auto side = static_cast<std::size_t>(std::ceil(std::sqrt(double(n))));
  for (std::size_t i = 0; i < n; ++i) {
    const double u = (double(i % side) / double(side) - 0.5) * 0.03;
    const double v = (double(i / side) / double(side) - 0.5) * 0.03;
    Vec3<double> from(u, v, -0.002);
    Vec3<double> along(0, 0, 1);
    double reach = 0.005;
    if (kind == PatchKind::convex) {
      along = Vec3<double>(u / 0.02, v / 0.02, 1).normalized();
      from = 0.02 * along - Vec3<double>(0, 0, 0.022);
      along = (along + 0.03 * random.in_cube(1.0)).normalized();
    } else if (kind == PatchKind::scattered) {
      from += 0.002 * random.in_cube(1.0);
      along = random.direction<double>();
      reach = random.uniform(0.001, 0.02);
    } else if (kind == PatchKind::column) {
      from = {0.0003 * double(i % 3), 0, 0.0005 * double(i)};
      along = {1, 0, 0};
    }
    rays.add(scale * from, along, scale * reach);
  }
  return rays;
}

/// The same rays in the order in which their nodes have them.
template <Scalar S>
RayPatch<S> in_tree_order(const RayPatch<S>& patch) {
  const RayBatch<S> rays = patch.batch(nullptr);
  const RayTree<S> ray_tree(rays);
  RayPatch<S> result = patch;
  for (std::size_t place = 0; place < ray_tree.size(); ++place) {
    const std::size_t i = ray_tree.ray_at(place);
    result.start.set(place, patch.start[i]);
    result.direction.set(place, patch.direction[i]);
    result.length[place] = patch.length[i];
  }
  return result;
}

/// Reference hit of a ray.
struct ReferenceHit {
  double distance = infinity<double>;
  Vec3<double> normal = Vec3<double>::Zero();
};

/// A mesh as it was rounded to S, asked in double.
template <Scalar S>
class ReferenceMesh {
 public:
  explicit ReferenceMesh(const TriangleMesh<S>& mesh) : tree_(in_double(mesh)) {}

  /// Nearest hit under the rules of ray_shapes.hpp.
  [[nodiscard]] ReferenceHit hit(const Ray<double>& ray) const {
    const TriangleTest<double> test(ray);
    TriangleCrossing<double> nearest;
    std::uint32_t triangle = 0;
    Ray<double> line = ray;
    line.length = infinity<double>;
    tree_.tree().walk_ray(line, [&](std::uint32_t i, double reach) {
      const auto [a, b, c] = tree_.corners(i);
      const TriangleCrossing<double> crossing = test(a, b, c);
      if (!(crossing.distance >= 0 && crossing.distance < nearest.distance)) return reach;
      nearest = crossing;
      triangle = i;
      return nearest.distance;
    });
    if (nearest.distance == infinity<double>) return {};
    if (!nearest.is_front) return {0, -ray.direction};
    if (nearest.distance > ray.length) return {};
    const auto [a, b, c] = tree_.corners(triangle);
    return {nearest.distance, (b - a).cross(c - a).normalized()};
  }

  [[nodiscard]] const std::vector<Vec3<double>>& vertices() const { return tree_.mesh().vertices; }

  /// Returns whether a hit is that of some ray within `error` [m] of the one asked.
  [[nodiscard]] bool allows(const Ray<double>& ray, const ReferenceHit& answer,
                            double error) const {
    const ReferenceHit expected = hit(ray);
    if (agree(answer, expected, expected, error)) return true;
    // Close to a tangent, an edge, a surface or the ray's end. Some such rays, to both sides of it.
    Random random(1);
    ReferenceHit low = expected;
    ReferenceHit high = expected;
    for (int i = 0; i < 64; ++i) {
      Ray<double> other = ray;
      other.origin += error * random.in_cube(1.0);
      other.direction += error / std::max(1e-9, extent()) * random.in_cube(1.0);
      other.direction.normalize();
      other.length = ray.length + (i % 2 == 0 ? error : -error);
      const ReferenceHit met = hit(other);
      if (agree(answer, met, met, error)) return true;
      if (met.distance < low.distance) low = met;
      if (met.distance > high.distance) high = met;
      const bool is_between =
          answer.distance >= low.distance - error && answer.distance <= high.distance + error;
      if (is_between && agree({met.distance, answer.normal}, met, met, error)) return true;
    }
    return false;
  }

 private:
  static bool agree(const ReferenceHit& answer, const ReferenceHit& low, const ReferenceHit& high,
                    double error) {
    if (answer.distance == infinity<double>) return low.distance == infinity<double>;
    if (low.distance == infinity<double>) return false;
    return answer.distance >= low.distance - error && answer.distance <= high.distance + error &&
           (answer.normal - low.normal).norm() < 1e-2;
  }
  [[nodiscard]] double extent() const { return tree_.root_box().half_extents().norm(); }
  static TriangleMesh<double> in_double(const TriangleMesh<S>& mesh) {
    TriangleMesh<double> result;
    for (const Vec3<S>& v : mesh.vertices) result.vertices.push_back(v.template cast<double>());
    result.triangles = mesh.triangles;
    return result;
  }

  MeshTree<double> tree_;
};

/// A mesh of the list above at some size, in S.
template <Scalar S>
TriangleMesh<S> scaled_mesh(const TriangleMesh<double>& mesh, double scale) {
  TriangleMesh<S> result;
  for (const Vec3<double>& v : mesh.vertices) {
    result.vertices.push_back((scale * v).template cast<S>());
  }
  result.triangles = mesh.triangles;
  return result;
}

/// A shape that wanders about a patch: now slowly, now by jumps to where one of some points on its
/// surface is near the patch.
class Wanderer {
 public:
  Wanderer(double scale, std::uint64_t seed, std::vector<Vec3<double>> surface)
      : scale_(scale), random_(seed), surface_(std::move(surface)) {
    jump();
  }

  [[nodiscard]] const Transform<double>& pose() const { return pose_; }
  void step() {
    const double speed = random_.index(10) == 0 ? 0.01 : 0.0005;
    pose_.translation += scale_ * speed * random_.in_cube(1.0);
    const Vec3<double> turn = 20 * speed * random_.in_cube(1.0);
    pose_.rotation = Quat<double>(1, turn.x(), turn.y(), turn.z()).normalized() * pose_.rotation;
    if (random_.index(6) == 0) jump();
  }

 private:
  void jump() {
    // Now and then with faces along the rays and starts on the surface, as far as rounding lets
    // them be.
    const bool is_aligned = random_.index(4) == 0;
    pose_.rotation = random_.rotation<double>();
    if (is_aligned) pose_.rotation.setIdentity();
    pose_.translation = scale_ * 0.004 * random_.in_cube(1.0) -
                        pose_.rotate(surface_[random_.index(surface_.size())]);
    if (!is_aligned) return;
    for (double& x : pose_.translation) x = scale_ * std::round(x / scale_ / 0.001) * 0.001;
  }

  double scale_;
  Random random_;
  std::vector<Vec3<double>> surface_;
  Transform<double> pose_;
};

/// How many answers of a backend about a patch and a mesh on its way are wrong.
/// @param cast  Callable: cast(pose, rays, hits).
template <Scalar S, typename Cast>
std::size_t wrong_answers(const ReferenceMesh<S>& reference, const RayPatch<S>& patch, double scale,
                          int steps, std::uint64_t seed, Cast&& cast) {
  const RayTree<S> ray_tree(patch.batch(nullptr));
  Wanderer wanderer(scale, seed, reference.vertices());
  RayHits<S> hits;
  std::size_t wrong = 0;
  for (int step = 0; step < steps; ++step, wanderer.step()) {
    const Transform<S> X = wanderer.pose().template cast<S>();
    hits.reset(patch.length.size());
    cast(X, patch.batch(&ray_tree), hits);
    // The pose as it was rounded; its rotation as a matrix, as long as S has it.
    const Mat3<double> R = X.rotation_matrix().template cast<double>();
    const Vec3<double> p = X.translation.template cast<double>();
    const double size = 0.2 * scale + p.norm();
    for (std::size_t i = 0; i < patch.length.size(); ++i) {
      const Ray<double> ray{
          R.transpose() * (patch.start[i].template cast<double>() - p),
          (R.transpose() * patch.direction[i].template cast<double>()).normalized(),
          double(patch.length[i])};
      const Vec3<double> normal = R.transpose() * hits.normal[i].template cast<double>();
      const ReferenceHit answer{double(hits.distance[i]), normal};
      wrong += reference.allows(ray, answer, size * double(Tolerance<S>::round_off())) ? 0u : 1u;
    }
  }
  return wrong;
}

}  // namespace bristle::test
