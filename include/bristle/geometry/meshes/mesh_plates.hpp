/// @file
/// Partition of a closed mesh's surface into convex plates.
///
/// Triangles of one flat face are joined across inner edges, the longest first, as long as the
/// union is convex (Hertel and Mehlhorn 1983). So contacts cost the plates of a part, not the
/// triangles that its export made of them. A curved surface keeps its triangles.
///
/// A plate turns at each of its corners. An outer edge is a part of one crease, the straight line
/// in which two flat faces meet. An inner edge has no contacts. Both may be several edges of the
/// mesh.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>
#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/no_index.hpp>
#include <bristle/geometry/geometry_constants.hpp>
#include <bristle/geometry/meshes/mesh_validation.hpp>
#include <bristle/geometry/shapes/support.hpp>
#include <bristle/math/types.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>
#include <utility>

namespace bristle::inline BRISTLE_ABI::detail {

/// Shape of the solid at an edge of its surface.
enum class SurfaceEdge : std::uint8_t { convex, flat, hollow };

/// The plates of a mesh with their neighbours.
template <Scalar S>
class MeshPlates {
 public:
  /// [-] Largest number of corners of a plate.
  static constexpr std::size_t capacity = 8;

  /// @tparam Tree  As `MeshTree`: `size()`, `corners(i)`, `vertex_numbers(i)`, `root_box()`.
  /// @pre The mesh is closed (`validate_solid`).
  template <typename Tree>
  explicit MeshPlates(const Tree& tree);

  /// [-] Number of plates.
  [[nodiscard]] std::size_t size() const { return normals_.size(); }
  /// Returns a plate. Its names are vertex numbers of the mesh.
  [[nodiscard]] Plate<S> plate(std::uint32_t i) const {
    const std::size_t first = first_[i];
    const std::size_t count = first_[i + 1] - first;
    return {{corners_.data() + first, count}, {names_.data() + first, count}, normals_[i]};
  }
  /// [1] Outward unit normal.
  [[nodiscard]] const Vec3<S>& normal(std::uint32_t i) const { return normals_[i]; }
  /// [-] Number that all plates of one flat face share, below `face_count()`.
  [[nodiscard]] std::uint32_t face(std::uint32_t i) const { return faces_[i]; }
  [[nodiscard]] std::size_t face_count() const { return face_count_; }
  /// [-] The first plate across edge k, which runs from corner k to the next. All plates across an
  /// edge are of one face.
  [[nodiscard]] std::uint32_t neighbour(std::uint32_t i, std::size_t k) const {
    return neighbours_[first_[i] + k];
  }
  [[nodiscard]] SurfaceEdge edge(std::uint32_t i, std::size_t k) const {
    return edges_[first_[i] + k];
  }
  /// [-] Number of the crease that the outer edge k is a part of, the same for the plates on both
  /// sides.
  [[nodiscard]] std::uint32_t crease(std::uint32_t i, std::size_t k) const {
    return creases_[first_[i] + k];
  }
  /// Returns whether edge k is inside a flat face. Flat edges may also lie between two faces: those
  /// of a surface that is curved so little that each of its edges is flat.
  [[nodiscard]] bool is_inner_edge(std::uint32_t i, std::size_t k) const {
    return edge(i, k) == SurfaceEdge::flat && face(neighbour(i, k)) == face(i);
  }
  /// [m] Round-off of the corners: those of a plate are in its plane, and its inner edges straight,
  /// to this much.
  [[nodiscard]] S hair() const { return hair_; }

 private:
  DynamicArray<std::uint32_t> first_;  // Of the corners of each plate, and of the end.
  DynamicArray<Vec3<S>> corners_;
  DynamicArray<std::uint32_t> names_;
  DynamicArray<std::uint32_t> neighbours_;  // By corner.
  DynamicArray<SurfaceEdge> edges_;         // By corner.
  DynamicArray<std::uint32_t> creases_;     // By corner.
  DynamicArray<Vec3<S>> normals_;
  DynamicArray<std::uint32_t> faces_;
  std::size_t face_count_ = 0;
  S hair_ = S(0);
};

// Implementation ----------------------------------------------------------------------------------

/// [1] Sine of the angle below which two triangles are one flat face. Meshes from files are no
/// flatter than single precision.
template <Scalar S>
inline constexpr S flat_sine = S(Tolerance<float>::equal());

template <Scalar S>
[[nodiscard]] bool is_same_plane(const Vec3<S>& normal, const Vec3<S>& other) {
  return normal.cross(other).norm() < flat_sine<S> && normal.dot(other) > S(0);
}

/// The triangles of a closed mesh while they are joined to plates. Half-edge 3 t + k runs from
/// corner k of triangle t to the next. Those around a plate are linked.
template <Scalar S>
class PlateJoin {
 public:
  template <typename Tree>
  explicit PlateJoin(const Tree& tree);

  /// Corners of each plate by the half-edges that start there. Empty for a triangle that has joined
  /// another.
  [[nodiscard]] const DynamicArray<DynamicArray<std::uint32_t>>& outlines() const {
    return outlines_;
  }
  /// [-] The outline of the plate that a half-edge belongs to.
  [[nodiscard]] std::uint32_t owner(std::uint32_t half_edge) const {
    std::uint32_t plate = half_edge / 3;
    while (joined_to_[plate] != plate) plate = joined_to_[plate];
    return plate;
  }
  [[nodiscard]] std::uint32_t twin(std::uint32_t half_edge) const { return twins_[half_edge]; }
  [[nodiscard]] SurfaceEdge edge(std::uint32_t half_edge) const { return edges_[half_edge]; }
  /// [-] A half-edge of the crease that a half-edge belongs to. Of an inner edge that edge.
  [[nodiscard]] std::uint32_t crease(std::uint32_t half_edge) const { return creases_[half_edge]; }
  [[nodiscard]] const Vec3<S>& start(std::uint32_t half_edge) const { return starts_[half_edge]; }
  [[nodiscard]] std::uint32_t name(std::uint32_t half_edge) const {
    return triangles_[half_edge / 3][half_edge % 3];
  }
  [[nodiscard]] std::uint32_t face(std::uint32_t triangle) const { return faces_[triangle]; }
  [[nodiscard]] std::size_t face_count() const { return face_count_; }
  [[nodiscard]] S hair() const { return hair_; }
  /// [1] Unit normal of an outline: that of its area.
  [[nodiscard]] Vec3<S> normal(std::span<const std::uint32_t> outline) const {
    Vec3<S> area = zero<Vec3<S>>();
    for (std::size_t k = 1; k + 1 < outline.size(); ++k) {
      const Vec3<S>& origin = start(outline[0]);
      area += (start(outline[k]) - origin).cross(start(outline[k + 1]) - origin);
    }
    return area.stableNormalized();
  }

 private:
  void find_edges();
  void find_faces();
  void find_creases();
  void join();
  bool try_join(std::uint32_t side);
  [[nodiscard]] bool is_inner_edge(std::uint32_t half_edge) const {
    return edges_[half_edge] == SurfaceEdge::flat &&
           faces_[half_edge / 3] == faces_[twins_[half_edge] / 3];
  }
  /// Returns whether two half-edges may be one edge of a plate if they are in a line.
  [[nodiscard]] bool is_one_edge(std::uint32_t half_edge, std::uint32_t other) const {
    return creases_[half_edge] == creases_[other] ||
           (is_inner_edge(half_edge) && is_inner_edge(other));
  }
  [[nodiscard]] bool is_plate(std::span<const std::uint32_t> outline) const;
  [[nodiscard]] bool is_straight(std::span<const std::uint32_t> outline, std::size_t corner) const;
  [[nodiscard]] bool is_straight(const Vec3<S>& before, const Vec3<S>& at,
                                 const Vec3<S>& after) const;
  void link(std::uint32_t half_edge, std::uint32_t next) {
    next_[half_edge] = next;
    previous_[next] = half_edge;
  }

  DynamicArray<std::array<std::uint32_t, 3>> triangles_;  // Vertex numbers.
  DynamicArray<Vec3<S>> starts_;
  DynamicArray<Vec3<S>> normals_;  // By triangle.
  DynamicArray<std::uint32_t> twins_;
  DynamicArray<SurfaceEdge> edges_;
  DynamicArray<std::uint32_t> faces_;  // By triangle.
  std::size_t face_count_ = 0;
  DynamicArray<std::uint32_t> creases_;  // By half-edge.
  DynamicArray<DynamicArray<std::uint32_t>> outlines_;
  // By triangle: one that it has joined, or itself. Chains are short, since it is the larger plate
  // that stays.
  DynamicArray<std::uint32_t> joined_to_;
  DynamicArray<std::uint32_t> sizes_;     // Triangles of each plate.
  DynamicArray<std::uint32_t> next_;      // Around the plate.
  DynamicArray<std::uint32_t> previous_;  // Around the plate.
  DynamicArray<bool> is_corner_;          // Where the half-edge starts.
  S hair_;  // [m] Round-off of a mesh that was written in single precision.
};

template <Scalar S>
template <typename Tree>
PlateJoin<S>::PlateJoin(const Tree& tree) {
  const auto box = tree.root_box();
  hair_ = S(Tolerance<float>::round_off()) * S(box.half_extents().maxCoeff());
  const auto count = static_cast<std::uint32_t>(tree.size());
  for (std::uint32_t t = 0; t < count; ++t) {
    const auto corners = tree.corners(t);
    triangles_.push_back(tree.vertex_numbers(t));
    for (std::uint32_t k = 0; k < 3; ++k) {
      starts_.push_back(corners[k].template cast<S>());
      next_.push_back(3 * t + (k + 1) % 3);
      previous_.push_back(3 * t + (k + 2) % 3);
      is_corner_.push_back(true);
    }
    outlines_.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    joined_to_.push_back(t);
    sizes_.push_back(1);
    normals_.push_back(normal(outlines_.back()));
  }
  find_edges();
  find_faces();
  find_creases();
  join();
}

template <Scalar S>
void PlateJoin<S>::find_edges() {
  const DynamicArray<EdgeUse> uses = sorted_edges(triangles_);
  const auto next = [](std::uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; };
  twins_.resize(starts_.size());
  edges_.resize(starts_.size());
  for (std::size_t i = 0; i + 1 < uses.size(); i += 2) {
    BRISTLE_ASSERT(uses[i].is_same_edge(uses[i + 1]));
    const std::uint32_t a = 3 * uses[i].triangle + uses[i].side;
    const std::uint32_t b = 3 * uses[i + 1].triangle + uses[i + 1].side;
    twins_[a] = b;
    twins_[b] = a;
    // The depth of the neighbour's far corner below the plane tells convex from hollow.
    const Vec3<S> far = starts_[next(next(b))] - starts_[a];
    SurfaceEdge kind = normals_[a / 3].dot(far) < S(0) ? SurfaceEdge::convex : SurfaceEdge::hollow;
    if (is_same_plane(normals_[a / 3], normals_[b / 3])) kind = SurfaceEdge::flat;
    edges_[a] = edges_[b] = kind;
  }
}

template <Scalar S>
void PlateJoin<S>::find_faces() {
  faces_.assign(normals_.size(), no_index);
  DynamicArray<std::uint32_t> open;
  for (std::uint32_t seed = 0; seed < faces_.size(); ++seed) {
    if (faces_[seed] != no_index) continue;
    const auto face = static_cast<std::uint32_t>(face_count_++);
    faces_[seed] = face;
    open.assign(1, seed);
    while (!open.empty()) {
      const std::uint32_t at = open.back();
      open.pop_back();
      for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t next = twins_[3 * at + k] / 3;
        // Compared with the seed: otherwise a finely curved surface would become one face.
        if (faces_[next] == no_index && is_same_plane(normals_[next], normals_[seed])) {
          faces_[next] = face;
          open.push_back(next);
        }
      }
    }
  }
}

/// Numbers creases: edges in a line between the same two faces, where no other face touches them.
template <Scalar S>
void PlateJoin<S>::find_creases() {
  const auto edge_count = static_cast<std::uint32_t>(starts_.size());
  for (std::uint32_t h = 0; h < edge_count; ++h) creases_.push_back(h);
  const auto root = [&](std::uint32_t h) {
    while (creases_[h] != h) h = creases_[h] = creases_[creases_[h]];
    return h;
  };
  const auto unite = [&](std::uint32_t a, std::uint32_t b) {
    const std::uint32_t root_a = root(a);
    const std::uint32_t root_b = root(b);
    creases_[std::max(root_a, root_b)] = std::min(root_a, root_b);
  };
  for (std::uint32_t h = 0; h < edge_count; ++h) {
    unite(h, twins_[h]);
    if (is_inner_edge(h)) continue;
    // The next edge of the face, and the last one of the face across.
    std::uint32_t next = next_[h];
    while (is_inner_edge(next)) next = next_[twins_[next]];
    std::uint32_t last = previous_[twins_[h]];
    while (is_inner_edge(last)) last = previous_[twins_[last]];
    if (twins_[next] == last && edges_[next] == edges_[h] &&
        is_straight(starts_[h], starts_[next], starts_[last])) {
      unite(h, next);
    }
  }
  for (std::uint32_t h = 0; h < edge_count; ++h) creases_[h] = root(h);
}

template <Scalar S>
void PlateJoin<S>::join() {
  struct Inner {
    S length;            // [m]
    std::uint32_t rank;  // By length, the same for those that are equal.
    std::uint32_t half_edge;
  };
  DynamicArray<Inner> inner;
  for (std::uint32_t h = 0; h < twins_.size(); ++h) {
    const std::uint32_t t = twins_[h];
    if (h < t && is_inner_edge(h)) inner.push_back({(starts_[t] - starts_[h]).norm(), 0, h});
  }
  std::sort(inner.begin(), inner.end(), [](const Inner& a, const Inner& b) {
    return std::tie(b.length, a.half_edge) < std::tie(a.length, b.half_edge);
  });
  // Lengths that are equal to round-off would come in any order. Two lengths have four ends that
  // are rounded.
  for (std::size_t i = 1, longest = 0; i < inner.size(); ++i) {
    if (inner[longest].length - inner[i].length > S(4) * hair_) longest = i;
    inner[i].rank = static_cast<std::uint32_t>(longest);
  }
  std::sort(inner.begin(), inner.end(), [](const Inner& a, const Inner& b) {
    return std::tie(a.rank, a.half_edge) < std::tie(b.rank, b.half_edge);
  });
  // One of the two starts at the corner where a side begins, if the edge is one of a side's ends.
  const auto try_edge = [&](std::uint32_t h) { return try_join(h) || try_join(twins_[h]); };
  for (const Inner& at : inner) try_edge(at.half_edge);
  // A plate that has grown may have a whole side in common with one that it had not.
  DynamicArray<std::uint32_t> sides;
  const auto add_sides = [&](std::uint32_t plate) {
    for (const std::uint32_t h : outlines_[plate]) {
      if (is_inner_edge(h)) sides.push_back(h);
    }
  };
  for (std::uint32_t t = 0; t < outlines_.size(); ++t) {
    if (sizes_[t] > 1) add_sides(t);
  }
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const std::uint32_t side = sides[i];
    if (try_edge(side)) add_sides(owner(side));
  }
}

/// Joins two plates along a side, unless that makes no plate. Returns whether it has.
///
/// A convex union has a whole side of each as common line: elsewhere a side of the one would meet
/// the other at a hollow corner.
/// @param side  Half-edge at which the side begins.
template <Scalar S>
bool PlateJoin<S>::try_join(std::uint32_t side) {
  const std::uint32_t other_last = twins_[side];
  if (!is_corner_[side] || !is_corner_[next_[other_last]]) return false;
  std::uint32_t last = side;
  while (!is_corner_[next_[last]]) {
    if (is_corner_[twins_[last]] || twins_[next_[last]] != previous_[twins_[last]]) return false;
    last = next_[last];
  }
  const std::uint32_t other_side = twins_[last];
  if (!is_corner_[other_side]) return false;
  const std::array<std::uint32_t, 2> plates{owner(side), owner(other_side)};

  DynamicArray<std::uint32_t> outline;
  for (const std::uint32_t h : {side, other_side}) {
    const DynamicArray<std::uint32_t>& from = outlines_[owner(h)];
    const auto place = std::find(from.begin(), from.end(), h);
    // Both begin behind the common side.
    for (auto it = place + 1; it != from.end(); ++it) outline.push_back(*it);
    for (auto it = from.begin(); it != place; ++it) outline.push_back(*it);
  }
  // Where the common side ends the outline may be straight. Inner edges and creases have no corner
  // there.
  const std::array<std::pair<std::uint32_t, std::uint32_t>, 2> ends{
      std::pair{previous_[other_side], next_[last]}, std::pair{previous_[side], next_[other_last]}};
  std::array<bool, 2> are_straight{};
  for (std::size_t i = 0; i < 2; ++i) {
    const auto [before, after] = ends[i];
    if (!is_one_edge(before, after)) continue;
    const auto place = std::find(outline.begin(), outline.end(), after);
    are_straight[i] = is_straight(outline, static_cast<std::size_t>(place - outline.begin()));
    if (are_straight[i]) outline.erase(place);
  }
  if (!is_plate(outline)) return false;

  for (std::size_t i = 0; i < 2; ++i) {
    const auto [before, after] = ends[i];
    link(before, after);
    if (are_straight[i]) is_corner_[after] = false;
  }
  // Inside a plate there are no sides to try.
  is_corner_[side] = is_corner_[other_side] = false;
  const bool is_first_larger = sizes_[plates[0]] >= sizes_[plates[1]];
  const std::uint32_t stays = plates[is_first_larger ? 0 : 1];
  const std::uint32_t goes = plates[is_first_larger ? 1 : 0];
  joined_to_[goes] = stays;
  sizes_[stays] += sizes_[goes];
  outlines_[goes].clear();
  outlines_[stays] = std::move(outline);
  return true;
}

/// Returns whether an outline goes straight on at a corner, to round-off.
template <Scalar S>
bool PlateJoin<S>::is_straight(std::span<const std::uint32_t> outline, std::size_t corner) const {
  const std::size_t count = outline.size();
  return is_straight(start(outline[(corner + count - 1) % count]), start(outline[corner]),
                     start(outline[(corner + 1) % count]));
}

/// Returns whether a way from one point to the next and on goes straight, to round-off.
template <Scalar S>
bool PlateJoin<S>::is_straight(const Vec3<S>& before, const Vec3<S>& at,
                               const Vec3<S>& after) const {
  const Vec3<S> in = at - before;
  const Vec3<S> out = after - at;
  return in.cross(out).norm() <= hair_ * (after - before).norm() && in.dot(out) > S(0);
}

/// Returns whether an outline is that of a flat plate that turns the same way at every corner. Then
/// all of it is behind each of its edges. It must not be straight at a corner, either: a contact
/// along a straight side takes one edge.
template <Scalar S>
bool PlateJoin<S>::is_plate(std::span<const std::uint32_t> outline) const {
  using std::abs;
  const std::size_t count = outline.size();
  if (count < 3 || count > MeshPlates<S>::capacity) return false;
  const Vec3<S> up = normal(outline);
  for (std::size_t k = 0; k < count; ++k) {
    const Vec3<S>& corner = start(outline[(k + 1) % count]);
    if (abs(up.dot(corner - start(outline[0]))) > hair_) return false;
    const Vec3<S> in = corner - start(outline[k]);
    const Vec3<S> out = start(outline[(k + 2) % count]) - corner;
    // Both directions may be off.
    if (in.cross(out).dot(up) <= S(2) * S(chosen::same_direction_sine) * in.norm() * out.norm()) {
      return false;
    }
  }
  return true;
}

template <Scalar S>
template <typename Tree>
MeshPlates<S>::MeshPlates(const Tree& tree) {
  const PlateJoin<S> join(tree);
  DynamicArray<std::uint32_t> number(join.outlines().size());
  std::uint32_t count = 0;
  for (std::uint32_t t = 0; t < number.size(); ++t) {
    if (!join.outlines()[t].empty()) number[t] = count++;
  }
  first_.push_back(0);
  for (std::uint32_t t = 0; t < number.size(); ++t) {
    const DynamicArray<std::uint32_t>& outline = join.outlines()[t];
    if (outline.empty()) continue;
    for (const std::uint32_t h : outline) {
      corners_.push_back(join.start(h));
      names_.push_back(join.name(h));
      neighbours_.push_back(number[join.owner(join.twin(h))]);
      edges_.push_back(join.edge(h));
      creases_.push_back(join.crease(h));
    }
    first_.push_back(static_cast<std::uint32_t>(corners_.size()));
    normals_.push_back(join.normal(outline));
    faces_.push_back(join.face(t));
  }
  face_count_ = join.face_count();
  hair_ = join.hair();
}

}  // namespace bristle::inline BRISTLE_ABI::detail
