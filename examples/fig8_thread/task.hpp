// The task of Fig. 8 (b): two hands take a thread by its ends, wrap it around a post, pull it over
// the post, and one takes it over from the other.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "fig8_thread/hand.hpp"
#include "fig8_thread/thread.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>
#include <vector>

namespace fig8b {

// The post lies along x, and the thread comes to lie on its upper half. The thread's joints allow
// no radius below pitch / largest_angle, 0.46 m.
inline constexpr double post_radius = 0.5;                    // [m]
inline constexpr double post_friction = 0.3;                  // [1]
inline constexpr double lever = post_radius + thread_radius;  // [m] to the thread's middle

inline constexpr double holding_force = 40;  // [N] of a gantry that goes where it should
inline constexpr double wrapping_force = 8;  // [N] of one that keeps the thread taut
inline constexpr double trailing_force = 4;  // [N] of one that is pulled along
inline constexpr double pull_speed = 0.2;    // [m/s]
inline constexpr double start_time = 0.1;    // [s] that a pull takes to get there

struct TaskDef {
  double time_step = 1e-3;  // [s]
  bristle::Integration integration = bristle::Integration::implicit;
  /// Links of a few grams between joints: the last digits that the default tolerance of 1e-8 asks
  /// for are rounding, and cost half as many factorisations again.
  bristle::SolverDef<double> solver{.tolerance = 1e-4};
};

/// Phases of the task, in this order.
enum class Phase { grip, wrap, pull, travel, hand_over, carry };
inline constexpr std::array<Phase, 6> phases{Phase::grip,   Phase::wrap,      Phase::pull,
                                             Phase::travel, Phase::hand_over, Phase::carry};

inline const char* name_of(Phase phase) {
  constexpr std::array<const char*, 6> names{"grip",   "wrap",      "pull",
                                             "travel", "hand over", "carry"};
  return names[static_cast<std::size_t>(phase)];
}
/// [s] How long it takes.
inline double duration_of(Phase phase) {
  constexpr std::array<double, 6> durations{0.25, 0.8, 0.7, 1.0, 0.5, 0.4};
  return durations[static_cast<std::size_t>(phase)];
}

/// From 0 to 1 at constant speed, but for a fifth of the time to start and to stop.
inline double eased(double x) {
  constexpr double ease = 0.2;
  if (x <= 0) return 0;
  if (x >= 1) return 1;
  if (x > 0.5) return 1 - eased(1 - x);
  return (x < ease ? x * x / (2 * ease) : x - ease / 2) / (1 - ease);
}

/// [N] Tension that pulls a heavy thread over the upper half of the post against a tension `low`.
/// Friction acts at the post's surface and tension at the thread's middle, so over an angle phi
/// from the top T' = a (T + w cos phi) - w sin phi, with a = mu post_radius / lever and the weight
/// w of a radian of thread; without weight, Euler's and Eytelwein's low exp(a pi).
inline double capstan(double low) {
  const double a = post_friction * post_radius / lever;
  const double w = (cylinder_mass + bead_mass) / pitch * gravity * lever;
  const double b = 2 * a * w / (1 + a * a);
  return (low + b) * std::exp(a * std::numbers::pi) + b;
}

/// Energy balance of a phase [J]. The work of motors equals the gain in held energy plus losses: on
/// the post, in the thread's joints, and the rest in the pads and in collisions.
struct EnergyBudget {
  double work = 0;
  double held = 0;  // kinetic, of height, in the thread's joints, in the pads
  double post = 0;
  double joints = 0;

  [[nodiscard]] double rest() const { return work - held - post - joints; }
};

/// One phase, measured.
struct Measured {
  Phase phase = Phase::grip;
  bool is_lost = false;             // a hand let go, or something came apart
  double length_error = 0;          // [1] largest
  double gap = 0;                   // [m] largest
  std::array<double, 2> slip{};     // [m] largest along the thread, of hands that hold
  std::array<double, 2> pull{};     // [N] of both hands, mean of the second half
  std::array<double, 2> tension{};  // [N] where the thread leaves the post at -y and y, likewise
  EnergyBudget energy{};
  double rows = 0;  // means a step
  double factorisations = 0;
  double capped = 0;                // [1] share of steps in which a limit ended the solution
  std::vector<Vec3<double>> beads;  // [m] at the end

  /// The thread keeps its length to 1 % and its joints to 0.1 mm, hands that hold it creep by less
  /// than bristles stretch before they let go, and hands that let go have let go.
  [[nodiscard]] bool is_held() const {
    const bool is_persisted = phase != Phase::carry || (pull[0] > 0 && pull[1] == 0);
    return !is_lost && length_error < 0.01 && gap < 1e-4 && std::max(slip[0], slip[1]) < creep &&
           is_persisted;
  }
  /// On the post no side pulls by more than friction holds; the side that slides pulls by as much.
  [[nodiscard]] bool is_balanced() const {
    const double high = std::max(tension[0], tension[1]);
    const double expected = capstan(std::min(tension[0], tension[1]));
    if (phase == Phase::grip || phase == Phase::wrap) return true;
    const bool slides = phase == Phase::pull || phase == Phase::carry;
    return high < 1.03 * expected && (!slides || high > 0.97 * expected);
  }
  /// Nothing comes from nowhere. While the weight comes on there is no such budget.
  [[nodiscard]] bool is_passive() const {
    return phase == Phase::grip ||
           energy.rest() > -0.01 * (std::abs(energy.work) + std::abs(energy.held));
  }
  [[nodiscard]] bool is_right() const { return is_held() && is_balanced() && is_passive(); }
};

class Task {
 public:
  explicit Task(const TaskDef& def)
      : def_(def),
        world_({.gravity = {0, 0, 0}, .time_step = def.time_step, .solver = def.solver}),
        post_(world_.add_body(
            {.motion = bristle::Motion::fixed, .filter = {post_category, thread_category, 0}})),
        thread_(world_, height, post_friction),
        hands_{Hand(world_, post_, {-reach, height, 0}, thread_radius, def.integration),
               Hand(world_, post_, {reach, height, 0}, thread_radius, def.integration)} {
    using namespace bristle;
    const Vec3<double> along_x(0, std::numbers::pi / 2, 0);
    world_.add_shape(post_, {.shape = Cylinder<double>{post_radius, 0.25},
                             .X_BS = {.rotation = exp_rotation(along_x)},
                             .material = {.friction = post_friction}});
  }

  /// Runs the next phase and tells what happened; `observe(task)` sees every step.
  template <typename Observe>
  Measured run(Phase phase, Observe&& observe);
  Measured run(Phase phase) {
    return run(phase, [](const Task&) {});
  }

  [[nodiscard]] const World& world() const { return world_; }
  [[nodiscard]] const Hand& hand(std::size_t k) const { return hands_[k]; }
  /// [s] Since the start.
  [[nodiscard]] double time() const { return time_; }
  /// [N] Tension where the thread leaves the post on the side of -y or y: what hands there pull by,
  /// and the weight of what hangs there.
  [[nodiscard]] double tension(double side) const;

 private:
  static constexpr double height = lever + 0.001;
  /// Each hand takes the last cylinder but one.
  static constexpr double reach = (0.5 * cylinder_count - 1.5) * pitch;
  /// Hand 0 comes to take the thread where it hangs from the post on hand 1's side.
  static constexpr double meeting_height = -0.2;

  void begin(Phase phase);
  void steer(Phase phase, double t);
  [[nodiscard]] Place place_at(Phase phase, std::size_t k, double t) const;
  [[nodiscard]] bool holds(Phase phase, std::size_t k, double t) const;
  void watch(Phase phase, double t, Measured& result);
  void mark_grip(std::size_t k);
  [[nodiscard]] double place_on_link(std::size_t k) const;
  [[nodiscard]] double held_energy() const;
  void account(EnergyBudget& energy);

  TaskDef def_;
  World world_;
  BodyId post_;
  Thread thread_;
  std::array<Hand, 2> hands_;
  std::array<Place, 2> began_at_{};
  std::array<BodyId, 2> gripped_{};     // the link nearest to the hand when it took the thread
  std::array<double, 2> gripped_at_{};  // [m] the hand's place along it
  std::array<double, 10> motor_rates_{};
  double time_ = 0;
};

// Implementation ----------------------------------------------------------------------------------

/// Where a hand shall be `t` seconds into a phase.
inline Place Task::place_at(Phase phase, std::size_t k, double t) const {
  const double side = k == 0 ? -1 : 1;
  Place place = began_at_[k];
  if (phase == Phase::wrap) {
    // The involute of the post: what does not lie on it is straight. A little farther out than the
    // thread reaches, so that the force of the drives keeps it taut.
    const double angle = 0.5 * std::numbers::pi * eased(t / duration_of(phase));
    const double straight = reach + 0.005 - lever * angle;
    place.y = side * (lever * std::sin(angle) + straight * std::cos(angle));
    place.z = height - lever + lever * std::cos(angle) - straight * std::sin(angle);
    place.angle = -side * angle;
  } else if ((phase == Phase::pull && k == 1) || (phase == Phase::carry && k == 0)) {
    place.z -= pull_speed * (t < start_time ? t * t / (2 * start_time) : t - start_time / 2);
  } else if (phase == Phase::travel && k == 0) {
    // Out, around the post, and in to the thread above hand 1.
    const double from = std::atan2(place.y, place.z);
    const double to = std::atan2(lever, meeting_height);
    const double start = std::hypot(place.y, place.z);
    const double far = lever + 0.12;
    const double end = std::hypot(lever, meeting_height);
    const double radius =
        start + (far - start) * eased((t - 0.05) / 0.2) + (end - far) * eased((t - 0.8) / 0.2);
    const double angle = from + (to - from) * eased((t - 0.1) / 0.75);
    place.y = radius * std::sin(angle);
    place.z = radius * std::cos(angle);
  } else if (phase == Phase::hand_over && k == 1) {
    place.y += 0.1 * eased((t - 0.25) / 0.25);
  }
  return place;
}

/// Returns whether a hand shall hold the thread.
inline bool Task::holds(Phase phase, std::size_t k, double t) const {
  switch (phase) {
    case Phase::grip:
      return t > 0.2;
    case Phase::wrap:
    case Phase::pull:
      return true;
    case Phase::travel:
      return k == 1;
    case Phase::hand_over:
      return k == 0 ? t > 0.2 : t < 0.2;
    case Phase::carry:
      return k == 0;
  }
  return false;
}

inline void Task::begin(Phase phase) {
  for (std::size_t k = 0; k < 2; ++k) began_at_[k] = hands_[k].place(world_);
  if (phase == Phase::grip) {
    for (const Hand& hand : hands_) hand.close(world_);
  } else if (phase == Phase::travel) {
    hands_[0].open(world_);
  } else if (phase == Phase::hand_over) {
    hands_[0].close(world_);
  }
}

inline void Task::steer(Phase phase, double t) {
  const double dt = def_.time_step;
  // Weight comes on when the fingers have closed.
  if (phase == Phase::grip) {
    world_.set_gravity({0, 0, -gravity * eased((t - 0.1) / 0.1)});
  }
  for (std::size_t k = 0; k < 2; ++k) {
    const bool held = holds(phase, k, t);
    const bool will_hold = holds(phase, k, t + dt);
    if (!held && will_hold) mark_grip(k);
    if (held && !will_hold) hands_[k].open(world_);
    const Place place = place_at(phase, k, t);
    const Place rate = 1 / dt * (place_at(phase, k, t + dt) - place);
    hands_[k].follow(world_, place, rate, phase == Phase::wrap ? wrapping_force : holding_force);
  }
  if (phase == Phase::pull) hands_[0].pull_down(world_, trailing_force);
}

/// Remembers where on the thread a hand is.
inline void Task::mark_grip(std::size_t k) {
  gripped_[k] = thread_.nearest(world_, hands_[k].middle(world_));
  gripped_at_[k] = place_on_link(k);
}
inline double Task::place_on_link(std::size_t k) const {
  return (world_.pose(gripped_[k]).inverse() * hands_[k].middle(world_)).y();
}

inline double Task::tension(double side) const {
  double sum = 0;
  for (const Hand& hand : hands_) {
    if (side * hand.middle(world_).y() > 0) sum += hand.pull(world_).z();
  }
  for (const BodyId link : thread_.links()) {
    const bristle::Body<double>& body = world_.body(link);
    const Vec3<double>& at = body.center_pose.translation;
    if (side * at.y() > 0 && at.z() < 0) sum += body.mass * gravity;
  }
  return sum;
}

inline double Task::held_energy() const {
  double sum = thread_.stored_energy(world_);
  const auto add = [&](BodyId id) {
    const bristle::Body<double>& body = world_.body(id);
    const Vec3<double> spin = body.center_pose.rotation.conjugate() * body.twist.angular;
    sum += 0.5 * body.mass * body.twist.linear.squaredNorm() +
           0.5 * spin.dot(body.inertia_B * spin) +
           body.gravity_scale * body.mass * gravity * body.center_pose.translation.z();
  };
  for (const BodyId link : thread_.links()) add(link);
  for (const Hand& hand : hands_) {
    sum += hand.stored_energy(world_);
    for (const BodyId body : hand.bodies()) add(body);
  }
  return sum;
}

/// Adds what the last step did.
inline void Task::account(EnergyBudget& energy) {
  const double dt = def_.time_step;
  std::size_t k = 0;
  for (const Hand& hand : hands_) {
    for (const JointId motor : hand.drives()) {
      const bristle::JointReading<double> reading = world_.reading(motor);
      energy.work += 0.5 * dt * reading.motor_force * (reading.velocity + motor_rates_[k]);
      motor_rates_[k++] = reading.velocity;
    }
  }
  energy.joints += dt * thread_.damping_power(world_);
  const auto velocity = [this](BodyId id, const Vec3<double>& at) {
    const bristle::Body<double>& body = world_.body(id);
    return body.twist.at(at - body.center_pose.translation);
  };
  world_.for_each_contact([&](const bristle::ContactReading<double>& contact) {
    contact.for_each_point([&](const auto& point) {
      energy.post -= point.friction_impulse.dot(velocity(contact.body_b, point.position) -
                                                velocity(contact.body_a, point.position));
    });
  });
}

/// Notes what the last step, at `t` in a phase, shows.
inline void Task::watch(Phase phase, double t, Measured& result) {
  const bristle::StepReport<double>& report = world_.report();
  result.rows += static_cast<double>(report.rows);
  result.factorisations += static_cast<double>(report.factorisations);
  result.capped += report.capped_islands > 0 ? 1 : 0;
  const double error = std::abs(thread_.length_error(world_));
  result.length_error = std::max(result.length_error, error);
  result.gap = std::max(result.gap, thread_.largest_gap(world_));
  result.is_lost = !(error < 0.1) || report.frozen_bodies + report.discarded_islands > 0;
  for (std::size_t k = 0; k < 2; ++k) {
    if (!holds(phase, k, t)) continue;
    if (!hands_[k].touches(world_)) result.is_lost = true;
    result.slip[k] = std::max(result.slip[k], std::abs(place_on_link(k) - gripped_at_[k]));
  }
  account(result.energy);
}

template <typename Observe>
Measured Task::run(Phase phase, Observe&& observe) {
  begin(phase);
  Measured result;
  result.phase = phase;
  const double held_before = held_energy();
  const long steps = std::lround(duration_of(phase) / def_.time_step);
  for (long i = 0; i < steps && !result.is_lost; ++i) {
    // The middle of the step, where no rounding decides whether something has begun.
    const double t = def_.time_step * (static_cast<double>(i) + 0.5);
    steer(phase, t);
    world_.step();
    time_ += def_.time_step;
    watch(phase, t, result);
    if (2 * i >= steps) {
      for (std::size_t k = 0; k < 2; ++k) {
        result.pull[k] += hands_[k].pull(world_).norm();
        result.tension[k] += tension(k == 0 ? -1 : 1);
      }
    }
    observe(std::as_const(*this));
  }
  for (double* sum : {&result.rows, &result.factorisations, &result.capped}) {
    *sum /= static_cast<double>(steps);
  }
  const auto averaged = static_cast<double>(steps - (steps + 1) / 2);
  for (std::size_t k = 0; k < 2; ++k) {
    result.pull[k] /= averaged;
    result.tension[k] /= averaged;
  }
  result.energy.held = held_energy() - held_before;
  result.beads = thread_.beads(world_);
  return result;
}

}  // namespace fig8b
