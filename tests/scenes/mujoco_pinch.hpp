/// @file
/// The pinch in MuJoCo.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/hosts/mujoco_host.hpp>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <scenes/pinch.hpp>
#include <stdexcept>
#include <string>

namespace bristle::scenes {

inline std::string mujoco_text(double x) { return std::to_string(x); }

/// Two pads on slides and a part between them.
[[nodiscard]] inline std::string mujoco_pinch_xml(const PinchDef& def) {
  // On a tilted arm nothing but springs keeps pads and part between the ends of the slides.
  const char* spring = def.has_arm ? " stiffness=\"1000\" damping=\"20\"" : "";
  const std::string contact = def.has_contacts
                                  ? " friction=\"" + mujoco_text(def.friction) + " 0.005 0.0001\""
                                  : " contype=\"0\" conaffinity=\"0\"";
  const auto pad = [&](const char* name, double side) {
    return "<body name=\"" + std::string(name) + "\" pos=\"" + mujoco_text(side * 0.0101) +
           " 0 0\"><joint name=\"" + name + "\" type=\"slide\" axis=\"1 0 0\"" + spring +
           "/><geom type=\"box\" size=\"0.005 0.01 0.01\" mass=\"0.1\"" + contact +
           "/><site name=\"" + name + "_pad\" type=\"box\" size=\"0.009 0.009 0.004\" pos=\"" +
           mujoco_text(-side * 0.006) + " 0 0\" zaxis=\"" + mujoco_text(-side) + " 0 0\"/></body>";
  };
  std::string pads = pad("left", -1) + pad("right", 1);
  if (def.has_arm) {
    // From the shoulder up, over and down to the pads.
    const char* axes[7] = {"0 0 1", "0 1 0", "1 0 0", "0 1 0", "1 0 0", "0 1 0", "0 0 1"};
    const char* places[7] = {"-0.5 0 -0.3", "0 0 0.1", "0 0 0.2",    "0 0 0.1",
                             "0.2 0 0",     "0.2 0 0", "0.1 0 -0.05"};
    std::string open, close;
    for (int i = 0; i < 7; ++i) {
      open += "<body pos=\"" + std::string(places[i]) + "\"><joint name=\"arm" + std::to_string(i) +
              "\" axis=\"" + axes[i] +
              "\" stiffness=\"2000\" damping=\"20\" armature=\"0.01\"/><geom type=\"sphere\" "
              "size=\"0.04\" mass=\"1\" contype=\"0\" conaffinity=\"0\"/>";
      close += "</body>";
    }
    // The wrist's frame in the world is the sum of the places.
    pads = open + "<body pos=\"0 0 -0.05\">" + pads + "</body>" + close;
  }
  const double own = def.offset > 0 ? 0.5 * def.mass : def.mass;
  const std::string beside = def.offset > 0 ? "<geom type=\"sphere\" size=\"0.005\" pos=\"0 " +
                                                  mujoco_text(2 * def.offset) + " 0\" mass=\"" +
                                                  mujoco_text(def.mass - own) +
                                                  "\" contype=\"0\" conaffinity=\"0\"/>"
                                            : "";
  return "<mujoco><option timestep=\"" + std::to_string(def.dt) +
         "\" gravity=\"0 0 0\"/><worldbody>" + pads +
         "<body name=\"part\"><freejoint/><geom type=\"box\" size=\"0.005 0.01 0.01\" mass=\"" +
         mujoco_text(own) + "\"" + contact + "/>" + beside +
         "</body></worldbody><actuator><motor joint=\"left\"/><motor joint=\"right\"/></actuator>"
         "</mujoco>";
}

using MujocoModel = std::unique_ptr<mjModel, decltype(&mj_deleteModel)>;
using MujocoData = std::unique_ptr<mjData, decltype(&mj_deleteData)>;

[[nodiscard]] inline MujocoModel mujoco_model_of(const std::string& xml) {
  auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  if (mj_makeEmptyFileVFS(files.get(), "model.xml", static_cast<int>(xml.size() + 1)) != 0) {
    throw std::runtime_error("MuJoCo has no room for a model");
  }
  std::memcpy(files->filedata[0], xml.c_str(), xml.size() + 1);
  char error[500] = "";
  MujocoModel model(mj_loadXML("model.xml", files.get(), error, sizeof(error)), mj_deleteModel);
  mj_deleteVFS(files.get());
  if (model == nullptr) throw std::runtime_error(error);
  return model;
}

class MujocoPinch : public Pinch {
 public:
  explicit MujocoPinch(const PinchDef& d)
      : Pinch(d), model(mujoco_model_of(mujoco_pinch_xml(def))) {
    model->opt.timestep = def.dt;
    data.reset(mj_makeData(model.get()));
    part_number = mj_name2id(model.get(), mjOBJ_BODY, "part");
    mj_forward(model.get(), data.get());
    host = std::make_unique<MujocoHost<>>(*model, *data);
    (void)host->mirror("part");
    patches = {add_pad("left_pad"), add_pad("right_pad")};
  }

  [[nodiscard]] World<double>& world() override { return host->world(); }
  [[nodiscard]] std::size_t missing() override { return host->sensors().report().missing_bodies; }
  [[nodiscard]] Vec3<double> part() const override {
    const mjtNum* x = data->xipos + 3 * part_number;
    return {x[0], x[1], x[2]};
  }
  [[nodiscard]] Vec3<double> pad(std::size_t k) const override {
    const mjtNum* x = data->xpos + 3 * mj_name2id(model.get(), mjOBJ_BODY, sides[k]);
    return {x[0], x[1], x[2]};
  }
  void open(double gap, double speed) override {
    for (std::size_t k = 0; k < 2; ++k) {
      const int joint = mj_name2id(model.get(), mjOBJ_JOINT, sides[k]);
      const double side = k == 0 ? 1 : -1;
      data->qpos[model->jnt_qposadr[joint]] -= side * gap;
      data->qvel[model->jnt_dofadr[joint]] = side * speed;
    }
    mj_kinematics(model.get(), data.get());
  }
  void step() override {
    data->ctrl[0] = def.squeeze;
    data->ctrl[1] = -def.squeeze;
    for (int i = 0; i < 3; ++i) model->opt.gravity[i] = gravity[i];
    host->step();
    // MuJoCo leaves places as they were at the step's start.
    mj_kinematics(model.get(), data.get());
  }

  MujocoModel model;
  MujocoData data{nullptr, mj_deleteData};
  std::unique_ptr<MujocoHost<>> host;
  int part_number = 0;

 private:
  [[nodiscard]] PatchId add_pad(const char* site) {
    const auto across = static_cast<std::uint32_t>(def.across);
    return host->add_pad(site, across, across, def.spec());
  }

  static constexpr const char* sides[2] = {"left", "right"};
};

}  // namespace bristle::scenes
