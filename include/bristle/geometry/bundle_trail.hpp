/// @file
/// What a query of rays in bundles finds out on its way down to a slice, for those that follow.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/bundle_leaves.hpp>
#include <bristle/geometry/ray.hpp>
#include <bristle/geometry/ray_bundles.hpp>

#include <array>
#include <cstddef>
#include <cstdint>

namespace bristle {

namespace detail {

/// Where the rays of a bundle start, as seen from a solid.
enum class Side { unknown, outside, inside };

/// What is known of a bundle from the one that it is a part of.
template <Scalar S>
struct KnownOfBundle {
  /// Leaves that it may meet, if they were sought; [-] how many lists are in use.
  const LeafList<S>* list = nullptr;
  std::size_t lists = 0;
  Side side = Side::unknown;
  /// A box in its frame, if the whole has that frame.
  const BoxInTree<S>* framed = nullptr;
};

}  // namespace detail

/// The way from the root of the bundles down to the slice that was asked last, for one shape at one
/// pose and one thread: slices that are asked one after the other find out only once what is known
/// of the bundles above them. It changes what a slice costs, not what it answers.
template <Scalar S>
class RayTrail {
 public:
  /// [-] Lists of leaves that are kept on the way down. Below, the last one serves.
  static constexpr std::size_t most_lists = 4;

  /// A bundle on the way, and what is known of its parts.
  struct Stop {
    std::size_t bundle = 0;
    detail::KnownOfBundle<S> of_parts{};
  };

  RayTrail() {}  // Room for lists, which nobody reads before they are written.
  RayTrail(const RayTrail&) = delete;  // Stops point to the lists.
  RayTrail& operator=(const RayTrail&) = delete;

  /// Whether it is the trail of a shape: that of the first one that asks.
  [[nodiscard]] bool serves(std::uint32_t tag) {
    if (!has_tag_) tag_ = tag;
    has_tag_ = true;
    return tag_ == tag;
  }

  /// Goes back to the lowest stop that all of some places are below of.
  /// @return Null where there is none: then nothing is known of them.
  const Stop* back_to(const RayBundles<S>& bundles, RaySlice places) {
    for (; stops_ > 0; --stops_) {
      const Stop& stop = stop_[stops_ - 1];
      const RayBundle<S>& bundle = bundles.bundles()[stop.bundle];
      if (bundle.first <= places.first && places.end <= bundle.first + bundle.count) return &stop;
    }
    return nullptr;
  }
  /// Goes on to a bundle, from whichever stop it is below of. Where the way is longer than there is
  /// room for, the rest of it is found anew.
  void go_to(const RayBundles<S>& bundles, const Stop& next) {
    const RayBundle<S>& bundle = bundles.bundles()[next.bundle];
    back_to(bundles, {bundle.first, bundle.first + bundle.count});
    if (stops_ < stop_.size()) stop_[stops_++] = next;
  }

  [[nodiscard]] detail::LeafList<S>& list(std::size_t i) { return lists_[i]; }

 private:
  std::uint32_t tag_ = 0;
  bool has_tag_ = false;
  std::size_t stops_ = 0;
  /// As many as there are above the slices of a million rays.
  std::array<Stop, 12> stop_;
  std::array<detail::LeafList<S>, most_lists> lists_;
};

namespace detail {

/// A call, so that who has a trail does not make room for another one: they are some 60 KiB in
/// double, and the stacks of threads may be small.
template <Scalar S, typename Query>
BRISTLE_OUTLINED void with_own_trail(const Query& query) {
  RayTrail<S> trail;
  query(trail);
}

/// Calls query(trail) with the trail of a batch if it serves a shape, and with a new one otherwise.
template <Scalar S, typename Query>
void with_trail(const RayBatch<S>& rays, std::uint32_t tag, const Query& query) {
  if (rays.trail != nullptr && rays.trail->serves(tag)) {
    query(*rays.trail);
  } else {
    with_own_trail<S>(query);
  }
}

}  // namespace detail

}  // namespace bristle
