/// @file
/// A solid mesh prepared for single rays, with boxes and triangles in lanes.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/rays/mesh_rays.hpp>
#include <bristle/geometry/rays/ray.hpp>
#include <bristle/geometry/trees/wide_tree.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

namespace bristle::inline BRISTLE_ABI::detail {

/// The triangles of a solid, a `SolidMesh`. Immutable.
template <Scalar S>
class RayMesh {
 public:
  RayMesh() = default;
  /// @param corners_of  Callable: std::array<Vec3<S>, 3> corners_of(triangle), counter-clockwise
  ///                    seen from outside, for each of `count`.
  template <typename CornersOf>
  RayMesh(std::size_t count, const CornersOf& corners_of) : tree_(count, corners_of) {}

  [[nodiscard]] const WideTree<S>& tree() const { return tree_; }
  /// [-] Number of triangles.
  [[nodiscard]] std::size_t size() const { return tree_.size(); }
  /// [m] Corners of a triangle.
  [[nodiscard]] std::array<Vec3<S>, 3> corners(std::uint32_t triangle) const {
    return tree_.corners(triangle);
  }
  /// [m] Box around all triangles.
  [[nodiscard]] Aabb<S> root_box() const { return tree_.box(); }

  /// Calls `visit(triangle, max_distance) -> new max_distance` for every triangle that the ray may
  /// pass before max_distance [m]. It starts as the ray's length. Nearer boxes come first.
  template <typename Visit>
  void walk_ray(const Ray<S>& ray, Visit&& visit) const;

 private:
  WideTree<S> tree_;
};

// Implementation ----------------------------------------------------------------------------------

/// The slab test of ray_box.hpp for all children of a node.
template <Scalar S>
class WideSlabTest {
 public:
  using Node = typename WideTree<S>::Node;

  explicit WideSlabTest(const Ray<S>& ray)
      : origin_(ray.origin), inverse_(cwise_inverse(ray.direction)) {}

  /// Returns a mask of the children, from `k` on in one pack, that the ray enters by `reach`.
  /// Writes the entries to `enter`.
  [[nodiscard]] BRISTLE_FORCE_INLINE std::uint32_t operator()(const Node& node, std::size_t k,
                                                              S reach, S* enter) const {
    Pack<S> first(S(0));
    Pack<S> last(reach);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const S inverse = inverse_[static_cast<int>(axis)];
      const Pack<S> origin(origin_[static_cast<int>(axis)]);
      const bool is_down = inverse < S(0);
      const auto& near = is_down ? node.upper[axis] : node.lower[axis];
      const auto& far = is_down ? node.lower[axis] : node.upper[axis];
      // max and min ignore a NaN, as from 0 times infinity.
      first = max((Pack<S>::load(near.data() + k) - origin) * inverse, first);
      last = min((Pack<S>::load(far.data() + k) - origin) * inverse, last);
    }
    first.store(enter);
    // A ray of NaNs passes every test. Absent children are masked out.
    return bits(first <= last * (S(1) + Tolerance<S>::round_off())) & first_bits(node.children - k);
  }

 private:
  Vec3<S> origin_;
  Vec3<S> inverse_;
};

/// The test of ray_triangle.hpp for triangles in lanes, up to its rounding. It drops the triangles
/// that the exact test would surely miss.
template <Scalar S>
class WideTriangleFilter {
 public:
  explicit WideTriangleFilter(const Ray<S>& ray) {
    int z = 0;
    cwise_abs(ray.direction).maxCoeff(&z);
    const int x = (z + 1) % 3;
    const int y = (z + 2) % 3;
    axis_ = {static_cast<std::size_t>(x), static_cast<std::size_t>(y), static_cast<std::size_t>(z)};
    origin_ = {ray.origin[x], ray.origin[y], ray.origin[z]};
    shear_ = {ray.direction[x] / ray.direction[z], ray.direction[y] / ray.direction[z],
              S(1) / ray.direction[z]};
  }

  /// Returns a mask of the triangles of a leaf that the ray may pass by `reach`.
  [[nodiscard]] BRISTLE_FORCE_INLINE std::uint32_t operator()(const WideTree<S>& tree,
                                                              const TriangleRange& leaf,
                                                              S reach) const {
    return among(tree.row(leaf, 0, 0), leaf.count, leaf.count, reach);
  }
  /// The same for `count` triangles whose corners are in nine rows, as those of a leaf are.
  [[nodiscard]] BRISTLE_FORCE_INLINE std::uint32_t among(const S* rows, std::size_t stride,
                                                         std::size_t count, S reach) const {
    std::uint32_t found = 0;
    for (std::size_t i = 0; i < count; i += lanes<S>) {
      found |= (bits(may_pass(rows + i, stride, reach)) & first_bits(count - i)) << i;
    }
    return found;
  }

 private:
  [[nodiscard]] BRISTLE_FORCE_INLINE Mask<S> may_pass(const S* rows, std::size_t stride,
                                                      S reach) const {
    Pack3<S> p[3];
    Pack<S> size(S(0));
    for (std::size_t c = 0; c < 3; ++c) {
      const Pack<S> x = Pack<S>::load(rows + (3 * c + axis_[0]) * stride) - origin_[0];
      const Pack<S> y = Pack<S>::load(rows + (3 * c + axis_[1]) * stride) - origin_[1];
      const Pack<S> z = Pack<S>::load(rows + (3 * c + axis_[2]) * stride) - origin_[2];
      p[c] = {x - shear_[0] * z, y - shear_[1] * z, shear_[2] * z};
      size = max(size, abs(x) + abs(y) + abs(z));
    }
    const auto& [a, b, c] = p;
    const Pack<S> u = c.x * b.y - c.y * b.x;
    const Pack<S> v = a.x * c.y - a.y * c.x;
    const Pack<S> w = b.x * a.y - b.y * a.x;
    // The shear is at most 1. So each coordinate is at most the size. Its error is some ulp of the
    // size. That of a determinant is some ulp of the square, of two products. Lengths are compared
    // with a height, and both are rounded.
    const Pack<S> slack = Tolerance<S>::round_off() * size;
    const Pack<S> doubt = S(2) * slack * size;
    const Mask<S> is_inside = (min(u, min(v, w)) >= -doubt) | (max(u, max(v, w)) <= doubt);
    return is_inside & (max(a.z, max(b.z, c.z)) >= -slack) &
           (min(a.z, min(b.z, c.z)) <= S(2) * slack + reach);
  }

  std::array<std::size_t, 3> axis_{};
  Vec3<S> origin_;
  Vec3<S> shear_;
};

template <Scalar S>
template <typename Visit>
void RayMesh<S>::walk_ray(const Ray<S>& ray, Visit&& visit) const {
  using Tree = WideTree<S>;
  if (tree_.nodes().empty()) return;
  const WideSlabTest<S> slabs(ray);
  const WideTriangleFilter<S> filter(ray);
  // Finite, so that planes at infinity are beyond it.
  S reach = std::min(ray.length, std::numeric_limits<S>::max() / S(2));
  struct Entry {
    S enter;
    TriangleRange child;
  };
  std::array<Entry, Tree::stack_size> stack;
  std::size_t count = 0;
  Entry next{S(0), {0, 0}};
  for (;;) {
    // The reach may have shrunk since the entry was computed.
    if (!(next.enter <= reach * (S(1) + Tolerance<S>::round_off()))) {
    } else if (next.child.count > 0) {
      for (std::uint32_t left = filter(tree_, next.child, reach); left != 0; left &= left - 1) {
        const auto i = static_cast<std::uint32_t>(std::countr_zero(left));
        reach = visit(tree_.number(next.child.first + i), reach);
      }
    } else {
      const typename Tree::Node& node = tree_.nodes()[next.child.first];
      const std::size_t bottom = count;
      for (std::size_t k = 0; k < node.children; k += lanes<S>) {
        std::array<S, lanes<S>> enter;
        for (std::uint32_t left = slabs(node, k, reach, enter.data()); left != 0;
             left &= left - 1) {
          const auto i = static_cast<std::size_t>(std::countr_zero(left));
          const Entry child{enter[i], {node.first[k + i], node.triangles[k + i]}};
          // Insertion sort: the nearest child goes on top.
          std::size_t at = count++;
          for (; at > bottom && stack[at - 1].enter < child.enter; --at) stack[at] = stack[at - 1];
          stack[at] = child;
        }
      }
    }
    if (count == 0) return;
    next = stack[--count];
  }
}

}  // namespace bristle::inline BRISTLE_ABI::detail
