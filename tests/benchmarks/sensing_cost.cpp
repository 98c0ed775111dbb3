// What a sensor costs, and how wrong the force is that it buys.
//
// A fixed pad of 40 x 40 mm with n sensors carries 2 kg: a box, a sphere, or the sphere's mesh of
// 9680 triangles. At rest the vertical force is m g, the closed form that the error is measured
// against. Printed for each backend, scalar, shape, integration and n:
//
//   rays   [ns]     one ray of the batch, asked of the shape alone
//   step   [ns]     one sensor of the world's whole step: rays, law, solver, readings
//   touch  [%]      of the sensors
//   error  [1/1000] of the weight
//
// and what a patch costs that has nothing near it. Times are processor time of the thread, medians
// of 11 runs.
// Usage: benchmark_sensing_cost [CSV file]
// SPDX-License-Identifier: BSD-3-Clause
#include "benchmarks/thread_clock.hpp"

#include <bristle/bristle.hpp>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <string>

using namespace bristle;

namespace {

constexpr double mass = 2;
constexpr double gravity = 9.81;

template <Scalar S>
struct NamedShape {
  const char* name;
  Shape<S> shape;
  S half_height;
};

template <Scalar S>
PatchDef<S> pad_of(int side, Integration integration) {
  PatchDef<S> def;
  const auto count = static_cast<std::size_t>(side);
  def.sensors = sensor_grid<S>(
      {.side_u = {S(0.04), 0, 0}, .side_v = {0, S(0.04), 0}, .count_u = count, .count_v = count});
  def.parameters =
      tuned_for<S>({.load = S(mass * gravity), .mass = S(mass)}).parameters(def.sensors);
  def.integration = integration;
  return def;
}

/// Prints lines of the table and keeps them as lines of the CSV file.
class Report {
 public:
  Report() {
    std::puts(
        "backend   scalar  shape   integration      n  rays [ns]  step [ns]  touch [%]  error "
        "[1/1000]");
  }
  void add(const std::string& backend, const std::string& scalar, const std::string& shape,
           const std::string& integration, std::size_t n, std::array<double, 4> values) {
    std::printf("%-8s  %-6s  %-6s  %-11s  %5zu  %9.1f  %9.1f  %9.0f  %14.4f\n", backend.c_str(),
                scalar.c_str(), shape.c_str(), integration.c_str(), n, values[0], values[1],
                values[2], values[3]);
    std::fflush(stdout);
    csv_ += backend + ',' + scalar + ',' + shape + ',' + integration + ',' + std::to_string(n);
    for (const double value : values) csv_ += ',' + detail::to_text(value);
    csv_ += '\n';
  }
  void write(const char* path) const { write_file(path, csv_); }

 private:
  std::string csv_ =
      "backend,scalar,shape,integration,sensors,ray [ns],step [ns],touching [%],error [1/1000]\n";
};

template <Scalar S, typename Backend>
void measure(Report& report, const char* backend, const char* scalar, const NamedShape<S>& object,
             Integration integration, int side) {
  World<S, Backend> world({.time_step = S(1e-3)});
  const BodyId pad = world.add_body({.motion = Motion::fixed});
  const PatchId patch = world.add_patch(pad, pad_of<S>(side, integration));
  // With its centre of mass at its underside it stands by itself, however soft the pad.
  const BodyId body = world.add_body({.mass = S(mass),
                                      .center_of_mass = Vec3<S>(0, 0, -object.half_height),
                                      .shape = object.shape,
                                      .position = {0, 0, object.half_height + S(0.002)}});
  for (int i = 0; i < 1000; ++i) world.step();

  const double n = static_cast<double>(world.patch(patch).size());
  const double step = benchmarks::median_nanoseconds([&] { world.step(); }) / n;
  const PatchReading<S> felt = world.reading(patch);
  const double weight = mass * gravity;
  // The pad feels the object's weight.
  const double error = std::abs(static_cast<double>(felt.wrench.force.z()) + weight) / weight;

  const auto shape = Backend::template make<S>(object.shape);
  const RayBatch<S> rays = world.patch(patch).rays(S(0));
  const Transform<S> pose = world.pose(body);
  RayHits<S> hits;
  const double ray = benchmarks::median_nanoseconds([&] {
                       hits.reset(rays.size());
                       Backend::cast_rays(shape, pose, rays, 0, hits);
                     }) /
                     n;
  report.add(backend, scalar, object.name,
             integration == Integration::implicit ? "implicit" : "explicit",
             world.patch(patch).size(),
             {ray, step, 100 * static_cast<double>(felt.touching()) / n, 1000 * error});
}

/// Many patches with nothing near them: what they cost when they do nothing.
template <Scalar S, typename Backend>
void measure_idle(const char* backend, const char* scalar) {
  World<S, Backend> world({.time_step = S(1e-3)});
  world.add_body({.mass = S(mass), .shape = Sphere<S>{S(0.1)}, .position = {0, 0, 100}});
  const int patches = 1000;
  for (int i = 0; i < patches; ++i) {
    const BodyId pad = world.add_body({.motion = Motion::fixed, .position = {S(i), 0, 0}});
    world.add_patch(pad, pad_of<S>(10, Integration::automatic));
  }
  const double step = benchmarks::median_nanoseconds([&] { world.step(); });
  std::printf("%-8s  %-6s  %.1f ns a patch of 100 sensors with nothing near; %.0f rays cast\n",
              backend, scalar, step / patches, static_cast<double>(world.report().rays_cast));
}

template <Scalar S, typename Backend>
void measure_shape(Report& report, const char* backend, const char* scalar,
                   const NamedShape<S>& object) {
  for (const Integration integration : {Integration::explicit_, Integration::implicit}) {
    for (const int side : {10, 32, 100}) {
      measure<S, Backend>(report, backend, scalar, object, integration, side);
    }
  }
}

template <Scalar S, typename Backend>
void measure_all(Report& report, const char* backend, const char* scalar) {
  const S half = S(0.1);
  measure_shape<S, Backend>(report, backend, scalar,
                            {"box", Box<S>{.half_extents = {half, half, half}}, half});
  measure_shape<S, Backend>(report, backend, scalar, {"sphere", Sphere<S>{half}, half});
  measure_shape<S, Backend>(report, backend, scalar, {"mesh", sphere_mesh<S>(half, 22), half});
}

template <typename Backend>
void measure_backend(Report& report, const char* name) {
  measure_all<double, Backend>(report, name, "double");
  measure_all<float, Backend>(report, name, "float");
}

}  // namespace

int main(int argc, char** argv) {
  Report report;
  measure_backend<AnalyticBackend>(report, "analytic");
#if defined(BRISTLE_WITH_FCL)
  measure_backend<FclBackend>(report, "fcl");
#endif
  std::puts("");
  measure_idle<double, AnalyticBackend>("analytic", "double");
  measure_idle<float, AnalyticBackend>("analytic", "float");
  if (argc > 1) report.write(argv[1]);
}
