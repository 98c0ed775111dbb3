// How many sensors a core feeds in a millisecond, how wrong they are, and what others need for the
// same rays.
//
//   sensors   the pad of pad_workload.hpp, from the pose of the object to the impulse on it
//             (transform, rays, law): nanoseconds a sensor and thousands of sensors a
//             millisecond, in float / double, explicit and implicit (one linear model a sensor and
//             its evaluation). `wrong`: rays, in ppm, that hit where there is nothing, miss, or are
//             off by more than 2 um (float) or 2 pm (double); `force error`: of the sum, against
//             one ray and one sensor after the other in double, worse of explicit and implicit [1]
//   peers     the same rays asked of Bullet (a world's rayTest) and Embree (one by one, and in
//             coherent packets of sixteen), where they are installed: nanoseconds a ray; `times` is
//             how often that is what a ray costs here, in float on the analytic backend
//   worlds    steps of worlds: patches that feel nothing, and 10,000 sensors that hold a ball
//   threads   two threads against one, by the wall clock; `within tasks` is the part of the step
//             that is shared, and `at best` what two undisturbed cores would make of that
//   bars      what was wanted, and what was found
//
// Times are processor time of the thread if not said otherwise, medians of seven runs and more.
// Usage: benchmark_sensor_rate [--markdown] [--csv FILE] [--only sensors|peers|worlds|threads]
//                              [--rows]
// With --rows the sensors of pads follow each other row by row, and not in the order of
// neighbour_order.hpp.
// SPDX-License-Identifier: BSD-3-Clause
#include "benchmarks/benchmark_table.hpp"
#include "benchmarks/pad_sensing.hpp"
#include "benchmarks/sensor_report.hpp"
#include "benchmarks/sensor_scenes.hpp"
#include "benchmarks/thread_clock.hpp"

#include <bristle/bristle.hpp>
#include <bristle/core/thread_pool.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdio>
#include <functional>
#include <string>
#include <variant>
#include <vector>

#if defined(BRISTLE_WITH_BULLET)
#include "benchmarks/bullet_rays.hpp"
#endif
#if defined(BRISTLE_WITH_EMBREE)
#include "benchmarks/embree_rays.hpp"
#endif

using namespace bristle;

using namespace bristle::detail;
using namespace bristle::benchmarks;

namespace {

template <Scalar S>
constexpr const char* scalar_name = std::is_same_v<S, float> ? "float" : "double";

/// [-] Steps over which n sensors are measured.
int steps_for(std::size_t n) { return n < 500 ? 400 : n < 5000 ? 200 : n < 50000 ? 60 : 12; }

/// One pad over one object, with what it should find.
struct Workload {
  Workload(const Object& of, const Reference& reference, std::size_t n, bool in_rows)
      : object(of),
        name(of.name + ' ' + std::to_string(n)),
        layout(pad_rays(n, in_rows)),
        gap(gap_for_half(of, reference, layout)),
        expected(of, reference, layout, gap) {}

  template <typename Distances>
  [[nodiscard]] std::size_t wrong_answers(int step, const Distances& distance) const {
    const std::vector<double>& right = expected.distances[static_cast<std::size_t>(step)];
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < layout.size(); ++i) {
      wrong += is_right(distance[i], right[i], layout.length[i]) ? 0u : 1u;
    }
    return wrong;
  }

  Object object;
  std::string name;
  SensorLayout<double> layout;
  double gap;
  PadReference expected;
  /// [ns] Of a ray in float on the analytic backend, where peers are compared with it.
  double ray_cost = 0;
};

/// Costs of a sensor [ns].
struct SensorCost {
  double ray = 0;
  double by_force = 0;
  double by_model = 0;
  /// Linear models, their sum and their impulses alone.
  double block = 0;
  /// [1] Wrong rays, and the larger error of the two forces.
  double wrong = 0;
  double error = 0;
};

template <Scalar S, typename Backend>
SensorCost cost_of(const Workload& work) {
  const auto shape = Backend::template make<S>(shape_as<S>(work.object.shape));
  const int steps = steps_for(work.layout.size());
  std::vector<Body<S>> bodies;
  for (int k = 0; k < steps; ++k) bodies.push_back(object_body<S>(work.object, k, work.gap));
  PadPatch<S> by_force(work.layout, Integration::explicit_);
  PadPatch<S> by_model(work.layout, Integration::implicit);
  const auto cast = [&](PadPatch<S>& pad, std::size_t k) {
    pad.scratch.reset_near_hits();  // As a world does, and all packets are near.
    Backend::cast_rays(shape, bodies[k].center_pose, pad.rays(bodies[k]), 0, pad.scratch.hits);
  };
  const auto sense = [&](PadPatch<S>& pad, std::size_t k) {
    cast(pad, k);
    pad.meet(bodies[k]);
    return pad.respond();
  };

  SensorCost cost;
  std::size_t wrong = 0;
  for (int step = 0; step < PadReference::steps; ++step) {
    const auto k = static_cast<std::size_t>(step);
    const Vec3<double> by_force_found = sense(by_force, k).force.template cast<double>();
    const Vec3<double> by_model_found = sense(by_model, k).force.template cast<double>();
    const auto error = [&](const Vec3<double>& found, const Vec3<double>& expected) {
      cost.error = std::max(cost.error, (found - expected).norm() / expected.norm());
    };
    error(by_force_found, work.expected.explicit_impulse[k]);
    error(by_model_found, work.expected.implicit_impulse[k]);
    wrong += work.wrong_answers(step, by_force.scratch.hits.distance);
  }
  const double n = double(work.layout.size());
  cost.wrong = double(wrong) / n / PadReference::steps;
  const auto per_sensor = [&](auto&& step) {
    return median_step_nanoseconds(steps, nullptr,
                                   [&](int k) { step(static_cast<std::size_t>(k)); }) /
           n;
  };
  cost.ray = per_sensor([&](std::size_t k) { cast(by_force, k); });
  cost.by_force = per_sensor([&](std::size_t k) { (void)sense(by_force, k); });
  cost.by_model = per_sensor([&](std::size_t k) { (void)sense(by_model, k); });
  cost.block = per_sensor([&](std::size_t) { (void)by_model.respond(); });
  return cost;
}

template <Scalar S, typename Backend>
SensorCost known_cost_of(Report& report, const Workload& work, const char* backend) {
  const SensorCost cost = cost_of<S, Backend>(work);
  const std::string name = work.name + ' ' + backend + ' ' + scalar_name<S> + ' ';
  report.figures[name + "ray"] = cost.ray;
  report.figures[name + "explicit"] = cost.by_force;
  report.figures[name + "implicit"] = cost.by_model;
  report.figures[name + "wrong"] = cost.wrong;
  report.figures[name + "error"] = cost.error;
  report.figures[name + "block"] = cost.block;
  return cost;
}

template <typename Backend>
void add_sensors(Report& report, Table& table, const char* backend, const Workload& work) {
  const SensorCost in_float = known_cost_of<float, Backend>(report, work, backend);
  const SensorCost in_double = known_cost_of<double, Backend>(report, work, backend);
  const auto both = [&](double SensorCost::*figure, double factor = 1) {
    return in_short(factor * in_float.*figure) + " / " + in_short(factor * in_double.*figure);
  };
  const auto rates = [&](double SensorCost::*figure) {
    return in_short(1e3 / in_float.*figure) + " / " + in_short(1e3 / in_double.*figure);
  };
  table.add({work.object.name, std::to_string(work.layout.size()), backend, both(&SensorCost::ray),
             both(&SensorCost::by_force), both(&SensorCost::by_model), rates(&SensorCost::by_force),
             rates(&SensorCost::by_model), both(&SensorCost::wrong, 1e6),
             both(&SensorCost::error)});
}

void measure_sensors(Report& report) {
  Table table(report.options.is_markdown,
              {"shape", "sensors", "backend", "     ray [ns]", "explicit [ns]", "implicit [ns]",
               "explicit [1000/ms]", "implicit [1000/ms]", "wrong [ppm]", "  force error"});
  for (const Object& object : pad_objects()) {
    const Reference reference(object.shape);
    for (const std::size_t n : {100u, 1000u, 10000u, 100000u}) {
      // Two shapes suffice to show how the cost grows with the number.
      if (n == 100000 && object.name != "mesh10k" && object.name != "sphere") continue;
      const Workload work(object, reference, n, report.options.in_rows);
      add_sensors<AnalyticBackend>(report, table, "analytic", work);
#if defined(BRISTLE_WITH_FCL)
      add_sensors<FclBackend>(report, table, "fcl", work);
#endif
    }
  }
}

/// A peer's answers [ppm wrong] and cost [ns a ray] against a ray of ours.
void add_peer(Report& report, Table& table, const char* peer, const Workload& work, double cost,
              std::size_t wrong, int checked) {
  const double n = double(work.layout.size());
  const double ratio = cost / work.ray_cost;
  table.add({work.object.name, std::to_string(work.layout.size()), peer, in_short(cost),
             in_short(work.ray_cost), in_short(ratio),
             in_short(1e6 * double(wrong) / n / checked)});
  report.figures[work.name + ' ' + peer] = ratio;
  report.figures[work.name + ' ' + peer + " [ns]"] = cost;
}

#if defined(BRISTLE_WITH_BULLET)
void measure_bullet(Report& report, Table& table, const Workload& work) {
  const PadPatch<float> pad(work.layout, Integration::explicit_);
  BulletBody body(shape_as<float>(work.object.shape));
  RayHits<float> hits;
  const auto cast = [&](int k) {
    hits.reset(pad.patch.size());
    body.cast_rays(work.object.pose(k, work.gap).cast<float>(), pad.patch.geometry->rays(0), 0,
                   hits);
  };
  std::size_t wrong = 0;
  for (int k = 0; k < PadReference::steps; ++k) {
    cast(k);
    wrong += work.wrong_answers(k, hits.distance);
  }
  const double cost = median_step_nanoseconds(6, nullptr, cast) / double(work.layout.size());
  add_peer(report, table, "Bullet rayTest", work, cost, wrong, PadReference::steps);
}
#endif

#if defined(BRISTLE_WITH_EMBREE)
void measure_embree(Report& report, Table& table, const Workload& work) {
  const auto* mesh = std::get_if<TriangleMesh<double>>(&work.object.shape);
  if (mesh == nullptr) return;
  EmbreeMesh embree(*mesh);
  // In the order of the nodes, in which neighbours follow each other.
  const RayTree<double> order(
      PadPatch<double>(work.layout, Integration::explicit_).patch.geometry->ray_tree);
  const auto prepare = [&](int k) {
    const Transform<double> X_CR = work.object.pose(k, work.gap).inverse();
    embree.clear();
    for (std::size_t place = 0; place < order.size(); ++place) {
      const std::size_t i = order.ray_at(place);
      embree.add({(X_CR * work.layout.start[i]).cast<float>(),
                  X_CR.rotate(work.layout.direction[i]).cast<float>(),
                  static_cast<float>(work.layout.length[i])});
    }
  };
  const auto measure = [&](const char* peer, const auto& cast) {
    std::size_t wrong = 0;
    std::vector<float> distance(order.size());
    for (int k = 0; k < PadReference::steps; ++k) {
      prepare(k);
      cast(k);
      for (std::size_t place = 0; place < order.size(); ++place) {
        distance[order.ray_at(place)] = embree.distance[place];
      }
      wrong += work.wrong_answers(k, distance);
    }
    const double cost = median_step_nanoseconds(30, prepare, cast) / double(order.size());
    add_peer(report, table, peer, work, cost, wrong, PadReference::steps);
  };
  measure("Embree single", [&](int) { embree.cast_single(); });
  measure("Embree coherent", [&](int) { embree.cast_coherent(); });
}
#endif

void measure_peers(Report& report) {
  Table table(report.options.is_markdown,
              {"shape", "rays", "peer", "peer [ns]", "here [ns]", "times", "peer wrong [ppm]"});
  for (const Object& object : pad_objects()) {
    const Reference reference(object.shape);
    for (const std::size_t n : {1000u, 10000u}) {
      Workload work(object, reference, n, report.options.in_rows);
      work.ray_cost = cost_of<float, AnalyticBackend>(work).ray;
#if defined(BRISTLE_WITH_BULLET)
      measure_bullet(report, table, work);
#endif
#if defined(BRISTLE_WITH_EMBREE)
      measure_embree(report, table, work);
#endif
    }
  }
}

/// [ns] A step of a world.
template <typename W>
double step_cost(W world) {
  return median_nanoseconds([&] { world.step(); });
}

template <Scalar S>
void measure_worlds_of(Report& report, Table& table) {
  const auto add = [&](const char* what, const std::string& sensors, double ns,
                       const std::string& remark) {
    table.add({what, sensors, scalar_name<S>, in_short(ns / 1000), remark});
    report.figures[std::string(what) + ' ' + sensors + ' ' + scalar_name<S>] = ns / 1000;
  };
  const Object mesh = pad_objects("mesh10k").front();
  for (const double gap : {0.7e-3, 4e-3}) {
    const double alone = step_cost(make_near_miss<S>(mesh, 0, report.options.in_rows, gap));
    for (const std::size_t n : {100u, 1000u, 10000u}) {
      World<S> world = make_near_miss<S>(mesh, n, report.options.in_rows, gap);
      const double cost = step_cost(world) - alone;
      world.step();
      add(gap < 1e-3 ? "out of reach by 0.7 mm" : "out of reach by 4 mm", std::to_string(n), cost,
          world.report().patches_near == 1 && world.report().sensors_touching == 0
              ? ""
              : "not what it should be");
    }
  }
  const double far = step_cost(make_far<S>(true)) - step_cost(make_far<S>(false));
  add("nothing near, each of 1000", "100", far / 1000, "");
  const double beside_sleeping = step_cost(make_sleeping<S>(true, true));
  const double beside_none = step_cost(make_sleeping<S>(false, true));
  add("asleep beside what moves", "10000", beside_sleeping - beside_none, "");
  add("all asleep", "10000", step_cost(make_sleeping<S>(true, false)), "the whole step");

  HeldBall<S> held(10000, report.options.in_rows, serial_for);
  const double cost = median_nanoseconds([&] { held.world.step(); });
  const auto sensors = held.world.report().rays_cast;
  add("a ball is held, whole step", std::to_string(sensors), cost,
      in_short(100 * double(held.world.report().sensors_touching) / double(sensors)) +
          " % touch, force error " + in_short(held.error()));
}

void measure_worlds(Report& report) {
  Table table(report.options.is_markdown, {"patch", "sensors", "scalar", "cost [us]", "remark"});
  measure_worlds_of<float>(report, table);
  measure_worlds_of<double>(report, table);
}

/// [s] By the wall clock.
double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Compares steps of the scenes that `make(hook)` builds.
template <typename Make>
void add_threads(Report& report, Table& table, const std::string& name, const Make& make) {
  ThreadPool pool(2);
  auto alone = make(ParallelFor(serial_for));
  auto shared = make(pool.hook());
  double within = 0;
  auto divided = make(ParallelFor([&](std::size_t count, const auto& task) {
    const double start = wall_seconds();
    serial_for(count, task);
    within += wall_seconds() - start;
  }));
  constexpr int steps = 20;
  const auto seconds = [&](auto& scene) {
    // A thread that slept while others had their turn is awake, and caches are filled.
    for (int i = 0; i < steps / 2; ++i) scene.world.step();
    within = 0;
    const double start = wall_seconds();
    for (int i = 0; i < steps; ++i) scene.world.step();
    return (wall_seconds() - start) / steps;
  };
  // In turn, so that what else the machine does falls on all; and for seconds, since what a host
  // does to its guests lasts for tenths of them.
  constexpr std::size_t rounds = 151;
  std::array<double, rounds> one{}, two{}, cut{}, part{};
  for (std::size_t i = 0; i < rounds; ++i) {
    one[i] = seconds(alone);
    two[i] = seconds(shared);
    cut[i] = seconds(divided);
    part[i] = within / steps;
  }
  const auto median = [](std::array<double, rounds>& values) {
    std::nth_element(values.begin(), values.begin() + rounds / 2, values.end());
    return values[rounds / 2];
  };
  const double best = median(cut) - median(part) / 2;
  const double ratio = median(one) / median(two);
  table.add({name, in_short(1e6 * median(one)), in_short(1e6 * median(two)), in_short(ratio),
             in_short(100 * median(part) / median(cut)), in_short(median(one) / best),
             alone.world.state_hash() == shared.world.state_hash() ? "same bits" : "OTHER BITS"});
  report.figures["two threads, " + name] = ratio;
  report.figures["within tasks, " + name] = median(part) / median(cut);
}

template <Scalar S>
void measure_threads_of(Report& report, Table& table) {
  const Object mesh = pad_objects("mesh10k").front();
  const Reference reference(mesh.shape);
  const double gap = gap_for_half(mesh, reference, pad_rays(10000, report.options.in_rows));
  for (const Integration integration : {Integration::explicit_, Integration::implicit}) {
    const std::string how = integration == Integration::implicit ? "implicit, " : "explicit, ";
    add_threads(report, table, "one pad, " + how + scalar_name<S>, [&](const ParallelFor& hook) {
      return TurningBall<S>(mesh, 10000, report.options.in_rows, gap, integration, hook);
    });
  }
  add_threads(
      report, table, std::string("a ball is held, ") + scalar_name<S>,
      [&](const ParallelFor& hook) { return HeldBall<S>(10000, report.options.in_rows, hook); });
}

void measure_threads(Report& report) {
  Table table(report.options.is_markdown, {"10,000 sensors on mesh10k", "one [us]", "two [us]",
                                           "times", "within tasks [%]", "at best", "results"});
  measure_threads_of<float>(report, table);
  measure_threads_of<double>(report, table);
}

}  // namespace

int main(int argc, char** argv) {
  Report report;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    if (option == "--markdown") {
      report.options.is_markdown = true;
    } else if (option == "--rows") {
      report.options.in_rows = true;
    } else if (option == "--csv" && i + 1 < argc) {
      report.options.csv = argv[++i];
    } else if (option == "--only" && i + 1 < argc) {
      report.options.only = argv[++i];
    } else {
      std::fprintf(stderr, "unknown option '%s'; see the top of sensor_rate.cpp\n", argv[i]);
      return 2;
    }
  }
  if (report.options.is_chosen("sensors")) measure_sensors(report);
  if (report.options.is_chosen("peers")) measure_peers(report);
  if (report.options.is_chosen("worlds")) measure_worlds(report);
  if (report.options.is_chosen("threads")) measure_threads(report);
  Bars(report).print();
  if (!report.options.csv.empty()) write_file(report.options.csv, report.csv());
}
