/// @file
/// Events of patches: which body a patch begins and ceases to touch, kept until a caller reads
/// them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/dynamics/bodies/body.hpp>
#include <bristle/sensors/patch.hpp>
#include <bristle/sensors/patch_def.hpp>
#include <bristle/sensors/sensor_packets.hpp>

#include <algorithm>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace bristle::inline BRISTLE_ABI {

/// A patch and a body that began to touch, or no longer do. They *touch* in a step when a reading
/// of the patch names the body.
struct TouchEvent {
  /// [-] Patch. After an end it may be removed, as may the body.
  PatchId patch{};
  /// [-] Body that its sensors touch.
  BodyId body{};
  /// True for a begin, false for an end.
  bool begins = false;
};

namespace detail {

/// The touches that a caller was told of, and the events since the caller last cleared them. What
/// is known is compared with readings after each step, so that steps cost nothing more where nobody
/// listens.
class TouchLog {
 public:
  /// Starts or ends to listen. Both forget all touches and events.
  void listen(bool is_on) {
    is_on_ = is_on;
    known_.clear();
    events_.clear();
  }
  [[nodiscard]] const DynamicArray<TouchEvent>& events() const { return events_; }
  void clear_events() { events_.clear(); }

  /// Compares the readings of all patches with what is known.
  /// @param patches  `SlotMap` of `SensorPatch`.
  template <typename Patches>
  void update(const Patches& patches);

 private:
  struct Touch {
    PatchId patch{};
    BodyId body{};
    friend auto operator<=>(const Touch&, const Touch&) = default;
  };

  template <Scalar S>
  void find(PatchId id, const SensorPatch<S>& patch);

  bool is_on_ = false;
  /// Sorted.
  DynamicArray<Touch> known_, found_;
  DynamicArray<TouchEvent> events_;
};

// Implementation ----------------------------------------------------------------------------------

template <typename Patches>
void TouchLog::update(const Patches& patches) {
  if (!is_on_) return;
  found_.clear();
  for (const std::uint32_t i : patches.live_slots()) find(patches.handle(i), patches.at(i));
  std::sort(found_.begin(), found_.end());
  found_.erase(std::unique(found_.begin(), found_.end()), found_.end());
  const auto add_missing = [this](const auto& from, const auto& in, bool begins) {
    for (const Touch& touch : from) {
      if (std::binary_search(in.begin(), in.end(), touch)) continue;
      events_.push_back({touch.patch, touch.body, begins});
    }
  };
  add_missing(known_, found_, false);
  add_missing(found_, known_, true);
  std::swap(known_, found_);
}

/// Finds the bodies that a patch touches; neighbours mostly touch the same.
template <Scalar S>
void TouchLog::find(PatchId id, const SensorPatch<S>& patch) {
  BodyId last{};
  for (std::size_t packet = 0; packet < patch.active_lanes.size(); ++packet) {
    if (patch.active_lanes[packet] == 0) continue;
    for (std::size_t lane = 0; lane < packet_size; ++lane) {
      if ((patch.active_lanes[packet] >> lane & 1u) == 0) continue;
      const BodyId body = patch.readings.body[packet * packet_size + lane];
      if (body == last) continue;
      found_.push_back({id, body});
      last = body;
    }
  }
}

}  // namespace detail

}  // namespace bristle::inline BRISTLE_ABI
