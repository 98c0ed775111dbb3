// What fixed and kinematic bodies crush between them: the fastest body, the largest gain of energy
// in a step and the largest impulse at a point, over several starts that differ by micrometres.
//
//     benchmark_crushing [starts] [--markdown]
// SPDX-License-Identifier: BSD-3-Clause
#include "benchmarks/benchmark_table.hpp"
#include "scenes/crushed.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <string>

using namespace bristle;

namespace {

struct Named {
  const char* name;
  std::function<scenes::Crushed(double dt, double aside)> make;
  double seconds;
  double height;  // [m] From which what is squeezed out may fall.
  double speed;   // [m/s] Of the movers.
};

Named towers(const char* name, const scenes::CrushedTowers& of) {
  return {name, [of](double dt, double aside) { return of.make(dt, aside); }, of.time_of(0.8),
          of.height(), of.speed};
}

}  // namespace

int main(int argc, char** argv) {
  int starts = 8;
  bool is_markdown = false;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--markdown") {
      is_markdown = true;
    } else {
      starts = std::atoi(argv[i]);
    }
  }
  const Shape<double> ball = Sphere<double>{0.1};
  const Named scenes_of[] = {
      towers("125 cubes", {.side = 5, .layers = 5}),
      towers("125 cubes, friction 0.8", {.side = 5, .layers = 5, .friction = 0.8}),
      towers("125 cubes, plate at 0.5 m/s", {.side = 5, .layers = 5, .speed = 0.5}),
      towers("125 balls", {.side = 5, .layers = 5, .shape = ball}),
      towers("27 cubes", {.side = 3, .layers = 3}),
      towers("three balls over each other", {.layers = 3, .shape = ball}),
      towers("one cube", {}),
      {"doors close on 40 bodies", scenes::make_closing_doors, 2, 0.9, 0.5},
      {"lift under a roof", scenes::make_rising_lift, 2, 1.1, 0.2},
      {"paddle turns into balls", scenes::make_turning_paddle, 2, 0.2, 0.6}};
  benchmarks::Table table(is_markdown,
                          {"                      scene", "step [s]", "starts", "fastest [m/s]",
                           "thrown out", "gain [J]", "impulse [N s]"});
  for (const Named& scene : scenes_of) {
    for (const double rate : {60.0, 240.0}) {
      double fastest = 0;
      double gain = 0;
      double impulse = 0;
      int thrown = 0;
      for (int start = 0; start < starts; ++start) {
        scenes::Crushed run = scene.make(1 / rate, 2.4e-6 * start * start);
        run.run(scene.seconds);
        fastest = std::max(fastest, run.fastest);
        gain = std::max(gain, run.largest_gain);
        impulse = std::max(impulse, run.largest_impulse);
        // Faster than a fall, and a slide by levers of three.
        if (run.fastest > std::sqrt(2 * 9.81 * scene.height) + 3 * scene.speed) ++thrown;
      }
      table.add({scene.name, "1/" + benchmarks::in_full(rate), std::to_string(starts),
                 benchmarks::in_full(fastest), std::to_string(thrown), benchmarks::in_full(gain),
                 benchmarks::in_full(impulse)});
    }
  }
}
