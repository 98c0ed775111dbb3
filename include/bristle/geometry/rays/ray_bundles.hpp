/// @file
/// Rays that stand beside each other, sorted once so that one search serves many of them.
///
/// A patch's rays never move in their body's frame. They are divided into bundles of neighbours,
/// and each bundle gets a box along a mean direction: a query compares boxes first and rays
/// last. Within a bundle a ray is a line over the box's z axis, so that triangles are turned into
/// the bundle's frame and the rays are not turned at all (docs/decisions/0022-bundles-of-rays.md).
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/rays/ray.hpp>
#include <bristle/geometry/trees/aabb.hpp>
#include <bristle/math/lane_vector.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// Some neighbouring rays of a `RayBundles`. Its frame G has its origin in the middle of some rays
/// and its z axis along their mean direction: its own, or those of a bundle that it is a part of
/// (`has_one_frame`).
template <Scalar S>
struct RayBundle {
  /// [-] The rays, as places in the order of the bundles.
  std::uint32_t first = 0;
  std::uint32_t count = 0;
  /// [-] The second of the two bundles it is divided into; the first is the next one. 0 in those
  /// that are not divided.
  std::uint32_t second = 0;
  /// Whether all rays run along the z axis, within 60 degrees of it.
  bool is_narrow = false;
  /// Whether it is narrow and what it is divided into has its frame: then its rays can be asked
  /// together.
  bool has_one_frame = false;
  /// [1] R_GR, with R the frame of the rays.
  Mat3<S> axes = Mat3<S>::Identity();
  /// [m] The origin of G in R.
  Vec3<S> center = Vec3<S>::Zero();
  /// [m] Around the rays from their starts to their ends, in G.
  Aabb<S> box{};
  /// [1] Around zero and the directions of the rays, in G.
  Aabb<S> directions{Vec3<S>::Zero(), Vec3<S>::Zero()};
  /// [m] Largest z of a start; the smallest is that of the box where the bundle is narrow.
  S highest_start = S(0);
  /// [1] Largest slope of a ray against the z axis, in x or y.
  S slope = S(0);

  [[nodiscard]] bool is_divided() const { return second != 0; }
  /// [m] What a box around some of its rays becomes where these are longer by `extra`: it grows to
  /// where they go, and not to all sides.
  [[nodiscard]] Aabb<S> lengthened(const Aabb<S>& around, S extra) const {
    return {around.lower + extra * directions.lower, around.upper + extra * directions.upper};
  }
};

/// The rays of a batch in bundles. A value; empty for rays of which one has no finite length.
template <Scalar S>
class RayBundles {
 public:
  /// [-] Rays of an undivided bundle at most, and of a block: a bundle is made of blocks of
  /// neighbours, all full but its last.
  static constexpr std::size_t bundle_size = 64;
  static constexpr std::size_t block_size = 16;
  /// [-] Rays of a bundle at most whose frame is that of all bundles it is divided into.
  static constexpr std::size_t frame_size = 256;
  /// [-] Rays of a slice at most. One takes some microseconds, which is more than it costs to hand
  /// it to another thread and to go down to its bundles once more; and there are sixteen of them in
  /// ten thousand rays.
  static constexpr std::size_t slice_size = 1024;

  /// Rays of one place each, in the frame of their undivided bundle: at height z a ray is at
  /// (x + slope_x z, y + slope_y z). Filled up to whole blocks with rays that reach nothing.
  struct Lines {
    LaneVector<S> x, y, slope_x, slope_y;
    /// [m] z of the start. [1] Length of the ray for each metre of z. [m] Reach.
    LaneVector<S> start, stretch, length;
  };

  RayBundles() = default;
  /// @param rays  Their `extra_length` is not looked at.
  explicit RayBundles(const RayBatch<S>& rays);

  [[nodiscard]] bool is_empty() const { return bundles_.empty(); }
  /// [-] Number of rays.
  [[nodiscard]] std::size_t size() const { return order_.size(); }
  /// Root first, each before those it is divided into.
  [[nodiscard]] const std::vector<RayBundle<S>>& bundles() const { return bundles_; }
  [[nodiscard]] const Lines& lines() const { return lines_; }
  /// All rays in slices of whole bundles: those of one slice lie in one branch.
  [[nodiscard]] const std::vector<RaySlice>& slices() const { return slices_; }
  /// Whether each slice is whole runs of the batch (`ray_run_size`), as it is in neighbour order:
  /// then a slice is the same rays for all shapes, and may ask one after the other.
  [[nodiscard]] bool has_runs_in_slices() const { return has_runs_in_slices_; }
  /// [-] Which ray of the batch is at a place.
  [[nodiscard]] std::uint32_t ray_at(std::size_t place) const { return order_[place]; }
  /// [-] The same for all places from one on.
  [[nodiscard]] const std::uint32_t* rays_from(std::size_t place) const {
    return order_.data() + place;
  }
  /// [m] Around the rays of the block that a place lies in, in the frame of their bundle.
  [[nodiscard]] const Aabb<S>& block_box(std::size_t place) const {
    return block_boxes_[place / block_size];
  }
  /// Whether the rays of that block follow each other in the batch, and fill the block.
  [[nodiscard]] bool is_in_order(std::size_t place) const {
    return is_in_order_[place / block_size] != 0;
  }

 private:
  using Places = std::span<std::uint32_t>;

  /// [-] Instead of a bundle.
  static constexpr std::size_t none = ~std::size_t(0);

  void build(const RayBatch<S>& rays, Places places, std::size_t parent);
  void fit(const RayBatch<S>& rays, Places places, RayBundle<S>& bundle) const;
  [[nodiscard]] static bool is_frame_for_parts(const RayBundle<S>& bundle);
  static void split_into_blocks(const RayBatch<S>& rays, Places places);
  void store(const RayBatch<S>& rays, const RayBundle<S>& bundle);
  void find_order();
  void cut_slices();

  std::vector<RayBundle<S>> bundles_;
  std::vector<RaySlice> slices_;
  bool has_runs_in_slices_ = false;
  std::vector<std::uint32_t> order_;
  std::vector<Aabb<S>> block_boxes_;
  // Bytes, as threads read them.
  std::vector<std::uint8_t> is_in_order_;
  Lines lines_;
};

// Implementation -----------------------------------------------------------------------------------

namespace detail {

/// [m] From one ray to the next if n of them stood on a whole square grid, or in a row, of these
/// extents: (a / s + 1)(b / s + 1) = n.
[[nodiscard]] inline double grid_spacing(double a, double b, std::size_t n) {
  const double gaps = static_cast<double>(n) - 1;
  return (a + b + std::sqrt((a + b) * (a + b) + 4 * gaps * a * b)) / (2 * gaps);
}

/// Divides rays along the longest extent of their starts into two parts of whole `size`s: near the
/// middle, at a multiple of the side of a square of `size` rays. Halves would tear the rows of
/// grids, and what is torn overlaps. Orders them so that those that start lowest come first.
/// @param some  More than `size`.
/// @return [-] How many are in the first part.
template <Scalar S>
std::size_t split_rays(const RayBatch<S>& rays, std::span<std::uint32_t> some, std::size_t size) {
  Aabb<S> starts;
  for (const std::uint32_t i : some) starts.include(rays[i].origin);
  int axis = 0;
  (starts.upper - starts.lower).maxCoeff(&axis);
  const std::span<const S> along =
      axis == 0 ? rays.origin_x : (axis == 1 ? rays.origin_y : rays.origin_z);
  // Where to divide is no matter of derivatives.
  std::array<double, 3> extent;
  for (int i = 0; i < 3; ++i) {
    extent[static_cast<std::size_t>(i)] = static_cast<double>(starts.upper[i] - starts.lower[i]);
  }
  std::sort(extent.begin(), extent.end());
  const double spacing = grid_spacing(extent[1], extent[2], some.size());
  const double squares = (extent[2] / spacing + 1) / std::sqrt(static_cast<double>(size));
  // False of starts that are all one, and of those so close that the spacing is rounded to nothing.
  const bool is_grid = squares >= 2 && squares <= static_cast<double>(some.size());
  const double share = is_grid ? std::floor(std::round(squares) / 2) / squares : 0.5;
  const std::size_t parts = (some.size() + size - 1) / size;
  const std::size_t first =
      size * std::clamp<std::size_t>(
                 static_cast<std::size_t>(share * static_cast<double>(parts) + 0.5), 1, parts - 1);
  // A total order, so that the parts do not depend on the standard library.
  std::nth_element(some.begin(), some.begin() + static_cast<std::ptrdiff_t>(first), some.end(),
                   [along](std::uint32_t a, std::uint32_t b) {
                     return along[a] < along[b] || (along[a] == along[b] && a < b);
                   });
  return first;
}

}  // namespace detail

template <Scalar S>
RayBundles<S>::RayBundles(const RayBatch<S>& rays) {
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Ray<S> ray = rays[i];
    // Only of finite numbers is the difference with themselves zero.
    const S ends = ray.origin.sum() + ray.direction.sum() + rays.length[i];
    if (!(ends - ends == S(0)) || !(rays.length[i] >= S(0))) return;
  }
  order_.resize(rays.size());
  for (std::uint32_t i = 0; i < rays.size(); ++i) order_[i] = i;
  if (order_.empty()) return;
  const std::size_t blocks = (rays.size() + block_size - 1) / block_size;
  block_boxes_.resize(blocks);
  for (auto* values : {&lines_.x, &lines_.y, &lines_.slope_x, &lines_.slope_y, &lines_.start}) {
    values->assign(blocks * block_size, S(0));
  }
  lines_.stretch.assign(blocks * block_size, S(1));
  lines_.length.assign(blocks * block_size, -infinity<S>);
  build(rays, order_, none);
  find_order();
  cut_slices();
}

template <Scalar S>
void RayBundles<S>::build(const RayBatch<S>& rays, Places places, std::size_t parent) {
  // Parts come in whatever order the standard library left them; sums of floats have one.
  std::sort(places.begin(), places.end());
  const std::size_t id = bundles_.size();
  RayBundle<S> bundle;
  bundle.first = static_cast<std::uint32_t>(places.data() - order_.data());
  bundle.count = static_cast<std::uint32_t>(places.size());
  if (parent != none && bundles_[parent].has_one_frame) {
    bundle.has_one_frame = true;
    bundle.axes = bundles_[parent].axes;
    bundle.center = bundles_[parent].center;
  }
  fit(rays, places, bundle);
  bundle.has_one_frame = bundle.has_one_frame || is_frame_for_parts(bundle);
  bundles_.push_back(bundle);
  if (places.size() <= bundle_size) {
    split_into_blocks(rays, places);
    store(rays, bundle);
    return;
  }
  const std::size_t first = detail::split_rays(rays, places, bundle_size);
  build(rays, places.first(first), id);
  bundles_[id].second = static_cast<std::uint32_t>(bundles_.size());
  build(rays, places.subspan(first), id);
}

/// Whether the frame of a bundle does for its parts: aside from it their rays would run by little
/// beside their width, so that boxes in frames of their own would hardly be smaller.
template <Scalar S>
bool RayBundles<S>::is_frame_for_parts(const RayBundle<S>& bundle) {
  if (!bundle.is_narrow || bundle.count <= bundle_size) return bundle.is_narrow;
  const Vec3<S> extent = bundle.box.upper - bundle.box.lower;
  const S drift = bundle.slope * extent.z();
  const S area = extent.x() * extent.y() * S(bundle_size) / S(bundle.count);
  return bundle.count <= frame_size && S(16) * drift * drift <= area;
}

/// Finds the box of a bundle, and its frame unless it has that of another one.
template <Scalar S>
void RayBundles<S>::fit(const RayBatch<S>& rays, Places places, RayBundle<S>& bundle) const {
  if (!bundle.has_one_frame) {
    Aabb<S> starts;
    Vec3<S> sum = Vec3<S>::Zero();
    for (const std::uint32_t i : places) {
      starts.include(rays[i].origin);
      sum += rays[i].direction;
    }
    bundle.center = starts.center();
    if (sum.norm() > Tolerance<S>::equal() * S(places.size())) {
      const Vec3<S> z = sum.normalized();
      // Sensors mostly stand in rows along the axes of their frame: so do the sides of the box.
      int across = 0;
      z.cwiseAbs().minCoeff(&across);
      const Vec3<S> x = (Vec3<S>::Unit(across) - z[across] * z).normalized();
      bundle.axes.row(0) = x;
      bundle.axes.row(1) = z.cross(x);
      bundle.axes.row(2) = z;
    }
  }
  bundle.is_narrow = true;
  bundle.highest_start = -infinity<S>;
  for (const std::uint32_t i : places) {
    const Vec3<S> start = bundle.axes * (rays[i].origin - bundle.center);
    const Vec3<S> direction = bundle.axes * rays[i].direction;
    bundle.box.include(start);
    bundle.box.include(Vec3<S>(start + rays.length[i] * direction));
    bundle.directions.include(direction);
    bundle.highest_start = std::max(bundle.highest_start, start.z());
    bundle.is_narrow = bundle.is_narrow && direction.z() > S(0.5);
    const S across = direction.template head<2>().cwiseAbs().maxCoeff();
    bundle.slope = std::max(bundle.slope, across / direction.z());
  }
}

/// Orders the rays of an undivided bundle, block by block.
template <Scalar S>
void RayBundles<S>::split_into_blocks(const RayBatch<S>& rays, Places places) {
  if (places.size() <= block_size) {
    // However the standard library left them.
    std::sort(places.begin(), places.end());
    return;
  }
  const std::size_t first = detail::split_rays(rays, places, block_size);
  split_into_blocks(rays, places.first(first));
  split_into_blocks(rays, places.subspan(first));
}

/// Writes down the rays of an undivided bundle in its frame.
template <Scalar S>
void RayBundles<S>::store(const RayBatch<S>& rays, const RayBundle<S>& bundle) {
  if (!bundle.is_narrow) return;
  for (std::size_t k = bundle.first; k < bundle.first + bundle.count; ++k) {
    const std::size_t i = order_[k];
    const Vec3<S> start = bundle.axes * (rays[i].origin - bundle.center);
    const Vec3<S> direction = bundle.axes * rays[i].direction;
    const Vec3<S> end = start + rays.length[i] * direction;
    lines_.slope_x[k] = direction.x() / direction.z();
    lines_.slope_y[k] = direction.y() / direction.z();
    lines_.x[k] = start.x() - lines_.slope_x[k] * start.z();
    lines_.y[k] = start.y() - lines_.slope_y[k] * start.z();
    lines_.start[k] = start.z();
    lines_.stretch[k] = S(1) / direction.z();
    lines_.length[k] = rays.length[i];
    block_boxes_[k / block_size].include(start);
    block_boxes_[k / block_size].include(end);
  }
}

/// Finds the blocks whose rays follow each other.
template <Scalar S>
void RayBundles<S>::find_order() {
  is_in_order_.assign(block_boxes_.size(), 0);
  for (std::size_t first = 0; first + block_size <= size(); first += block_size) {
    const auto block = order_.begin() + static_cast<std::ptrdiff_t>(first);
    const auto gap =
        std::adjacent_find(block, block + block_size, [](auto a, auto b) { return b != a + 1; });
    is_in_order_[first / block_size] = gap == block + block_size ? 1 : 0;
  }
}

/// The highest bundles that are small enough. Each stands before those it is divided into.
template <Scalar S>
void RayBundles<S>::cut_slices() {
  for (const RayBundle<S>& bundle : bundles_) {
    const std::uint32_t cut = slices_.empty() ? 0 : slices_.back().end;
    if (bundle.first < cut || (bundle.is_divided() && bundle.count > slice_size)) continue;
    slices_.push_back({bundle.first, bundle.first + bundle.count});
  }
  static_assert(bundle_size % ray_run_size == 0);  // So that all slices begin with a run.
  has_runs_in_slices_ = std::all_of(slices_.begin(), slices_.end(), [this](RaySlice slice) {
    const auto is_in = [slice](std::uint32_t ray) { return slice.first <= ray && ray < slice.end; };
    return std::all_of(order_.begin() + slice.first, order_.begin() + slice.end, is_in);
  });
}

}  // namespace bristle::inline BRISTLE_ABI
