// A part is pinched and lifted in MuJoCo: by MuJoCo's own contacts, and by bristle's sensors.
//
// gripper.xml is an ordinary MJCF file; its two sites of type box become sensors by one line each.
// The table says how fast a light part and a heavy one creep out of the pads at steps from 1 to 17
// ms; the plot shows where they are between the pads.
//
// Usage: host_mujoco [PLOT.svg]
// SPDX-License-Identifier: BSD-3-Clause
#include "support/lifted_pinch.hpp"

#include <bristle/bristle.hpp>
#include <bristle/hosts/mujoco_host.hpp>

#include <cstdio>
#include <exception>
#include <memory>
#include <optional>
#include <stdexcept>

using namespace bristle;
using namespace figure;

namespace {

using Model = std::unique_ptr<mjModel, decltype(&mj_deleteModel)>;
using Data = std::unique_ptr<mjData, decltype(&mj_deleteData)>;

Model load(const char* file) {
  char error[500] = "";
  Model model(mj_loadXML(file, nullptr, error, sizeof(error)), mj_deleteModel);
  if (model == nullptr) throw std::runtime_error(error);
  return model;
}

class MujocoPinch {
 public:
  MujocoPinch(const LiftedPinch& pinch, bool has_sensors) : pinch_(pinch) {
    model->opt.timestep = pinch.dt;
    // The file's part weighs 45 g.
    const int part = mj_name2id(model.get(), mjOBJ_BODY, "part");
    const double scale = pinch.mass / model->body_mass[part];
    model->body_mass[part] *= scale;
    mju_scl3(model->body_inertia + 3 * part, model->body_inertia + 3 * part, scale);
    mj_setConst(model.get(), data.get());
    mj_forward(model.get(), data.get());
    if (!has_sensors) return;
    host.emplace(*model, *data);
    const GripSpec<double> spec{
        .friction = pinch.friction, .load = pinch.squeeze, .mass = pinch.mass};
    host->mirror("part");
    host->add_pad("left_pad", 6, 6, spec);
    host->add_pad("right_pad", 6, 6, spec);
    // Sensors do what contacts of pads and part did.
    for (int i = 0; i < model->ngeom; ++i) model->geom_contype[i] = model->geom_conaffinity[i] = 0;
  }

  void step(double t) {
    data->ctrl[0] = LiftedPinch::height(t);
    data->ctrl[1] = pinch_.squeeze;
    data->ctrl[2] = -pinch_.squeeze;
    if (host) {
      host->step();
    } else {
      mj_step(model.get(), data.get());
    }
  }
  [[nodiscard]] double place() const { return height_of("part") - height_of("lift"); }

 private:
  [[nodiscard]] double height_of(const char* body) const {
    return data->xpos[3 * mj_name2id(model.get(), mjOBJ_BODY, body) + 2];
  }

  LiftedPinch pinch_;
  Model model = load(BRISTLE_EXAMPLE_DIR "/gripper.xml");
  Data data{mj_makeData(model.get()), mj_deleteData};
  std::optional<MujocoHost<>> host;
};

}  // namespace

int main(int count, char** arguments) {
  try {
    const char* plot = count > 1 ? arguments[1] : "host_mujoco.svg";
    return compare_pinches<MujocoPinch>("MuJoCo", plot, 1e-9);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "host_mujoco: %s\n", error.what());
    return 2;
  }
}
