/// @file
/// Watertight, two-sided test of a ray against triangles.
///
/// After Woop, Benthin, Wald 2013, "Watertight Ray/Triangle Intersection". Space is sheared so that
/// the ray runs along one axis. The signs of three 2x2 determinants then say whether it passes
/// inside. Two triangles with a common edge compute the same determinant with opposite sign. So no
/// ray slips through between them. For that the sign must be right whatever the compiler fuses. A
/// doubtful sign is computed again by Kahan's method, which is exact (Jeannerod, Louvet, Muller
/// 2013, "Further analysis of Kahan's algorithm for the accurate computation of 2x2 determinants").
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/rays/ray.hpp>

#include <algorithm>
#include <cmath>
#include <concepts>
#include <utility>

namespace bristle::inline BRISTLE_ABI::detail {

/// Crossing of a ray's line with a triangle.
template <Scalar S>
struct TriangleCrossing {
  /// [m] Distance from the ray's start. Infinite if there is none, negative behind the start.
  S distance = infinity<S>;
  /// [m] Bound of the rounding error of `distance`. Large if the ray runs nearly in the plane.
  S uncertainty = S(0);
  /// True if the ray sees the side from which the corners run counter-clockwise.
  bool is_front = false;
};

/// A ray prepared for many triangles.
template <Scalar S>
class TriangleTest {
 public:
  /// @param ray  Its length is ignored.
  explicit TriangleTest(const Ray<S>& ray) : origin_(ray.origin) {
    cwise_abs(ray.direction).maxCoeff(&kz_);
    kx_ = (kz_ + 1) % 3;
    ky_ = (kx_ + 1) % 3;
    // Along a negative axis the other two swap. So no triangle turns its back.
    if (ray.direction[kz_] < S(0)) std::swap(kx_, ky_);
    shear_ = {ray.direction[kx_] / ray.direction[kz_], ray.direction[ky_] / ray.direction[kz_],
              S(1) / ray.direction[kz_]};
  }

  /// Edges and corners belong to the triangle. A triangle seen edge-on has no crossing.
  [[nodiscard]] TriangleCrossing<S> operator()(const Vec3<S>& a, const Vec3<S>& b,
                                               const Vec3<S>& c) const {
    const Vec3<S> pa = sheared(a);
    const Vec3<S> pb = sheared(b);
    const Vec3<S> pc = sheared(c);
    const S u = determinant(pc.x(), pc.y(), pb.x(), pb.y());
    const S v = determinant(pa.x(), pa.y(), pc.x(), pc.y());
    const S w = determinant(pb.x(), pb.y(), pa.x(), pa.y());
    if ((u < S(0) || v < S(0) || w < S(0)) && (u > S(0) || v > S(0) || w > S(0))) return {};
    const S sum = u + v + w;
    if (!(value_of(sum) != 0)) return {};
    const S distance = (u * pa.z() + v * pb.z() + w * pc.z()) / sum;
    return {distance, uncertainty(pa, pb, pc, sum), sum > S(0)};
  }

 private:
  /// A corner relative to the ray: x and y across it, z along it.
  [[nodiscard]] Vec3<S> sheared(const Vec3<S>& corner) const {
    const Vec3<S> p = corner - origin_;
    return {p[kx_] - shear_.x() * p[kz_], p[ky_] - shear_.y() * p[kz_], shear_.z() * p[kz_]};
  }

  /// px qy - py qx, with the right sign. Exactly minus itself when p and q swap.
  [[nodiscard]] static S determinant(S px, S py, S qx, S qy) {
    using std::abs;
    const S left = px * qy;
    const S right = py * qx;
    const S difference = left - right;
    if constexpr (std::floating_point<S>) {
      if (abs(difference) <= Tolerance<S>::round_off() * (abs(left) + abs(right))) {
        const S error = std::fma(-py, qx, right);
        return std::fma(px, qy, -right) + error;
      }
    }
    return difference;
  }

  /// Error bound of the weighted mean of the corners' distances, from rounding of the corners
  /// (their size along the ray) and of the determinants (their size across it).
  [[nodiscard]] static S uncertainty(const Vec3<S>& a, const Vec3<S>& b, const Vec3<S>& c, S sum) {
    using std::abs;
    const S across = cwise_abs(xy_of(a)).maxCoeff() + cwise_abs(xy_of(b)).maxCoeff() +
                     cwise_abs(xy_of(c)).maxCoeff();
    const S nearest = std::min({a.z(), b.z(), c.z()});
    const S farthest = std::max({a.z(), b.z(), c.z()});
    const S along = std::max(abs(nearest), abs(farthest));
    return Tolerance<S>::round_off() *
           (along + (across + along) * across * (farthest - nearest) / abs(sum));
  }

  Vec3<S> origin_;
  Vec3<S> shear_;
  int kx_ = 0;
  int ky_ = 0;
  int kz_ = 0;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
