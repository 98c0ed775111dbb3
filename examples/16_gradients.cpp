// Two questions that a grip is asked by gradient: how little force holds, and what is this skin?
//
// A world of `Dual` numbers computes with every number its derivatives by those that were marked as
// variables, here two at most. With them
//   (a) Newton's method finds the force with which a box sags by half of what lets bristles slip:
//       a grip twice as strong as it must be. Closed form: F = m g / (2 mu_S sag).
//   (b) the method of Gauss and Newton finds mu_S and mu_V of a skin from 30 noisy heights of the
//       box as it sags.
// Expected output: 16_gradients.expected
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/bristle.hpp>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <vector>

namespace {

using namespace bristle;
using D = Dual<double, 2>;

constexpr double mass = 0.5;      // kg
constexpr double gravity = 9.81;  // m/s^2

// Heights of a box that two fingers of a skin hold with a force each, `count` of them, 10 ms apart,
// from when its weight comes to bear. In S = double a measurement, in duals with derivatives.
template <typename S>
std::vector<S> heights(S force, const SensorParameters<S>& skin, int count) {
  World<S> world({.gravity = {0, 0, 0}, .time_step = 1e-3});
  const BodyId box =
      world.add_body({.mass = mass, .shape = Box<S>{.half_extents = {0.03, 0.02, 0.03}}});
  const BodyId palm = world.add_body({.motion = Motion::kinematic});
  for (const double side : {-1.0, 1.0}) {
    const Transform<S> start{Quat<S>::Identity(), {0, side * 0.033, 0}};
    const Transform<S> towards_box{exp_rotation<S>({0, 0, -side * std::numbers::pi / 2})};
    const BodyId finger = world.add_body({.mass = 0.2,
                                          .shape = Box<S>{.half_extents = {0.015, 0.01, 0.015}},
                                          .position = start.translation});
    world.add_joint({.kind = JointKind::prismatic,
                     .body_a = palm,
                     .body_b = finger,
                     .X_AJ = start * towards_box,
                     .X_BJ = towards_box,
                     .motor = {MotorMode::velocity, 0.1, force}});
    world.add_patch(finger,
                    sensor_grid<S>({.center = {0, -side * 0.01, 0},
                                    .side_u = {0.03, 0, 0},
                                    .side_v = {0, 0, side * 0.03},
                                    .count_u = 6,
                                    .count_v = 6}),
                    skin);
  }
  for (int i = 0; i < 200; ++i) world.step();
  world.set_gravity({0, 0, -gravity});
  std::vector<S> result;
  for (int k = 0; k < count; ++k) {
    for (int i = 0; i < 10; ++i) world.step();
    result.push_back(world.pose(box).translation.z());
  }
  return result;
}

}  // namespace

int main() {
  // K_N, K_D, mu_S, mu_V, sigma_a: slips at mu_S sigma_a = 0.8 of the force.
  const SensorParameters<double> skin{1.5, 0.05, 800, 1.2, 1e-3};

  const double wanted = 0.5 * skin.breakaway_distance;
  double force = 4;
  for (int iteration = 0; iteration < 5; ++iteration) {
    const SensorParameters<D> constant{1.5, 0.05, 800, 1.2, 1e-3};
    const D sag = -heights<D>(D::variable(force), constant, 30).back();
    std::printf("force %.4f N: sag %.2f um, %.2f um/N\n", force, 1e6 * sag.value(),
                1e6 * sag.partial());
    force += (wanted - sag.value()) / sag.partial();
  }
  std::printf("smallest force %.3f N, closed form %.3f N\n", force,
              mass * gravity / (2 * skin.static_friction * wanted));

  // The measurement: another skin, and 5 um of noise.
  SensorParameters<double> hidden = skin;
  hidden.static_friction = 650;
  hidden.sliding_friction = 0.9;
  const double noise = 5e-6;
  std::vector<double> measured = heights<double>(10, hidden, 30);
  std::mt19937 random(16);
  for (double& height : measured) {
    double sum = -6;  // Of twelve uniform numbers: nearly normal, of deviation 1.
    for (int i = 0; i < 12; ++i) sum += double(random()) / 0x1p32;
    height += noise * sum;
  }

  Eigen::Vector2d guess(400, 2);
  Eigen::Matrix2d certainty;
  for (int iteration = 0; iteration < 5; ++iteration) {
    SensorParameters<D> model{1.5, 0.05, D::variable(guess[0], 0), D::variable(guess[1], 1), 1e-3};
    const std::vector<D> modelled = heights<D>(10, model, 30);
    certainty.setZero();
    Eigen::Vector2d pull = Eigen::Vector2d::Zero();
    double square = 0;
    for (std::size_t k = 0; k < measured.size(); ++k) {
      const double rest = measured[k] - modelled[k].value();
      const Eigen::Vector2d slope(modelled[k].partial(0), modelled[k].partial(1));
      certainty += slope * slope.transpose();
      pull += rest * slope;
      square += rest * rest;
    }
    std::printf("mu_S %.2f 1/m, mu_V %.3f N s/m: misses by %.2f um\n", guess[0], guess[1],
                1e6 * std::sqrt(square / double(measured.size())));
    guess += certainty.inverse() * pull;
  }
  const Eigen::Matrix2d spread = noise * noise * certainty.inverse();
  std::printf("mu_S %.1f of 650, off by %.1f deviations\n", guess[0],
              std::abs(guess[0] - 650) / std::sqrt(spread(0, 0)));
  std::printf("mu_V %.3f of 0.9, off by %.1f deviations\n", guess[1],
              std::abs(guess[1] - 0.9) / std::sqrt(spread(1, 1)));
}
