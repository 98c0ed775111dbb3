/// @file
/// Mechanisms without a world: bodies and joints for `MechanismIntegrator`, stepped one after the
/// other.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/joints/mechanism_integrator.hpp>
#include <bristle/math/rotation.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace bristle::test {

using namespace bristle::detail;

template <typename S>
struct Mechanism {
  MechanismIntegrator<S> integrator{};
  std::vector<MechanismBody<S>> bodies{};
  std::vector<MechanismJoint<S>> joints{};
  std::vector<Wrench<S>> impulses{};
  Vec3<S> gravity = Vec3<S>(0, 0, S(-9.81));

  std::uint32_t add_fixed(const Vec3<S>& position = Vec3<S>::Zero()) {
    MechanismBody<S> body;
    body.center_pose.translation = position;
    bodies.push_back(body);
    return static_cast<std::uint32_t>(bodies.size() - 1);
  }
  std::uint32_t add(S mass, const Mat3<S>& inertia, const Vec3<S>& position,
                    const Quat<S>& orientation = Quat<S>::Identity()) {
    MechanismBody<S> body;
    body.moves_by_forces = true;
    body.mass = mass;
    body.inertia_B = inertia;
    body.inverse_inertia_B = inertia.inverse();
    body.center_pose = {orientation, position};
    body.load.force = mass * gravity;
    bodies.push_back(body);
    return static_cast<std::uint32_t>(bodies.size() - 1);
  }
  /// Joins two bodies as they stand, at a point of the world and with x along `axis`.
  void join(JointKind kind, std::uint32_t a, std::uint32_t b, const Vec3<S>& point,
            const Vec3<S>& axis = Vec3<S>::UnitX()) {
    const Transform<S> X_WJ{exp_rotation<S>(shortest_turn<S>(Vec3<S>::UnitX(), axis)), point};
    joints.push_back({kind, a, b, bodies[a].center_pose.inverse() * X_WJ,
                      bodies[b].center_pose.inverse() * X_WJ});
  }

  bool step(S dt) {
    std::vector<Transform<S>> poses(bodies.size());
    std::vector<Twist<S>> twists(bodies.size());
    impulses.resize(joints.size());
    if (!integrator.advance(bodies, joints, dt, poses, twists, impulses)) return false;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      bodies[i].center_pose = poses[i];
      bodies[i].twist = twists[i];
    }
    return true;
  }
  bool run(S seconds, S dt) {
    const long steps = std::lround(static_cast<double>(seconds / dt));
    for (long i = 0; i < steps; ++i) {
      if (!step(dt)) return false;
    }
    return true;
  }

  [[nodiscard]] static Vec3<S> spin_of(const MechanismBody<S>& body) {
    const Mat3<S> R = body.center_pose.rotation_matrix();
    return R * (body.inertia_B * (R.transpose() * body.twist.angular));
  }
  /// [J] Kinetic energy and energy under the (constant) forces.
  [[nodiscard]] S energy() const {
    S sum = S(0);
    for (const MechanismBody<S>& body : bodies) {
      if (!body.moves_by_forces) continue;
      sum += S(0.5) *
             (body.mass * body.twist.linear.squaredNorm() + body.twist.angular.dot(spin_of(body)));
      sum -= body.load.force.dot(body.center_pose.translation);
    }
    return sum;
  }
  /// [N s, N m s] Momentum, and angular momentum about the world's origin.
  [[nodiscard]] Wrench<S> momentum() const {
    Wrench<S> sum;
    for (const MechanismBody<S>& body : bodies) {
      const Vec3<S> p = body.mass * body.twist.linear;
      sum += Wrench<S>{p, body.center_pose.translation.cross(p) + spin_of(body)};
    }
    return sum;
  }
  /// [m] Largest distance of two joint origins that a joint without a slide keeps together.
  [[nodiscard]] S largest_gap() const {
    S largest = S(0);
    for (const MechanismJoint<S>& joint : joints) {
      if (joint.kind == JointKind::prismatic) continue;
      const Vec3<S> p = bodies[joint.body_a].center_pose * joint.X_CmA_J.translation;
      const Vec3<S> q = bodies[joint.body_b].center_pose * joint.X_CmB_J.translation;
      largest = std::max(largest, (p - q).norm());
    }
    return largest;
  }
  /// [rad] Largest angle between the two axes of a hinge.
  [[nodiscard]] S largest_tilt() const {
    S largest = S(0);
    for (const MechanismJoint<S>& joint : joints) {
      if (joint.kind != JointKind::revolute) continue;
      const Vec3<S> x = Vec3<S>::UnitX();
      const Vec3<S> a = bodies[joint.body_a].center_pose.rotate(joint.X_CmA_J.rotate(x));
      const Vec3<S> b = bodies[joint.body_b].center_pose.rotate(joint.X_CmB_J.rotate(x));
      largest = std::max(largest, a.cross(b).norm());
    }
    return largest;
  }
};

/// Box of 1 kg, half sizes 0.1, 0.02, 0.02 m, about its centre.
template <typename S>
Mat3<S> link_inertia() {
  return Vec3<S>(S(2 * 0.02 * 0.02 / 3), S((0.01 + 0.0004) / 3), S((0.01 + 0.0004) / 3))
      .asDiagonal();
}

/// Chain of n such links along x; body 0 is fixed at the origin, where it hangs.
/// @param twist  [rad] Angle about x from y to the axis of the first joint, and from each to the
///               next.
template <typename S>
Mechanism<S> chain(int n, bool is_anchored = true, JointKind kind = JointKind::ball,
                   S twist = S(0)) {
  using std::cos;
  using std::sin;
  Mechanism<S> m;
  if (is_anchored) m.add_fixed();
  for (int i = 0; i < n; ++i) {
    const std::uint32_t link = m.add(S(1), link_inertia<S>(), {S(0.2) * S(i) + S(0.1), 0, 0});
    if (link == 0) continue;
    const S angle = twist * S(i + 1);
    m.join(kind, link - 1, link, {S(0.2) * S(i), 0, 0}, {S(0), cos(angle), sin(angle)});
  }
  return m;
}

/// [s] Period of a pendulum whose small swings take 2 pi / w0, by the arithmetic-geometric mean.
inline double pendulum_period(double w0, double amplitude) {
  double a = 1, b = std::cos(amplitude / 2);
  for (int i = 0; i < 10; ++i) {
    const double mean = (a + b) / 2;
    b = std::sqrt(a * b);
    a = mean;
  }
  return 2 * 3.14159265358979323846 / (w0 * a);
}

/// [1] Largest change of energy in a run of a chain of n links, relative to n m g times half its
/// length; infinite if a step fails.
template <typename S>
double chain_energy_error(Mechanism<S>& m, int n, double seconds, double dt) {
  const double start = static_cast<double>(m.energy());
  double worst = 0;
  for (long i = std::lround(seconds / dt); i > 0; --i) {
    if (!m.step(S(dt))) return std::numeric_limits<double>::infinity();
    worst = std::max(worst, std::abs(static_cast<double>(m.energy()) - start));
  }
  return worst / (n * 9.81 * n * 0.1);
}

}  // namespace bristle::test
