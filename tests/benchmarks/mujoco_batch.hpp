/// @file
/// The grip of batch_cost.cpp in MuJoCo, by its contacts and without taxels: two pads on slides
/// that motors press against a cube.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstring>
#include <memory>
#include <mujoco/mujoco.h>
#include <stdexcept>
#include <string>
#include <vector>

namespace bristle::benchmarks {

/// Many states of one model.
class MujocoBatch {
 public:
  explicit MujocoBatch(std::size_t count) : model_(load(), mj_deleteModel) {
    for (std::size_t i = 0; i < count; ++i) {
      states_.emplace_back(mj_makeData(model_.get()), mj_deleteData);
      states_.back()->ctrl[0] = 20;
      states_.back()->ctrl[1] = -20;
      step(i, 200);
    }
  }
  [[nodiscard]] std::size_t size() const { return states_.size(); }
  void step(std::size_t number, int steps) {
    for (int k = 0; k < steps; ++k) mj_step(model_.get(), states_[number].get());
  }
  /// [-] Contacts of a state.
  [[nodiscard]] int contacts(std::size_t number) const { return states_[number]->ncon; }

 private:
  static mjModel* load() {
    const auto pad = [](const char* name, const char* x) {
      return "<body name=\"" + std::string(name) + "\" pos=\"" + x + " 0 0\"><joint name=\"" +
             name +
             "\" type=\"slide\" axis=\"1 0 0\"/><geom type=\"box\" size=\"0.01 0.02 0.02\" "
             "mass=\"0.1\"/></body>";
    };
    const std::string xml =
        "<mujoco><option timestep=\"0.001\"/><worldbody>" + pad("left", "-0.04") +
        pad("right", "0.04") +
        "<body name=\"part\"><freejoint/><geom type=\"box\" size=\"0.03 0.03 0.03\" "
        "mass=\"0.5\"/></body></worldbody>"
        "<actuator><motor joint=\"left\"/><motor joint=\"right\"/></actuator></mujoco>";
    auto files = std::make_unique<mjVFS>();
    mj_defaultVFS(files.get());
    (void)mj_makeEmptyFileVFS(files.get(), "grip.xml", static_cast<int>(xml.size() + 1));
    std::memcpy(files->filedata[0], xml.c_str(), xml.size() + 1);
    char error[500] = "";
    mjModel* model = mj_loadXML("grip.xml", files.get(), error, sizeof(error));
    mj_deleteVFS(files.get());
    if (model == nullptr) throw std::runtime_error(error);
    return model;
  }

  std::unique_ptr<mjModel, decltype(&mj_deleteModel)> model_;
  std::vector<std::unique_ptr<mjData, decltype(&mj_deleteData)>> states_;
};

}  // namespace bristle::benchmarks
