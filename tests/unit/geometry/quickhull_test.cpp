// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"
#include "support/texts.hpp"

#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/geometry/shapes/quickhull.hpp>
#include <bristle/geometry/shapes/shape_properties.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <support/random.hpp>
#include <support/rounds.hpp>
#include <vector>

using namespace bristle;
using namespace bristle::detail;
using bristle::test::error_of;
using bristle::test::Random;
using bristle::test::rounds;

namespace {

template <typename S>
using Points = std::vector<Vec3<S>>;

template <typename S>
ConvexHull<S> hull_of(const Points<S>& points) {
  return convex_hull<S>(std::span<const Vec3<S>>(points));
}

/// How far the points stand out of the hull, in units of the accuracy that `convex_hull` promises.
template <typename S>
S protrusion(const ConvexHull<S>& hull, const Points<S>& points) {
  Aabb<S> box;
  for (const auto& p : points) box.include(p);
  const S size = (box.upper - box.lower).maxCoeff();
  const S reach = std::max(box.lower.cwiseAbs().maxCoeff(), box.upper.cwiseAbs().maxCoeff());
  S worst = S(0);
  for (std::size_t f = 0; f < hull.face_count(); ++f) {
    for (const auto& p : points) {
      worst = std::max(worst, hull.face_normals[f].dot(p) - hull.face_offsets[f]);
    }
  }
  return worst / (hull_resolution<S>() * size + Tolerance<S>::round_off() * reach);
}

/// Valid, of the topology of a ball, and around all points.
template <typename S>
void check_hull(const ConvexHull<S>& hull, const Points<S>& points) {
  CHECK_NOTHROW(hull.validate());
  CHECK(hull.vertices.size() + hull.face_count() == hull.face_vertices.size() / 2 + 2);
  CHECK(protrusion(hull, points) <= S(4));
}

/// Corners and `extra` points inside the faces of a cube from -1 to 1.
template <typename S>
Points<S> points_on_cube(Random& random, int extra) {
  Points<S> points = box_mesh<S>({1, 1, 1}).vertices;
  for (int i = 0; i < extra; ++i) {
    Vec3<S> p = random.in_cube(S(1));
    p[static_cast<int>(random.index(3))] = random.index(2) == 0 ? S(-1) : S(1);
    points.push_back(p);
  }
  return points;
}

template <typename S>
Points<S> prism(std::uint32_t segments) {
  Points<S> points;
  for (const auto& v : cylinder_mesh<S>({S(1), S(1)}, segments).vertices) points.push_back(v);
  return points;
}

template <typename S>
void place_points(Points<S>& points, const Transform<S>& X, S scale) {
  for (auto& p : points) p = scale * (X * p);
}

template <typename S>
std::string hull_error(const Points<S>& points) {
  return error_of([&] { (void)hull_of(points); });
}

}  // namespace

TEST_CASE_TEMPLATE("convex_hull: of a cube's corners has six squares with exact planes", S, float,
                   double) {
  const ConvexHull<S> hull = hull_of(box_mesh<S>({1, 2, 3}).vertices);
  hull.validate();
  CHECK(hull.vertices == box_mesh<S>({1, 2, 3}).vertices);
  REQUIRE(hull.face_count() == 6);
  for (std::size_t f = 0; f < 6; ++f) {
    CHECK(hull.face(f).size() == 4);
    Eigen::Index axis = 0;
    CHECK(hull.face_normals[f].cwiseAbs().maxCoeff(&axis) == S(1));
    CHECK(hull.face_normals[f].cwiseAbs().sum() == S(1));
    CHECK(hull.face_offsets[f] == S(axis + 1));
  }
}

TEST_CASE_TEMPLATE("convex_hull: leaves out points inside, on faces, on edges and repeated", S,
                   float, double) {
  Points<S> points;
  for (int x = 0; x < 5; ++x) {
    for (int y = 0; y < 5; ++y) {
      for (int z = 0; z < 5; ++z) {
        points.push_back({S(x) / S(4), S(y) / S(4), S(z) / S(4)});
        points.push_back(points.back());
      }
    }
  }
  const ConvexHull<S> hull = hull_of(points);
  check_hull(hull, points);
  CHECK(hull.vertices.size() == 8);
  CHECK(hull.face_count() == 6);
  CHECK(unit_mass_properties<S>(hull).mass == test::relative(1.0));
}

TEST_CASE_TEMPLATE("convex_hull: finds the faces of turned cubes and prisms at every scale", S,
                   float, double) {
  const std::uint64_t seed = 23;
  CAPTURE(seed);
  Random random(seed);
  for (int round = 0; round < rounds(60); ++round) {
    CAPTURE(round);
    const Transform<S> X = random.pose(S(2));
    const S scale = std::pow(S(10), random.uniform(S(-5), S(5)));
    Points<S> points = points_on_cube<S>(random, 150);
    place_points(points, X, scale);
    const ConvexHull<S> cube = hull_of(points);
    check_hull(cube, points);
    CHECK(cube.face_count() == 6);
    CHECK(cube.vertices.size() == 8);
    for (const auto& normal : cube.face_normals) {
      // Along an axis of the cube, to the rounding of its corners.
      const Vec3<S> n = X.rotation.conjugate() * normal;
      CHECK(n.cwiseAbs().maxCoeff() >= S(1) - Tolerance<S>::round_off());
      CHECK(n.cwiseAbs().sum() <= S(1) + S(4) * Tolerance<S>::round_off());
    }

    const auto segments = static_cast<std::uint32_t>(3 + random.index(60));
    points = prism<S>(segments);
    place_points(points, X, scale);
    const ConvexHull<S> round_hull = hull_of(points);
    check_hull(round_hull, points);
    CHECK(round_hull.face_count() == segments + 2);
    CHECK(round_hull.vertices.size() == 2 * segments);
  }
}

TEST_CASE_TEMPLATE("convex_hull: keeps every point of a sphere", S, float, double) {
  const TriangleMesh<S> mesh = sphere_mesh(S(0.1), 6);
  const ConvexHull<S> hull = convex_hull(mesh);
  check_hull(hull, mesh.vertices);
  CHECK(hull.vertices == mesh.vertices);
  CHECK(hull.face_count() == mesh.triangles.size());
  CHECK(unit_mass_properties<S>(hull).mass ==
        test::relative(double(unit_mass_properties<S>(mesh).mass)).epsilon(1e-5));
}

TEST_CASE_TEMPLATE("convex_hull: of random and nearly degenerate clouds is valid", S, float,
                   double) {
  const std::uint64_t seed = 29;
  CAPTURE(seed);
  Random random(seed);
  const S fine = hull_resolution<S>();
  int flat = 0;
  for (int round = 0; round < rounds(150); ++round) {
    CAPTURE(round);
    const Transform<S> X = random.pose(S(2));
    const S scale = std::pow(S(10), random.uniform(S(-4), S(4)));
    const std::size_t count = 4 + random.index(80);
    const auto noise = [&](S size) -> Vec3<S> {
      return fine * random.uniform(S(0), size) * random.direction<S>();
    };
    std::vector<Points<S>> clouds(8);
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3<S> p = random.in_cube(S(1));
      clouds[0].push_back(p);
      clouds[1].push_back({p.x(), p.y(), S(40) * fine * p.z()});
      clouds[2].push_back(p.normalized());
      clouds[2].push_back(p.normalized() + noise(S(4)));
      clouds[3].push_back({p.x(), p.y(), p.z() < S(0) ? S(-1) : S(1)});
      clouds[3].back() += noise(S(6));
      clouds[4].push_back({p.x(), p.y(), -S(30) * fine * (p.x() * p.x() + p.y() * p.y())});
      clouds[5].push_back(p.cwiseAbs2().cwiseProduct(p).cwiseProduct(Vec3<S>(1000, 1, 1)));
    }
    clouds[3].push_back({0, 0, -1});
    clouds[3].push_back({0, 0, 1});
    clouds[4].push_back({0, 0, -1});
    clouds[6] = points_on_cube<S>(random, 0);
    for (std::size_t i = 0; i < count; ++i) {
      Vec3<S> p = clouds[6][random.index(8)];
      p[static_cast<int>(random.index(3))] = random.uniform(S(-1), S(1));
      clouds[6].push_back(p + noise(S(2)));
    }
    // A round needle, so thin that all its facets are slivers.
    const S thin = fine * random.uniform(S(60), S(120));
    for (const auto& v : prism<S>(static_cast<std::uint32_t>(20 + count))) {
      clouds[7].push_back(v.cwiseProduct(Vec3<S>(thin, thin, 1)));
    }
    for (std::size_t c = 0; c < clouds.size(); ++c) {
      CAPTURE(c);
      place_points(clouds[c], X, scale);
      const std::string error = hull_error(clouds[c]);
      // The thin clouds are about as thick as what counts as flat.
      if (error != "") {
        CHECK(error.find("must span a volume") != std::string::npos);
        CHECK((c == 1 || c == 5));
        ++flat;
        continue;
      }
      check_hull(hull_of(clouds[c]), clouds[c]);
    }
  }
  CHECK(flat < rounds(150));
}

TEST_CASE(
    "convex_hull: takes the plane of a thin face from the grid where single precision loses it") {
  // A needle of 4000 km and 20 km, both scaled by chance; the cross product of its longest edges is
  // wrong by 1e-3.
  const Points<float> needle{{131101.062f, -109378.969f, -207524.516f},
                             {2052539.62f, -1593709.38f, -3303172.25f},
                             {8532.70703f, -10217.7822f, -9278.05469f},
                             {-2605.55322f, -1606.67139f, 8604.85352f},
                             {451020.969f, -357569.656f, -721364.938f}};
  check_hull(hull_of(needle), needle);
}

TEST_CASE_TEMPLATE("convex_hull: does not depend on the order of the points", S, float, double) {
  const std::uint64_t seed = 31;
  CAPTURE(seed);
  Random random(seed);
  Points<S> points;
  for (int i = 0; i < 100; ++i) points.push_back(random.in_cube(S(1)));
  const auto is_less = [](const Vec3<S>& a, const Vec3<S>& b) {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
  };
  ConvexHull<S> first = hull_of(points);
  std::reverse(points.begin(), points.end());
  ConvexHull<S> second = hull_of(points);
  CHECK(first.face_count() == second.face_count());
  std::sort(first.vertices.begin(), first.vertices.end(), is_less);
  std::sort(second.vertices.begin(), second.vertices.end(), is_less);
  CHECK(first.vertices == second.vertices);
}

TEST_CASE("convex_hull: of 10 000 points takes well under a second") {
  const std::uint64_t seed = 37;
  CAPTURE(seed);
  Random random(seed);
  Points<double> cloud;
  for (int i = 0; i < 10000; ++i) cloud.push_back(random.in_cube(1.0));
  check_hull(hull_of(cloud), cloud);
  for (auto& p : cloud) p.normalize();
  CHECK(hull_of(cloud).vertices.size() == cloud.size());
}

TEST_CASE_TEMPLATE("convex_hull: refuses points without a volume", S, float, double) {
  CHECK(hull_error<S>({}).find("0 points") != std::string::npos);
  CHECK(hull_error<S>({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}).find("3 points") != std::string::npos);
  CHECK(hull_error<S>(Points<S>(9, Vec3<S>(1, 2, 3))).find("all equal") != std::string::npos);
  const std::uint64_t seed = 41;
  CAPTURE(seed);
  Random random(seed);
  const Transform<S> X = random.pose(S(1));
  for (const S scale : {S(1e-3), S(1), S(1e3)}) {
    Points<S> line;
    Points<S> plane;
    for (int i = 0; i < 20; ++i) {
      line.push_back(scale * (X * Vec3<S>(random.uniform(S(-1), S(1)), 0, 0)));
      const Vec3<S> p = random.in_cube(S(1));
      plane.push_back(scale * (X * Vec3<S>(p.x(), p.y(), 0)));
    }
    CHECK(hull_error(line).find("all on a line") != std::string::npos);
    CHECK(hull_error(plane).find("all on a plane") != std::string::npos);
  }
  CHECK_THROWS_AS((void)convex_hull(grid_mesh<S>({1, 1}, {3, 3})), InvalidArgument);
}

TEST_CASE_TEMPLATE("convex_hull: names the point that is not finite", S, float, double) {
  Points<S> points = box_mesh<S>({1, 1, 1}).vertices;
  points[5].y() = std::numeric_limits<S>::quiet_NaN();
  CHECK(hull_error(points).find("points[5]") != std::string::npos);
  points[5].y() = infinity<S>;
  CHECK(hull_error(points).find("points[5]") != std::string::npos);
  points = box_mesh<S>({1, 1, 1}).vertices;
  for (auto& p : points) p *= S(0.9) * std::numeric_limits<S>::max();
  CHECK(hull_error(points).find("its square has to be finite") != std::string::npos);
}
