/// @file
/// Leaves of a tree of triangles that the box of a node of rays meets.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/trees/aabb.hpp>
#include <bristle/geometry/trees/wide_tree.hpp>
#include <bristle/math/pack3.hpp>

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// A box in a frame G that stands in the frame C of a tree, against boxes of the tree. Only six of
/// the fifteen separating axes are tested. Triangles of the remaining boxes are tested more closely
/// anyway.
template <Scalar S>
class BoxInTree {
 public:
  /// @param R_GC, p_GC  Pose of C in G.
  BoxInTree(const Mat3<S>& R_GC, const Vec3<S>& p_GC, const Aabb<S>& box_G)
      : R_GC_(R_GC), p_GC_(p_GC), box_G_(box_G) {
    const Vec3<S> center = box_G.center() - p_GC;
    const Vec3<S> half = box_G.half_extents();
    using std::abs;
    for (int i = 0; i < 3; ++i) {
      const S middle = R_GC(0, i) * center[0] + R_GC(1, i) * center[1] + R_GC(2, i) * center[2];
      const S reach =
          abs(R_GC(0, i)) * half[0] + abs(R_GC(1, i)) * half[1] + abs(R_GC(2, i)) * half[2];
      box_C_.lower[i] = middle - reach;
      box_C_.upper[i] = middle + reach;
    }
  }

  [[nodiscard]] const Mat3<S>& R_GC() const { return R_GC_; }
  [[nodiscard]] const Vec3<S>& p_GC() const { return p_GC_; }
  [[nodiscard]] const Aabb<S>& box_G() const { return box_G_; }
  [[nodiscard]] const Aabb<S>& box_C() const { return box_C_; }

  /// Returns a mask of the boxes in C, given in lanes, that it may overlap.
  [[nodiscard]] BRISTLE_FORCE_INLINE Mask<S> overlaps(const Pack3<S>& lower,
                                                      const Pack3<S>& upper) const {
    Mask<S> found = (lower.x <= box_C_.upper[0]) & (upper.x >= box_C_.lower[0]) &
                    (lower.y <= box_C_.upper[1]) & (upper.y >= box_C_.lower[1]) &
                    (lower.z <= box_C_.upper[2]) & (upper.z >= box_C_.lower[2]);
    const Pack3<S> center = Pack<S>(S(0.5)) * (lower + upper);
    const Pack3<S> half = Pack<S>(S(0.5)) * (upper - lower);
    using std::abs;
    for (int k = 0; k < 3; ++k) {
      const Pack<S> middle =
          p_GC_[k] + (R_GC_(k, 0) * center.x + R_GC_(k, 1) * center.y + R_GC_(k, 2) * center.z);
      const Pack<S> reach =
          abs(R_GC_(k, 0)) * half.x + abs(R_GC_(k, 1)) * half.y + abs(R_GC_(k, 2)) * half.z;
      found = found & (middle - reach <= box_G_.upper[k]) & (middle + reach >= box_G_.lower[k]);
    }
    return found;
  }

 private:
  Mat3<S> R_GC_;
  Vec3<S> p_GC_;
  Aabb<S> box_G_;
  Aabb<S> box_C_;
};

/// Leaves with their boxes, coordinate by coordinate, in whole cache lines.
template <Scalar S>
class alignas(64) LeafList {
 public:
  /// [-] Most leaves. More have too many triangles to be worth a list.
  static constexpr std::size_t capacity = 256;

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] const TriangleRange& operator[](std::size_t i) const { return leaves_[i]; }

  /// Fills the list with the leaves of a tree that a box meets.
  /// @return False if there are too many.
  [[nodiscard]] bool search(const WideTree<S>& tree, const BoxInTree<S>& box);

  /// Fills the list with the leaves of another list that a box meets.
  void filter(const LeafList& from, const BoxInTree<S>& box) {
    size_ = 0;
    from.for_each(box, [&](std::size_t i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        lower_[axis][size_] = from.lower_[axis][i];
        upper_[axis][size_] = from.upper_[axis][i];
      }
      leaves_[size_++] = from.leaves_[i];
      return true;
    });
    finish();
  }

  /// Calls visit(i) -> bool for the leaves that a box meets, until one returns false.
  /// @return True if none did.
  template <typename Visit>
  BRISTLE_FORCE_INLINE bool for_each(const BoxInTree<S>& box, Visit&& visit) const {
    for (std::size_t k = 0; k < size_; k += lanes<S>) {
      const auto lower = Pack3<S>::load(&lower_[0][k], &lower_[1][k], &lower_[2][k]);
      const auto upper = Pack3<S>::load(&upper_[0][k], &upper_[1][k], &upper_[2][k]);
      const std::uint32_t there = first_bits(size_ - k);
      for (std::uint32_t left = bits(box.overlaps(lower, upper)) & there; left != 0;
           left &= left - 1) {
        if (!visit(k + static_cast<std::size_t>(std::countr_zero(left)))) return false;
      }
    }
    return true;
  }

 private:
  /// Fills the last pack behind the last leaf. Its memory may be denormal, which costs a hundred
  /// cycles an operation.
  void finish() {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Pack<S>(S(0)).store(&lower_[axis][size_]);
      Pack<S>(S(0)).store(&upper_[axis][size_]);
    }
  }

  // A pack may be loaded from the last leaf.
  std::array<std::array<S, capacity + 16>, 3> lower_;
  std::array<std::array<S, capacity + 16>, 3> upper_;
  std::array<TriangleRange, capacity> leaves_;
  std::size_t size_ = 0;
};

template <Scalar S>
bool LeafList<S>::search(const WideTree<S>& tree, const BoxInTree<S>& box) {
  using Tree = WideTree<S>;
  size_ = 0;
  if (tree.nodes().empty()) return true;
  std::array<std::uint32_t, Tree::stack_size> stack;
  std::size_t count = 0;
  stack[count++] = 0;
  while (count > 0) {
    const typename Tree::Node& node = tree.nodes()[stack[--count]];
    for (std::size_t k = 0; k < node.children; k += lanes<S>) {
      const auto lower = Pack3<S>::load(&node.lower[0][k], &node.lower[1][k], &node.lower[2][k]);
      const auto upper = Pack3<S>::load(&node.upper[0][k], &node.upper[1][k], &node.upper[2][k]);
      for (std::uint32_t left = bits(box.overlaps(lower, upper)); left != 0; left &= left - 1) {
        const std::size_t i = k + static_cast<std::size_t>(std::countr_zero(left));
        if (node.triangles[i] == 0) {
          stack[count++] = node.first[i];
          continue;
        }
        if (size_ == capacity) return false;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          lower_[axis][size_] = node.lower[axis][i];
          upper_[axis][size_] = node.upper[axis][i];
        }
        leaves_[size_++] = {node.first[i], node.triangles[i]};
      }
    }
  }
  finish();
  return true;
}

/// Side of a solid's surface on which the rays of a node start.
enum class Side { unknown, outside, inside };

/// Knowledge about a node that it inherits from its parent. It spares children a search of their
/// own.
template <Scalar S>
struct KnownOfNode {
  /// Leaves that it may meet, if they were searched; [-] number of lists in use.
  const LeafList<S>* list = nullptr;
  std::size_t lists = 0;
  Side side = Side::unknown;
  /// A box in its frame, if its parent has the same frame.
  const BoxInTree<S>* framed = nullptr;
};

/// Storage for the lists of leaves on the way down. Deeper nodes use the last one.
template <Scalar S>
using LeafLists = std::array<LeafList<S>, 4>;

}  // namespace bristle::inline BRISTLE_ABI::detail
