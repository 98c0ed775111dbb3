/// @file
/// Rays asked of Bullet, in the form of a shape backend.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/rays/ray.hpp>
#include <bristle/geometry/shapes/shapes.hpp>
#include <bristle/math/transform.hpp>

#include <btBulletCollisionCommon.h>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <variant>
#include <vector>

namespace bristle::benchmarks {

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

}  // namespace bristle::benchmarks
