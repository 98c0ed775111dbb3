/// @file
/// A patch evaluated one sensor after the other, in plain scalars: what lanes are measured against.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/sensors/linear_model.hpp>
#include <bristle/sensors/patch_scratch.hpp>
#include <bristle/sensors/patch_touch.hpp>

#include <vector>

namespace bristle::test {

using namespace bristle::detail;

/// The contact in lane i of a packet as one of scalars, before anything is linearised.
template <Scalar S>
PatchContact<S> scalar_contact(const SensorPatch<S>& patch, const RayHits<S>& hits,
                               const PatchPair<S>& pair, const ContactPacket<S>& packet,
                               std::size_t i) {
  PatchContact<S> c;
  c.is_in_contact = (packet.is_in_contact >> i & 1u) != 0;
  const SensorTouch<S> touch = touch_of(*patch.geometry, hits, packet.packet * packet_size + i);
  c.n = touch.n;
  c.g = touch.g;
  c.rho = touch.point - pair.center;
  c.stretch = packet.stretch[i];
  c.start_velocity = pair.start_motion.at(touch.point);
  c.depth = touch.depth;
  c.inverse_length = touch.inverse_length;
  c.force = c.is_in_contact ? normal_force<S>(patch.parameters(packet.packet * packet_size + i),
                                              c.depth, c.g.dot(c.start_velocity) * c.inverse_length)
                            : S(0);
  return c;
}

/// All contacts of a pair, in order.
template <Scalar S>
std::vector<PatchContact<S>> scalar_contacts(const SensorPatch<S>& patch,
                                             const PatchScratch<S>& scratch,
                                             const PatchPair<S>& pair) {
  std::vector<PatchContact<S>> contacts;
  for (std::uint32_t k = pair.first; k < pair.first + pair.count; ++k) {
    for (std::size_t i = 0; i < packet_size; ++i) {
      if ((scratch.contacts[k].is_in_range >> i & 1u) == 0) continue;
      contacts.push_back(scalar_contact(patch, scratch.hits, pair, scratch.contacts[k], i));
    }
  }
  return contacts;
}

/// `start_linearisation` of one contact under shared constants.
template <Scalar S>
void linearise_start(const SensorPatch<S>& patch, const PatchPair<S>& pair, PatchContact<S>& c,
                     S dt) {
  const SensorParameters<S>& p = patch.def.parameters;
  detail::linearise_normal<S>(p, c, dt);
  c.is_loaded = c.normal_constant + c.a_normal * c.g.dot(c.start_velocity) > S(0);
  c.normal_impulse = dt * c.force;
  detail::linearise<S>(p, patch.def.options, pair, c, c.start_velocity, dt);
  if (!c.is_loaded) c.a_normal = S(0);
}

/// [N s, N m s] `start_linearisation` and `evaluate` of a pair: what its contacts give
/// about c at the motion u, in A's axes.
template <Scalar S>
Wrench<S> scalar_block_impulse(const SensorPatch<S>& patch, const PatchScratch<S>& scratch,
                               const PatchPair<S>& pair, const Vec6<S>& motion, S dt) {
  Wrench<S> sum;
  for (PatchContact<S>& c : scalar_contacts(patch, scratch, pair)) {
    linearise_start(patch, pair, c, dt);
    const Vec3<S> v =
        detail::velocity_at<S>(motion.template head<3>(), motion.template tail<3>(), c.rho);
    Vec3<S> impulse = detail::model_impulse<S>(c, v);
    if (c.is_loaded && impulse.dot(c.n) < S(0)) impulse = tangential<S>(impulse, c.n);
    sum += Wrench<S>::at(c.rho, impulse);
  }
  return sum;
}

}  // namespace bristle::test
