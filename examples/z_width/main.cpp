// Z-width of a haptic loop: how stiff and how damped a wall a hand's device can feel before it
// buzzes, with and without the passivity observer.
//
// The loop feels a wall where the tool will be at the end of a period, if it moves on as in the
// last one. To the device that is a damper of K h beside the wall's own, and the stiffest wall is
// many times that of a loop which takes the present place.
//
// The device is a mass with a damper of its own that holds its motor's force over a millisecond and
// tells its place once in that time. A hand leans on the wall with 2 N and does nothing against
// vibration. For each damping of the wall the stiffest one is searched at which a knock of 10 mm/s
// dies out. A linear analysis of the sampled loop says where that is: the largest eigenvalue of a
// period has the absolute value 1.
//
// Prints a table and writes z_width.svg. Usage: z_width [PLOT.svg]
// SPDX-License-Identifier: BSD-3-Clause
#include "support/svg_plot.hpp"

#include <bristle/bristle.hpp>

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

using namespace bristle;

namespace {

/// [kg], [N s/m] The device, as a light desktop one; [N] the hand; [s] the period of the loop.
constexpr double device_mass = 0.1;
constexpr double device_damping = 0.5;
constexpr double press = 2;
constexpr double period = 1e-3;
/// [m] Length of the ray that feels the wall.
constexpr double ray = 0.02;

struct Wall {
  /// [N/m], [N s/m]
  double stiffness = 0;
  double damping = 0;
};

/// Place and velocity of the device after a period under a constant force [N].
struct Device {
  double x = 0;
  double v = 0;

  void advance(double force) {
    const double decay = std::exp(-device_damping * period / device_mass);
    const double limit = force / device_damping;
    const double way = (1 - decay) * device_mass / device_damping;
    x += limit * period + (v - limit) * way;
    v = limit + (v - limit) * decay;
  }
};

/// Returns whether a knock dies out: the way of the last of three seconds is below a tenth of that
/// of the first tenth of a second.
bool dies_out(const Wall& wall, bool has_observer) {
  World<double> world({.gravity = {0, 0, 0}, .time_step = period});
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
  const BodyId tip = world.add_body({.motion = Motion::kinematic, .position = {0, 0, 0.1}});
  PatchDef<double> pad;
  pad.sensors.add({0, 0, 0}, {0, 0, -ray});
  pad.parameters.normal_stiffness = wall.stiffness * ray;
  pad.parameters.normal_damping = wall.damping * ray;
  HapticLoop<double> loop({.substeps = 1});
  const ToolId tool = loop.add_tool(tip);
  loop.add_patch(tool, pad);
  world.open(loop);

  // Along the outward normal of the wall. The tip feels the wall by a ray's length ahead of it.
  Device device{ray - press / wall.stiffness, 0.01};
  double last = device.x, early = 0, low = device.x, high = device.x;
  PassivityObserver<double> observer(0.5 * wall.stiffness * std::pow(ray - device.x, 2));
  const int count = 3000;
  for (int i = 0; i < count; ++i) {
    loop.move(tool, {Quat<double>::Identity(), {0, 0, device.x}});
    loop.substep();
    Wrench<double> wrench = loop.wrench(tool);
    const Twist<double> moved{{0, 0, (device.x - last) / period}, Vec3<double>::Zero()};
    last = device.x;
    if (has_observer) wrench = observer.control(wrench, moved, period);
    device.advance(wrench.force.z() - press);
    world.step(loop);
    if (i == count / 30) early = high - low;
    if (i == 2 * count / 3) low = high = device.x;
    low = std::min(low, device.x);
    high = std::max(high, device.x);
  }
  return high - low < 0.1 * early;
}

/// Returns whether the sampled loop of a mass, a held force and a wall is stable.
/// @param ahead  [-] Periods ahead for which the place is foretold by the last period's velocity.
bool is_stable(const Wall& wall, double ahead) {
  // State: place, velocity, place a period ago. The force acts over the period after it was found.
  Device place{1, 0}, speed{0, 1}, forced{0, 0};
  place.advance(0);
  speed.advance(0);
  forced.advance(1);
  const double before = ahead * wall.stiffness + wall.damping / period;
  const double now = -wall.stiffness - before;
  Eigen::Matrix3d next;
  next << place.x + forced.x * now, speed.x, forced.x * before,  //
      place.v + forced.v * now, speed.v, forced.v * before,      //
      1, 0, 0;
  return next.eigenvalues().cwiseAbs().maxCoeff() < 1;
}

/// [N/m] The stiffest wall of a damping for which a test holds, to a thousandth; 0 if none.
template <typename Test>
double stiffest(double damping, Test&& holds) {
  double low = 200, high = 1e5;
  if (!holds(Wall{low, damping})) return 0;
  while (high > 1.001 * low) {
    const double middle = std::sqrt(low * high);
    (holds(Wall{middle, damping}) ? low : high) = middle;
  }
  return low;
}

int run(const std::string& path) {
  std::vector<figure::PlotSeries> curves{{"loop", {}, {}, true},
                                         {"loop and observer", {}, {}, true},
                                         {"loop, linear analysis", {}, {}},
                                         {"present place, linear analysis", {}, {}}};
  std::puts("             stiffest wall [N/m]");
  std::puts("damping       loop   and observer   linear analysis   of the present place");
  double error = 0;
  for (const double damping : {0.0, 1.0, 2.0, 5.0, 10.0, 15.0, 20.0, 30.0, 40.0, 50.0}) {
    const double found[] = {stiffest(damping, [](const Wall& w) { return dies_out(w, false); }),
                            stiffest(damping, [](const Wall& w) { return dies_out(w, true); }),
                            stiffest(damping, [](const Wall& w) { return is_stable(w, 1); }),
                            stiffest(damping, [](const Wall& w) { return is_stable(w, 0); })};
    for (std::size_t i = 0; i < curves.size(); ++i) {
      curves[i].x.push_back(damping);
      curves[i].y.push_back(found[i]);
    }
    std::printf("%2.0f N s/m  %8.0f  %13.0f  %16.0f  %21.0f\n", damping, found[0], found[1],
                found[2], found[3]);
    error = std::max(error, std::abs(found[0] / found[2] - 1));
  }
  figure::SvgPlot plot{.title = "Stiffest wall that a device of 0.1 kg can feel at 1 kHz",
                       .x_label = "damping of the wall [N s/m]"};
  plot.panels.push_back({.y_label = "stiffness [N/m]", .series = curves, .is_logarithmic = true});
  plot.write_svg(path);
  std::printf("the loop is within %.0f %% of its linear analysis\n", 100 * error);
  return error < 0.05 ? 0 : 1;
}

}  // namespace

int main(int count, char** arguments) {
  try {
    return run(count > 1 ? arguments[1] : "z_width.svg");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "z_width: %s\n", error.what());
    return 2;
  }
}
