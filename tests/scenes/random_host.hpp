/// @file
/// An engine whose bodies are anywhere, move anyhow, and are sometimes gone or no numbers.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/hosts/host_sensors.hpp>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <random>

namespace bristle::scenes {

using namespace bristle::detail;

template <typename S>
class RandomHost {
 public:
  explicit RandomHost(std::uint64_t seed) : random_(seed) {
    const Shape<S> shapes[] = {Box<S>{{S(0.05), S(0.04), S(0.03)}}, Sphere<S>{S(0.05)},
                               Capsule<S>{S(0.03), S(0.04)}, Cylinder<S>{S(0.04), S(0.05)}};
    World<S>& world = sensors.world();
    (void)world.add_body({.motion = Motion::fixed, .shape = HalfSpace<S>{}});
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      BodyDef<S> def;
      def.motion = Motion::kinematic;
      def.shape = shapes[i % std::size(shapes)];
      // Not where the engine has it.
      def.center_of_mass = Vec3<S>(S(0.01), S(0), S(0));
      bodies_[i] = world.add_body(def);
      PatchDef<S> patch;
      patch.may_point_inwards = true;
      for (int k = 0; k < 20; ++k) {
        const S y = S(0.01) * (S(k % 5) - S(2));
        const S z = S(0.01) * (S(k / 5) - S(1.5));
        patch.sensors.add({S(0.03), y, z}, {S(0.09), y, z});
      }
      patch.parameters = {S(std::pow(10.0, within(3))), S(0.1), S(1000), S(0.3), S(1e-3)};
      if (i == 3) patch.integration = Integration::explicit_;
      (void)world.add_patch(bodies_[i], patch);
    }
  }

  HostSensors<S> sensors;
  /// [-] Wrenches that were applied, and those of them that were not finite.
  std::size_t given = 0;
  std::size_t bad = 0;

  /// One step, with all states chosen anew.
  /// @return Whether it was refused where its length is negative, and nowhere else.
  bool step() {
    for (std::optional<HostBody<S>>& state : states_) state = random_body();
    S dt = S(std::pow(10.0, -3 + within(2)));
    if (one_in(1000)) dt = -dt;
    try {
      sensors.step(*this, dt);
    } catch (const InvalidArgument& error) {
      return error.field() == "dt" && dt < S(0);
    }
    return dt > S(0);
  }

  // Interface that the sensors query.

  [[nodiscard]] std::optional<HostBody<S>> body(BodyId id) const { return states_[number(id)]; }
  [[nodiscard]] Mat6<S> mobility(BodyId i, BodyId j) const {
    // J M^-1 J^T of one joint for each two bodies; the same answer for the same question.
    const auto row = [](std::size_t n) {
      Vec6<S> J;
      for (Eigen::Index k = 0; k < 6; ++k) {
        J[k] = S(std::sin(1.7 * static_cast<double>(n) + static_cast<double>(k)));
      }
      return J;
    };
    Mat6<S> W = scale_ * row(number(i)) * row(number(j)).transpose();
    if (i == j) W += scale_ * Mat6<S>::Identity();
    return W;
  }
  void apply_wrench(BodyId, const Wrench<S>& wrench) {
    ++given;
    if (!wrench.force.allFinite() || !wrench.torque.allFinite()) ++bad;
  }

 private:
  [[nodiscard]] std::size_t number(BodyId id) const {
    std::size_t i = 0;
    while (bodies_[i] != id) ++i;
    return i;
  }
  double within(double size) {
    return std::uniform_real_distribution<double>(-size, size)(random_);
  }
  bool one_in(int times) { return std::uniform_int_distribution<int>(1, times)(random_) == 1; }
  /// Mostly of a usual size.
  S number(double size) {
    if (one_in(2000)) {
      using Limits = std::numeric_limits<S>;
      const S odd[] = {Limits::quiet_NaN(),
                       Limits::infinity(),
                       -Limits::max(),
                       Limits::max(),
                       std::sqrt(Limits::max()) / S(2),
                       Limits::min()};
      return odd[std::uniform_int_distribution<std::size_t>(0, std::size(odd) - 1)(random_)];
    }
    return S(within(size));
  }
  Vec3<S> vector(double size) {
    const S x = number(size);
    const S y = number(size);
    return {x, y, number(size)};
  }
  std::optional<HostBody<S>> random_body() {
    if (one_in(50)) return {};
    HostBody<S> body;
    const double speed = std::pow(10.0, within(2));
    const Vec3<S> axis = vector(1);
    body.pose.rotation = Quat<S>(number(1), axis.x(), axis.y(), axis.z());
    if (!one_in(100)) body.pose.rotation.normalize();
    body.pose.translation = vector(0.1);
    body.center = body.pose.translation;
    body.twist.linear = vector(speed);
    body.twist.angular = vector(speed);
    body.acceleration.linear = vector(100);
    body.acceleration.angular = vector(100);
    if (one_in(2)) body.mechanism = 1;
    scale_ = S(std::pow(10.0, within(6)));
    return body;
  }

  std::mt19937_64 random_;
  std::array<BodyId, 4> bodies_{};
  std::array<std::optional<HostBody<S>>, 4> states_{};
  S scale_ = S(1);
};

}  // namespace bristle::scenes
