// Cost of a contact query by each backend, and the difference of their gaps.
//
// For each pair: 64 random poses of shapes of about a metre, brought to a gap by moving B along a
// random line: 0.1 apart within a margin of 0.2 (speculative), 1e-6 deep (resting), 0.1 deep. And
// poses at rest: B flat on A. Printed: mean time of a query on either backend, largest difference
// of the deepest gaps. Times are processor time of the thread, medians of 11 runs.
// Usage: benchmark_contact_cost
// SPDX-License-Identifier: BSD-3-Clause
#include "benchmarks/thread_clock.hpp"

#include <bristle/geometry/backends/analytic_backend.hpp>
#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/geometry/shapes/quickhull.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <support/random.hpp>
#include <vector>
#if defined(BRISTLE_WITH_FCL)
#include <bristle/geometry/backends/fcl_backend.hpp>
#endif

using namespace bristle;

namespace {

using S = double;

template <typename Backend>
S deepest_gap(const typename Backend::template Collidable<S>& a,
              const typename Backend::template Collidable<S>& b, const Transform<S>& X, S margin) {
  static ContactManifolds<S> out;
  out.clear();
  if (Backend::collide(a, b, X, margin, out) != ContactStatus::ok) return -infinity<S>;
  S gap = infinity<S>;
  for (const auto& m : out) {
    for (std::size_t i = 0; i < m.size; ++i) gap = std::min(gap, m.points[i].gap);
  }
  return gap;
}

/// [ns] Mean time of a query over the poses.
template <typename Backend>
double query_time(const Shape<S>& shape_a, const Shape<S>& shape_b,
                  const std::vector<Transform<S>>& poses) {
  const auto a = Backend::template make<S>(shape_a);
  const auto b = Backend::template make<S>(shape_b);
  std::array<double, 11> times{};
  for (double& time : times) {
    int queries = 0;
    const double start = benchmarks::thread_seconds();
    while (benchmarks::thread_seconds() - start < 3e-3) {
      for (const auto& X : poses) deepest_gap<Backend>(a, b, X, 0.2);
      queries += static_cast<int>(poses.size());
    }
    time = 1e9 * (benchmarks::thread_seconds() - start) / queries;
  }
  std::nth_element(times.begin(), times.begin() + 5, times.end());
  return times[5];
}

struct NamedShape {
  const char* name;
  Shape<S> shape;
  // Distance of its lowest point from its origin.
  S foot;
};

/// Poses along random lines with a given gap, as far as there are any.
std::vector<Transform<S>> poses_with_gap(const Shape<S>& shape_a, const Shape<S>& shape_b, S gap) {
  test::Random random(17);
  const auto a = AnalyticBackend::make<S>(shape_a);
  const auto b = AnalyticBackend::make<S>(shape_b);
  std::vector<Transform<S>> poses;
  for (int i = 0; i < 400 && poses.size() < 64; ++i) {
    const Vec3<S> away = random.direction<S>();
    const Quat<S> attitude = random.rotation<S>();
    S near = 0, far = 6;
    while (far - near > 1e-9) {
      const S middle = (near + far) / 2;
      (deepest_gap<AnalyticBackend>(a, b, {attitude, middle * away}, 10) < gap ? near : far) =
          middle;
    }
    const Transform<S> X{attitude, far * away};
    if (std::abs(deepest_gap<AnalyticBackend>(a, b, X, 10) - gap) < 1e-7) poses.push_back(X);
  }
  return poses;
}

void report(const NamedShape& a, const NamedShape& b, const char* state,
            const std::vector<Transform<S>>& poses) {
  if (poses.empty()) return;
  std::printf("%-10s %-10s %-10s %9.0f", a.name, b.name, state,
              query_time<AnalyticBackend>(a.shape, b.shape, poses));
#if defined(BRISTLE_WITH_FCL)
  std::printf(" %9.0f", query_time<FclBackend>(a.shape, b.shape, poses));
  const auto own_a = AnalyticBackend::make<S>(a.shape), own_b = AnalyticBackend::make<S>(b.shape);
  const auto fcl_a = FclBackend::make<S>(a.shape), fcl_b = FclBackend::make<S>(b.shape);
  S worst = 0;
  for (const auto& X : poses) {
    worst = std::max(worst, std::abs(deepest_gap<AnalyticBackend>(own_a, own_b, X, 0.2) -
                                     deepest_gap<FclBackend>(fcl_a, fcl_b, X, 0.2)));
  }
  std::printf(" %9.1e", worst);
#endif
  std::printf("\n");
}

}  // namespace

int main() {
  test::Random random(3);
  std::vector<Vec3<S>> points;
  for (int i = 0; i < 32; ++i) points.push_back(0.6 * random.direction<S>());
  const NamedShape sphere{"sphere", Sphere<S>{0.5}, 0.5};
  const NamedShape box{"box", Box<S>{{0.5, 0.4, 0.3}}, 0.3};
  const NamedShape capsule{"capsule", Capsule<S>{0.3, 0.4}, 0.7};
  const NamedShape cylinder{"cylinder", Cylinder<S>{0.4, 0.5}, 0.5};
  const NamedShape cone{"cone", Cone<S>{0.4, 0.5}, 0.5};
  const NamedShape ellipsoid{"ellipsoid", Ellipsoid<S>{{0.5, 0.4, 0.3}}, 0.3};
  const NamedShape hull{"hull of 32", convex_hull<S>(points), 0.6};
  const NamedShape mesh{"mesh of 320", sphere_mesh<S>(0.5, 4), 0.5};
  const NamedShape block{"block mesh", box_mesh<S>({0.5, 0.4, 0.3}), 0.3};
  const std::array<std::array<const NamedShape*, 2>, 20> pairs{
      {{&sphere, &sphere},     {&box, &box},         {&capsule, &capsule},
       {&box, &capsule},       {&sphere, &cylinder}, {&box, &cylinder},
       {&cylinder, &cylinder}, {&sphere, &cone},     {&box, &cone},
       {&sphere, &ellipsoid},  {&box, &ellipsoid},   {&ellipsoid, &ellipsoid},
       {&sphere, &hull},       {&box, &hull},        {&cylinder, &hull},
       {&hull, &hull},         {&sphere, &mesh},     {&box, &block},
       {&block, &block},       {&cylinder, &mesh}}};
  std::printf("%-10s %-10s %-10s %9s %9s %9s\n", "A", "B", "state", "own [ns]", "FCL [ns]",
              "differ [m]");
  for (const auto& [a, b] : pairs) {
    report(*a, *b, "apart", poses_with_gap(a->shape, b->shape, 0.1));
    report(*a, *b, "touching", poses_with_gap(a->shape, b->shape, -1e-6));
    report(*a, *b, "deep", poses_with_gap(a->shape, b->shape, -0.1));
  }
  const NamedShape table{"table", Box<S>{{2, 2, 0.5}}, 0.5};
  for (const NamedShape* b : {&box, &capsule, &cylinder, &cone, &ellipsoid, &hull, &block}) {
    const Transform<S> X{Quat<S>::Identity(), Vec3<S>(0.1, 0.2, 0.5 + b->foot - 1e-6)};
    report(table, *b, "at rest", {X});
  }
}
