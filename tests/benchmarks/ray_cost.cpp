// Cost of a ray of a patch, cast at the shape alone, and the number of wrong hits.
//
// The workload is that of pad_workload.hpp. Printed in ns a ray for each backend, scalar, shape and
// n:
//
//   alone    one ray after the other         nodes  the same rays as a patch prepares them
//   wrong    of the answers of the nodes, in ppm: hit where there is none, none where there is,
//            or at another distance by more than 2 um (float) or 2 pm (double)
//
// each the sum over all steps of a step's median over 7 runs.
// Usage: benchmark_ray_cost [part of the name of a shape]
// SPDX-License-Identifier: BSD-3-Clause
#include "benchmarks/pad_workload.hpp"

#include <bristle/bristle.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdio>

#if defined(BRISTLE_WITH_BULLET)
#include "benchmarks/bullet_rays.hpp"
#endif

using namespace bristle;

using namespace bristle::detail;
using namespace bristle::benchmarks;

namespace {

/// [s] Reading it costs little beside the shortest query; medians leave out what others do to the
/// machine.
double now_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

template <Scalar S>
struct Measured {
  double alone = 0;
  double ray_tree = 0;
  double wrong = 0;
  double hits = 0;
};

template <Scalar S, typename Backend>
class RayCost {
 public:
  RayCost(const Object& object, const Reference& reference, std::size_t n, double gap)
      : object_(object),
        reference_(reference),
        layout_(pad_rays(n)),
        gap_(gap),
        shape_(Backend::template make<S>(shape_as<S>(object.shape))),
        patch_(make_patch(patch_def(layout_), BodyId{}, Vec3<S>(Vec3<S>::Zero()))) {}

  Measured<S> run() {
    const int steps = layout_.size() <= 100 ? 1000 : (layout_.size() <= 1024 ? 300 : 100);
    Measured<S> sum;
    std::size_t wrong = 0;
    std::size_t checked = 0;
    for (int step = 0; step < steps; ++step) {
      const Transform<S> X = object_.pose(step, gap_).template cast<S>();
      RayBatch<S> batch = patch_.geometry->rays(S(0));
      sum.ray_tree += median_seconds(X, batch);
      if (step % 10 == 0) {
        wrong += wrong_answers(step, batch, sum.hits);
        checked += layout_.size();
      }
      batch.ray_tree = nullptr;
      sum.alone += median_seconds(X, batch);
    }
    const double rays = double(steps) * double(layout_.size());
    sum.ray_tree *= 1e9 / rays;
    sum.alone *= 1e9 / rays;
    sum.wrong = 1e6 * double(wrong) / double(checked);
    sum.hits /= double(checked);
    return sum;
  }

 private:
  static PatchDef<S> patch_def(const SensorLayout<double>& rays) {
    PatchDef<S> def;
    def.sensors = layout_as<S>(rays);
    return def;
  }

  double median_seconds(const Transform<S>& X, const RayBatch<S>& batch) {
    std::array<double, 7> times{};
    for (double& time : times) {
      hits_.reset(batch.size());
      const double start = now_seconds();
      Backend::cast_rays(shape_, X, batch, 0, hits_);
      time = now_seconds() - start;
    }
    std::nth_element(times.begin(), times.begin() + 3, times.end());
    return times[3];
  }

  std::size_t wrong_answers(int step, const RayBatch<S>& batch, double& hits) const {
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < batch.size(); ++i) {
      const Ray<S> ray = batch[i];
      // The pose and the ray as they were rounded.
      const double expected =
          reference_
              .hit(object_.pose(step, gap_).template cast<S>().template cast<double>(),
                   {ray.origin.template cast<double>(),
                    ray.direction.template cast<double>().normalized(), double(ray.length)})
              .distance;
      hits += hits_.is_hit(i) ? 1 : 0;
      wrong += is_right(hits_.distance[i], expected, double(ray.length)) ? 0u : 1u;
    }
    return wrong;
  }

  const Object& object_;
  const Reference& reference_;
  SensorLayout<double> layout_;
  double gap_;
  typename Backend::template Collidable<S> shape_;
  SensorPatch<S> patch_;
  RayHits<S> hits_;
};

template <Scalar S, typename Backend>
void measure(const char* backend, const Object& object, const Reference& reference) {
  for (const std::size_t n : {100u, 1024u, 10000u}) {
    const double gap = gap_for_half(object, reference, pad_rays(n));
    const Measured<S> m = RayCost<S, Backend>(object, reference, n, gap).run();
    std::printf("%-8s  %-6s  %-8s  %5zu  %8.2f  %8.2f  %8.1f  %4.0f %%\n", backend,
                std::is_same_v<S, float> ? "float" : "double", object.name.c_str(), n, m.alone,
                m.ray_tree, m.wrong, 100 * m.hits);
    std::fflush(stdout);
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::puts("backend   scalar  shape         n     alone   nodes     wrong    hit");
  for (const Object& object : pad_objects(argc > 1 ? argv[1] : "")) {
    const Reference reference(object.shape);
    measure<float, AnalyticBackend>("analytic", object, reference);
    measure<double, AnalyticBackend>("analytic", object, reference);
#if defined(BRISTLE_WITH_FCL)
    measure<float, FclBackend>("fcl", object, reference);
    measure<double, FclBackend>("fcl", object, reference);
#endif
#if defined(BRISTLE_WITH_BULLET)
    measure<float, BulletBackend>("bullet", object, reference);
#endif
  }
}
