// A part is pinched and lifted in MuJoCo: by MuJoCo's own contacts, and by bristle's sensors.
//
// gripper.xml is an ordinary MJCF file; its two sites of type box become sensors by one line each.
// 45 g are squeezed with 12 N at mu = 0.7, 38 times what would do, lifted by 0.1 m and held for
// five seconds. The table says how fast the part creeps out of the pads meanwhile, at steps from 1
// to 17 ms; the plot shows where it is between the pads.
//
// Usage: host_mujoco [PLOT.svg]
// SPDX-License-Identifier: BSD-3-Clause
#include "support/svg_plot.hpp"

#include <bristle/bristle.hpp>
#include <bristle/hosts/mujoco_host.hpp>

#include <cmath>
#include <cstdio>
#include <exception>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

using namespace bristle;
using namespace figure;

namespace {

constexpr double squeeze = 12;

/// Result of a run: the part's height in the pads over time, and its creep rate [m/s] in the end.
struct Run {
  PlotSeries height;
  double creep = 0;
  bool is_lost = false;
};

using Model = std::unique_ptr<mjModel, decltype(&mj_deleteModel)>;
using Data = std::unique_ptr<mjData, decltype(&mj_deleteData)>;

Run run(bool has_sensors, double dt, const std::string& name) {
  char error[500] = "";
  const Model model(mj_loadXML(BRISTLE_EXAMPLE_DIR "/gripper.xml", nullptr, error, sizeof(error)),
                    mj_deleteModel);
  if (model == nullptr) throw std::runtime_error(error);
  model->opt.timestep = dt;
  const Data data(mj_makeData(model.get()), mj_deleteData);
  mj_forward(model.get(), data.get());
  std::optional<MujocoHost<>> host;
  if (has_sensors) {
    host.emplace(*model, *data);
    const GripSpec<double> spec{.friction = 0.7, .load = squeeze, .mass = 0.045};
    host->mirror("part");
    host->add_pad("left_pad", 6, 6, spec);
    host->add_pad("right_pad", 6, 6, spec);
    // Sensors do what contacts of pads and part did.
    for (int i = 0; i < model->ngeom; ++i) model->geom_contype[i] = model->geom_conaffinity[i] = 0;
  }
  const int part = mj_name2id(model.get(), mjOBJ_BODY, "part");
  const int lift = mj_name2id(model.get(), mjOBJ_BODY, "lift");
  Run result{.height = {.name = name, .x = {}, .y = {}}};
  double start = 0;
  for (int i = 0; i * dt < 9; ++i) {
    const double t = i * dt;
    data->ctrl[0] = 0.1 * std::fmin(1.0, std::fmax(0.0, t - 1));
    data->ctrl[1] = squeeze;
    data->ctrl[2] = -squeeze;
    if (host) {
      host->step();
    } else {
      mj_step(model.get(), data.get());
    }
    const double height = data->xpos[3 * part + 2] - data->xpos[3 * lift + 2];
    if (t < 4) start = height;
    if (std::lround(t / dt) % std::lround(0.02 / std::fmin(dt, 0.02)) == 0) {
      result.height.x.push_back(t);
      result.height.y.push_back(1e3 * height);
    }
    if (!(std::abs(height) < 0.02)) {
      result.is_lost = true;
      return result;
    }
    result.creep = (start - height) / 5;
  }
  return result;
}

void print(const Run& result) {
  if (result.is_lost) {
    std::printf("  %14s", "dropped");
  } else {
    std::printf("  %14.4f", 1e6 * result.creep);
  }
}

int run_all(const std::string& file) {
  std::printf("step [ms]   creep by contacts   creep by sensors [um/s]\n");
  SvgPlot plot{.title = "45 g between two pads in MuJoCo, lifted and held", .x_label = "time [s]"};
  PlotPanel panel{.y_label = "part in the pads [mm]", .series = {}};
  bool all_held = true;
  for (const double dt : {0.001, 0.002, 1.0 / 240, 1.0 / 120, 1.0 / 60}) {
    char step[32];
    std::snprintf(step, sizeof step, "%.1f ms", 1e3 * dt);
    const Run contacts = run(false, dt, std::string("contacts, ") + step);
    const Run sensors = run(true, dt, std::string("sensors, ") + step);
    std::printf("%9.1f  ", 1e3 * dt);
    print(contacts);
    std::printf("    ");
    print(sensors);
    std::printf("\n");
    all_held = all_held && !sensors.is_lost && std::abs(sensors.creep) < 1e-9;
    if (dt == 0.002) panel.series = {contacts.height, sensors.height};
  }
  plot.panels.push_back(panel);
  plot.write_svg(file);
  std::printf("wrote %s\n", file.c_str());
  return all_held ? 0 : 1;
}

}  // namespace

int main(int count, char** arguments) {
  try {
    return run_all(count > 1 ? arguments[1] : "host_mujoco.svg");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "host_mujoco: %s\n", error.what());
    return 2;
  }
}
