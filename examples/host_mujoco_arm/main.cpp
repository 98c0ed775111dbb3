// An arm of seven joints in MuJoCo picks a part, carries it at 1 m/s, turns it and sets it down.
//
// arm.xml is an ordinary MJCF file; the program makes sensors of two of its sites, as host_mujoco
// does. The host knows the mobility of the whole arm, so the pads hold the part as well as pads on
// slides. The table says how far the part moves in the hand between the lift and the end of the
// turn, how much of that is left after it, and how far from its target the part stands in the end,
// by MuJoCo's contacts and by sensors. Bristles give way by the load over their stiffness, and
// come back.
//
// Usage: host_mujoco_arm [PLOT.svg]
// SPDX-License-Identifier: BSD-3-Clause
#include "support/svg_plot.hpp"

#include <bristle/bristle.hpp>
#include <bristle/hosts/mujoco_host.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <exception>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

using namespace bristle;
using namespace figure;

namespace {

constexpr int joints = 7;
constexpr double squeeze = 20;  // [N] of each finger; 2.1 would do to hold the part at rest.

using Model = std::unique_ptr<mjModel, decltype(&mj_deleteModel)>;
using Data = std::unique_ptr<mjData, decltype(&mj_deleteData)>;
using Joints = Eigen::Matrix<double, joints, 1>;
using MatrixMap = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;

Model load(const char* file) {
  char error[500] = "";
  Model model(mj_loadXML(file, nullptr, error, sizeof(error)), mj_deleteModel);
  if (model == nullptr) throw std::runtime_error(error);
  return model;
}

/// Command for the hand: place of the grip [m], its tilt about the world's x axis [rad], and
/// whether the fingers shall be closed.
struct Command {
  Vec3<double> place;
  double tilt = 0;
  bool is_closed = false;
};

/// A stage of the task: the command at its end, and its duration [s].
struct Stage {
  const char* name;
  Command end;
  double duration;
};

const Vec3<double> pick(0.5, -0.3, 0.06);
const Vec3<double> place(0.5, 0.3, 0.06);
const Vec3<double> rise(0, 0, 0.24);
/// The carriage takes 1.875 times the mean speed in its middle, which is 1 m/s.
const std::array<Stage, 10> task{{{"above", {pick + rise, 0, false}, 0.2},
                                  {"down", {pick, 0, false}, 1},
                                  {"close", {pick, 0, true}, 0.5},
                                  {"lift", {pick + rise, 0, true}, 0.8},
                                  {"carry", {place + rise, 0, true}, 1.125},
                                  {"turn", {place + rise, 1.2, true}, 0.8},
                                  {"hold", {place + rise, 1.2, true}, 1},
                                  {"back", {place + rise, 0, true}, 0.8},
                                  {"set down", {place, 0, true}, 1},
                                  {"open", {place + rise, 0, false}, 1.5}}};

/// [s] When a stage ends.
double end_of(const std::string& name) {
  double t = 0;
  for (const Stage& stage : task) {
    t += stage.duration;
    if (name == stage.name) return t;
  }
  throw std::logic_error(name);
}

/// The command at a time [s]; within a stage along the curve of least jerk.
Command command_at(double t) {
  Command from = task.front().end;
  for (const Stage& stage : task) {
    if (t < stage.duration) {
      const double x = t / stage.duration;
      const double share = x * x * x * (10 - x * (15 - 6 * x));
      return {from.place + share * (stage.end.place - from.place),
              from.tilt + share * (stage.end.tilt - from.tilt), stage.end.is_closed};
    }
    t -= stage.duration;
    from = stage.end;
  }
  return from;
}

/// Result of a run: how far the part is in the hand from where it was after the lift, at most and
/// after the turn [m], distance from the target in the end [m], and speed of the part at its
/// fastest [m/s].
struct Run {
  PlotSeries shift;
  double largest_shift = 0;
  double last_shift = 0;
  double miss = 0;
  double fastest = 0;
};

class Arm {
 public:
  Arm(double dt, bool has_sensors) {
    model_->opt.timestep = dt;
    const Joints start(-0.5, 0.2, 0, -2, 0, 2.2, 0);
    for (int i = 0; i < joints; ++i) data_->qpos[i] = start[i];
    mj_forward(model_.get(), data_.get());
    mj_copyData(plan_.get(), model_.get(), data_.get());
    // The plan starts above the part, and the arm with it.
    for (int i = 0; i < 200; ++i) reach(command_at(0));
    wanted_ = planned();
    for (int i = 0; i < joints; ++i) data_->qpos[i] = wanted_[i];
    mj_forward(model_.get(), data_.get());
    if (has_sensors) {
      host_.emplace(*model_, *data_);
      const GripSpec<double> spec{.friction = 0.7, .load = squeeze, .mass = 0.3};
      host_->mirror("part");
      host_->add_pad("left_pad", 6, 10, spec);
      host_->add_pad("right_pad", 6, 10, spec);
    } else {
      for (const char* finger : {"left", "right"}) {
        const int geom = mj_name2id(model_.get(), mjOBJ_GEOM, finger);
        model_->geom_contype[geom] = model_->geom_conaffinity[geom] = 1;
      }
    }
  }

  void step() {
    drive(command_at(data_->time + model_->opt.timestep));
    if (host_) {
      host_->step();
    } else {
      mj_step(model_.get(), data_.get());
    }
  }
  [[nodiscard]] double time() const { return data_->time; }
  /// [m] Place of the part in the frame of the hand, and in the world.
  [[nodiscard]] Vec3<double> in_hand() const {
    const int hand = id(mjOBJ_BODY, "hand");
    const MatrixMap R(data_->xmat + 9 * hand);
    return R.transpose() * (part() - vector(data_->xpos + 3 * hand));
  }
  [[nodiscard]] Vec3<double> part() const {
    return vector(data_->xpos + 3 * id(mjOBJ_BODY, "part"));
  }

 private:
  [[nodiscard]] static Vec3<double> vector(const mjtNum* x) { return {x[0], x[1], x[2]}; }
  [[nodiscard]] int id(mjtObj kind, const char* name) const {
    return mj_name2id(model_.get(), kind, name);
  }
  [[nodiscard]] Joints planned() const { return Eigen::Map<const Joints>(plan_->qpos); }

  /// Moves the plan's joints towards a command: a step of Newton's method, damped, since at the
  /// ends of its reach the arm has fewer than six ways to move.
  void reach(const Command& command) {
    const int site = id(mjOBJ_SITE, "grip");
    const MatrixMap R(plan_->site_xmat + 9 * site);
    // The hand's z axis points down when it is not tilted, its y axis along the world's negative y.
    const Eigen::Matrix3d wanted = (Eigen::AngleAxisd(command.tilt, Vec3<double>::UnitX()) *
                                    Eigen::AngleAxisd(3.14159265358979, Vec3<double>::UnitX()))
                                       .toRotationMatrix();
    const Eigen::AngleAxisd rest(Eigen::Matrix3d(wanted * R.transpose()));
    Eigen::Matrix<double, 6, 1> error;
    error << command.place - vector(plan_->site_xpos + 3 * site), rest.angle() * rest.axis();
    Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor> J(6, model_->nv);
    mj_jacSite(model_.get(), plan_.get(), J.data(), J.data() + 3 * model_->nv, site);
    const Eigen::Matrix<double, 6, joints> arm = J.leftCols<joints>();
    const Eigen::Matrix<double, 6, 6> A =
        arm * arm.transpose() + 1e-6 * Eigen::Matrix<double, 6, 6>::Identity();
    const Joints step = arm.transpose() * A.ldlt().solve(error);
    for (int i = 0; i < joints; ++i) plan_->qpos[i] += step[i];
    mj_kinematics(model_.get(), plan_.get());
    mj_comPos(model_.get(), plan_.get());
  }

  /// Computed torques: motors give what moves the arm along the plan by its own inertia, and pull
  /// it back to it.
  void drive(const Command& command) {
    const double dt = model_->opt.timestep;
    const Joints before = wanted_, speed_before = speed_;
    for (int i = 0; i < 3; ++i) reach(command);
    wanted_ = planned();
    speed_ = (wanted_ - before) / dt;
    const Joints acceleration = (speed_ - speed_before) / dt;
    // Poles at 30 rad/s, damped critically.
    Eigen::VectorXd asked = Eigen::VectorXd::Zero(model_->nv);
    for (int i = 0; i < joints; ++i) {
      asked[i] = acceleration[i] + 900 * (before[i] - data_->qpos[i]) +
                 60 * (speed_before[i] - data_->qvel[i]);
    }
    Eigen::VectorXd torque(model_->nv);
    mj_mulM(model_.get(), data_.get(), torque.data(), asked.data());
    for (int i = 0; i < joints; ++i) {
      data_->ctrl[i] = torque[i] + data_->qfrc_bias[i] - data_->qfrc_passive[i];
    }
    // The left finger is kept at a place by a stiff servo, the right one pushes against it.
    const double closed = 0.02, open = 0;
    const double to = command.is_closed ? closed : open;
    const double force = command.is_closed ? squeeze : 0;
    data_->ctrl[joints] = force + 4000 * (to - data_->qpos[joints]) - 40 * data_->qvel[joints];
    data_->ctrl[joints + 1] =
        command.is_closed ? squeeze - 2 * data_->qvel[joints + 1]
                          : 400 * (open - data_->qpos[joints + 1]) - 12 * data_->qvel[joints + 1];
  }

  Model model_ = load(BRISTLE_EXAMPLE_DIR "/arm.xml");
  Data data_{mj_makeData(model_.get()), mj_deleteData};
  // Kinematics of the command.
  Data plan_{mj_makeData(model_.get()), mj_deleteData};
  Joints wanted_ = Joints::Zero();
  Joints speed_ = Joints::Zero();
  std::optional<MujocoHost<>> host_;
};

Run run(double dt, bool has_sensors) {
  Arm arm(dt, has_sensors);
  Run result;
  const double lifted = end_of("lift"), back = end_of("back"), end = end_of("open");
  Vec3<double> there = Vec3<double>::Zero(), last = arm.part();
  for (int i = 0; arm.time() < end; ++i) {
    arm.step();
    const double t = arm.time();
    result.fastest = std::max(result.fastest, (arm.part() - last).norm() / dt);
    last = arm.part();
    if (t <= lifted) there = arm.in_hand();
    if (t <= lifted || t > back) continue;
    result.last_shift = (arm.in_hand() - there).norm();
    result.largest_shift = std::max(result.largest_shift, result.last_shift);
    if (i % 5 != 0) continue;
    result.shift.x.push_back(t);
    result.shift.y.push_back(1e3 * result.last_shift);
  }
  result.miss = (last - (place + Vec3<double>(0, 0, 0.05 - place.z()))).norm();
  return result;
}

int run_all(const std::string& file) {
  std::printf("shift in the hand [mm]   at most    left   from the target   fastest [m/s]\n");
  SvgPlot plot{.title = "300 g in the hand of an arm in MuJoCo, steps of 2 ms",
               .x_label = "time [s]"};
  PlotPanel panel{.y_label = "shift in the hand [mm]", .series = {}};
  bool all_held = true;
  for (const double dt : {0.001, 0.002, 0.004}) {
    for (const bool has_sensors : {false, true}) {
      Run result = run(dt, has_sensors);
      const char* name = has_sensors ? "sensors" : "contacts";
      std::printf("%8.1f ms, %-8s  %10.3f  %6.3f   %15.2f   %13.2f\n", 1e3 * dt, name,
                  1e3 * result.largest_shift, 1e3 * result.last_shift, 1e3 * result.miss,
                  result.fastest);
      if (has_sensors) all_held = all_held && result.last_shift < 5e-5 && result.miss < 5e-3;
      if (dt == 0.002) {
        result.shift.name = name;
        panel.series.push_back(result.shift);
      }
    }
  }
  plot.panels.push_back(panel);
  plot.write_svg(file);
  std::printf("wrote %s\n", file.c_str());
  return all_held ? 0 : 1;
}

}  // namespace

int main(int count, char** arguments) {
  try {
    return run_all(count > 1 ? arguments[1] : "host_mujoco_arm.svg");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "host_mujoco_arm: %s\n", error.what());
    return 2;
  }
}
