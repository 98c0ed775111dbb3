/// @file
/// A part between two pads on slides, in an engine that is not ours: plain symplectic Euler over
/// bodies that know nothing of contact.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/hosts/host_sensors.hpp>
#include <bristle/math/rotation.hpp>
#include <bristle/sensors/tuning.hpp>

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

namespace bristle::scenes {

template <typename S>
struct HostPinchDef {
  /// [kg], [N], [m] Mass of the part, squeeze of each pad, and how far the part's centre of mass
  /// lies beside the pads along y.
  S mass = S(0.045);
  S squeeze = S(12);
  S offset = S(0);
  /// [1] Coulomb's coefficient, and [m] breakaway distance.
  S friction = S(0.7);
  S breakaway = S(1e-3);
  /// Whether one motor drives both pads against each other, as a gripper's does.
  bool is_geared = false;
};

/// Pads of 10 x 20 x 20 mm whose sensors start 3 mm below their faces and reach 5 mm beyond, and a
/// part of the same size.
template <typename S>
struct HostPinch {
  static constexpr S pad_mass = S(0.1);
  HostPinchDef<S> def;
  HostSensors<S> sensors;
  std::array<BodyId, 2> pads{};
  std::array<PatchId, 2> patches{};
  BodyId part{};
  /// [m], [m/s] Along x: where the pads are.
  std::array<S, 2> x{S(-0.0101), S(0.0101)};
  std::array<S, 2> v{S(0), S(0)};
  /// [m], [m/s, rad/s] Of the part's centre of mass.
  Transform<S> center{};
  Twist<S> twist{};
  Vec3<S> gravity = Vec3<S>::Zero();
  /// [m/s^2] Of all that is held by the ground: pads with their slides.
  Vec3<S> shake = Vec3<S>::Zero();
  std::array<Wrench<S>, 3> given{};

  explicit HostPinch(const HostPinchDef<S>& d) : def(d) {
    const Box<S> box{{S(0.005), S(0.01), S(0.01)}};
    World<S>& world = sensors.world();
    for (std::size_t k = 0; k < 2; ++k) {
      pads[k] = world.add_body({.motion = Motion::kinematic, .shape = box});
      patches[k] = world.add_patch(pads[k], pad(k == 0 ? S(1) : S(-1)));
    }
    BodyDef<S> part_def;
    part_def.motion = Motion::kinematic;
    part_def.shape = box;
    part = world.add_body(part_def);
    center.translation.y() = def.offset;
  }

  [[nodiscard]] PatchDef<S> pad(S side) const {
    PatchDef<S> patch;
    for (int i = 0; i < 36; ++i) {
      const S y = S(0.003) * (S(i % 6) - S(2.5));
      const S z = S(0.003) * (S(i / 6) - S(2.5));
      patch.sensors.add({side * S(0.002), y, z}, {side * S(0.010), y, z});
    }
    GripWants<S> wants;
    wants.friction = def.friction;
    wants.creep = def.breakaway;
    wants.load = def.squeeze;
    wants.mass = def.mass;
    wants.press = S(0.45);
    patch.parameters = tuned_for<S>(wants).parameters(patch.sensors);
    return patch;
  }

  /// [kg m^2] Of a box of the part's size with its mass.
  [[nodiscard]] Vec3<S> inertia() const {
    return def.mass / S(3) * Vec3<S>(S(2e-4), S(1.25e-4), S(1.25e-4));
  }
  [[nodiscard]] Mat3<S> inverse_inertia_W() const {
    const Mat3<S> R = center.rotation_matrix();
    return R * Vec3<S>(inertia().cwiseInverse()).asDiagonal() * R.transpose();
  }
  [[nodiscard]] std::optional<std::size_t> pad_of(BodyId id) const {
    if (id == pads[0]) return std::size_t(0);
    if (id == pads[1]) return std::size_t(1);
    return {};
  }

  [[nodiscard]] HostBody<S> body(BodyId id) const {
    HostBody<S> b;
    if (const auto k = pad_of(id)) {
      b.pose.translation = b.center = Vec3<S>(x[*k], S(0), S(0));
      b.twist.linear = Vec3<S>(v[*k], S(0), S(0));
      b.acceleration.linear =
          Vec3<S>((*k == 0 ? S(1) : S(-1)) * def.squeeze / pad_mass, S(0), S(0));
      if (def.is_geared) b.mechanism = 7;
      return b;
    }
    b.pose = {center.rotation, center * Vec3<S>(S(0), -def.offset, S(0))};
    b.center = center.translation;
    b.twist = twist;
    // In the frame of the slides.
    b.acceleration = {gravity - shake, inverse_inertia_W() * -gyroscopic()};
    return b;
  }
  [[nodiscard]] Vec3<S> gyroscopic() const {
    const Mat3<S> R = center.rotation_matrix();
    const Vec3<S> momentum = R * inertia().cwiseProduct(R.transpose() * twist.angular);
    return twist.angular.cross(momentum);
  }
  [[nodiscard]] Mat6<S> mobility(BodyId i, BodyId j) const {
    if (i == part) return free_mobility<S>(S(1) / def.mass, inverse_inertia_W());
    const S along = def.is_geared ? (i == j ? S(0.5) : S(-0.5)) : S(1);
    Mat6<S> W = Mat6<S>::Zero();
    W(0, 0) = along / pad_mass;
    return W;
  }
  void apply_wrench(BodyId id, const Wrench<S>& w) { given[pad_of(id).value_or(2)] += w; }

  void step(S dt) {
    sensors.step(*this, dt);
    std::array<S, 2> a{};
    for (std::size_t k = 0; k < 2; ++k) {
      a[k] = ((k == 0 ? def.squeeze : -def.squeeze) + given[k].force.x()) / pad_mass;
    }
    if (def.is_geared) a = {S(0.5) * (a[0] - a[1]), S(0.5) * (a[1] - a[0])};
    for (std::size_t k = 0; k < 2; ++k) {
      v[k] += dt * a[k];
      x[k] += dt * v[k];
    }
    const Wrench<S>& on_part = given[2];
    twist.linear += dt * (gravity - shake + on_part.force / def.mass);
    twist.angular += dt * (inverse_inertia_W() * (on_part.torque - gyroscopic()));
    center.translation += dt * twist.linear;
    center.rotation = step_rotation<S>(center.rotation, twist.angular, dt);
    given = {};
  }
  void run(S seconds, S dt) {
    const int steps = static_cast<int>(std::lround(static_cast<double>(seconds / dt)));
    for (int i = 0; i < steps; ++i) step(dt);
  }
};

}  // namespace bristle::scenes
