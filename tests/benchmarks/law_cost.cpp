// Cost of the sensors' law without rays and solver, and the error of its sums against plain scalars
// in double.
//
// A pad of 30 x 30 mm with n sensors slides over a ball of 50 mm that about half of its rays meet,
// 0.05 mm and 0.1 degrees a step, there and back over 16 poses; hits are made beforehand. Printed
// for each scalar and n, in nanoseconds a sensor (all sensors counted):
//
//   touch      [%] of the sensors
//   explicit   the law of an explicit patch: hits to geometry, bristles and impulses
//   automatic  the same for a patch that is found explicit: sums for Lambda, two passes
//   collect    the first part of an implicit patch: hits to contacts and bristles
//   models     the second: the 6x6 sum of the linear models
//   answer     the third: impulses at a motion, and whether sensors changed their state
//   read       readings
//   error      of the explicit wrench, and of the models', against scalars in double [1]
//
// Times are processor time of the thread, medians of 15 runs.
// Usage: benchmark_law_cost [sensors]
// SPDX-License-Identifier: BSD-3-Clause
#include "benchmarks/thread_clock.hpp"
#include "support/scalar_patch.hpp"

#include <bristle/geometry/backends/analytic_backend.hpp>
#include <bristle/math/rotation.hpp>
#include <bristle/sensors/patch_contacts.hpp>
#include <bristle/sensors/patch_explicit.hpp>
#include <bristle/sensors/patch_readings.hpp>
#include <bristle/sensors/placement.hpp>
#include <bristle/sensors/sensor_wrench.hpp>
#include <bristle/sensors/tuning.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <vector>

using namespace bristle;

using namespace bristle::detail;

namespace {

constexpr double dt = 1e-3;
constexpr BodyId ball_id{1, 0};
constexpr std::size_t poses = 16;

/// The pad over the ball, with the hits of each pose.
template <Scalar S>
class Slide {
 public:
  /// @param is_moving  True if the ball has the velocity that its poses tell of. Otherwise it rests
  ///         in each, and no sensor changes its state within a step.
  Slide(std::size_t side, Integration integration, bool is_moving) {
    PatchDef<S> def;
    def.sensors = sensor_grid<S>({.side_u = {S(0.03), 0, 0},
                                  .side_v = {0, S(-0.03), 0},
                                  .count_u = side,
                                  .count_v = side,
                                  .depth = S(0.002),
                                  .range = S(0.005)});
    def.parameters = tuned_for<S>({.load = S(20), .mass = S(2)}).parameters(def.sensors);
    def.integration = integration;
    moving.inverse_mass.setConstant(S(0.5));
    moving.inverse_inertia = Mat3<S>::Identity() * S(100);
    patch = make_patch<S>(std::move(def), BodyId{0, 0}, Vec3<S>(Vec3<S>::Zero()));
    scratch.begin(patch);
    scratch.list_all();
    for (std::size_t k = 0; k < poses; ++k) {
      // There and back, so that no pose is far from the one before.
      const double at = k < poses / 2 ? double(k) : double(poses - k);
      const S angle = S(at * 0.1 * std::numbers::pi / 180);
      Body<S>& ball = balls[k];
      ball.center_pose = {exp_rotation<S>(Vec3<S>(0, 0, angle)),
                          Vec3<S>(S(5e-5 * at), 0, S(-0.05165))};
      const S sense = k < poses / 2 ? S(1) : S(-1);
      if (is_moving) {
        ball.twist = {Vec3<S>(sense * S(0.05), 0, S(0.01)), Vec3<S>(0, 0, sense * S(1.7))};
      }
      hits[k].reset(scratch.hits.distance.size());
      AnalyticBackend::cast_rays(AnalyticBackend::make<S>(Sphere<S>{S(0.05)}), ball.center_pose,
                                 patch.geometry->rays(S(0)), 0, hits[k]);
    }
  }

  void collect() {
    // All that comes after recomputes from the hits.
    if (next < poses) std::swap(scratch.hits, hits[next]);
    next = (next + 1) % poses;
    std::swap(scratch.hits, hits[next]);
    collect_contacts(patch, scratch, pad,
                     [&](std::uint32_t) {
                       return TouchedBody<S>{&balls[next], ball_id};
                     },
                     {.dt = S(dt),
                      .measures_lambda = patch.def.integration == Integration::automatic,
                      .only_tag = 0});
  }
  void measure() { measure_pair(patch, pair(), fixed, moving, S(dt)); }
  Wrench<S> explicit_sum() { return explicit_impulses(patch, scratch, pair(), ball_id, S(dt)); }
  void read() {
    fill_readings<S>(patch, scratch, Vec3<S>(Vec3<S>::Zero()), S(dt),
                     [](std::uint32_t) { return ball_id; });
  }
  void model() {
    start_linearisation(patch, scratch, pair(), S(dt));
    fill_block(pair(), block);
  }
  PairResponse<S> answer(const Vec6<S>& motion) {
    return evaluate(patch, scratch, pair(), motion, S(dt), SolvePass{.left = 2});
  }
  PatchPair<S>& pair() { return scratch.pairs[0]; }

  SensorPatch<S> patch;
  PatchScratch<S> scratch;
  Body<S> pad;
  std::array<Body<S>, poses> balls;
  std::array<RayHits<S>, poses> hits;
  std::size_t next = poses;
  SolverBody<S> fixed, moving;
  SoftBlock<S> block;
};

/// The same in scalars of double: forces and bristles of each sensor by `sensor_wrench`.
class ScalarSlide {
 public:
  ScalarSlide(std::size_t side, bool is_moving)
      : slide_(side, Integration::automatic, is_moving), memory_(slide_.patch.size()) {}

  /// The impulse on the ball about the pad's centre at the next pose.
  Wrench<double> explicit_sum() {
    slide_.collect();
    const std::size_t k = slide_.next;
    const SensorPatch<double>& patch = slide_.patch;
    const Body<double>& ball = slide_.balls[k];
    Wrench<double> sum;
    for (std::size_t i = 0; i < patch.size(); ++i) {
      sum += -sensor_wrench<double>(
          patch.def.parameters, patch.def.options,
          {patch.geometry->start[i], patch.geometry->direction[i], patch.geometry->length[i]},
          slide_.scratch.hits.distance[i], slide_.scratch.hits.normal[i], {}, {}, ball.center_pose,
          ball.twist, dt, memory_[i]);
    }
    return {dt * sum.force, dt * sum.torque};
  }
  /// The impulse of the linear models about c at the same pose.
  Wrench<double> block_sum(const Vec6<double>& motion) {
    slide_.measure();
    return test::scalar_block_impulse(slide_.patch, slide_.scratch, slide_.pair(), motion, dt);
  }

 private:
  Slide<double> slide_;
  std::vector<SensorMemory<double>> memory_;
};

template <Scalar S>
double difference(const Wrench<S>& a, const Wrench<double>& b) {
  const Vec3<double> force = a.force.template cast<double>() - b.force;
  return force.norm() / b.force.norm();
}

template <Scalar S>
void measure(const char* name, std::size_t side) {
  Slide<S> explicit_slide(side, Integration::explicit_, true);
  Slide<S> automatic(side, Integration::automatic, true);
  Slide<S> implicit(side, Integration::implicit, false);
  ScalarSlide scalar(side, true), resting_scalar(side, false);
  const Vec6<double> motion = (Vec6<double>() << -0.05, 1e-3, -0.01, 0.02, -0.03, -1.7).finished();
  double explicit_error = 0, model_error = 0;
  for (std::size_t k = 0; k < 2 * poses; ++k) {
    const Wrench<double> expected = scalar.explicit_sum();
    for (Slide<S>* slide : {&explicit_slide, &automatic}) {
      slide->collect();
      explicit_error = std::max(explicit_error, difference<S>(slide->explicit_sum(), expected));
    }
    implicit.collect();
    implicit.measure();
    implicit.model();
    (void)resting_scalar.explicit_sum();
    model_error = std::max(model_error, difference<S>(implicit.answer(motion.cast<S>()).impulse,
                                                      resting_scalar.block_sum(motion)));
  }
  const double n = static_cast<double>(implicit.patch.size());
  implicit.read();
  const auto cost = [n](auto&& call) { return benchmarks::median_nanoseconds(call) / n; };
  const double touch = 100 * static_cast<double>(implicit.patch.active_count()) / n;
  const double explicit_cost = cost([&] {
    explicit_slide.collect();
    (void)explicit_slide.explicit_sum();
  });
  const double automatic_cost = cost([&] {
    automatic.collect();
    automatic.measure();
    (void)automatic.explicit_sum();
  });
  const double collect = cost([&] { implicit.collect(); });
  const double models = cost([&] {
    implicit.measure();
    implicit.model();
  });
  // The first models at rest.
  implicit.model();
  const double answer = cost([&] { (void)implicit.answer(Vec6<S>::Zero()); });
  const double read = cost([&] { implicit.read(); });
  std::printf("%-6s  %5.0f  %5.1f  %8.2f  %9.2f  %7.2f  %6.2f  %6.2f  %4.2f  %8.1e  %8.1e\n", name,
              n, touch, explicit_cost, automatic_cost, collect, models, answer, read,
              explicit_error, model_error);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  std::puts(
      "scalar      n  touch  explicit  automatic  collect  models  answer  read  error of the "
      "sums");
  for (const std::size_t side : {10u, 32u, 100u}) {
    if (argc > 1 && side * side != static_cast<std::size_t>(std::atoi(argv[1]))) continue;
    measure<float>("float", side);
    measure<double>("double", side);
  }
}
