/// @file
/// What a query of rays in bundles finds out on its way down to a slice, for those that follow.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/rays/bundle_leaves.hpp>
#include <bristle/geometry/rays/ray.hpp>
#include <bristle/geometry/rays/ray_bundles.hpp>
#include <bristle/geometry/rays/ray_mesh.hpp>
#include <bristle/math/transform.hpp>

#include <array>
#include <cstddef>

namespace bristle::inline BRISTLE_ABI {

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

/// Room for the lists of leaves that are made on the way down. Below, the last one serves.
template <Scalar S>
using LeafLists = std::array<LeafList<S>, 4>;

}  // namespace detail

/// The way from the root of the bundles down to the slice that was asked last, for one mesh at one
/// pose and one thread: slices that are asked one after the other find out only once what is known
/// of the bundles above them. It changes what a slice costs, not what it answers. Who asks another
/// mesh, or at another pose, begins a new way: slices that ask two meshes in turn gain nothing.
///
/// It knows a mesh and bundles by their addresses: a trail is done with before any that it served
/// change or go.
template <Scalar S>
class RayTrail {
 public:
  /// A bundle on the way, and what is known of its parts.
  struct Stop {
    std::size_t bundle = 0;
    detail::KnownOfBundle<S> of_parts{};
  };

  RayTrail() {}  // Room for lists, which nobody reads before they are written.
  RayTrail(const RayTrail&) = delete;  // Stops point to the lists.
  RayTrail& operator=(const RayTrail&) = delete;

  /// To be called before all else: forgets the way unless these very rays asked for this mesh last,
  /// in the same place.
  void serve(const RayMesh<S>& mesh, const Transform<S>& X_RC, const RayBatch<S>& rays) {
    if (mesh_ == &mesh && bundles_ == rays.bundles && extra_length_ == rays.extra_length &&
        X_RC_.rotation.coeffs() == X_RC.rotation.coeffs() &&
        X_RC_.translation == X_RC.translation) {
      return;
    }
    mesh_ = &mesh;
    bundles_ = rays.bundles;
    extra_length_ = rays.extra_length;
    X_RC_ = X_RC;
    stops_ = 0;
  }

  /// Goes back to the lowest stop that all of some places are below of.
  /// @return Null where there is none: then nothing is known of them.
  const Stop* back_to(RaySlice places) {
    for (; stops_ > 0; --stops_) {
      const Stop& stop = stop_[stops_ - 1];
      const RayBundle<S>& bundle = bundles_->bundles()[stop.bundle];
      if (bundle.first <= places.first && places.end <= bundle.first + bundle.count) return &stop;
    }
    return nullptr;
  }
  /// Goes on to a bundle below the last stop. Where the way is longer than there is room for, the
  /// rest of it is found anew.
  void go_to(const Stop& next) {
    if (stops_ < stop_.size()) stop_[stops_++] = next;
  }

  [[nodiscard]] detail::LeafLists<S>& lists() { return lists_; }

 private:
  const RayMesh<S>* mesh_ = nullptr;
  const RayBundles<S>* bundles_ = nullptr;
  S extra_length_ = S(0);
  Transform<S> X_RC_{};
  std::size_t stops_ = 0;
  /// As many as there are above the slices of a million rays.
  std::array<Stop, 12> stop_;
  detail::LeafLists<S> lists_;
};

namespace detail {

/// A call, so that who has a trail does not make room for other lists: they are some 60 KiB in
/// double, and the stacks of threads may be small.
template <Scalar S, typename Query>
BRISTLE_OUTLINED void with_own_lists(const Query& query) {
  LeafLists<S> lists;
  query(lists);
}

/// Calls query(lists) with the lists of the trail of a batch, or with some for this query alone.
template <Scalar S, typename Query>
void with_lists(const RayMesh<S>& mesh, const Transform<S>& X_RC, const RayBatch<S>& rays,
                const Query& query) {
  if (rays.trail == nullptr) return with_own_lists<S>(query);
  rays.trail->serve(mesh, X_RC, rays);
  query(rays.trail->lists());
}

}  // namespace detail

}  // namespace bristle::inline BRISTLE_ABI
