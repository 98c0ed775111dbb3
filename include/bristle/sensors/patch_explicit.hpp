/// @file
/// The explicit patch, the choice between explicit and implicit, and what a patch finally reads.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/solver_types.hpp>
#include <bristle/math/rotation.hpp>
#include <bristle/sensors/ambf_law.hpp>
#include <bristle/sensors/patch.hpp>
#include <bristle/sensors/patch_block.hpp>

namespace bristle {

/// Measures a pair before the step: sets Lambda and the weights of the implicit scheme.
///
/// Lambda = max over tangential and normal of w sum s + w_rot sum s |rho|^2 over the sensors that
/// touch or can reach the body within the step, with s = dt^2 k_t + 2 dt mu_V or (dt^2 K_N + 2 dt
/// K_D) / L, and thirds of the traces of the mobility's linear and angular parts. Symplectic Euler
/// is stable below 4 for one mode (docs/sensors.md); 0.5 leaves room for traces that one axis
/// dominates. Zero where nothing can move.
template <Scalar S>
void measure_pair(const SensorPatch<S>& patch, PatchPair<S>& pair, const SolverBody<S>& a,
                  const SolverBody<S>& b, S dt);

/// Evaluates every contact of a pair at the start of the step, under the law of the patch.
/// @return [N s, N m s] The sum of the impulses on B about c.
template <Scalar S>
Wrench<S> explicit_impulses(SensorPatch<S>& patch, const PatchPair<S>& pair, BodyId id_b, S dt);

/// Turns the impulses of all contacts into readings.
/// @param R_AW     [1] World axes in A: rotation from the world into the patch's body.
/// @param origin   [m] A's centre of mass in the world.
/// @param find_id  Callable: BodyId find_id(slot).
template <Scalar S, typename FindId>
void fill_readings(SensorPatch<S>& patch, const Mat3<S>& R_AW, const Vec3<S>& origin, S dt,
                   FindId&& find_id);

// Implementation -----------------------------------------------------------------------------------

template <Scalar S>
void measure_pair(const SensorPatch<S>& patch, PatchPair<S>& pair, const SolverBody<S>& a,
                  const SolverBody<S>& b, S dt) {
  using std::max;
  S bristle_sum = S(0);
  S viscous_sum = S(0);
  // Sums of s, and of s |rho|^2.
  S tangential_sum = S(0), tangential_moment = S(0);
  S normal_sum = S(0), normal_moment = S(0);
  for (std::uint32_t k = pair.first; k < pair.first + pair.count; ++k) {
    const PatchContact<S>& c = patch.contacts[k];
    const SensorParameters<S>& p = patch.parameters(c.sensor);
    const S arm2 = c.rho.squaredNorm();
    const S normal = (dt * dt * p.normal_stiffness + S(2) * dt * p.normal_damping) / c.length;
    normal_sum += normal;
    normal_moment += normal * arm2;
    if (!c.is_touching) continue;
    const S force = normal_force(p, c.depth, c.g.dot(c.start_velocity) / c.length);
    const S k_t = bristle_stiffness(p, patch.def.options.scaling, force, c.depth);
    bristle_sum += k_t;
    viscous_sum += p.sliding_friction;
    const S shear = dt * dt * k_t + S(2) * dt * p.sliding_friction;
    tangential_sum += shear;
    tangential_moment += shear * arm2;
  }
  const Mat6<S> W = mobility(a.inverse_mass, a.inverse_inertia, pair.arm_a) +
                    mobility(b.inverse_mass, b.inverse_inertia, pair.arm_b);
  const S w = W.template topLeftCorner<3, 3>().trace() / S(3);
  const S w_rot = W.template bottomRightCorner<3, 3>().trace() / S(3);
  pair.lambda =
      max(w * tangential_sum + w_rot * tangential_moment, w * normal_sum + w_rot * normal_moment);
  set_scheme(pair, bristle_sum, viscous_sum, w, dt);
}

template <Scalar S>
Wrench<S> explicit_impulses(SensorPatch<S>& patch, const PatchPair<S>& pair, BodyId id_b, S dt) {
  Wrench<S> sum;
  const LawOptions& options = patch.def.options;
  for (std::uint32_t k = pair.first; k < pair.first + pair.count; ++k) {
    PatchContact<S>& c = patch.contacts[k];
    c.normal_impulse = S(0);
    c.impulse.setZero();
    if (!c.is_touching) continue;
    const SensorParameters<S>& p = patch.parameters(c.sensor);
    const SensorContact<S> contact{c.depth, c.length, c.n, c.g, c.start_velocity};
    SensorForce<S> force;
    if (options.law == Law::ambf) {
      Anchor<S> anchor{patch.root_a[c.sensor], patch.root_b[c.sensor]};
      bool is_rooted = patch.rooted_in[c.sensor] == id_b;
      const Vec3<S> m = c.g.normalized() * S(-1);
      force = ambf_sensor_force(p, options.scaling, contact, m, pair.pose,
                                Vec3<S>(c.rho + pair.arm_a), anchor, is_rooted, c.is_slipping);
      patch.root_a.set(c.sensor, anchor.q_A);
      patch.root_b.set(c.sensor, anchor.q_B);
      patch.rooted_in[c.sensor] = is_rooted ? id_b : BodyId{};
    } else {
      force = sensor_force(p, options, contact, c.stretch, dt);
    }
    c.normal_impulse = dt * force.normal;
    c.impulse = dt * force.total();
    sum += Wrench<S>::at(c.rho, c.impulse);
  }
  return sum;
}

template <Scalar S, typename FindId>
void fill_readings(SensorPatch<S>& patch, const Mat3<S>& R_AW, const Vec3<S>& origin, S dt,
                   FindId&& find_id) {
  ReadingStore<S>& out = patch.readings;
  for (const std::uint32_t i : patch.felt) out.clear(i);
  patch.felt.clear();
  out.wrench = {};
  out.shear_W.setZero();
  for (const PatchPair<S>& pair : patch.pairs) {
    const BodyId id = find_id(pair.body_b);
    for (std::uint32_t k = pair.first; k < pair.first + pair.count; ++k) {
      const PatchContact<S>& c = patch.contacts[k];
      if (!c.is_touching && !(c.normal_impulse > S(0))) continue;
      const std::size_t i = c.sensor;
      const Vec3<S> arm = c.rho + pair.arm_a;
      const Vec3<S> force = c.impulse / -dt;
      const Vec3<S> shear = tangential(force, c.n);
      out.depth[i] = c.is_touching ? c.depth : S(0);
      out.normal_force[i] = c.normal_impulse / dt;
      Vec3<S> t1, t2;
      tangent_basis<S>(patch.direction[i], t1, t2);
      const Vec3<S> shear_A = R_AW * shear;
      out.shear_1[i] = t1.dot(shear_A);
      out.shear_2[i] = t2.dot(shear_A);
      out.point.set(i, origin + arm);
      out.body[i] = id;
      out.state[i] = c.is_slipping ? SensorState::slipping : SensorState::stuck;
      out.wrench += Wrench<S>::at(arm, force);
      out.shear_W += shear;
      patch.felt.push_back(c.sensor);
    }
  }
}

}  // namespace bristle
