/// @file
/// A tree over the rays of a patch. One search serves many neighbours.
///
/// A patch's rays never move in their body's frame. They are divided into nodes of neighbours. Each
/// node has a box along a mean direction. A query tests boxes first and rays last. Within a node a
/// ray is a line over the box's z axis. So triangles are turned into the node's frame, and rays are
/// never turned (docs/decisions/0022-bundles-of-rays.md).
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/no_index.hpp>
#include <bristle/geometry/geometry_constants.hpp>
#include <bristle/geometry/rays/ray.hpp>
#include <bristle/geometry/trees/aabb.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// Some neighbouring rays of a `RayTree`. The frame G of the node has its origin in the middle of
/// some rays. Its z axis is along their mean direction. Those are its own rays, or the rays of an
/// ancestor (`has_one_frame`).
template <Scalar S>
struct RayTreeNode {
  /// [-] Range of its rays, in the order of the nodes.
  std::uint32_t first = 0;
  std::uint32_t count = 0;
  /// [-] The second of its two children. The first is the next node. 0 for leaves.
  std::uint32_t second = 0;
  /// True if all rays are within 60 degrees of the z axis.
  bool is_narrow = false;
  /// True if it is narrow and its children have its frame. Then its rays can be cast together.
  bool has_one_frame = false;
  /// [1] R_GR, with R the frame of the rays.
  Mat3<S> axes = identity<Mat3<S>>();
  /// [m] The origin of G in R.
  Vec3<S> center = zero<Vec3<S>>();
  /// [m] Box around the rays from their starts to their ends, in G.
  Aabb<S> box{};
  /// [1] Box around zero and the directions of the rays, in G.
  Aabb<S> directions{zero<Vec3<S>>(), zero<Vec3<S>>()};
  /// [m] Largest z of a start. The smallest is that of the box if the node is narrow.
  S highest_start = S(0);
  /// [1] Largest slope of a ray against the z axis, in x or y.
  S slope = S(0);

  [[nodiscard]] bool is_divided() const { return second != 0; }
  /// [m] Returns the box `around` some of its rays after these grow longer by `extra`. It grows
  /// along the rays' directions, not to all sides.
  [[nodiscard]] Aabb<S> lengthened(const Aabb<S>& around, S extra) const {
    return {around.lower + extra * directions.lower, around.upper + extra * directions.upper};
  }
};

/// The rays of a batch in nodes. A value. Empty if a ray has no finite length.
template <Scalar S>
class RayTree {
 public:
  /// [-] Most rays of a leaf. It consists of packets of neighbours, all full but its last.
  static constexpr std::size_t leaf_size = 64;
  /// [-] Most rays of a node whose descendants have its frame.
  static constexpr std::size_t frame_size = 256;
  /// [-] Most rays of a range. A range takes some microseconds. That exceeds the cost of another
  /// thread and of descending to its nodes once more. Ten thousand rays have sixteen ranges.
  static constexpr std::size_t range_size = 1024;

  /// Rays in the order of the nodes, in the frame of their leaf. At height z a ray is at (x +
  /// slope_x z, y + slope_y z). Filled up to whole packets with rays that reach nothing (length
  /// -infinity).
  struct Lines {
    LineArray<S> x, y, slope_x, slope_y;
    /// [m] z of the start. [1] Length of the ray for each metre of z. [m] Length.
    LineArray<S> start, stretch, length;
  };

  RayTree() = default;
  /// @param rays  Their `extra_length` is ignored.
  explicit RayTree(const RayBatch<S>& rays);

  [[nodiscard]] bool is_empty() const { return nodes_.empty(); }
  /// [-] Number of rays.
  [[nodiscard]] std::size_t size() const { return order_.size(); }
  /// Root first. Parents come before their children.
  [[nodiscard]] const DynamicArray<RayTreeNode<S>>& nodes() const { return nodes_; }
  [[nodiscard]] const Lines& lines() const { return lines_; }
  /// All rays in ranges of whole nodes. The nodes of one range are in one branch.
  [[nodiscard]] const DynamicArray<RayRange>& ranges() const { return ranges_; }
  /// True if each range is whole packets of the batch, as it is in neighbour order. Then a range is
  /// the same rays for all shapes. Ranges need not wait for each other.
  [[nodiscard]] bool has_packets_in_ranges() const { return has_packets_in_ranges_; }
  /// [-] Index in the batch of the ray at a position.
  [[nodiscard]] std::uint32_t ray_at(std::size_t place) const { return order_[place]; }
  /// [-] The same for all positions from one on.
  [[nodiscard]] const std::uint32_t* rays_from(std::size_t place) const {
    return order_.data() + place;
  }
  /// [m] Box around the rays of the packet at a position, in the frame of their node.
  [[nodiscard]] const Aabb<S>& packet_box(std::size_t place) const {
    return packet_boxes_[place / packet_size];
  }
  /// Returns whether the rays of the packet at a position are consecutive in the batch, and fill
  /// the packet.
  [[nodiscard]] bool is_in_order(std::size_t place) const {
    return is_in_order_[place / packet_size] != 0;
  }

 private:
  using Places = std::span<std::uint32_t>;

  void build(const RayBatch<S>& rays, Places places, std::size_t parent);
  void fit(const RayBatch<S>& rays, Places places, RayTreeNode<S>& node) const;
  [[nodiscard]] static bool is_frame_for_parts(const RayTreeNode<S>& node);
  static void split_into_packets(const RayBatch<S>& rays, Places places);
  void store(const RayBatch<S>& rays, const RayTreeNode<S>& node);
  void find_order();
  void cut_ranges();

  DynamicArray<RayTreeNode<S>> nodes_;
  DynamicArray<RayRange> ranges_;
  bool has_packets_in_ranges_ = false;
  DynamicArray<std::uint32_t> order_;
  DynamicArray<Aabb<S>> packet_boxes_;
  // Bytes, not bits, as threads read them.
  DynamicArray<std::uint8_t> is_in_order_;
  Lines lines_;
};

// Implementation ----------------------------------------------------------------------------------

/// [m] Spacing of n rays on a whole square grid, or in a row, of these extents: (a / s + 1)(b / s +
/// 1) = n.
[[nodiscard]] inline double grid_spacing(double a, double b, std::size_t n) {
  const double gaps = static_cast<double>(n) - 1;
  return (a + b + std::sqrt((a + b) * (a + b) + 4 * gaps * a * b)) / (2 * gaps);
}

/// Sorts numbers of rays. By pointers, since std::sort then is the one of other numbers in a file.
inline void sort_places(std::span<std::uint32_t> places) {
  std::sort(places.data(), places.data() + places.size());
}

/// Divides rays into two parts of whole `size`s, along the longest extent of their starts. In a fan
/// ends are much farther apart than starts, and it is theirs. The cut is near the middle, at a
/// multiple of the side of a square of `size` rays. Halves would tear the rows of grids, and torn
/// parts overlap. The part with the lowest coordinates comes first.
/// @param some  More than `size`.
/// @return [-] Number of rays in the first part.
template <Scalar S>
std::size_t split_rays(const RayBatch<S>& rays, std::span<std::uint32_t> some, std::size_t size) {
  Aabb<S> starts, ends;
  for (const std::uint32_t i : some) {
    starts.include(rays[i].origin);
    ends.include(Vec3<S>(rays[i].origin + rays.length[i] * rays[i].direction));
  }
  const auto longest = [](const Aabb<S>& box) { return Vec3<S>(box.upper - box.lower).maxCoeff(); };
  const bool is_fan = longest(ends) > S(chosen::fan_spread) * longest(starts);
  const Aabb<S>& box = is_fan ? ends : starts;
  int axis = 0;
  (box.upper - box.lower).maxCoeff(&axis);
  // Coordinates are computed once: rounded anew in each comparison they might give no order.
  struct Along {
    S coordinate;
    std::uint32_t ray;
  };
  DynamicArray<Along> along;
  for (const std::uint32_t i : some) {
    const S way = is_fan ? rays.length[i] * rays[i].direction[axis] : S(0);
    along.push_back({rays[i].origin[axis] + way, i});
  }
  // The cut is not differentiated.
  std::array<double, 3> extent;
  for (int i = 0; i < 3; ++i) {
    extent[static_cast<std::size_t>(i)] = static_cast<double>(box.upper[i] - box.lower[i]);
  }
  std::sort(extent.begin(), extent.end());
  const double spacing = grid_spacing(extent[1], extent[2], some.size());
  const double squares = (extent[2] / spacing + 1) / std::sqrt(static_cast<double>(size));
  // False if all points coincide, or are so close that the spacing is rounded to nothing.
  const bool is_grid = squares >= 2 && squares <= static_cast<double>(some.size());
  const double share = is_grid ? std::floor(std::round(squares) / 2) / squares : 0.5;
  const std::size_t parts = (some.size() + size - 1) / size;
  const std::size_t first =
      size * std::clamp<std::size_t>(
                 static_cast<std::size_t>(share * static_cast<double>(parts) + 0.5), 1, parts - 1);
  // A total order. So the parts do not depend on the standard library.
  std::nth_element(
      along.begin(), along.begin() + first, along.end(), [](const Along& a, const Along& b) {
        return a.coordinate < b.coordinate || (a.coordinate == b.coordinate && a.ray < b.ray);
      });
  std::transform(along.begin(), along.end(), some.begin(), [](const Along& a) { return a.ray; });
  return first;
}

template <Scalar S>
RayTree<S>::RayTree(const RayBatch<S>& rays) {
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Ray<S> ray = rays[i];
    // The difference of a number with itself is zero only if it is finite.
    const S ends = ray.origin.sum() + ray.direction.sum() + rays.length[i];
    if (!(ends - ends == S(0)) || !(rays.length[i] >= S(0))) return;
  }
  order_.resize(rays.size());
  for (std::uint32_t i = 0; i < rays.size(); ++i) order_[i] = i;
  if (order_.empty()) return;
  const std::size_t packets = (rays.size() + packet_size - 1) / packet_size;
  packet_boxes_.resize(packets);
  for (auto* values : {&lines_.x, &lines_.y, &lines_.slope_x, &lines_.slope_y, &lines_.start}) {
    values->assign(packets * packet_size, S(0));
  }
  lines_.stretch.assign(packets * packet_size, S(1));
  lines_.length.assign(packets * packet_size, -infinity<S>);
  build(rays, order_, no_index);
  find_order();
  cut_ranges();
}

template <Scalar S>
void RayTree<S>::build(const RayBatch<S>& rays, Places places, std::size_t parent) {
  // The standard library leaves parts in any order. Sums of floats depend on it.
  sort_places(places);
  const std::size_t id = nodes_.size();
  RayTreeNode<S> node;
  node.first = static_cast<std::uint32_t>(places.data() - order_.data());
  node.count = static_cast<std::uint32_t>(places.size());
  if (parent != no_index && nodes_[parent].has_one_frame) {
    node.has_one_frame = true;
    node.axes = nodes_[parent].axes;
    node.center = nodes_[parent].center;
  }
  fit(rays, places, node);
  node.has_one_frame = node.has_one_frame || is_frame_for_parts(node);
  nodes_.push_back(node);
  if (places.size() <= leaf_size) {
    split_into_packets(rays, places);
    store(rays, node);
    return;
  }
  const std::size_t first = split_rays(rays, places, leaf_size);
  build(rays, places.first(first), id);
  nodes_[id].second = static_cast<std::uint32_t>(nodes_.size());
  build(rays, places.subspan(first), id);
}

/// Returns whether the frame of a node serves its children. Across it their rays spread little
/// beside their width. So boxes in frames of their own would hardly be smaller.
template <Scalar S>
bool RayTree<S>::is_frame_for_parts(const RayTreeNode<S>& node) {
  if (!node.is_narrow || node.count <= leaf_size) return node.is_narrow;
  const Vec3<S> extent = node.box.upper - node.box.lower;
  const S drift = node.slope * extent.z();
  const S area = extent.x() * extent.y() * S(leaf_size) / S(node.count);
  return node.count <= frame_size && S(chosen::shared_frame_drift) * drift * drift <= area;
}

/// Finds the box of a node, and its frame unless it has that of an ancestor.
template <Scalar S>
void RayTree<S>::fit(const RayBatch<S>& rays, Places places, RayTreeNode<S>& node) const {
  if (!node.has_one_frame) {
    Aabb<S> starts;
    Vec3<S> sum = zero<Vec3<S>>();
    for (const std::uint32_t i : places) {
      starts.include(rays[i].origin);
      sum += rays[i].direction;
    }
    node.center = starts.center();
    if (sum.norm() > Tolerance<S>::equal() * S(places.size())) {
      const Vec3<S> z = sum.normalized();
      // Sensors mostly stand in rows along the axes of their frame; so do the sides of the box.
      int across = 0;
      cwise_abs(z).minCoeff(&across);
      const Vec3<S> x = (unit_vector<Vec3<S>>(across) - z[across] * z).normalized();
      set_row(node.axes, 0, x);
      set_row(node.axes, 1, z.cross(x));
      set_row(node.axes, 2, z);
    }
  }
  node.is_narrow = true;
  node.highest_start = -infinity<S>;
  for (const std::uint32_t i : places) {
    const Vec3<S> start = node.axes * (rays[i].origin - node.center);
    const Vec3<S> direction = node.axes * rays[i].direction;
    node.box.include(start);
    node.box.include(Vec3<S>(start + rays.length[i] * direction));
    node.directions.include(direction);
    node.highest_start = std::max(node.highest_start, start.z());
    node.is_narrow = node.is_narrow && direction.z() > S(chosen::narrow_node_cosine);
    const S across = cwise_abs(xy_of(direction)).maxCoeff();
    node.slope = std::max(node.slope, across / direction.z());
  }
}

/// Orders the rays of a leaf, packet by packet.
template <Scalar S>
void RayTree<S>::split_into_packets(const RayBatch<S>& rays, Places places) {
  if (places.size() <= packet_size) {
    // The standard library left them in any order.
    sort_places(places);
    return;
  }
  const std::size_t first = split_rays(rays, places, packet_size);
  split_into_packets(rays, places.first(first));
  split_into_packets(rays, places.subspan(first));
}

/// Stores the rays of a leaf in its frame.
template <Scalar S>
void RayTree<S>::store(const RayBatch<S>& rays, const RayTreeNode<S>& node) {
  if (!node.is_narrow) return;
  for (std::size_t k = node.first; k < node.first + node.count; ++k) {
    const std::size_t i = order_[k];
    const Vec3<S> start = node.axes * (rays[i].origin - node.center);
    const Vec3<S> direction = node.axes * rays[i].direction;
    const Vec3<S> end = start + rays.length[i] * direction;
    lines_.slope_x[k] = direction.x() / direction.z();
    lines_.slope_y[k] = direction.y() / direction.z();
    lines_.x[k] = start.x() - lines_.slope_x[k] * start.z();
    lines_.y[k] = start.y() - lines_.slope_y[k] * start.z();
    lines_.start[k] = start.z();
    lines_.stretch[k] = S(1) / direction.z();
    lines_.length[k] = rays.length[i];
    packet_boxes_[k / packet_size].include(start);
    packet_boxes_[k / packet_size].include(end);
  }
}

/// Finds the packets whose rays are consecutive in the batch.
template <Scalar S>
void RayTree<S>::find_order() {
  is_in_order_.assign(packet_boxes_.size(), 0);
  for (std::size_t first = 0; first + packet_size <= size(); first += packet_size) {
    const auto packet = order_.begin() + static_cast<std::ptrdiff_t>(first);
    const auto gap =
        std::adjacent_find(packet, packet + packet_size, [](auto a, auto b) { return b != a + 1; });
    is_in_order_[first / packet_size] = gap == packet + packet_size ? 1 : 0;
  }
}

/// Collects the highest nodes that are small enough. Parents come before their children.
template <Scalar S>
void RayTree<S>::cut_ranges() {
  for (const RayTreeNode<S>& node : nodes_) {
    const std::uint32_t cut = ranges_.empty() ? 0 : ranges_.back().end;
    if (node.first < cut || (node.is_divided() && node.count > range_size)) continue;
    ranges_.push_back({node.first, node.first + node.count});
  }
  static_assert(leaf_size % packet_size == 0);  // So that all ranges begin with a packet.
  has_packets_in_ranges_ = std::all_of(ranges_.begin(), ranges_.end(), [this](RayRange range) {
    const auto is_in = [range](std::uint32_t ray) { return range.first <= ray && ray < range.end; };
    return std::all_of(order_.begin() + range.first, order_.begin() + range.end, is_in);
  });
}

}  // namespace bristle::inline BRISTLE_ABI::detail
