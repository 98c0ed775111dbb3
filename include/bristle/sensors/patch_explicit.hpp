/// @file
/// The explicit patch, and the choice between explicit and implicit.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/solver/solver_types.hpp>
#include <bristle/sensors/ambf_law.hpp>
#include <bristle/sensors/patch.hpp>
#include <bristle/sensors/patch_block.hpp>
#include <bristle/sensors/patch_contacts.hpp>
#include <bristle/sensors/patch_scratch.hpp>
#include <bristle/sensors/patch_touch.hpp>

namespace bristle::inline BRISTLE_ABI::detail {

/// Measures a pair before the step. Sets Lambda and the weights of the implicit scheme from the
/// sums over its contacts in `PatchPair::stiffness`.
///
/// Lambda = max over tangential and normal of w sum s + w_rot sum s |rho|^2. The sums run over the
/// sensors that are in contact or can be within the step, with s = dt^2 k_t + 2 dt mu_V or (dt^2
/// K_N + 2 dt K_D) / L. w and w_rot are thirds of the traces of the mobility's linear and angular
/// parts. Symplectic Euler is stable below 4 for one mode (docs/sensors.md). 0.5 leaves room for
/// traces that one axis dominates. Lambda is zero where nothing can move.
template <Scalar S>
void measure_pair(const SensorPatch<S>& patch, PatchPair<S>& pair, const SolverBody<S>& a,
                  const SolverBody<S>& b, S dt);

/// Evaluates every contact of a pair at the start of the step, under the law of the patch. Returns
/// the stored sum if the impulses were applied with the contacts.
/// @param parallel_for  Shares the contacts of a large patch; the impulses are the same bits.
/// @return [N s, N m s] The sum of the impulses on B about c.
template <Scalar S>
Wrench<S> explicit_impulses(SensorPatch<S>& patch, PatchScratch<S>& scratch,
                            const PatchPair<S>& pair, BodyId id_b, S dt,
                            const ParallelFor& parallel_for = serial_for);

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
void measure_pair(const SensorPatch<S>& patch, PatchPair<S>& pair, const SolverBody<S>& a,
                  const SolverBody<S>& b, S dt) {
  using std::max;
  const Mat6<S> W = mobility(a.inverse_mass, a.inverse_inertia, pair.arm_a) +
                    mobility(b.inverse_mass, b.inverse_inertia, pair.arm_b);
  const S w = quarter<0, 0, S>(W).trace() / S(3);
  const S w_rot = quarter<3, 3, S>(W).trace() / S(3);
  const PairStiffness<S>& k = pair.stiffness;
  // Shifts the moments from the patch's middle to c.
  const Vec3<S> shift = pair.center - patch.geometry->box.center();
  const S tangential_moment = k.tangential_second - S(2) * shift.dot(k.tangential_first) +
                              shift.squaredNorm() * k.tangential;
  const S normal_moment =
      k.normal_second - S(2) * shift.dot(k.normal_first) + shift.squaredNorm() * k.normal;
  pair.lambda =
      max(w * k.tangential + w_rot * tangential_moment, w * k.normal + w_rot * normal_moment);
  set_scheme(pair, k.bristle_sum, k.viscous_sum, w, dt);
}

/// `explicit_impulses` under AMBF's law, one sensor after the other.
template <Scalar S>
Wrench<S> ambf_impulses(SensorPatch<S>& patch, PatchScratch<S>& scratch, const PatchPair<S>& pair,
                        BodyId id_b, S dt) {
  Wrench<S> sum;
  for (ContactPacket<S>& packet : contacts_of(scratch, pair)) {
    BristlePacket<S>& bristles = patch.bristles[packet.packet];
    LaneBits& anchored = patch.is_anchored[packet.packet];
    packet.is_slipping = 0;
    for (std::size_t i = 0; i < packet_size; ++i) {
      const LaneBits bit = static_cast<LaneBits>(1u << i);
      packet.impulse.set(i, zero<Vec3<S>>());
      packet.normal_impulse[i] = S(0);
      if ((packet.is_in_contact & bit) == 0) continue;
      const auto [n, g, point, depth, inverse_length] =
          touch_of(*patch.geometry, scratch.hits, packet.packet * packet_size + i);
      const SensorContact<S> contact{depth, inverse_length, n, g, pair.start_motion.at(point)};
      Anchor<S> anchor{bristles.anchor_a[i], bristles.anchor_b[i]};
      BodyId& body = patch.readings.body[packet.packet * packet_size + i];
      bool is_anchored = (anchored & bit) != 0 && body == id_b;
      bool did_slip = false;
      const SensorForce<S> force = ambf_sensor_force<S>(
          patch.parameters(packet.packet * packet_size + i), patch.def.options.scaling, contact,
          g.normalized() * S(-1), pair.pose, point, anchor, is_anchored, did_slip);
      bristles.anchor_a.set(i, anchor.q_A);
      bristles.anchor_b.set(i, anchor.q_B);
      anchored = static_cast<LaneBits>(is_anchored ? anchored | bit : anchored & ~bit);
      if (is_anchored) body = id_b;
      if (did_slip) packet.is_slipping = static_cast<LaneBits>(packet.is_slipping | bit);
      packet.normal_impulse[i] = dt * force.normal;
      packet.impulse.set(i, dt * force.total());
      sum += Wrench<S>::at(point - pair.center, packet.impulse[i]);
    }
  }
  return {pair.R_WA * sum.force, pair.R_WA * sum.torque};
}

/// Impulses of some contacts at the start of the step, under the paper's law.
template <Scalar S>
void apply_at_start(const SensorPatch<S>& patch, const RayHits<S>& hits, const PatchPair<S>& pair,
                    std::span<ContactPacket<S>> packets, const LaneParameters<S>& parameters, S dt,
                    LaneWrench<S>& total) {
  const LawOptions options = patch.def.options;
  const LaneMotion<S> start(pair.start_motion.linear, pair.start_motion.angular);
  const Pack3<S> center = Pack3<S>::all(pair.center);
  LaneWrench<S> sum;
  SensorParameters<Pack<S>> scratch;
  for (ContactPacket<S>& packet : packets) {
    const RayPacket<S>& rays = patch.geometry->packets[packet.packet];
    for (std::size_t at = 0; at < packet_size; at += lanes<S>) {
      if (pack_bits<S>(packet.is_in_range, at) == 0) continue;
      const TouchPack<S> touch(hits, rays, packet.packet, at, packet.is_in_range, false);
      const SensorContact<Pack<S>> contact{touch.depth, touch.inverse_length, touch.n, touch.g,
                                           start.at(touch.point)};
      apply_impulses<S>(packet, at, parameters(packet.packet, at, scratch), options, contact,
                        load_pack(packet.stretch, at), touch.point - center,
                        load_mask<S>(packet.is_in_contact, at), dt, sum.force, sum.torque);
    }
  }
  total = sum;
}

/// `explicit_impulses` under the paper's law.
template <Scalar S>
Wrench<S> paper_impulses(const SensorPatch<S>& patch, PatchScratch<S>& scratch,
                         const PatchPair<S>& pair, S dt, const ParallelFor& parallel_for) {
  using Sum = LaneWrench<S>;
  const LaneParameters<S> parameters(patch.def);
  return sum_of_contacts<Sum>(contacts_of(scratch, pair), parallel_for,
                              [&](std::span<ContactPacket<S>> packets, Sum& part) {
                                apply_at_start<S>(patch, scratch.hits, pair, packets, parameters,
                                                  dt, part);
                              })
      .in_world(pair);
}

template <Scalar S>
Wrench<S> explicit_impulses(SensorPatch<S>& patch, PatchScratch<S>& scratch,
                            const PatchPair<S>& pair, BodyId id_b, S dt,
                            const ParallelFor& parallel_for) {
  if (pair.is_applied) {
    return {pair.R_WA * pair.applied.force, pair.R_WA * pair.applied.torque};
  }
  return patch.def.options.law == Law::ambf
             ? ambf_impulses(patch, scratch, pair, id_b, dt)
             : paper_impulses(patch, scratch, pair, dt, parallel_for);
}

}  // namespace bristle::inline BRISTLE_ABI::detail
