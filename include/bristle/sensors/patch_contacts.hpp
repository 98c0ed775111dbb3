/// @file
/// From hits to contacts: sorts the hits of a patch by touched body and advances its bristles.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/sensors/patch.hpp>

namespace bristle {

/// A body that a ray met.
template <Scalar S>
struct TouchedBody {
  const Body<S>* body = nullptr;
  BodyId id{};
};

/// Makes a patch read and remember nothing. Costs nothing when it does so already.
template <Scalar S>
void clear_patch(SensorPatch<S>& patch);

/// Fills `contacts` and `pairs` from `hits`; a sensor without a hit lets go of what it held. For
/// the paper's law the bristles are advanced too.
///
/// @param A        The patch's own body.
/// @param find     Callable: TouchedBody<S> find(tag), the body that owns the shape with that tag.
template <Scalar S, typename FindBody>
void collect_contacts(SensorPatch<S>& patch, const Body<S>& A, FindBody&& find);

// Implementation -----------------------------------------------------------------------------------

template <Scalar S>
void clear_patch(SensorPatch<S>& patch) {
  for (const std::uint32_t i : patch.felt) patch.readings.clear(i);
  for (const PatchContact<S>& c : patch.contacts) patch.release(c.sensor);
  patch.felt.clear();
  patch.contacts.clear();
  patch.pairs.clear();
  patch.last_impulses.clear();
  patch.readings.wrench = {};
  patch.readings.shear_W.setZero();
}

namespace detail {

/// One contact from sensor i's hit on the body of `pair`; false when the touch is grazing.
template <Scalar S>
bool fill_contact(SensorPatch<S>& patch, std::size_t i, const PatchPair<S>& pair, const Body<S>& A,
                  const Body<S>& B, PatchContact<S>& c) {
  c.n = pair.pose.R_WA * patch.direction[i];
  const Vec3<S> m = pair.pose.R_WA * patch.hits.normal[i];
  if (!(m.dot(c.n) <= grazing_cosine<S>))
    return false;  // False for a normal that is no number, too.
  c.sensor = static_cast<std::uint32_t>(i);
  c.g = depth_gradient(c.n, m);
  c.length = patch.length[i];
  c.depth = sensor_depth(patch.hits.distance[i], c.length);
  c.is_touching = c.depth > S(0);
  c.rho = pair.pose.R_WA * (patch.start[i] + patch.hits.distance[i] * patch.direction[i]);
  c.start_velocity = A.twist.at(c.rho) - B.twist.at(c.rho - pair.pose.p_AB_W);
  return true;
}

/// Advances the bristle of a contact; a surface the ray does not reach yet lets go of it.
template <Scalar S>
void advance_bristle(SensorPatch<S>& patch, const PatchPair<S>& pair, BodyId id_b,
                     PatchContact<S>& c) {
  if (!c.is_touching) {
    patch.release(c.sensor);
    return;
  }
  Anchor<S> anchor{patch.root_a[c.sensor], patch.root_b[c.sensor]};
  c.stretch = advance_anchor(anchor, patch.rooted_in[c.sensor] == id_b, pair.pose, c.n, c.rho,
                             patch.parameters(c.sensor).breakaway_distance, patch.def.options.reset,
                             c.is_slipping);
  patch.root_a.set(c.sensor, anchor.q_A);
  patch.root_b.set(c.sensor, anchor.q_B);
  patch.rooted_in[c.sensor] = id_b;
}

}  // namespace detail

template <Scalar S, typename FindBody>
void collect_contacts(SensorPatch<S>& patch, const Body<S>& A, FindBody&& find) {
  patch.contacts.clear();
  patch.pairs.clear();
  const std::size_t n = patch.size();
  // Which bodies were met at all; nearly always one or two, so a linear search serves.
  for (std::size_t i = 0; i < n; ++i) {
    if (!patch.hits.is_hit(i)) {
      patch.release(i);
      continue;
    }
    const std::uint32_t slot = find(patch.hits.tag[i]).id.index;
    bool is_known = false;
    for (const PatchPair<S>& pair : patch.pairs) is_known = is_known || pair.body_b == slot;
    if (!is_known) patch.pairs.emplace_back().body_b = slot;
  }
  const Mat3<S> R_WA = A.center_pose.rotation_matrix();
  for (PatchPair<S>& pair : patch.pairs) {
    pair.first = static_cast<std::uint32_t>(patch.contacts.size());
    const Body<S>* B = nullptr;
    Vec3<S> sum = Vec3<S>::Zero();
    for (std::size_t i = 0; i < n; ++i) {
      if (!patch.hits.is_hit(i)) continue;
      const TouchedBody<S> touched = find(patch.hits.tag[i]);
      if (touched.id.index != pair.body_b) continue;
      if (B == nullptr) {
        B = touched.body;
        pair.pose = {R_WA, B->center_pose.rotation_matrix(),
                     B->center_pose.translation - A.center_pose.translation};
      }
      PatchContact<S> contact;
      if (!detail::fill_contact(patch, i, pair, A, *B, contact)) {
        patch.release(i);
        continue;
      }
      if (patch.def.options.law == Law::paper) {
        detail::advance_bristle(patch, pair, touched.id, contact);
      }
      sum += contact.rho;
      patch.contacts.push_back(contact);
    }
    pair.count = static_cast<std::uint32_t>(patch.contacts.size()) - pair.first;
    if (pair.count == 0) continue;
    // Moments are taken about the middle of the contacts, where they are smallest.
    pair.arm_a = sum / S(pair.count);
    pair.arm_b = pair.arm_a - pair.pose.p_AB_W;
    for (std::uint32_t k = 0; k < pair.count; ++k) {
      patch.contacts[pair.first + k].rho -= pair.arm_a;
    }
  }
}

}  // namespace bristle
