// The hand, the part and the incline, and the phases of the run; the same for every backend.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scenario.hpp"

#include <bristle/bristle.hpp>
#include <bristle/io/glb.hpp>
#include <bristle/io/mesh_file.hpp>
#include <bristle/io/recorder.hpp>

#include <ctime>
#include <numbers>

namespace gripper {

/// Lengths in m, masses in kg, forces in N.
struct Layout {
  double slope = 20 * std::numbers::pi / 180;
  double part_mass = 0.5;
  bristle::Vec3<double> part_half{0.03, 0.02, 0.03};
  double finger_mass = 0.2;
  bristle::Vec3<double> finger_half{0.015, 0.02, 0.01};  // z points at the part
  double open_gap = 0.02;                                // pad to part while open
  double closing_speed = 0.1;
  double grip_force = 20;  // of each finger
  double friction = 0.8;   // wanted of the pads
  double creep = 1e-3;     // sigma_a
  double lift = 0.12;
};

template <typename World, typename S>
class Gripper {
 public:
  explicit Gripper(const Settings& settings) : settings_(settings), world_(world_def(settings)) {
    using namespace bristle;
    // The hand and the part lean with the incline: G maps their axes to the world's.
    const Vec3<S> tilt(S(0), S(layout_.slope), S(0));
    lean_ = exp_rotation<S>(tilt);
    start_ = lean_ * Vec3<S>(S(0), S(0), S(layout_.part_half.z()));

    BodyDef<S> incline;
    incline.motion = Motion::fixed;
    incline.shape = HalfSpace<S>{lean_ * Vec3<S>(Vec3<S>::UnitZ()), S(0)};
    incline.material.friction = S(0.7);
    recorder_.add_body(world_.add_body(incline), incline, "incline", S(0.5));

    BodyDef<S> part;
    part.mass = S(layout_.part_mass);
    part.shape = Box<S>{layout_.part_half.template cast<S>()};
    part.material.friction = S(0.7);
    part.position = start_;
    part.orientation = lean_;
    part_ = world_.add_body(part);
    recorder_.add_body(part_, part, "part");

    BodyDef<S> palm;
    palm.motion = Motion::kinematic;
    palm.position = start_;
    palm.orientation = lean_;
    palm_ = world_.add_body(palm);

    for (int side : {0, 1}) add_finger(side);
    outcome_.weight = layout_.part_mass * 9.81;
    outcome_.friction = layout_.friction;
    outcome_.sensors = 2 * world_.reading(pads_[0]).size();
  }

  Outcome run() {
    const std::clock_t begin = std::clock();
    for (int side : {0, 1}) motor(side, S(layout_.grip_force));
    phase("close", 0.6, [](double) {});
    stop_first_finger();
    const double before_lift = sag_depth();
    phase("lift", 1.2, [&](double t) { raise(layout_.lift * smooth(t / 1.2)); });
    phase("settle", 1.0, [](double) {});
    measure_hold(before_lift);
    loosen_until_slip();
    catch_again();
    set_down();
    outcome_.simulated_time = time_;
    outcome_.cpu_time = double(std::clock() - begin) / CLOCKS_PER_SEC;
    if (!settings_.replay.empty()) outcome_.replay = glb(recorder_.recording());
    return std::move(outcome_);
  }

 private:
  static bristle::WorldDef<S> world_def(const Settings& settings) {
    bristle::WorldDef<S> def;
    def.time_step = S(settings.time_step);
    return def;
  }

  void add_finger(int side) {
    using namespace bristle;
    const S sign = side == 0 ? S(-1) : S(1);
    const S quarter = S(std::numbers::pi / 2);
    const S reach = S(layout_.part_half.y() + layout_.open_gap + layout_.finger_half.z());
    // Frame of the finger in the hand: z points at the part.
    const Transform<S> X_GF{exp_rotation<S>(Vec3<S>(sign * quarter, S(0), S(0))),
                            Vec3<S>(S(0), sign * reach, S(0))};
    BodyDef<S> def;
    def.mass = S(layout_.finger_mass);
    def.shape = Box<S>{layout_.finger_half.template cast<S>()};
    def.position = start_ + lean_ * X_GF.translation;
    def.orientation = lean_ * X_GF.rotation;
    fingers_[side] = world_.add_body(def);
    recorder_.add_body(fingers_[side], def, side == 0 ? "first finger" : "second finger");

    // It slides along its z axis, which is the x axis of the joint.
    const Transform<S> X_FJ{exp_rotation<S>(Vec3<S>(S(0), -quarter, S(0))), Vec3<S>::Zero()};
    JointDef<S> joint;
    joint.kind = JointKind::prismatic;
    joint.body_a = palm_;
    joint.body_b = fingers_[side];
    joint.X_AJ = X_GF * X_FJ;
    joint.X_BJ = X_FJ;
    joint.lower_limit = S(0);
    joint.upper_limit = S(layout_.open_gap + 0.01);
    slides_[side] = world_.add_joint(joint);
    recorder_.add_joint(world_, slides_[side], side == 0 ? "first slide" : "second slide");

    // The pad's mesh lies in its own plane z = 0; it goes onto the finger's front.
    PlacementDef<S> placement;
    placement.depth = S(0.004);
    placement.range = S(0.008);
    placement.X_AM.translation.z() = S(layout_.finger_half.z());
    PatchDef<S> pad;
    pad.sensors = sensors_from_mesh(load_mesh<S>(settings_.pad), placement);
    GripSpec<S> spec;
    spec.friction = S(layout_.friction);
    spec.creep = S(layout_.creep);
    spec.load = S(layout_.grip_force);
    spec.mass = S(layout_.part_mass);
    pad.parameters = tuned_for<S>(spec).parameters(pad.sensors);
    pad.integration = settings_.integration;
    if (settings_.law == "drag") pad.options.reset = SlipReset::drag;
    if (settings_.law == "ambf") pad.options.law = Law::ambf;
    stiffness_ = pad.parameters.static_friction;
    pads_[side] = world_.add_patch(fingers_[side], pad);
    recorder_.add_patch(world_, pads_[side], side == 0 ? "first pad" : "second pad");
  }

  /// One finger closes with a force [N], or opens with a negative one.
  void motor(int side, S force) {
    const S speed = force < S(0) ? S(-layout_.closing_speed) : S(layout_.closing_speed);
    world_.set_motor(slides_[side], {bristle::MotorMode::velocity, speed, std::abs(force)});
  }
  /// The first finger stays where it is from now on, so that the second squeezes against it: two
  /// equal forces alone would let hand and part drift along the rails.
  void stop_first_finger() {
    world_.set_motor(slides_[0], {bristle::MotorMode::position, world_.reading(slides_[0]).position,
                                  S(10 * layout_.grip_force)});
  }

  static double smooth(double x) { return x <= 0 ? 0 : x >= 1 ? 1 : x * x * (3 - 2 * x); }

  /// Height [m] of the hand above where it gripped, at the end of the next step.
  void raise(double height) {
    height_ = height;
    bristle::Transform<S> X{lean_, start_};
    X.translation.z() += S(height);
    world_.move_to(palm_, X);
  }

  /// [m] How much deeper the part hangs in the hand than where it was taken.
  double sag_depth() const {
    return double(world_.pose(palm_).translation.z() - world_.pose(part_).translation.z());
  }
  bristle::Vec3<S> place_in_hand() const {
    return world_.pose(part_).translation - world_.pose(palm_).translation;
  }
  double total_normal() const {
    return double(world_.reading(pads_[0]).total_normal() +
                  world_.reading(pads_[1]).total_normal());
  }
  /// [N] Force of all sensors on the part.
  bristle::Vec3<S> force_on_part() const {
    return -(world_.reading(pads_[0]).wrench.force + world_.reading(pads_[1]).wrench.force);
  }
  std::size_t slipping() const {
    return world_.reading(pads_[0]).slipping() + world_.reading(pads_[1]).slipping();
  }

  void step() {
    world_.step();
    world_.set_velocity(palm_, {});
    if (!settings_.replay.empty()) observe();
    time_ += settings_.time_step;
    const auto& report = world_.report();
    outcome_.rays_cast += report.rays_cast;
    outcome_.rays_skipped += report.sensors_skipped;
    outcome_.explicit_pairs += report.explicit_pairs;
    outcome_.implicit_pairs += report.implicit_pairs;
    outcome_.backend_failures += report.backend_failures;
    // A bristle that lets go slips for one step only, which a record every few steps would miss.
    most_slipping_ = std::max(most_slipping_, slipping());
    if (time_ + 1e-9 < next_record_) return;
    next_record_ += 0.005;
    outcome_.trace.add_row({time_, 1e3 * double(world_.pose(part_).translation.z()),
                            1e3 * double(world_.pose(palm_).translation.z()), 1e6 * sag_depth(),
                            total_normal(), double(force_on_part().z()), double(most_slipping_),
                            double(world_.reading(slides_[1]).motor_force)});
    most_slipping_ = 0;
  }

  void observe() {
    recorder_.scalar("grip force", "N", total_normal());
    recorder_.scalar("sag", "mm", 1e3 * sag_depth());
    recorder_.observe(world_);
  }

  /// Steps for `duration` [s], calling `before_step(t)` with the time [s] at the end of each step.
  template <typename BeforeStep>
  void phase(const char* name, double duration, BeforeStep&& before_step) {
    const double start = time_;
    phase_until(name, duration, [&] {
      before_step(time_ - start + settings_.time_step);
      return false;
    });
  }

  /// Steps until `is_done()` is true, at most for `limit` [s].
  template <typename IsDone>
  void phase_until(const char* name, double limit, IsDone&& is_done) {
    const double start = time_;
    const long steps = std::lround(limit / settings_.time_step);
    for (long i = 0; i < steps && !is_done(); ++i) step();
    outcome_.phases.push_back({name, start, time_});
  }

  void measure_hold(double before_lift) {
    outcome_.sag = sag_depth() - before_lift;
    outcome_.predicted_sag = outcome_.weight / (double(stiffness_) * total_normal());
    const bristle::Vec3<S> place = place_in_hand();
    outcome_.hold_time = 5;
    phase("hold", outcome_.hold_time, [](double) {});
    outcome_.creep = double((place_in_hand() - place).norm());
    outcome_.hold_force_error = std::abs(double(force_on_part().z()) - outcome_.weight);
    outcome_.was_held = sag_depth() < 0.02 && total_normal() > 0;
  }

  /// Lets the grip go down until most sensors slip, then waits for 2 mm of sliding. The last part
  /// is slow: while the grip softens the part sinks, and the bristles' damping then carries some
  /// load.
  void loosen_until_slip() {
    const double start = time_;
    double depth_at_slip = 0;
    bool slides = false;
    phase_until("loosen", 12, [&] {
      const double t = time_ - start;
      const double quick = layout_.grip_force * (1 - 0.75 * smooth(t));
      if (!slides) {
        motor(1, S(quick - 0.4 * std::max(0.0, t - 1)));
        slides = 2 * slipping() > outcome_.sensors;
        if (slides) {
          outcome_.slip_load = total_normal();
          depth_at_slip = sag_depth();
          // A little less still, so that it slides on with friction that does not fall, too.
          motor(1, S(0.4 * outcome_.slip_load));
        }
      }
      outcome_.slid = slides ? sag_depth() - depth_at_slip : 0;
      return outcome_.slid > 0.002;
    });
  }

  void catch_again() {
    motor(1, S(layout_.grip_force));
    phase("catch", 0.5, [](double) {});
    const bristle::Vec3<S> place = place_in_hand();
    phase("hold again", 0.5, [](double) {});
    outcome_.caught_creep = double((place_in_hand() - place).norm());
    outcome_.was_caught = sag_depth() < 0.02 && total_normal() > 0;
  }

  /// Goes down until the sensors feel half the weight gone, opens, and waits.
  void set_down() {
    const double top = height_;
    const double start = time_;
    const double speed = 0.05;
    const double run_up = 0.2;  // [s] A jump in speed would take the weight off the sensors, too.
    phase_until("set down", 5, [&] {
      if (double(force_on_part().z()) < 0.5 * outcome_.weight) return true;
      const double t = time_ - start + settings_.time_step;
      raise(top - speed * (t < run_up ? t * t / (2 * run_up) : t - run_up / 2));
      return false;
    });
    for (int side : {0, 1}) motor(side, S(-layout_.grip_force));
    phase("release", 1, [](double) {});
    const bristle::Vec3<S> normal = lean_ * bristle::Vec3<S>(bristle::Vec3<S>::UnitZ());
    outcome_.final_speed = double(world_.body(part_).twist.linear.norm());
    outcome_.final_height_error =
        std::abs(double(normal.dot(world_.pose(part_).translation)) - layout_.part_half.z());
  }

  Settings settings_;
  Layout layout_;
  World world_;
  bristle::Recorder<S> recorder_;
  bristle::Quat<S> lean_;
  bristle::Vec3<S> start_;
  bristle::BodyId part_, palm_, fingers_[2];
  bristle::JointId slides_[2];
  bristle::PatchId pads_[2];
  S stiffness_ = S(0);
  double height_ = 0;
  double time_ = 0;
  double next_record_ = 0;
  std::size_t most_slipping_ = 0;
  Outcome outcome_;
};

template <typename Backend>
Outcome run_with(const Settings& settings) {
  if (settings.scalar == "float") {
    return Gripper<bristle::World<float, Backend>, float>(settings).run();
  }
  return Gripper<bristle::World<double, Backend>, double>(settings).run();
}

}  // namespace gripper
