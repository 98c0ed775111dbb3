/// @file
/// Triangles near a node of rays, in the node's frame. Rays in lanes are tested against them.
///
/// The test is that of ray_triangle.hpp in another frame. There a doubtful sign is computed again
/// exactly. Here a ray that passes an edge closer than the test's rounding is cast again alone.
/// Turning puts each corner in one place for all its triangles. So no ray slips through between two
/// of them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/rays/ray_tree.hpp>
#include <bristle/geometry/rays/ray_tree_leaves.hpp>
#include <bristle/geometry/trees/wide_tree.hpp>
#include <bristle/math/pack3.hpp>

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// Crossings found so far of rays in lanes. The rules are those of `MeshCrossings`, with two
/// exceptions. Crossings beyond a ray's end are ignored. One error bound serves all crossings of a
/// ray.
template <Scalar S>
struct LaneCrossings {
  /// [m] Nearest crossing of each kind, and the error bound of all of them.
  Pack<S> front{infinity<S>}, back{infinity<S>};
  Pack<S> uncertainty{S(0)};
  /// [-] Number of the triangle that was crossed from its front; [1] its outward unit normal.
  Pack<S> number{infinity<S>};
  Pack3<S> normal{S(0), S(0), S(0)};
  /// Rays that pass an edge too closely to tell.
  Mask<S> is_doubtful = Mask<S>::first(0);
};

/// Rays in lanes, as `RayTree::Lines` has them.
template <Scalar S>
struct LaneRays {
  Pack<S> x, y, slope_x, slope_y, start, stretch, length;
};

/// Candidates for the rays of one node, coordinate by coordinate.
template <Scalar S>
class NodeTriangles {
 public:
  /// [-] Most candidates. Their numbers fit into a byte.
  static constexpr std::size_t capacity = 192;

  [[nodiscard]] std::size_t size() const { return size_; }
  void clear() { size_ = 0; }

  /// Adds those triangles of a leaf that the box meets.
  /// @return False if the capacity is exceeded. Only `clear` may be called then.
  [[nodiscard]] bool add(const WideTree<S>& tree, const TriangleRange& leaf,
                         const BoxInTree<S>& box);

  /// Returns whether one of a leaf's triangles meets the box, to rounding. Boxes are inflated by
  /// that.
  [[nodiscard]] static bool is_any_in(const WideTree<S>& tree, const TriangleRange& leaf,
                                      const BoxInTree<S>& box);

  /// Finishes the list after the last `add`.
  /// @param R_RG  Rotation from the node's axes to those of the normals.
  /// @param size  [m] Size of the coordinates' sources, to which rounding is relative.
  void finish(const RayTreeNode<S>& node, const Mat3<S>& R_RG, S size);

  /// Writes to `found` the candidates whose boxes meet a box. Returns their number.
  std::size_t within(const Aabb<S>& box, std::array<std::uint8_t, capacity>& found) const;

  /// [m] Range of the candidate along z.
  [[nodiscard]] S lowest(std::size_t i) const { return lower_[2][i]; }
  [[nodiscard]] S highest(std::size_t i) const { return upper_[2][i]; }

  /// Tests rays against candidate i.
  BRISTLE_FORCE_INLINE void test(std::size_t i, const LaneRays<S>& rays,
                                 LaneCrossings<S>& found) const;

 private:
  // A pack may be loaded from the last candidate.
  using Row = std::array<S, capacity + 16>;

  /// [m] Corner c of the triangles of a leaf from its i-th on, in the frame of the tree.
  [[nodiscard]] BRISTLE_FORCE_INLINE static Pack3<S> corner(const WideTree<S>& tree,
                                                            const TriangleRange& leaf,
                                                            std::size_t c, std::size_t i) {
    return Pack3<S>::load(tree.row(leaf, c, 0) + i, tree.row(leaf, c, 1) + i,
                          tree.row(leaf, c, 2) + i);
  }

  /// Corners of triangles in lanes, in the node's frame. `in_box` marks those that meet the box.
  struct Turned {
    Pack3<S> corners[3];
    std::uint32_t in_box;
  };
  [[nodiscard]] BRISTLE_FORCE_INLINE static Turned turned(const WideTree<S>& tree,
                                                          const TriangleRange& leaf, std::size_t i,
                                                          const BoxInTree<S>& box);

  // Rows of each corner's x, y, z, and of the triangles' numbers [-]. They are adjacent, so that
  // `add` goes from row to row by a constant step. As one long row, rays took up to 7 % more time.
  static constexpr std::size_t number_row = 9;
  std::array<Row, number_row + 1> rows_;
  std::array<Row, 3> lower_, upper_;
  std::array<Row, 3> normal_;
  // `doubt_`: [m^2] error bound of a determinant of turned corners. The error of distances is
  // `along_` [m] plus `across_` [m^3] over the sum of determinants.
  Row doubt_, along_, across_;
  std::size_t size_ = 0;
};

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
BRISTLE_FORCE_INLINE auto NodeTriangles<S>::turned(const WideTree<S>& tree,
                                                   const TriangleRange& leaf, std::size_t i,
                                                   const BoxInTree<S>& box) -> Turned {
  Turned result;
  const Pack3<S> origin = Pack3<S>::all(box.p_GC());
  for (std::size_t c = 0; c < 3; ++c) {
    result.corners[c] = origin + box.R_GC() * corner(tree, leaf, c, i);
  }
  const auto& [a, b, c] = result.corners;
  const Aabb<S>& limits = box.box_G();
  const Mask<S> in_box =
      (min(a.x, min(b.x, c.x)) <= limits.upper[0]) & (max(a.x, max(b.x, c.x)) >= limits.lower[0]) &
      (min(a.y, min(b.y, c.y)) <= limits.upper[1]) & (max(a.y, max(b.y, c.y)) >= limits.lower[1]) &
      (min(a.z, min(b.z, c.z)) <= limits.upper[2]) & (max(a.z, max(b.z, c.z)) >= limits.lower[2]);
  result.in_box = bits(in_box) & first_bits(leaf.count - i);
  return result;
}

template <Scalar S>
bool NodeTriangles<S>::is_any_in(const WideTree<S>& tree, const TriangleRange& leaf,
                                 const BoxInTree<S>& box) {
  const Pack3<S> along = Pack3<S>::all(Vec3<S>(row_of(box.R_GC(), 2)));
  const auto z = [&](std::size_t c, std::size_t i) {
    return dot(along, corner(tree, leaf, c, i)) + box.p_GC().z();
  };
  for (std::size_t i = 0; i < leaf.count; i += lanes<S>) {
    // One coordinate mostly suffices. Near triangles out of reach are so along the rays.
    const Pack<S> a = z(0, i), b = z(1, i), c = z(2, i);
    const Mask<S> in_z =
        (min(a, min(b, c)) <= box.box_G().upper[2]) & (max(a, max(b, c)) >= box.box_G().lower[2]);
    if ((bits(in_z) & first_bits(leaf.count - i)) == 0) continue;
    if (turned(tree, leaf, i, box).in_box != 0) return true;
  }
  return false;
}

template <Scalar S>
bool NodeTriangles<S>::add(const WideTree<S>& tree, const TriangleRange& leaf,
                           const BoxInTree<S>& box) {
  for (std::size_t i = 0; i < leaf.count; i += lanes<S>) {
    const Turned t = turned(tree, leaf, i, box);
    if (t.in_box == 0) continue;
    const auto& [a, b, c] = t.corners;
    const auto number = Pack<S>::load_integers(tree.numbers(leaf.first + i));
    size_ += store_packed({a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, number}, t.in_box,
                          rows_[0].data() + size_, std::tuple_size_v<Row>);
    if (size_ > capacity) return false;
  }
  return true;
}

template <Scalar S>
void NodeTriangles<S>::finish(const RayTreeNode<S>& node, const Mat3<S>& R_RG, S size) {
  const S round_off = Tolerance<S>::round_off();
  const Vec3<S> half = cwise_max(cwise_abs(node.box.lower), cwise_abs(node.box.upper));
  // Memory behind the last candidate may hold denormal numbers, which are slow.
  for (Row& row : rows_) Pack<S>(S(0)).store(&row[size_]);
  for (std::size_t i = 0; i < size_; i += lanes<S>) {
    Pack3<S> p[3];
    for (std::size_t c = 0; c < 3; ++c) {
      p[c] = Pack3<S>::load(&rows_[3 * c][i], &rows_[3 * c + 1][i], &rows_[3 * c + 2][i]);
    }
    const auto& [a, b, c] = p;
    const Pack3<S> lower{min(a.x, min(b.x, c.x)), min(a.y, min(b.y, c.y)), min(a.z, min(b.z, c.z))};
    const Pack3<S> upper{max(a.x, max(b.x, c.x)), max(a.y, max(b.y, c.y)), max(a.z, max(b.z, c.z))};
    lower.store(&lower_[0][i], &lower_[1][i], &lower_[2][i]);
    upper.store(&upper_[0][i], &upper_[1][i], &upper_[2][i]);
    const Pack3<S> n = cross(b - a, c - a);
    const Pack<S> largest = max(abs(n.x), max(abs(n.y), abs(n.z)));
    const Pack3<S> scaled = (S(1) / largest) * n;
    const Pack3<S> normal = R_RG * ((S(1) / sqrt(dot(scaled, scaled))) * scaled);
    normal.store(&normal_[0][i], &normal_[1][i], &normal_[2][i]);
    // Bounds of a corner's distance from any ray across it, and from its start along it. They bound
    // the distance from the origin, too.
    const Pack<S> z = max(-lower.z, upper.z) + half.z();
    const Pack<S> x = max(-lower.x, upper.x) + half.x();
    const Pack<S> y = max(-lower.y, upper.y) + half.y();
    const Pack<S> aside = max(x, y) + node.slope * z;
    // A coordinate of a corner relative to a ray is wrong by up to eight ulp of `aside`, which is
    // half a round-off. A determinant has two products of two of them, so four such errors times
    // `aside`. The error of turning a corner does not matter. All its triangles have it in one
    // place. Distances weight heights that differ by upper.z - lower.z with three determinants.
    // Turning counts there: a coordinate is wrong by half a round-off of 3 aside + 2 z + size.
    (round_off * (S(2) * aside * aside)).store(&doubt_[i]);
    (round_off * (S(2) * z + size)).store(&along_[i]);
    (round_off * ((S(3) * aside + S(2) * z + size) * (S(6) * aside) * (upper.z - lower.z)))
        .store(&across_[i]);
  }
}

template <Scalar S>
std::size_t NodeTriangles<S>::within(const Aabb<S>& box,
                                     std::array<std::uint8_t, capacity>& found) const {
  std::size_t count = 0;
  for (std::size_t i = 0; i < size_; i += lanes<S>) {
    Mask<S> meets = Mask<S>::first(lanes<S>);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto k = static_cast<int>(axis);
      meets = meets & (Pack<S>::load(&lower_[axis][i]) <= box.upper[k]) &
              (Pack<S>::load(&upper_[axis][i]) >= box.lower[k]);
    }
    for (std::uint32_t left = bits(meets) & first_bits(size_ - i); left != 0; left &= left - 1) {
      found[count++] =
          static_cast<std::uint8_t>(i + static_cast<std::size_t>(std::countr_zero(left)));
    }
  }
  return count;
}

template <Scalar S>
BRISTLE_FORCE_INLINE void NodeTriangles<S>::test(std::size_t i, const LaneRays<S>& rays,
                                                 LaneCrossings<S>& found) const {
  const auto corner = [&](std::size_t k) { return Pack<S>(rows_[k][i]); };
  const Pack<S> az = corner(2);
  const Pack<S> bz = corner(5);
  const Pack<S> cz = corner(8);
  const Pack<S> ax = corner(0) - (rays.x + rays.slope_x * az);
  const Pack<S> ay = corner(1) - (rays.y + rays.slope_y * az);
  const Pack<S> bx = corner(3) - (rays.x + rays.slope_x * bz);
  const Pack<S> by = corner(4) - (rays.y + rays.slope_y * bz);
  const Pack<S> cx = corner(6) - (rays.x + rays.slope_x * cz);
  const Pack<S> cy = corner(7) - (rays.y + rays.slope_y * cz);
  const Pack<S> u = cx * by - cy * bx;
  const Pack<S> v = ax * cy - ay * cx;
  const Pack<S> w = bx * ay - by * ax;
  const Pack<S> least = min(u, min(v, w));
  const Pack<S> most = max(u, max(v, w));
  const Pack<S> doubt(doubt_[i]);
  const Mask<S> may_pass = (least >= -doubt) | (most <= doubt);
  // Early out if no ray passes: it pays with few rays. With many some mostly do. A mispredicted
  // branch then costs more than it saves.
  constexpr bool is_wide = has_register<S> && sizeof(Pack<S>) >= 32;
  if (!is_wide && none(may_pass)) return;
  const Mask<S> is_front = least > doubt;
  const Mask<S> passes = is_front | (most < -doubt);
  found.is_doubtful = found.is_doubtful | (may_pass & !passes);
  const Pack<S> inverse = S(1) / (u + v + w);
  const Pack<S> distance = ((u * az + v * bz + w * cz) * inverse - rays.start) * rays.stretch;
  const Mask<S> counts = passes & (distance >= S(0)) & (distance <= rays.length);
  const Pack<S> uncertainty = along_[i] + across_[i] * abs(inverse);
  found.uncertainty = select(counts, max(found.uncertainty, uncertainty), found.uncertainty);
  const Mask<S> back = counts & !is_front;
  found.back = select(back, min(distance, found.back), found.back);
  const Mask<S> front = counts & is_front;
  const Pack<S> number(rows_[number_row][i]);
  const Mask<S> is_nearer =
      front & ((distance < found.front) | ((distance == found.front) & (number < found.number)));
  const Pack3<S> normal{normal_[0][i], normal_[1][i], normal_[2][i]};
  found.front = select(is_nearer, distance, found.front);
  found.number = select(is_nearer, number, found.number);
  found.normal = select(is_nearer, normal, found.normal);
}

}  // namespace bristle::inline BRISTLE_ABI::detail
