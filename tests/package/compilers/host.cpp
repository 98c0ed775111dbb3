// A file of a host that has the headers among its own: a world with a patch, in one scalar or two,
// on every backend that there is. It is checked by compilers.cmake and never run.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/bristle.hpp>
#if defined(HOST_WITH_ADF)
#include <bristle/io/adf.hpp>
#endif

#include <unordered_set>

// Code is younger than this, or it was checked with another library than it is for.
#if BRISTLE_VERSION < 100
#error "bristle 0.1 or later is needed"
#endif

namespace {

using namespace bristle;

template <typename S, typename Backend>
S hold() {
  World<S, Backend> world({.gravity = {0, 0, S(-9.81)}, .time_step = S(1e-3)});
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<S>{}});
  const BodyId box = world.add_body({.mass = S(0.5),
                                     .shape = Box<S>{.half_extents = {S(0.03), S(0.03), S(0.03)}},
                                     .position = {0, 0, S(0.1)}});
  const std::unordered_set<BodyId> known{box};
  const PatchId skin = world.add_patch(
      box,
      sensor_grid<S>({.center = {0, 0, S(-0.03)},
                      .side_u = {0, S(0.06), 0},
                      .side_v = {S(0.06), 0, 0},
                      .count_u = 5,
                      .count_v = 5}),
      tuned_for<S>({.friction = S(0.8), .creep = S(1e-3), .load = S(0.5) * S(9.81)}));
  for (int i = 0; i < 1000; ++i) world.step();
#if defined(HOST_WITH_ADF)
  add_adf(world, "scene.yaml");
#endif
#if defined(HOST_FAULT)
  // Fails with -Wconversion, once it is instantiated.
  const short rounded = world.reading(skin).total_normal();
  return S(rounded);
#else
  return known.count(box) == 1 ? world.reading(skin).total_normal() : S(0);
#endif
}

}  // namespace

int main() {
  bool holds = hold<double, AnalyticBackend>() > 0;
#if defined(HOST_IN_FLOAT)
  holds = hold<float, AnalyticBackend>() > 0 && holds;
#endif
#if defined(BRISTLE_WITH_FCL)
  holds = hold<double, FclBackend>() > 0 && holds;
#endif
  return holds ? 0 : 1;
}
