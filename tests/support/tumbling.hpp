/// @file
/// How a body that nothing acts on turns: Euler's equations by Runge-Kutta of fourth order.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/types.hpp>

namespace bristle::test {

/// Attitude after `duration` [s] of a body that starts along the world's axes.
/// @param moments  [kg m^2] Along its own axes.
/// @param spin     [rad/s] At the start.
/// @param steps    [-] With 20 to 50 us each the error is that of round-off, up to 1e-12.
[[nodiscard]] inline Quat<double> tumbled_attitude(const Vec3<double>& moments,
                                                   const Vec3<double>& spin, double duration,
                                                   int steps) {
  struct State {
    Vec3<double> w;
    Eigen::Vector4d q;
  };
  const auto rate = [&](const State& s) {
    const Vec3<double> l = moments.cwiseProduct(s.w);
    const Quat<double> turn(0, s.w.x(), s.w.y(), s.w.z());
    return State{Vec3<double>(l.cross(s.w)).cwiseQuotient(moments),
                 0.5 * (Quat<double>(s.q) * turn).coeffs()};
  };
  const auto ahead = [](const State& s, double h, const State& d) {
    return State{s.w + h * d.w, s.q + h * d.q};
  };
  const double h = duration / steps;
  State s{spin, Quat<double>::Identity().coeffs()};
  for (int i = 0; i < steps; ++i) {
    const State a = rate(s);
    const State b = rate(ahead(s, h / 2, a));
    const State c = rate(ahead(s, h / 2, b));
    const State d = rate(ahead(s, h, c));
    s.w += h / 6 * (a.w + 2 * b.w + 2 * c.w + d.w);
    s.q += h / 6 * (a.q + 2 * b.q + 2 * c.q + d.q);
    s.q.normalize();
  }
  return Quat<double>(s.q);
}

}  // namespace bristle::test
