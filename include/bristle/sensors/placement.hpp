/// @file
/// Covers a surface with sensors (Algorithm 2 and its extension to vertices and edges).
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/geometry/meshes/triangle_mesh.hpp>
#include <bristle/math/transform.hpp>
#include <bristle/sensors/sensor_layout.hpp>

#include <cstddef>
#include <cstdint>
#include <span>

namespace bristle::inline BRISTLE_ABI {

/// Placement of sensors on a mesh. The defaults put one 10 mm ray on every face, half of it below
/// the surface.
template <Scalar S>
struct PlacementDef {
  /// [m] Depth below the surface at which the rays start, D in Algorithm 2. Finite, >= 0.
  S depth = S(0.005);
  /// [m] Length of the rays from their starts, R in Algorithm 2. Finite, > depth: they end above
  /// the surface.
  S range = S(0.010);
  /// [-] One sensor at the centroid of every face, along the face's normal.
  bool faces = true;
  /// [-] One sensor at every vertex, along the mean normal of its faces, weighted by their angles.
  bool vertices = false;
  /// [-] One sensor at the midpoint of every edge, along the mean normal of its faces.
  bool edges = false;
  /// [m] Pose of the mesh in the frame A of the body that carries the sensors.
  Transform<S> X_AM{};
};

/// Numbers of sensors that `sensors_from_mesh` placed, and of those it had to leave out.
struct PlacementReport {
  /// [-] Sensors on faces. They come first.
  std::size_t face_sensors = 0;
  /// [-] Sensors on vertices. They follow those on faces.
  std::size_t vertex_sensors = 0;
  /// [-] Sensors on edges. They come last.
  std::size_t edge_sensors = 0;
  /// [-] Indices of the triangles without a normal. They carry no sensor and do not count for the
  /// normals of their vertices and edges.
  std::vector<std::uint32_t> degenerate_faces;
  /// [-] Indices of the vertices whose faces' normals cancel (both sides of a sheet, say).
  std::vector<std::uint32_t> vertices_without_normal;
  /// [-] Likewise edges, by the indices of their two vertices.
  std::vector<std::array<std::uint32_t, 2>> edges_without_normal;
};

/// Sensors along the surface of a mesh, in the frame A of the body that carries them.
///
/// A sensor starts `depth` below the surface and runs along the outward normal for `range`
/// (Algorithm 2; its line 6 prints the sum of the corners where their mean is meant). Faces come
/// first, in the order of the triangles. Vertices follow in the order of the mesh; then edges, by
/// their lower and then their higher vertex. Vertices with equal coordinates count as the first of
/// them, so a mesh with seams gets no sensor twice.
///
/// @param report  Receives the placed and the omitted sensors. May be null.
/// @throws InvalidArgument when the mesh is no valid surface (see `validate_surface`) or the
///         definition breaks a rule. A definition without any sensors breaks one.
template <Scalar S>
[[nodiscard]] SensorLayout<S> sensors_from_mesh(const TriangleMesh<S>& mesh,
                                                const PlacementDef<S>& def,
                                                PlacementReport* report = nullptr);

/// Regular grid of sensors on a flat rectangle, all vectors in the frame A of the body.
template <Scalar S>
struct SensorGridDef {
  /// [m] Middle of the rectangle.
  Vec3<S> center = detail::zero<Vec3<S>>();
  /// [m] One whole side of the rectangle. The rays point along side_u x side_v.
  Vec3<S> side_u = detail::zero<Vec3<S>>();
  /// [m] The other whole side; not parallel to side_u.
  Vec3<S> side_v = detail::zero<Vec3<S>>();
  /// [-] Number of sensors along side_u, >= 1.
  std::size_t count_u = 1;
  /// [-] Number of sensors along side_v, >= 1.
  std::size_t count_v = 1;
  /// [m] Depth of the rays' starts below the rectangle. Finite, >= 0.
  S depth = S(0.005);
  /// [m] Length of the rays from their starts. Finite, > depth.
  S range = S(0.010);
};

/// Puts one sensor into the middle of each of count_u x count_v equal cells. Those along side_u
/// follow one another.
///
/// @throws InvalidArgument when the definition breaks a rule.
template <Scalar S>
[[nodiscard]] SensorLayout<S> sensor_grid(const SensorGridDef<S>& def);

}  // namespace bristle::inline BRISTLE_ABI

// Implementation ----------------------------------------------------------------------------------

#if BRISTLE_HAS_DEFINITIONS
#include <bristle/core/error.hpp>
#include <bristle/geometry/meshes/mesh_normals.hpp>
#include <bristle/geometry/meshes/mesh_validation.hpp>

#include <array>
#include <string>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

namespace detail {

template <Scalar S>
void require_depth_and_range(const std::string& def, S depth, S range) {
  require_not_negative(def + "::depth", depth);
  require_positive(def + "::range", range);
  require(range > depth, def + "::range", range,
          "must exceed depth = " + to_text(depth) + ", so that the ray ends above the surface");
}

/// Returns the mesh with each corner replaced by the first vertex with equal coordinates.
template <Scalar S>
[[nodiscard]] TriangleMesh<S> without_seams(TriangleMesh<S> mesh) {
  const MergedPoints merged = merge_points<S>(std::span<const Vec3<S>>(mesh.vertices), S(0));
  for (auto& t : mesh.triangles) {
    for (std::uint32_t& v : t) v = merged.unique[merged.renumber[v]];
  }
  return mesh;
}

/// Puts sensors on the faces, vertices and edges of a mesh without seams.
template <Scalar S>
class MeshPlacement {
 public:
  MeshPlacement(const TriangleMesh<S>& mesh, const PlacementDef<S>& def)
      : mesh_(mesh), def_(def), R_AM_(def.X_AM.rotation_matrix()) {
    report.degenerate_faces = degenerate_triangles(mesh);
    normals_ = face_normals<S>(mesh, report.degenerate_faces);
  }

  void add_faces() {
    for (std::size_t t = 0; t < normals_.size(); ++t) {
      if (has_normal(t)) add(triangle_centroid(mesh_, t), normals_[t], report.face_sensors);
    }
  }

  void add_vertices() {
    const DynamicArray<NormalSum<S>> sums = vertex_normals<S>(mesh_, normals_);
    for (std::uint32_t v = 0; v < sums.size(); ++v) {
      if (sums[v].has_direction()) {
        add(mesh_.vertices[v], sums[v].sum, report.vertex_sensors);
      } else if (sums[v].weight > S(0)) {
        report.vertices_without_normal.push_back(v);
      }
    }
  }

  void add_edges() {
    const DynamicArray<EdgeUse> uses = sorted_edges(mesh_.triangles);
    for (std::size_t i = 0; i < uses.size();) {
      const EdgeUse& edge = uses[i];
      NormalSum<S> normal;
      for (; i < uses.size() && uses[i].is_same_edge(edge); ++i) {
        if (has_normal(uses[i].triangle)) normal.add(normals_[uses[i].triangle], S(1));
      }
      if (normal.has_direction()) {
        add(S(0.5) * (mesh_.vertices[edge.low] + mesh_.vertices[edge.high]), normal.sum,
            report.edge_sensors);
      } else if (normal.weight > S(0)) {
        report.edges_without_normal.push_back({edge.low, edge.high});
      }
    }
  }

  SensorLayout<S> layout;
  PlacementReport report;

 private:
  [[nodiscard]] bool has_normal(std::size_t triangle) const {
    return normals_[triangle] != zero<Vec3<S>>();
  }

  void add(const Vec3<S>& p_M, const Vec3<S>& n_M, std::size_t& counter) {
    const Vec3<S> n_A = (R_AM_ * n_M).normalized();
    layout.add(def_.X_AM * p_M - def_.depth * n_A, n_A, def_.range);
    ++counter;
  }

  const TriangleMesh<S>& mesh_;
  const PlacementDef<S>& def_;
  Mat3<S> R_AM_;
  /// Normals of the faces; zero if degenerate.
  DynamicArray<Vec3<S>> normals_;
};

}  // namespace detail

template <Scalar S>
SensorLayout<S> sensors_from_mesh(const TriangleMesh<S>& mesh, const PlacementDef<S>& def,
                                  PlacementReport* report) {
  detail::require_depth_and_range("PlacementDef", def.depth, def.range);
  detail::require_pose("PlacementDef::X_AM", def.X_AM);
  detail::require(def.faces || def.vertices || def.edges, "PlacementDef::faces", false,
                  "must be true where vertices and edges are false");
  validate_surface(mesh);

  const TriangleMesh<S> seamless = detail::without_seams(mesh);
  detail::MeshPlacement<S> placement(seamless, def);
  if (def.faces) placement.add_faces();
  if (def.vertices) placement.add_vertices();
  if (def.edges) placement.add_edges();
  if (report != nullptr) *report = std::move(placement.report);
  return std::move(placement.layout);
}

template <Scalar S>
SensorLayout<S> sensor_grid(const SensorGridDef<S>& def) {
  detail::require_depth_and_range("SensorGridDef", def.depth, def.range);
  detail::require_all_finite("SensorGridDef::center", def.center);
  detail::require_all_finite("SensorGridDef::side_u", def.side_u);
  detail::require_all_finite("SensorGridDef::side_v", def.side_v);
  detail::require(def.count_u >= 1, "SensorGridDef::count_u", def.count_u, "must be >= 1");
  detail::require(def.count_v >= 1, "SensorGridDef::count_v", def.count_v, "must be >= 1");
  const Vec3<S> u = def.side_u.stableNormalized();
  const Vec3<S> v = def.side_v.stableNormalized();
  const S sine = u.cross(v).norm();
  detail::require(sine > detail::Tolerance<S>::equal(),
                  "SensorGridDef: sine of the angle of the sides", sine,
                  "must not be 0 (sides parallel or of no length)");

  const Vec3<S> normal = u.cross(v) / sine;
  const Vec3<S> corner = def.center - S(0.5) * (def.side_u + def.side_v) - def.depth * normal;
  SensorLayout<S> layout;
  for (std::size_t j = 0; j < def.count_v; ++j) {
    for (std::size_t i = 0; i < def.count_u; ++i) {
      const S along_u = (S(i) + S(0.5)) / S(def.count_u);
      const S along_v = (S(j) + S(0.5)) / S(def.count_v);
      layout.add(corner + along_u * def.side_u + along_v * def.side_v, normal, def.range);
    }
  }
  return layout;
}

}  // namespace bristle::inline BRISTLE_ABI
#endif

#if defined(BRISTLE_COMPILED) && BRISTLE_HAS_DEFINITIONS
namespace bristle::inline BRISTLE_ABI {

#define BRISTLE_COMPILED_PLACEMENT(S)                                          \
  extern template SensorLayout<S> sensor_grid<S>(const SensorGridDef<S>& def); \
  extern template SensorLayout<S> sensors_from_mesh<S>(                        \
      const TriangleMesh<S>& mesh, const PlacementDef<S>& def, PlacementReport* report);
BRISTLE_COMPILED_PLACEMENT(float)
BRISTLE_COMPILED_PLACEMENT(double)
#undef BRISTLE_COMPILED_PLACEMENT

}  // namespace bristle::inline BRISTLE_ABI
#endif
