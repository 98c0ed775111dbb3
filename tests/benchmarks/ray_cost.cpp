// What a ray of a patch costs, asked of the shape alone, and how many answers are wrong.
//
// A pad of 30 x 30 mm with a convex face (radius 150 mm) and n sensors on it meets a box, a ball, a
// capsule, or a bumpy ball as a mesh of 980, 9680 or 100820 triangles. Rays start 2 mm below the
// face, are 5 mm long and scatter by 2 degrees; from step to step the pad moves by 0.1 mm and turns
// by 0.1 degrees, and the shape is as far away as lets about half of the rays hit. Printed in ns a
// ray for each backend, scalar, shape and n:
//
//   alone    one ray after the other         bundles  the same rays as a patch prepares them
//   wrong    of the answers of the bundles, in ppm: hit where there is none, none where there is,
//            or at another distance by more than 2 um (float) or 2 pm (double)
//
// each the sum over all steps of a step's median over 7 runs.
// Usage: benchmark_ray_cost [part of the name of a shape]
// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"

#include <bristle/bristle.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#if defined(BRISTLE_WITH_BULLET)
#include <btBulletCollisionCommon.h>
#endif

using namespace bristle;

namespace {

constexpr double radius = 0.05;
constexpr double degree = std::numbers::pi / 180;

/// A ball with bumps of up to 1.2 mm, 6 to 8 mm long.
TriangleMesh<double> bumpy_ball(std::uint32_t frequency) {
  TriangleMesh<double> mesh = sphere_mesh<double>(radius, frequency);
  for (Vec3<double>& v : mesh.vertices) {
    const Vec3<double> waves(std::sin(v.x() * 900), std::sin(v.y() * 1000), std::sin(v.z() * 800));
    v *= 1 + 0.0012 / radius * waves.prod();
  }
  return mesh;
}

/// Rays of the pad, in its frame: the face's apex in the origin, its normal along z.
SensorLayout<double> pad_rays(std::size_t n) {
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
  return rays;
}

struct Object {
  std::string name;
  Shape<double> shape;
  /// [m] From its middle to its lowest point, about.
  double half_height;
  bool slides;

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
                   AngleAxisd(0.1e-3 / radius * step, Vec3<double>::UnitX());
    }
    return X;
  }
};

/// Nearest hits by the tree and the arithmetic that contacts use, in double.
class Reference {
 public:
  explicit Reference(const Shape<double>& shape) : shape_(AnalyticBackend::make(shape)) {}

  [[nodiscard]] double distance(const Transform<double>& X, const Ray<double>& ray) const {
    const Ray<double> ray_C{X.inverse() * ray.origin, X.inverse().rotate(ray.direction),
                            infinity<double>};
    return std::visit([&](const auto& s) { return distance(s, ray_C); }, shape_->shape());
  }

 private:
  template <typename Primitive>
  static double distance(const Primitive& shape, const Ray<double>& ray) {
    return ray_cast(shape, ray).distance;
  }
  static double distance(const MeshTree<double>& mesh, const Ray<double>& ray) {
    const TriangleTest<double> test(ray);
    TriangleCrossing<double> nearest;
    mesh.tree().walk_ray(ray, [&](std::uint32_t i, double reach) {
      const auto [a, b, c] = mesh.corners(i);
      const TriangleCrossing<double> crossing = test(a, b, c);
      if (!(crossing.distance >= 0 && crossing.distance < nearest.distance)) return reach;
      nearest = crossing;
      return nearest.distance;
    });
    if (nearest.distance == infinity<double>) return nearest.distance;
    return nearest.is_front ? nearest.distance : 0;
  }

  AnalyticBackend::Collidable<double> shape_;
};

#if defined(BRISTLE_WITH_BULLET)
/// Bullet in float as its users ask it: one rayTest of a world of one body for each ray.
class BulletBody {
 public:
  explicit BulletBody(const Shape<float>& shape) : dispatcher_(&configuration_) {
    std::visit([this](const auto& s) { shape_ = make(s); }, shape);
    object_.setCollisionShape(shape_.get());
    world_.addCollisionObject(&object_);
  }
  BulletBody(const BulletBody&) = delete;
  BulletBody& operator=(const BulletBody&) = delete;
  ~BulletBody() { world_.removeCollisionObject(&object_); }

  void cast_rays(const Transform<float>& X, const RayBatch<float>& rays, std::uint32_t tag,
                 RayHits<float>& hits) {
    const auto& q = X.rotation;
    object_.setWorldTransform(
        btTransform(btQuaternion(q.x(), q.y(), q.z(), q.w()), vector(X.translation)));
    world_.updateSingleAabb(&object_);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const Ray<float> ray = rays[i];
      const btVector3 from = vector(ray.origin);
      const btVector3 to = vector(ray.origin + ray.length * ray.direction);
      btCollisionWorld::ClosestRayResultCallback result(from, to);
      world_.rayTest(from, to, result);
      if (!result.hasHit()) continue;
      const btVector3& n = result.m_hitNormalWorld;
      hits.offer(i, {ray.length * result.m_closestHitFraction, {n.x(), n.y(), n.z()}}, tag);
    }
  }

 private:
  static btVector3 vector(const Vec3<float>& v) { return {v.x(), v.y(), v.z()}; }

  std::unique_ptr<btCollisionShape> make(const Box<float>& s) {
    auto box = std::make_unique<btBoxShape>(vector(s.half_extents));
    box->setMargin(0);
    return box;
  }
  std::unique_ptr<btCollisionShape> make(const Sphere<float>& s) {
    return std::make_unique<btSphereShape>(s.radius);
  }
  std::unique_ptr<btCollisionShape> make(const Capsule<float>& s) {
    return std::make_unique<btCapsuleShapeZ>(s.radius, 2 * s.half_length);
  }
  std::unique_ptr<btCollisionShape> make(const TriangleMesh<float>& s) {
    for (const Vec3<float>& v : s.vertices) vertices_.insert(vertices_.end(), v.begin(), v.end());
    for (const auto& t : s.triangles) {
      for (const std::uint32_t v : t) indices_.push_back(static_cast<int>(v));
    }
    triangles_ = std::make_unique<btTriangleIndexVertexArray>(
        static_cast<int>(s.triangles.size()), indices_.data(), static_cast<int>(3 * sizeof(int)),
        static_cast<int>(s.vertices.size()), vertices_.data(), static_cast<int>(3 * sizeof(float)));
    return std::make_unique<btBvhTriangleMeshShape>(triangles_.get(), true);
  }
  template <typename Other>
  std::unique_ptr<btCollisionShape> make(const Other&) {
    return nullptr;  // Not among the objects.
  }

  std::vector<float> vertices_;
  std::vector<int> indices_;
  std::unique_ptr<btTriangleIndexVertexArray> triangles_;
  std::unique_ptr<btCollisionShape> shape_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btCollisionWorld world_{&dispatcher_, &broadphase_, &configuration_};
  btCollisionObject object_;
};

struct BulletBackend {
  template <Scalar S>
  using Collidable = std::shared_ptr<BulletBody>;
  template <Scalar S>
  static std::shared_ptr<BulletBody> make(const Shape<S>& shape) {
    return std::make_shared<BulletBody>(shape);
  }
  static void cast_rays(const std::shared_ptr<BulletBody>& body, const Transform<float>& X,
                        const RayBatch<float>& rays, std::uint32_t tag, RayHits<float>& hits) {
    body->cast_rays(X, rays, tag, hits);
  }
};
#endif

/// [s] Reading it costs little beside the shortest query; medians leave out what others do to the
/// machine.
double now_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// [m] The gap with which about 47 % of the rays hit, over a motion.
double gap_for_half(const Object& object, const Reference& reference,
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
        hits += reference.distance(object.pose(step, gap), ray) <= ray.length ? 1u : 0u;
      }
    }
    (double(hits) > 0.47 * double(all) ? low : high) = gap;
  }
  return (low + high) / 2;
}

template <Scalar S>
struct Measured {
  double alone = 0;
  double bundles = 0;
  double wrong = 0;
  double hits = 0;
};

template <Scalar S, typename Backend>
class RayCost {
 public:
  RayCost(const Object& object, const Reference& reference, std::size_t n, double gap)
      : object_(object),
        reference_(reference),
        layout_(pad_rays(n)),
        gap_(gap),
        shape_(Backend::template make<S>(shape_in_S(object.shape))),
        patch_(make_patch(patch_def(layout_), BodyId{}, Vec3<S>(Vec3<S>::Zero()))) {}

  Measured<S> run() {
    const int steps = layout_.size() <= 100 ? 1000 : (layout_.size() <= 1024 ? 300 : 100);
    Measured<S> sum;
    std::size_t wrong = 0;
    std::size_t checked = 0;
    for (int step = 0; step < steps; ++step) {
      const Transform<S> X = object_.pose(step, gap_).template cast<S>();
      RayBatch<S> batch = patch_.rays(S(0));
      sum.bundles += median_seconds(X, batch);
      if (step % 10 == 0) {
        wrong += wrong_answers(step, batch, sum.hits);
        checked += layout_.size();
      }
      batch.bundles = nullptr;
      sum.alone += median_seconds(X, batch);
    }
    const double rays = double(steps) * double(layout_.size());
    sum.bundles *= 1e9 / rays;
    sum.alone *= 1e9 / rays;
    sum.wrong = 1e6 * double(wrong) / double(checked);
    sum.hits /= double(checked);
    return sum;
  }

 private:
  static Shape<S> shape_in_S(const Shape<double>& shape) {
    if (const auto* mesh = std::get_if<TriangleMesh<double>>(&shape)) {
      TriangleMesh<S> result;
      for (const Vec3<double>& v : mesh->vertices) result.vertices.push_back(v.template cast<S>());
      result.triangles = mesh->triangles;
      return result;
    }
    return std::visit(detail::ShapeCast<S, double>{}, shape);
  }
  static PatchDef<S> patch_def(const SensorLayout<double>& rays) {
    PatchDef<S> def;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      def.sensors.add(rays.start[i].template cast<S>(),
                      rays.direction[i].template cast<S>().normalized(), S(rays.length[i]));
    }
    return def;
  }

  double median_seconds(const Transform<S>& X, const RayBatch<S>& batch) {
    std::array<double, 7> times{};
    for (double& time : times) {
      hits_.reset(batch.size());
      const double start = now_seconds();
      Backend::cast_rays(shape_, X, batch, 0, hits_);
      time = now_seconds() - start;
    }
    std::nth_element(times.begin(), times.begin() + 3, times.end());
    return times[3];
  }

  std::size_t wrong_answers(int step, const RayBatch<S>& batch, double& hits) const {
    // Rounding of coordinates and of a distance along a slanting surface.
    const double tolerance = std::is_same_v<S, float> ? 2e-6 : 2e-12;
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < batch.size(); ++i) {
      const Ray<S> ray = batch[i];
      // The pose and the ray as they were rounded.
      const double expected = reference_.distance(
          object_.pose(step, gap_).template cast<S>().template cast<double>(),
          {ray.origin.template cast<double>(), ray.direction.template cast<double>().normalized(),
           double(ray.length)});
      const double found = double(hits_.distance[i]);
      hits += hits_.is_hit(i) ? 1 : 0;
      const bool is_right = hits_.is_hit(i) ? std::abs(found - expected) <= tolerance
                                            : expected >= double(ray.length) - tolerance;
      wrong += is_right ? 0u : 1u;
    }
    return wrong;
  }

  const Object& object_;
  const Reference& reference_;
  SensorLayout<double> layout_;
  double gap_;
  typename Backend::template Collidable<S> shape_;
  SensorPatch<S> patch_;
  RayHits<S> hits_;
};

template <Scalar S, typename Backend>
void measure(const char* backend, const Object& object, const Reference& reference) {
  for (const std::size_t n : {100u, 1024u, 10000u}) {
    const double gap = gap_for_half(object, reference, pad_rays(n));
    const Measured<S> m = RayCost<S, Backend>(object, reference, n, gap).run();
    std::printf("%-8s  %-6s  %-8s  %5zu  %8.2f  %8.2f  %8.1f  %4.0f %%\n", backend,
                std::is_same_v<S, float> ? "float" : "double", object.name.c_str(), n, m.alone,
                m.bundles, m.wrong, 100 * m.hits);
    std::fflush(stdout);
  }
}

}  // namespace

int main(int argc, char** argv) {
  const Object objects[] = {
      {"box", Box<double>{.half_extents = {0.05, 0.05, 0.05}}, 0.05, true},
      {"sphere", Sphere<double>{radius}, radius, false},
      {"capsule", Capsule<double>{0.02, 0.04}, 0.06, false},
      {"mesh1k", bumpy_ball(7), radius, false},
      {"mesh10k", bumpy_ball(22), radius, false},
      {"mesh100k", bumpy_ball(71), radius, false},
  };
  std::puts("backend   scalar  shape         n     alone   bundles     wrong    hit");
  for (const Object& object : objects) {
    if (argc > 1 && object.name.find(argv[1]) == std::string::npos) continue;
    const Reference reference(object.shape);
    measure<float, AnalyticBackend>("analytic", object, reference);
    measure<double, AnalyticBackend>("analytic", object, reference);
#if defined(BRISTLE_WITH_FCL)
    measure<float, FclBackend>("fcl", object, reference);
    measure<double, FclBackend>("fcl", object, reference);
#endif
#if defined(BRISTLE_WITH_BULLET)
    measure<float, BulletBackend>("bullet", object, reference);
#endif
  }
}
