// SPDX-License-Identifier: BSD-3-Clause
#include "support/ray_patches.hpp"
#include "support/rounds.hpp"

#include <bristle/geometry/contacts/triangle_cache.hpp>
#include <bristle/geometry/rays/ray_tree_mesh_query.hpp>

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

using namespace bristle;

using namespace bristle::detail;
using bristle::test::ray_mesh;
using test::PatchKind;

namespace {

/// A cube of 32 mm whose faces are divided into squares of 0.5 mm.
TriangleMesh<double> divided_cube() {
  constexpr std::uint32_t n = 64;
  TriangleMesh<double> mesh;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
      for (std::uint32_t k = 0; k < (n + 1) * (n + 1); ++k) {
        Vec3<double> v;
        v[axis] = side * 0.016;
        v[(axis + 1) % 3] = side * (double(k % (n + 1)) - n / 2) * 0.0005;
        v[(axis + 2) % 3] = (double(k / (n + 1)) - n / 2) * 0.0005;
        mesh.vertices.push_back(v);
      }
      for (std::uint32_t k = 0; k < n * n; ++k) {
        const std::uint32_t a = first + k / n * (n + 1) + k % n;
        mesh.triangles.push_back({a, a + 1, a + n + 2});
        mesh.triangles.push_back({a, a + n + 2, a + n + 1});
      }
    }
  }
  return mesh;
}

/// Rays that are asked twice: with what they keep, and without.
template <Scalar S>
class Compared {
 public:
  explicit Compared(const test::RayPatch<S>& patch)
      : patch_(patch), ray_tree_(patch.batch(nullptr)) {}

  /// How many of the answers differ in any bit.
  [[nodiscard]] std::size_t differences(const RayMesh<S>& mesh, const Transform<S>& X,
                                        std::uint32_t life = 0, S extra = S(0),
                                        S known = infinity<S>) {
    RayBatch<S> rays = patch_.batch(&ray_tree_, extra);
    RayHits<S> alone, with;
    for (RayHits<S>* hits : {&alone, &with}) {
      hits->reset(rays.size());
      for (S& distance : hits->distance) distance = known;
    }
    cast_rays_at_mesh(mesh, X, rays, 7, alone);
    rays.triangle_cache = &kept;
    rays.shape_life = life;
    cast_rays_at_mesh(mesh, X, rays, 7, with);
    std::size_t count = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const bool is_met = alone.distance[i] < known;
      hits_ += is_met ? 1u : 0u;
      const bool is_same = with.distance[i] == alone.distance[i] && with.tag[i] == alone.tag[i] &&
                           (!is_met || with.normal[i] == alone.normal[i]);
      count += is_same ? 0u : 1u;
    }
    return count;
  }
  [[nodiscard]] std::size_t hits() const { return hits_; }

  TriangleCache<S> kept;

 private:
  const test::RayPatch<S>& patch_;
  RayTree<S> ray_tree_;
  std::size_t hits_ = 0;
};

template <Scalar S>
Transform<S> pose(const Vec3<double>& p, const Vec3<double>& turn = Vec3<double>::Zero()) {
  Transform<double> X;
  X.translation = p;
  const double angle = turn.norm();
  if (angle > 0) X.rotation = Eigen::AngleAxisd(angle, Vec3<double>(turn / angle));
  return X.template cast<S>();
}

}  // namespace

TEST_CASE_TEMPLATE("TriangleCache: answers are those without them, to the bit, however things move",
                   S, float, double) {
  test::Random random(5);
  std::size_t reused = 0;
  std::size_t searched = 0;
  for (const TriangleMesh<double>& shape : {test::bumpy_mesh(40), divided_cube()}) {
    for (const double scale : {0.01, 1.0, 100.0}) {
      const RayMesh<S> mesh = ray_mesh(test::scaled_mesh<S>(shape, scale));
      for (const PatchKind kind :
           {PatchKind::pad, PatchKind::convex, PatchKind::scattered, PatchKind::column}) {
        const auto patch = test::make_rays<S>(kind, 30, scale, random);
        Compared<S> rays(patch);
        Vec3<double> p(0, 0, 0.05);
        Vec3<double> turn = Vec3<double>::Zero();
        Vec3<double> velocity = Vec3<double>::Zero();
        Vec3<double> spin = Vec3<double>::Zero();
        std::size_t wrong = 0;
        for (int step = 0; step < test::rounds(900); ++step) {
          // Now and then it goes on at another speed, from crawling to flying, or from elsewhere.
          if (step % 25 == 0) {
            const double speed = 2e-6 * std::pow(1000.0, random.uniform(0.0, 1.0));
            velocity = speed * random.in_cube(1.0);
            spin = 40 * speed * random.in_cube(1.0);
          }
          if (step % 100 == 0) {
            p = {random.uniform(-0.01, 0.01), random.uniform(-0.01, 0.01),
                 random.uniform(0.012, 0.055)};
          }
          p += velocity;
          turn += spin;
          const S extra = S(scale * random.uniform(0.0, 1e-5));
          const S known = step % 3 == 0 ? S(scale * 0.003) : infinity<S>;
          wrong += rays.differences(mesh, pose<S>(scale * p, turn), 0, extra, known);
        }
        CAPTURE(scale);
        CAPTURE(int(kind));
        CAPTURE(shape.triangles.size());
        CHECK(wrong == 0);
        CHECK(rays.hits() > 0);
        reused += rays.kept.reused();
        searched += rays.kept.searched();
      }
    }
  }
  CHECK(searched > 1000);
  CHECK(reused > 3 * searched);
}

TEST_CASE_TEMPLATE("TriangleCache: rays along faces, edges and corners", S, float, double) {
  const RayMesh<S> mesh = ray_mesh(test::scaled_mesh<S>(divided_cube(), 1));
  test::RayPatch<S> patch;
  for (int i = 0; i < 36; ++i) {
    patch.add({(i % 6 - 3) * 0.004, (i / 6 - 3) * 0.004, -0.002}, {0, 0, 1}, 0.005);
  }
  Compared<S> rays(patch);
  test::Random random(9);
  std::size_t wrong = 0;
  for (int step = 0; step < test::rounds(2000); ++step) {
    // Over the lines of the faces and along their planes, exactly and nearly.
    const double nearly = step % 3 == 0 ? 1e-8 : 0.0;
    const Vec3<double> p((step % 256) * 3.125e-5, (step / 256 % 128) * 0.000125,
                         step / 256 % 2 == 0 ? 0.016 : 0.004);
    wrong += rays.differences(
        mesh, pose<S>(p + nearly * random.in_cube(1.0), nearly * random.in_cube(1.0)));
  }
  CHECK(wrong == 0);
  CHECK(rays.hits() > 0);
  CHECK(rays.kept.reused() > 3 * rays.kept.searched());
}

TEST_CASE_TEMPLATE("TriangleCache: serve while motion is slow, and are not made while it is fast",
                   S, float, double) {
  const RayMesh<S> mesh = ray_mesh(test::scaled_mesh<S>(test::bumpy_mesh(40), 1));
  test::Random random(3);
  const auto patch = test::make_rays<S>(PatchKind::pad, 30, 1, random);
  const auto move = [&](Compared<S>& rays, double speed, int steps) {
    const std::size_t searched = rays.kept.searched();
    const std::size_t reused = rays.kept.reused();
    for (int k = 0; k < steps; ++k) {
      const Vec3<double> turn(speed / 0.05 * k, speed / 0.1 * k, 0);
      REQUIRE(rays.differences(mesh, pose<S>({0, 0, 0.051}, turn)) == 0);
    }
    return std::array<std::size_t, 2>{rays.kept.searched() - searched, rays.kept.reused() - reused};
  };
  Compared<S> rays(patch);
  // Triangles have an area of about 1 mm^2.
  const auto slow = move(rays, 5e-5, 200);
  CHECK(slow[1] > 30 * 200 * 4 / 5);
  // The credit may be spent, and then one ray in 80.
  const auto fast = move(rays, 3e-3, 1000);
  CHECK(fast[0] < 30 * 2 + 30 * 1000 / 80 + 30);
  CHECK(fast[1] < 100);
  const auto again = move(rays, 5e-5, 400);
  CHECK(again[1] > 30 * 400 / 2);
}

TEST_CASE("TriangleCache: a query of many nodes is one query") {
  // 1296 rays in 21 leaves, each with some twenty triangles before it.
  const RayMesh<double> mesh = ray_mesh(test::bumpy_mesh(64));
  test::RayPatch<double> patch;
  constexpr int side = 36;
  for (int i = 0; i < side * side; ++i) {
    const double x = 0.08 * (i % side / double(side - 1) - 0.5);
    const double y = 0.08 * (i / side / double(side - 1) - 0.5);
    patch.add({x, y, -0.06}, {0, 0, 1}, 0.06);
  }
  Compared<double> rays(patch);
  std::size_t wrong = 0;
  for (int k = 0; k < 40; ++k) {
    wrong += rays.differences(mesh, pose<double>({0, 0, 0}, {0.06 * k, 0.03 * k, 0}));
  }
  CHECK(wrong == 0);
  // Fast motion: all search in the first query, and in the one after each pause of twenty.
  CHECK(rays.kept.searched() > 0);
  CHECK(rays.kept.searched() < 3 * side * side);
}

TEST_CASE("TriangleCache: rays that turn about their starts move as well") {
  const RayMesh<double> mesh = ray_mesh(test::bumpy_mesh(71));
  test::RayPatch<double> patch;
  for (const double x : {-0.5, 0.5}) {
    for (const double y : {-0.5, 0.5}) patch.add({0, 0, 0}, {x, y, 1}, 0.005);
  }
  Compared<double> rays(patch);
  std::size_t wrong = 0;
  for (int step = 0; step < test::rounds(1000); ++step) {
    const Transform<double> turned =
        pose<double>({0, 0, 0}, {0.2 * std::sin(0.05 * step), 0.1 * std::sin(0.03 * step), 0});
    wrong += rays.differences(mesh, turned * pose<double>({0, 0, 0.0535}));
  }
  CHECK(wrong == 0);
  CHECK(rays.hits() > 0);
  CHECK(rays.kept.reused() > 2 * rays.kept.searched());
}

TEST_CASE("TriangleCache: a shape in the place of another is not taken for it") {
  const std::array<RayMesh<double>, 2> balls{ray_mesh(test::bumpy_mesh(40)),
                                             ray_mesh(test::bumpy_mesh(37))};
  test::Random random(4);
  const auto patch = test::make_rays<double>(PatchKind::pad, 30, 1, random);
  Compared<double> rays(patch);
  std::size_t wrong = 0;
  for (std::uint32_t life = 0; life < 12; ++life) {
    for (int k = 0; k < 40; ++k) {
      wrong += rays.differences(balls[life % 2], pose<double>({1e-6 * k, 0, 0.051}), life);
    }
  }
  CHECK(wrong == 0);
  CHECK(rays.hits() > 0);
  // Of two that are asked in turn one has the lists.
  const std::size_t searched = rays.kept.searched();
  for (std::uint32_t k = 0; k < 100; ++k) {
    wrong += rays.differences(balls[k % 2], pose<double>({0, 0, 0.051}), 20 + k % 2);
  }
  CHECK(wrong == 0);
  CHECK(rays.kept.searched() <= searched + patch.length.size());
}

TEST_CASE("TriangleCache: nodes and ranges have no use for them") {
  const RayMesh<double> ball = ray_mesh(test::bumpy_mesh(7));
  test::Random random(4);
  const auto patch = test::make_rays<double>(PatchKind::pad, 200, 1, random);
  Compared<double> rays(patch);
  CHECK(rays.differences(ball, pose<double>({0, 0, 0.0505})) == 0);
  CHECK(rays.differences(ball, pose<double>({0, 0, 0.0505})) == 0);
  CHECK(rays.hits() > 0);
  CHECK(rays.kept.searched() + rays.kept.reused() == 0);
}
