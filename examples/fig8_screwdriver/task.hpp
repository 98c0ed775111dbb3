// The task of the paper's Fig. 8 (a): the major hand picks the driver up, both insert it into the
// cast, the minor hand softens, the major one turns the shaft and the cast below it, the minor one
// holds while the major one takes a new grip, and so on.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "budget.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <ctime>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

namespace fig8 {

/// Bounds on the cost of the worst step, as a task in real time wants them: where the tip slides on
/// the cast, the defaults take three times as long for the same motion (fig9_real_time).
inline bristle::SolverDef<double> bounded_solver() {
  bristle::SolverDef<double> solver;
  solver.max_newton_steps = 15;
  solver.max_sweeps = 10;
  return solver;
}

struct TaskDef {
  int turns = 3;            // [-] of the wrist
  double time_step = 1e-3;  // [s]
  bristle::Integration integration = bristle::Integration::implicit;
  PadGrid grid{};  // of each of the four pads
  bristle::SolverDef<double> solver = bounded_solver();
  /// Sees the world after every step.
  std::function<void(const bristle::World<double>&)> watch{};
};

/// One phase of the task.
struct Phase {
  std::string name;
  double begin = 0;          // [s]
  double end = 0;            // [s]
  std::string holder;        // Which hand holds the driver: "major", "minor" or none.
  double height = 0;         // [m] of the tip's middle, at the end
  double driver_turn = 0;    // [rad] of the driver in this phase
  double cast_turn = 0;      // [rad] of the cast
  double slip = 0;           // [m] the most that the holder has slipped since it took hold
  std::size_t released = 0;  // [-] the most of the holder's bristles that let go in a step
  double squeeze_major = 0;  // [N] at the end
  double squeeze_minor = 0;  // [N]
  double torque = 0;         // [N m] the most that the major wrist gave
  double cpu_time = 0;       // [s] of all its steps

  [[nodiscard]] bool is_turn() const { return name.starts_with("turn"); }
  /// Returns whether plots name the phase.
  [[nodiscard]] bool is_shown() const { return is_turn() || name == "lift" || name == "insert"; }
  [[nodiscard]] double real_time_factor() const { return (end - begin) / cpu_time; }
};

/// Values that the curves show.
struct Sample {
  double time = 0;           // [s]
  double driver_turn = 0;    // [rad]
  double cast_turn = 0;      // [rad]
  double squeeze_major = 0;  // [N]
  double squeeze_minor = 0;  // [N]
  double height = 0;         // [m] of the tip's middle
  double slip = 0;           // [m] of the hand that holds
  double cpu_time = 0;       // [s] of this step
};

class Task {
 public:
  explicit Task(const TaskDef& def)
      : def_(def),
        world_({.time_step = def.time_step, .solver = def.solver}),
        bench_(world_),
        hands_{Hand(world_, bench_, major_def(def)), Hand(world_, bench_, minor_def(def))},
        budget_(world_, bench_, hands_) {}
  Task(const Task&) = delete;
  Task& operator=(const Task&) = delete;

  /// Does it all; ends early when the driver is lost.
  void run() {
    const Goal minor_rest{{0, 0, clear_height + minor_grip}, 0};
    const double major_high = clear_height + major_grip;
    const Goal above_stand{{0, stand_y, standing_height + major_grip}, 0};
    const Goal lifted{{0, stand_y, major_high}, 0};
    const Goal above_cast{{0, 0, major_high}, 0};
    const Goal major_seated{{0, 0, seated_height + major_grip}, 0};
    const Goal minor_seated{{0, 0, seated_height + minor_grip}, 0};

    play("reach", 0.8, {above_stand, minor_rest});
    major_hand().close(world_, firm);
    play("grip", 0.6, {above_stand, minor_rest});
    take(major_hand());
    play("lift", 1.0, {lifted, minor_rest});
    play("carry", 1.6, {above_cast, minor_rest});
    minor_hand().close(world_, firm);
    play("guide", 0.6, {above_cast, minor_rest});
    play("insert", 1.2, {major_seated, minor_seated});
    for (int i = 1; i <= def_.turns; ++i) {
      const auto name = [i](const char* what) { return what + (" " + std::to_string(i)); };
      Goal turned = major_seated;
      turned.turn = stroke;
      play(name("soften"), 0.3, {major_seated, minor_seated}, minor_from(firm, soft));
      play(name("turn"), 1.0, {turned, minor_seated});
      play(name("tighten"), 0.3, {turned, minor_seated}, minor_from(soft, firm));
      take(minor_hand());
      major_hand().open(world_);
      play(name("release"), 0.5, {turned, minor_seated});
      play(name("go back"), 0.7, {major_seated, minor_seated});
      major_hand().close(world_, firm);
      play(name("re-grip"), 0.6, {major_seated, minor_seated});
      take(major_hand());
    }
    play("rest", 0.5, {major_seated, minor_seated});
  }

  [[nodiscard]] const std::vector<Phase>& phases() const { return phases_; }
  [[nodiscard]] const std::vector<Sample>& samples() const { return samples_; }
  [[nodiscard]] const Account& account() const { return budget_.account(); }
  /// Phase in which the driver was lost; empty if it was not.
  [[nodiscard]] const std::string& lost_in() const { return lost_in_; }
  /// [-] Simulated time over time of the processor.
  [[nodiscard]] double real_time_factor() const {
    double cpu_time = 0;
    for (const Phase& phase : phases_) cpu_time += phase.cpu_time;
    return time_ / cpu_time;
  }
  /// [rad] The least that driver or cast turned in one of the turns.
  [[nodiscard]] double least_turn() const {
    double least = bristle::infinity<double>;
    for (const Phase& phase : phases_) {
      if (phase.is_turn()) least = std::min({least, phase.driver_turn, phase.cast_turn});
    }
    return least;
  }
  /// [m] The most that a hand slipped while it held.
  [[nodiscard]] double slip() const {
    double most = 0;
    for (const Phase& phase : phases_) most = std::max(most, phase.slip);
    return most;
  }
  /// [-] The most bristles of a hand that held that let go in a step.
  [[nodiscard]] std::size_t released() const {
    std::size_t most = 0;
    for (const Phase& phase : phases_) most = std::max(most, phase.released);
    return most;
  }

  /// Returns whether the task was done. The driver was never lost and is seated in the slot. It
  /// turned with the cast by the wanted angle each time, without slipping. Energy is balanced to
  /// first order, as it is integrated; momentum is kept to round-off.
  [[nodiscard]] bool is_right() const {
    const Account& sum = account();
    return lost_in_.empty() && std::abs(height() - seated_height) < 1e-4 &&
           least_turn() > wanted_turn && slip() < slip_bound && released() == 0 &&
           std::abs(sum.error()) < 0.01 * sum.drives && sum.lost_momentum < 1e-12 &&
           sum.lost_angular < 1e-12;
  }

  static constexpr double wanted_turn = 30 * degree;
  /// [m] A hand holds while none of its bristles lets go.
  static constexpr double slip_bound = table_constants.breakaway_distance;
  static constexpr double stroke = 45 * degree;  // of the major wrist
  static constexpr double firm = 20;             // [N] of each finger
  static constexpr double soft = 0.5;            // [N]
  static constexpr double major_grip = 0.86;     // [m] of the hands above the tip
  static constexpr double minor_grip = 0.40;     // [m]

 private:
  using Goals = std::array<Goal, 2>;

  [[nodiscard]] static HandDef major_def(const TaskDef& def) {
    return {.start = {0, stand_y + 0.25, standing_height + major_grip},
            .grid = def.grid,
            .integration = def.integration};
  }
  [[nodiscard]] static HandDef minor_def(const TaskDef& def) {
    return {.radius = shaft_radius,
            .half_width = 0.008,
            .half_height = 0.05,
            .start = {0, 0, clear_height + minor_grip},
            .grid = def.grid,
            .integration = def.integration};
  }
  [[nodiscard]] Hand& major_hand() { return hands_[0]; }
  [[nodiscard]] Hand& minor_hand() { return hands_[1]; }

  /// From now on this hand is the one that holds.
  void take(Hand& hand) {
    hand.hold(world_);
    holder_ = &hand;
  }

  /// Moves the hands to their goals. `during` is told how far that is, from 0 to 1, before each
  /// step.
  void play(
      const std::string& name, double seconds, const Goals& goals,
      const std::function<void(double)>& during = [](double) {});
  /// Changes the force of the minor hand little by little, so that its fingers do not jump.
  [[nodiscard]] std::function<void(double)> minor_from(double before, double after) {
    return [this, before, after](double s) {
      minor_hand().close(world_, before + s * (after - before));
    };
  }
  void step();
  [[nodiscard]] double cast_turn() const { return world_.reading(bench_.turning).position; }
  [[nodiscard]] double height() const { return world_.pose(bench_.driver).translation.z(); }
  [[nodiscard]] bool is_lost() const;

  TaskDef def_;
  bristle::World<double> world_;
  Bench bench_;
  std::array<Hand, 2> hands_;
  Budget budget_;
  const Hand* holder_ = nullptr;
  std::vector<Phase> phases_;
  std::vector<Sample> samples_;
  std::string lost_in_;
  double time_ = 0;         // [s]
  double driver_turn_ = 0;  // [rad] heading of the driver, whole turns counted
};

// Implementation ----------------------------------------------------------------------------------

/// From 0 to 1 with speed and acceleration zero at both ends.
inline double smooth_step(double u) { return u * u * u * (10 - u * (15 - 6 * u)); }

inline void Task::play(const std::string& name, double seconds, const Goals& goals,
                       const std::function<void(double)>& during) {
  if (!lost_in_.empty()) return;
  Phase phase;
  phase.name = name;
  phase.begin = time_;
  if (holder_ != nullptr) phase.holder = holder_ == &hands_[0] ? "major" : "minor";
  const double driver_before = driver_turn_;
  const double cast_before = cast_turn();
  const Goals from{hands_[0].goal(), hands_[1].goal()};
  const long steps = std::lround(seconds / def_.time_step);
  for (long i = 1; i <= steps && lost_in_.empty(); ++i) {
    const double s = smooth_step(static_cast<double>(i) / static_cast<double>(steps));
    for (std::size_t k = 0; k < 2; ++k) {
      hands_[k].move_to(world_, {from[k].place + s * (goals[k].place - from[k].place),
                                 from[k].turn + s * (goals[k].turn - from[k].turn)});
    }
    during(s);
    step();
    if (is_lost()) lost_in_ = name;
    const Sample& now = samples_.back();
    phase.slip = std::max(phase.slip, now.slip);
    phase.cpu_time += now.cpu_time;
    phase.torque = std::max(phase.torque, std::abs(hands_[0].torque(world_)));
    if (holder_ != nullptr) phase.released = std::max(phase.released, holder_->released(world_));
  }
  phase.end = time_;
  phase.height = height();
  phase.driver_turn = driver_turn_ - driver_before;
  phase.cast_turn = cast_turn() - cast_before;
  phase.squeeze_major = hands_[0].squeeze(world_);
  phase.squeeze_minor = hands_[1].squeeze(world_);
  phases_.push_back(phase);
}

inline void Task::step() {
  budget_.before_step(world_);
  const std::clock_t start = std::clock();
  world_.step();
  const double cpu_time = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  budget_.after_step(world_);
  if (def_.watch) def_.watch(world_);
  time_ += def_.time_step;
  const Vec3<double> x = world_.pose(bench_.driver).rotation * Vec3<double>::UnitX();
  driver_turn_ += std::remainder(std::atan2(x.y(), x.x()) - driver_turn_, 2 * std::numbers::pi);
  samples_.push_back({time_, driver_turn_, cast_turn(), hands_[0].squeeze(world_),
                      hands_[1].squeeze(world_), height(),
                      holder_ != nullptr ? holder_->slip(world_) : 0, cpu_time});
}

/// Leaning by more than 20 degrees, below where it stood, or not a number.
inline bool Task::is_lost() const {
  const bristle::Transform<double> X = world_.pose(bench_.driver);
  const double up = (X.rotation * Vec3<double>::UnitZ()).z();
  return !(up > std::cos(20 * degree) && X.translation.z() > 0.5 * standing_height);
}

}  // namespace fig8
