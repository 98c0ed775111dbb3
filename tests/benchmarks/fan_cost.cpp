// Cost of a ray of a fan that looks all around, 10 m far, among meshes or balls.
//
//   array   `World::sense` of a `ProximityArray`
//   rays    `World::cast_rays` of the same rays
//   wrong   distances in which the two differ by more than round-off
//
// ns a ray, processor time, medians of 15 runs.
// Usage: benchmark_fan_cost [--markdown]
// SPDX-License-Identifier: BSD-3-Clause
#include "benchmarks/benchmark_table.hpp"
#include "benchmarks/pad_workload.hpp"
#include "benchmarks/thread_clock.hpp"
#include "support/random.hpp"

#include <bristle/bristle.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

using namespace bristle;

namespace {

/// [ns] Median of 15 calls, for each of n rays.
template <typename Call>
double median(std::size_t n, const Call& call) {
  std::array<double, 15> times;
  for (double& time : times) {
    const double start = benchmarks::thread_seconds();
    call();
    time = benchmarks::thread_seconds() - start;
  }
  std::nth_element(times.begin(), times.begin() + 7, times.end());
  return 1e9 * times[7] / static_cast<double>(n);
}

template <typename S>
void measure(benchmarks::Table& table, const char* scalar, bool has_meshes, int count,
             std::size_t rows) {
  World<S> world({.gravity = Vec3<S>::Zero()});
  const BodyId carrier = world.add_body({.motion = Motion::kinematic});
  test::Random random(3);
  const double half = 8 * std::cbrt(count / 200.0);
  // 0.25 m, bumpy, of 980 triangles; or balls of that size.
  TriangleMesh<double> mesh = benchmarks::bumpy_ball(7);
  for (Vec3<double>& v : mesh.vertices) v *= 5;
  const Shape<S> shape = has_meshes ? benchmarks::shape_as<S>(mesh) : Sphere<S>{S(0.25)};
  for (int i = 0; i < count; ++i) {
    Vec3<double> at = Vec3<double>::Zero();
    while (at.norm() < 0.5) at = random.in_cube(half).cwiseProduct(Vec3<double>(1, 1, 2 / half));
    (void)world.add_body(
        {.motion = Motion::fixed, .shape = shape, .position = Vec3<S>(at.template cast<S>())});
  }
  const SensorLayout<S> layout = ray_fan<S>({.width = S(2 * std::numbers::pi),
                                             .height = rows > 1 ? S(0.5) : S(0),
                                             .columns = 360,
                                             .rows = rows,
                                             .range = S(10)});
  const std::size_t n = layout.size();
  ProximityArray<S> array(layout);
  std::vector<Ray<S>> rays;
  for (std::size_t i = 0; i < n; ++i) {
    rays.push_back({layout.start[i], layout.direction[i], layout.length[i]});
  }
  std::vector<WorldHit<S>> hits(n);
  QueryFilter filter;
  filter.excluded = {carrier};
  const double of_array = median(n, [&] { world.sense(carrier, array); });
  const double of_rays = median(n, [&] { world.cast_rays(rays, filter, hits); });
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const S a = array.distance()[i];
    const S b = hits[i].distance;
    const bool is_same =
        a == b || std::abs(a - b) <= 64 * detail::Tolerance<S>::round_off() * S(10);
    wrong += is_same ? 0u : 1u;
  }
  table.add({std::to_string(count) + (has_meshes ? " meshes" : " balls"), scalar, std::to_string(n),
             benchmarks::in_short(of_array), benchmarks::in_short(of_rays), std::to_string(wrong)});
}

}  // namespace

int main(int argc, char** argv) {
  benchmarks::Table table(argc > 1 && std::string(argv[1]) == "--markdown",
                          {"      among", "scalar", "  rays", "array", " rays", "wrong"});
  for (const std::size_t rows : {std::size_t(1), std::size_t(8)}) {
    measure<float>(table, "float", true, 200, rows);
    measure<double>(table, "double", true, 200, rows);
    for (const int count : {200, 2000, 10000}) measure<float>(table, "float", false, count, rows);
  }
}
