/// @file
/// Makes the report of a patch: on its body, and among the bodies that it may sense.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/sensors/patch_report.hpp>
#include <bristle/world/outward_rays.hpp>
#include <bristle/world/patch_rays.hpp>
#include <bristle/world/world_state.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// Reports the weight of a body, if it has one.
template <Scalar S>
void add_weight(const WorldState<S>& state, const Body<S>& body, PatchReport<S>& report) {
  using std::abs;
  if (body.motion != Motion::dynamic) return;
  const S weight = body.mass * abs(body.gravity_scale) * state.def.gravity.norm();
  if (!(weight > S(0))) return;
  report.least_weight =
      report.largest_weight > S(0) ? std::min(report.least_weight, weight) : weight;
  report.largest_weight = std::max(report.largest_weight, weight);
}

/// Report of a patch of the world.
template <Scalar S>
PatchReport<S> report_patch(const WorldState<S>& state, const SensorPatch<S>& patch) {
  PatchReport<S> report;
  const Body<S>& own = state.bodies.at(patch.body.index);
  const DynamicArray<S> outside = lengths_outside(state, patch.body.index, patch, own.center_B);
  for (std::size_t i = 0; i < outside.size(); ++i) {
    report.share_outside.push_back(outside[i] / patch.geometry->length[i]);
    report.largest_load += patch.parameters(i).normal_stiffness;
  }
  report.intended_load = patch.def.load;
  const PatchReading<S> reading = patch.readings.view();
  report.load = reading.total_normal();
  report.bottomed_out = reading.bottomed_out();
  add_weight(state, own, report);
  for (const std::uint32_t tag : state.colliders.live_slots()) {
    const Collider<S>& c = state.colliders.at(tag);
    if (senses(state, patch, c)) add_weight(state, state.body_of(c), report);
  }
  return report;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
