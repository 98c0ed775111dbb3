// Where momentum and energy of the task of Fig. 8 (a) go, step by step.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "hand.hpp"

#include <bristle/math/spatial.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

namespace fig8 {

/// Work and impulses since the task began.
struct Account {
  double drives = 0;    // [J] work of all motors of the hands
  double cast = 0;      // [J] of friction and damping in the cast's joint
  double sensors = 0;   // [J] of the pads, on driver and fingers
  double contacts = 0;  // [J] of contacts, on driver and cast
  double gained = 0;    // [J] kinetic energy and energy in gravity that the bodies gained
  /// [N s] The most by which a step changed the driver's momentum beyond what weight, contacts and
  /// sensors gave it; [N m s] the same of its angular momentum about its centre of mass.
  double lost_momentum = 0;
  double lost_angular = 0;

  /// [J] Energy that no entry accounts for: from joints and from integration.
  [[nodiscard]] double error() const { return drives + cast + sensors + contacts - gained; }
};

/// Keeps an account over a world's steps.
class Budget {
 public:
  Budget(const bristle::World<double>& world, const Bench& bench, const std::array<Hand, 2>& hands)
      : bench_(bench) {
    bodies_ = {bench.driver, bench.cast};
    for (const Hand& hand : hands) {
      bodies_.insert(bodies_.end(), hand.bodies().begin(), hand.bodies().end());
      const std::vector<bristle::JointId> joints = hand.joints();
      joints_.insert(joints_.end(), joints.begin(), joints.end());
      for (std::size_t k = 0; k < 2; ++k) pads_.push_back({hand.finger(k), hand.pad(k)});
    }
    energy_ = energy(world);
    rates_.resize(joints_.size());
  }

  void before_step(const bristle::World<double>& world) {
    before_.clear();
    for (const bristle::BodyId id : bodies_) before_.push_back(world.body(id));
    for (std::size_t i = 0; i < joints_.size(); ++i) rates_[i] = world.reading(joints_[i]).velocity;
    cast_rate_ = world.reading(bench_.turning).velocity;
  }

  /// Forces do work at the mean of the velocities before and after the step.
  void after_step(const bristle::World<double>& world) {
    using bristle::Wrench;
    const double dt = world.time_step();
    for (std::size_t i = 0; i < joints_.size(); ++i) {
      const bristle::JointReading<double> joint = world.reading(joints_[i]);
      account_.drives += dt * joint.motor_force * 0.5 * (rates_[i] + joint.velocity);
    }
    const bristle::JointReading<double> turning = world.reading(bench_.turning);
    account_.cast += dt * turning.reaction.torque.z() * 0.5 * (cast_rate_ + turning.velocity);

    const bristle::Body<double>& driver = before_[0];
    Wrench<double> pushed{driver.mass * dt * world.def().gravity, {0, 0, 0}};
    for (const auto& [finger, pad] : pads_) {
      const Wrench<double> reading = dt * world.reading(pad).wrench;
      const bristle::Body<double>& before = body_before(finger);
      account_.sensors += work(reading, before, world.body(finger));
      const Wrench<double> given =
          -reading.shifted(driver.center_pose.translation - before.center_pose.translation);
      account_.sensors += work(given, driver, world.body(bench_.driver));
      pushed += given;
    }
    for (const bristle::BodyId id : {bench_.driver, bench_.cast}) {
      const Wrench<double> touched = world.contact_impulse(id);
      account_.contacts += work(touched, body_before(id), world.body(id));
      if (id == bench_.driver) pushed += touched;
    }

    const bristle::Body<double>& after = world.body(bench_.driver);
    const Vec3<double> momentum = after.mass * (after.twist.linear - driver.twist.linear);
    const Vec3<double> angular = after.angular_momentum() - driver.angular_momentum();
    account_.lost_momentum = std::max(account_.lost_momentum, (momentum - pushed.force).norm());
    account_.lost_angular = std::max(account_.lost_angular, (angular - pushed.torque).norm());
    account_.gained = energy(world) - energy_;
  }

  [[nodiscard]] const Account& account() const { return account_; }

 private:
  /// [J] Work of an impulse about the centre of mass on a body.
  [[nodiscard]] static double work(const bristle::Wrench<double>& impulse,
                                   const bristle::Body<double>& before,
                                   const bristle::Body<double>& after) {
    return 0.5 * (impulse.force.dot(before.twist.linear + after.twist.linear) +
                  impulse.torque.dot(before.twist.angular + after.twist.angular));
  }
  [[nodiscard]] const bristle::Body<double>& body_before(bristle::BodyId id) const {
    const auto place = std::find(bodies_.begin(), bodies_.end(), id) - bodies_.begin();
    return before_[static_cast<std::size_t>(place)];
  }
  [[nodiscard]] double energy(const bristle::World<double>& world) const {
    double sum = 0;
    for (const bristle::BodyId id : bodies_) {
      const bristle::Body<double>& body = world.body(id);
      sum += body.kinetic_energy() -
             body.mass * body.gravity_scale * world.def().gravity.dot(body.center_pose.translation);
    }
    return sum;
  }

  Bench bench_;
  std::vector<bristle::BodyId> bodies_;
  std::vector<bristle::JointId> joints_;
  std::vector<std::pair<bristle::BodyId, bristle::PatchId>> pads_;
  std::vector<bristle::Body<double>> before_;
  std::vector<double> rates_;
  double cast_rate_ = 0;
  double energy_ = 0;
  Account account_{};
};

}  // namespace fig8
