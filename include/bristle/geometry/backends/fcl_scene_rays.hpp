/// @file
/// Rays through a scene in FCL's dynamic tree of boxes.
///
/// For users of FCL who need the ray query it lacks. bristle's own world does not use it.
///
/// On AVX machines -march=native needs EIGEN_MAX_ALIGN_BYTES=16. A static_assert says so otherwise.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/backends/fcl_rays.hpp>
#include <bristle/geometry/rays/ray_box.hpp>

#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/narrowphase/collision_object.h>

#include <algorithm>
#include <limits>
#include <type_traits>
#include <utility>

namespace bristle::inline BRISTLE_ABI {

/// Nearest hit of a ray in an FCL scene.
template <Scalar S>
struct FclSceneHit {
  /// Distance and normal, in the world.
  RayHit<S> hit;
  /// The hit object. Null if there is no hit.
  fcl::CollisionObject<S>* object = nullptr;
};

/// Returns the nearest hit of a ray among the objects of an FCL scene, under the rules of
/// ray_shapes.hpp. Of objects at equal distance, the one that FCL's tree yields first.
///
/// The manager must be set up (`setup`, or `update` after objects moved). Objects without a shape
/// in bristle (planes, octrees, point clouds, other meshes than `FclMesh`) are ignored. O(log
/// objects) for short rays. Convex geometry is converted anew for each ray that comes near it, so
/// large convex objects are better given as meshes.
///
/// @param ray  In the world.
template <Scalar S>
[[nodiscard]] FclSceneHit<S> cast_ray(const fcl::DynamicAABBTreeCollisionManager<S>& scene,
                                      const Ray<S>& ray);

/// Returns the hit of a ray in the world with one FCL object. The distance is infinite if there is
/// none, or bristle has no such shape.
template <Scalar S>
[[nodiscard]] RayHit<S> ray_cast(const fcl::CollisionObject<S>& object, const Ray<S>& ray);

// Implementation ----------------------------------------------------------------------------------

namespace detail {

/// True if this translation unit and libfcl agree on the layout of a CollisionObject. That of
/// double holds 4x4 matrices. Eigen aligns them to 64 bytes where the compiler may use AVX-512, and
/// to 32 with AVX; Debian's libfcl was built with 16. A different alignment changes the object's
/// size and the offsets of its members, so FCL and user code read each other's garbage
/// (ipab-slmc/exotica#198). Other scalars are compiled here and not in libfcl.
template <Scalar S>
inline constexpr bool is_fcl_layout_common =
    !std::is_same_v<S, double> || alignof(fcl::CollisionObject<S>) <= 16;

/// Returns whether `from_fcl` knows the geometry.
template <Scalar S>
[[nodiscard]] bool is_known_to_bristle(const fcl::CollisionGeometry<S>& geometry) {
  switch (geometry.getNodeType()) {
    case fcl::GEOM_SPHERE:
    case fcl::GEOM_BOX:
    case fcl::GEOM_CAPSULE:
    case fcl::GEOM_CYLINDER:
    case fcl::GEOM_CONE:
    case fcl::GEOM_ELLIPSOID:
    case fcl::GEOM_HALFSPACE:
    case fcl::GEOM_CONVEX:
      return true;
    case fcl::BV_AABB: {
      const auto& mesh = static_cast<const FclMesh<S>&>(geometry);
      return mesh.getModelType() == fcl::BVH_MODEL_TRIANGLES && mesh.getNumBVs() > 0;
    }
    default:
      return false;
  }
}

/// Descends the tree, nearer boxes first.
template <Scalar S, typename Node>
void cast_below(const Node& node, S enter, const SlabTest<S>& slabs, Ray<S>& ray,
                FclSceneHit<S>& best) {
  if (!(enter <= ray.length * (S(1) + Tolerance<S>::round_off()))) return;
  if (node.isLeaf()) {
    auto* object = static_cast<fcl::CollisionObject<S>*>(node.data);
    const RayHit<S> hit = ray_cast(*object, ray);
    if (hit.distance < best.hit.distance) {
      best = {hit, object};
      ray.length = hit.distance;
    }
    return;
  }
  const auto enter_child = [&](const Node& child) {
    return slabs.enter({child.bv.min_, child.bv.max_}, ray.length);
  };
  const Node* near = node.children[0];
  const Node* far = node.children[1];
  S enter_near = enter_child(*near);
  S enter_far = enter_child(*far);
  if (enter_far < enter_near) {
    std::swap(near, far);
    std::swap(enter_near, enter_far);
  }
  cast_below(*near, enter_near, slabs, ray, best);
  cast_below(*far, enter_far, slabs, ray, best);
}

}  // namespace detail

template <Scalar S>
RayHit<S> ray_cast(const fcl::CollisionObject<S>& object, const Ray<S>& ray) {
  static_assert(detail::is_fcl_layout_common<S>,
                "Define EIGEN_MAX_ALIGN_BYTES=16 for all code that shares fcl::CollisionObject "
                "with a libfcl that was built without -march");
  const fcl::CollisionGeometry<S>* geometry = object.collisionGeometry().get();
  if (!detail::is_known_to_bristle(*geometry)) return {};
  const Mat3<S> R_WO = object.getRotation();
  const Ray<S> ray_O{R_WO.transpose() * (ray.origin - object.getTranslation()),
                     R_WO.transpose() * ray.direction, ray.length};
  RayHit<S> hit = ray_cast(detail::from_fcl(*geometry), ray_O);
  hit.normal = R_WO * hit.normal;
  return hit;
}

template <Scalar S>
FclSceneHit<S> cast_ray(const fcl::DynamicAABBTreeCollisionManager<S>& scene, const Ray<S>& ray) {
  FclSceneHit<S> best;
  const auto* root = scene.getTree().getRoot();
  if (root == nullptr) return best;
  Ray<S> shortened = ray;
  // Finite, so that planes at infinity are beyond it.
  shortened.length = std::min(ray.length, std::numeric_limits<S>::max() / S(2));
  const detail::SlabTest<S> slabs(ray);
  const S enter = slabs.enter({root->bv.min_, root->bv.max_}, shortened.length);
  detail::cast_below(*root, enter, slabs, shortened, best);
  return best;
}

}  // namespace bristle::inline BRISTLE_ABI
