/// @file
/// The pinch in an engine that is not ours: plain symplectic Euler over bodies that know nothing of
/// contact.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/hosts/host_sensors.hpp>
#include <bristle/math/rotation.hpp>

#include <array>
#include <cstddef>
#include <optional>
#include <scenes/pinch.hpp>

namespace bristle::scenes {

class ToyPinch : public Pinch {
 public:
  HostSensors<double> sensors;
  std::array<BodyId, 2> pads{};
  BodyId part_id{};
  /// [m] The part's centre of mass, with its rotation.
  Transform<double> center{};
  /// [m/s, rad/s] Of the part, about its centre of mass.
  Twist<double> twist{};
  /// Wrenches on the pads and the part for the next step.
  std::array<Wrench<double>, 3> given{};

  explicit ToyPinch(const PinchDef& d) : Pinch(d) {
    const Box<double> box{{0.005, 0.01, 0.01}};
    for (std::size_t k = 0; k < 2; ++k) {
      pads[k] = world().add_body({.motion = Motion::kinematic, .shape = box});
      patches[k] = world().add_patch(pads[k], pinch_pad(k == 0 ? 1 : -1, def.spec(), def.across));
    }
    part_id = world().add_body({.motion = Motion::kinematic, .shape = box});
    center.translation.y() = def.offset;
  }

  [[nodiscard]] World<double>& world() override { return sensors.world(); }
  [[nodiscard]] std::size_t missing() override { return sensors.report().missing_bodies; }
  [[nodiscard]] Vec3<double> part() const override { return center.translation; }
  [[nodiscard]] Vec3<double> pad(std::size_t k) const override { return {x_[k], 0, 0}; }
  void open(double gap, double speed) override {
    x_ = {x_[0] - gap, x_[1] + gap};
    v_ = {speed, -speed};
  }
  void step() override {
    sensors.step(*this, def.dt);
    std::array<double, 2> a{};
    for (std::size_t k = 0; k < 2; ++k) {
      a[k] = (side(k) * def.squeeze + given[k].force.x()) / pad_mass;
    }
    if (def.is_geared) a = {0.5 * (a[0] - a[1]), 0.5 * (a[1] - a[0])};
    for (std::size_t k = 0; k < 2; ++k) {
      v_[k] += def.dt * a[k];
      x_[k] += def.dt * v_[k];
    }
    twist.linear += def.dt * (gravity + given[2].force / def.mass);
    twist.angular += def.dt * (inverse_inertia_W() * (given[2].torque - gyroscopic()));
    center.translation += def.dt * twist.linear;
    center.rotation = step_rotation<double>(center.rotation, twist.angular, def.dt);
    given = {};
  }

  // Interface of `HostSensors`.

  [[nodiscard]] std::optional<HostBody<double>> body(BodyId id) const {
    HostBody<double> b;
    if (const auto k = pad_of(id)) {
      b.pose.translation = b.center = pad(*k);
      b.twist.linear = {v_[*k], 0, 0};
      b.acceleration.linear = {side(*k) * def.squeeze / pad_mass, 0, 0};
      if (def.is_geared) b.mechanism = 7;
      return b;
    }
    if (id != part_id) return {};
    b.pose = {center.rotation, center * Vec3<double>(0, -def.offset, 0)};
    b.center = center.translation;
    b.twist = twist;
    b.acceleration = {gravity, inverse_inertia_W() * -gyroscopic()};
    return b;
  }
  [[nodiscard]] Mat6<double> mobility(BodyId i, BodyId j) const {
    if (i == part_id) return free_mobility<double>(1 / def.mass, inverse_inertia_W());
    const double along = def.is_geared ? (i == j ? 0.5 : -0.5) : 1;
    Mat6<double> W = Mat6<double>::Zero();
    W(0, 0) = along / pad_mass;
    return W;
  }
  void apply_wrench(BodyId id, const Wrench<double>& w) { given[pad_of(id).value_or(2)] += w; }

 private:
  [[nodiscard]] static double side(std::size_t k) { return k == 0 ? 1 : -1; }
  [[nodiscard]] std::optional<std::size_t> pad_of(BodyId id) const {
    if (id == pads[0]) return std::size_t(0);
    if (id == pads[1]) return std::size_t(1);
    return {};
  }
  /// [kg m^2] Of a box of the part's size with its mass.
  [[nodiscard]] Vec3<double> inertia() const {
    return def.mass / 3 * Vec3<double>(2e-4, 1.25e-4, 1.25e-4);
  }
  [[nodiscard]] Mat3<double> inverse_inertia_W() const {
    const Mat3<double> R = center.rotation_matrix();
    return R * Vec3<double>(inertia().cwiseInverse()).asDiagonal() * R.transpose();
  }
  [[nodiscard]] Vec3<double> gyroscopic() const {
    const Mat3<double> R = center.rotation_matrix();
    const Vec3<double> momentum = R * inertia().cwiseProduct(R.transpose() * twist.angular);
    return twist.angular.cross(momentum);
  }

  /// [m], [m/s] Along x: where the pads are.
  std::array<double, 2> x_{-0.0101, 0.0101};
  std::array<double, 2> v_{};
};

}  // namespace bristle::scenes
