/// @file
/// Entry of a ray into a box: the inner loop of every traversal of a tree.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/rays/ray.hpp>
#include <bristle/geometry/trees/aabb.hpp>

namespace bristle::inline BRISTLE_ABI::detail {

/// Entry of a ray into boxes, by three pairs of planes (Kay and Kajiya 1986). The exit is moved
/// outwards (Ize 2013, "Robust BVH Ray Traversal"). So rounding loses nothing.
template <Scalar S>
class SlabTest {
 public:
  explicit SlabTest(const Ray<S>& ray)
      : origin_(ray.origin), inverse_(cwise_inverse(ray.direction)) {}

  /// [m] Distance of the entry, >= 0. Infinite if the ray does not enter by `max_distance`.
  [[nodiscard]] S enter(const Aabb<S>& box, S max_distance) const {
    S enter = S(0);
    S leave = max_distance;
    for (int i = 0; i < 3; ++i) {
      const S a = (box.lower[i] - origin_[i]) * inverse_[i];
      const S b = (box.upper[i] - origin_[i]) * inverse_[i];
      // A ray within one of the planes gives 0 * infinity = NaN. It loses both comparisons. So the
      // pair of planes sets no bound, as it should.
      const S near = inverse_[i] < S(0) ? b : a;
      const S far = inverse_[i] < S(0) ? a : b;
      if (near > enter) enter = near;
      if (far < leave) leave = far;
    }
    return enter <= leave * (S(1) + Tolerance<S>::round_off()) ? enter : infinity<S>;
  }

 private:
  Vec3<S> origin_;
  Vec3<S> inverse_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
