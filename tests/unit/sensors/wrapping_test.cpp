// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/io/obj.hpp>
#include <bristle/io/stl.hpp>
#include <bristle/math/rotation.hpp>
#include <bristle/sensors/placement.hpp>
#include <bristle/sensors/wrapping.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numbers>

using namespace bristle;
using namespace bristle::detail;

namespace {

template <typename S>
constexpr S near_zero_of_wrapping = S(64) * Tolerance<S>::round_off();

/// Pose of a patch moved along z.
template <typename S>
Transform<S> raised(S height) {
  return {Quat<S>::Identity(), Vec3<S>(0, 0, height)};
}

/// [m] Smallest distance of the centre from the planes of a sphere's triangles.
template <typename S>
S inner_radius(const TriangleMesh<S>& sphere) {
  S smallest = infinity<S>;
  for (std::size_t t = 0; t < sphere.triangles.size(); ++t) {
    smallest = std::min(smallest, triangle_normal(sphere, t).dot(triangle_centroid(sphere, t)));
  }
  return smallest;
}

}  // namespace

TEST_CASE_TEMPLATE("wrap_patch: a plane over a box lies on its top, and is cut where the box ends",
                   S, float, double) {
  const TriangleMesh<S> box = box_mesh<S>({S(0.35), S(0.15), S(0.2)});
  // Vertices at multiples of 0.1 from -0.5 to 0.5: seven of eleven lie over the box along x, three
  // along y.
  const PatchMesh<S> patch = plane_patch<S>({1, 1}, {10, 10});
  WrapReport report;
  const TriangleMesh<S> skin =
      wrap_patch<S>(patch, box, {.offset = S(0.01), .X_SM = raised(S(0.5))}, &report);
  CHECK(report.missed.size() == 121 - 7 * 3);
  CHECK(report.discarded() == report.missed.size());
  CHECK(report.dropped_faces.size() == 200 - 2 * 6 * 2);
  REQUIRE(skin.vertices.size() == 7 * 3);
  REQUIRE(skin.triangles.size() == 2 * 6 * 2);
  for (const Vec3<S>& p : skin.vertices) {
    CHECK(std::abs(p.z() - S(0.21)) <= near_zero_of_wrapping<S>);
    CHECK(std::abs(p.x()) <= S(0.3) + near_zero_of_wrapping<S>);
    CHECK(std::abs(p.y()) <= S(0.1) + near_zero_of_wrapping<S>);
  }
  for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
    CHECK((triangle_normal(skin, t) - Vec3<S>::UnitZ()).norm() <= near_zero_of_wrapping<S>);
  }
}

TEST_CASE_TEMPLATE(
    "wrap_patch: a plane over a sphere stands off by the offset, along ray or normal", S, float,
    double) {
  const S radius = S(0.5);
  const S offset = S(0.02);
  const TriangleMesh<S> sphere = sphere_mesh<S>(radius, 16);
  const S inner = inner_radius(sphere);
  const PatchMesh<S> patch = plane_patch<S>({S(0.6), S(0.6)}, {12, 12});
  WrapDef<S> def{.offset = offset, .X_SM = raised(S(1))};
  for (const WrapOffset along : {WrapOffset::ray, WrapOffset::normal}) {
    def.offset_along = along;
    WrapReport report;
    const TriangleMesh<S> skin = wrap_patch<S>(patch, sphere, def, &report);
    CHECK(report.discarded() == 0);
    CHECK(report.dropped_faces.empty());
    REQUIRE(skin.vertices.size() == patch.mesh.vertices.size());
    for (std::size_t v = 0; v < skin.vertices.size(); ++v) {
      const Vec3<S>& p = skin.vertices[v];
      if (along == WrapOffset::ray) {
        // Straight above where it was met, which lies between the two radii.
        CHECK((p - patch.mesh.vertices[v]).template head<2>().norm() <= near_zero_of_wrapping<S>);
        const S met = (p - offset * Vec3<S>::UnitZ()).norm();
        CHECK(met >= inner - near_zero_of_wrapping<S>);
        CHECK(met <= radius + near_zero_of_wrapping<S>);
      } else {
        // |q + offset n|^2 = |q|^2 + 2 offset q . n + offset^2, and inner <= q . n <= |q|.
        CHECK(p.norm() >= inner + offset - near_zero_of_wrapping<S>);
        CHECK(p.norm() <= radius + offset + near_zero_of_wrapping<S>);
      }
    }
    for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
      CHECK(triangle_normal(skin, t).dot(triangle_centroid(skin, t)) > S(0));
    }
  }
}

TEST_CASE_TEMPLATE("wrap_patch: a cylinder shrinks onto a cylinder of facets", S, float, double) {
  // The shape's axis is z, the patch's y; turned onto z by a quarter about x. Every second vertex
  // of the patch looks at an edge of the shape, the others at the middles of its faces.
  const S radius = S(0.1);
  const std::uint32_t n = 12;
  const TriangleMesh<S> core = cylinder_mesh<S>({.radius = radius, .half_length = S(0.3)}, n);
  const PatchMesh<S> patch =
      cylinder_patch<S>({.radius = S(0.2), .length = S(0.5), .cells = {2 * n, 5}});
  const Transform<S> X{exp_rotation<S>({S(std::numbers::pi / 2), 0, 0}), Vec3<S>::Zero()};
  for (const S offset : {S(0), S(0.01)}) {
    WrapReport report;
    const TriangleMesh<S> skin = wrap_patch<S>(patch, core, {.offset = offset, .X_SM = X}, &report);
    CHECK(report.discarded() == 0);
    CHECK(skin.triangles.size() == patch.mesh.triangles.size());
    const S face = radius * S(std::cos(std::numbers::pi / n));
    int on_edges = 0;
    for (const Vec3<S>& p : skin.vertices) {
      const S r = std::hypot(p.x(), p.y()) - offset;
      const bool is_on_edge = r > (radius + face) / S(2);
      on_edges += is_on_edge ? 1 : 0;
      CHECK(std::abs(r - (is_on_edge ? radius : face)) <= near_zero_of_wrapping<S>);
      CHECK(std::abs(p.z()) <= S(0.25) + near_zero_of_wrapping<S>);
    }
    CHECK(on_edges == int(n) * 6);
    for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
      const Vec3<S> middle = triangle_centroid(skin, t);
      CHECK(triangle_normal(skin, t).dot(Vec3<S>(middle.x(), middle.y(), 0)) > S(0));
    }
  }
}

TEST_CASE_TEMPLATE(
    "wrap_patch: a half sphere over a box meets it where rays from the centre leave it", S, float,
    double) {
  const Vec3<S> half(S(0.3), S(0.2), S(0.25));
  const S offset = S(0.015);
  const PatchMesh<S> patch = half_sphere_patch<S>(S(0.6), 7, 20);
  WrapReport report;
  const TriangleMesh<S> skin = wrap_patch<S>(patch, box_mesh<S>(half), {.offset = offset}, &report);
  CHECK(report.discarded() == 0);
  REQUIRE(skin.vertices.size() == patch.mesh.vertices.size());
  for (std::size_t v = 0; v < skin.vertices.size(); ++v) {
    const Vec3<S>& d = patch.normals[v];
    const S met = half.cwiseQuotient(d.cwiseAbs()).minCoeff();
    CHECK((skin.vertices[v] - (met + offset) * d).norm() <= near_zero_of_wrapping<S>);
  }
  for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
    CHECK(triangle_normal(skin, t).dot(triangle_centroid(skin, t)) > S(0));
  }
}

TEST_CASE_TEMPLATE("wrap_patch: says why it discarded each vertex", S, float, double) {
  // Four strips of a plane over a stair of single triangles: free, from behind, too near, good.
  const auto step = [](S x, S z, bool is_up) {
    TriangleMesh<S> one{{{x - S(0.4), -3, z}, {x + S(0.4), -3, z}, {x, 6, z}}, {{0, 1, 2}}};
    if (!is_up) std::swap(one.triangles[0][1], one.triangles[0][2]);
    return one;
  };
  TriangleMesh<S> stair;
  for (const TriangleMesh<S>& one :
       {step(1, -1, false), step(2, S(-0.05), true), step(3, -1, true)}) {
    const auto first = static_cast<std::uint32_t>(stair.vertices.size());
    stair.vertices.insert(stair.vertices.end(), one.vertices.begin(), one.vertices.end());
    const auto& t = one.triangles[0];
    stair.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  }
  // A triangle without a normal stands in the way of nothing.
  stair.triangles.push_back({0, 0, 1});
  PatchMesh<S> patch = plane_patch<S>({4, 1}, {4, 1});
  for (Vec3<S>& p : patch.mesh.vertices) p.x() += S(2);
  patch.normals[4].setZero();
  WrapReport report;
  const TriangleMesh<S> skin = wrap_patch<S>(patch, stair, {.offset = S(0.1)}, &report);
  using Numbers = std::vector<std::uint32_t>;
  CHECK(report.missed == Numbers{0, 5, 9});
  CHECK(report.met_from_behind == Numbers{1, 6});
  CHECK(report.too_near == Numbers{2, 7});
  CHECK(report.without_normal == Numbers{4});
  CHECK(report.discarded() == 8);
  // Two neighbours in a row make no triangle; vertices without one are left out.
  CHECK(report.dropped_faces == Numbers{0, 1, 2, 3, 4, 5, 6, 7});
  CHECK(skin.triangles.empty());
  CHECK(skin.vertices.empty());
  // The last strip, which is 1 away, counts only within reach.
  (void)wrap_patch<S>(patch, stair, {.offset = S(0.04), .reach = S(0.5)}, &report);
  CHECK(report.missed == Numbers{0, 1, 3, 5, 6, 8, 9});
  CHECK(report.too_near.empty());
}

TEST_CASE_TEMPLATE("wrap_patch: turns with its pose", S, float, double) {
  const TriangleMesh<S> sphere = sphere_mesh<S>(S(0.5), 6);
  const Transform<S> X{exp_rotation<S>({S(0.3), S(-0.7), S(1.1)}), Vec3<S>::Zero()};
  TriangleMesh<S> turned_sphere = sphere;
  for (Vec3<S>& p : turned_sphere.vertices) p = X * p;
  const PatchMesh<S> patch = half_sphere_patch<S>(S(0.7), 5, 9);
  const TriangleMesh<S> skin = wrap_patch<S>(patch, sphere, {.offset = S(0.01)});
  const TriangleMesh<S> turned =
      wrap_patch<S>(patch, turned_sphere, {.offset = S(0.01), .X_SM = X});
  REQUIRE(turned.vertices.size() == skin.vertices.size());
  for (std::size_t v = 0; v < skin.vertices.size(); ++v) {
    CHECK((turned.vertices[v] - X * skin.vertices[v]).norm() <= near_zero_of_wrapping<S>);
  }
}

TEST_CASE_TEMPLATE("wrap_patch: the result carries sensors, and survives both file formats", S,
                   float, double) {
  const TriangleMesh<S> skin =
      wrap_patch<S>(plane_patch<S>({S(0.06), S(0.06)}, {6, 6}), sphere_mesh<S>(S(0.05), 8),
                    {.offset = S(0.001), .X_SM = raised(S(0.1))});
  const PlacementDef<S> def{.depth = S(0.002), .range = S(0.004)};
  const SensorLayout<S> layout = sensors_from_mesh(skin, def);
  REQUIRE(layout.size() == 72);
  for (std::size_t i = 0; i < layout.size(); ++i) CHECK(layout.direction[i].z() > S(0));

  const TriangleMesh<S> from_obj = read_obj<S>(write_obj(skin));
  CHECK(from_obj.vertices == skin.vertices);
  CHECK(from_obj.triangles == skin.triangles);
  // STL keeps single precision, and the corners' places rather than their numbers.
  const TriangleMesh<S> from_stl = read_stl<S>(write_stl(skin));
  REQUIRE(from_stl.triangles.size() == skin.triangles.size());
  CHECK(from_stl.vertices.size() == skin.vertices.size());
  for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3<S>& p = skin.vertices[skin.triangles[t][k]];
      CHECK(from_stl.vertices[from_stl.triangles[t][k]] ==
            p.template cast<float>().template cast<S>());
    }
  }
}

TEST_CASE("wrap_patch: refuses what it cannot do, naming the field") {
  const TriangleMesh<double> box = box_mesh<double>({1, 1, 1});
  const PatchMesh<double> patch = plane_patch<double>({1, 1}, {1, 1});
  const auto error_of = [&](const PatchMesh<double>& p, const TriangleMesh<double>& shape,
                            const WrapDef<double>& def) -> std::string {
    try {
      (void)wrap_patch<double>(p, shape, def);
    } catch (const InvalidArgument& error) {
      return error.what();
    }
    return {};
  };
  const auto names = [](const std::string& text, const char* field) {
    return text.find(field) != std::string::npos;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(names(error_of(patch, box, {.offset = -1}), "WrapDef::offset"));
  CHECK(names(error_of(patch, box, {.offset = nan}), "WrapDef::offset"));
  CHECK(names(error_of(patch, box, {.reach = 0}), "WrapDef::reach"));
  CHECK(names(error_of(patch, box, {.reach = nan}), "WrapDef::reach"));
  CHECK(names(error_of(patch, box, {.X_SM = {{2, 0, 0, 0}, {0, 0, 0}}}), "WrapDef::X_SM.rotation"));
  CHECK(names(error_of(patch, {}, {}), "TriangleMesh"));
  PatchMesh<double> bad = patch;
  bad.normals.pop_back();
  CHECK(names(error_of(bad, box, {}), "PatchMesh::normals: size"));
  bad = patch;
  bad.normals[2] *= 2;
  CHECK(names(error_of(bad, box, {}), "PatchMesh::normals[2]"));
  CHECK(error_of(patch, box, {.reach = infinity<double>}).empty());
}
