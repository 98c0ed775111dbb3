/// @file
/// Contact points of two shapes, as a backend reports them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/math/types.hpp>

#include <array>
#include <cstddef>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI {

/// One point of contact.
template <Scalar S>
struct ContactPoint {
  /// [m] Halfway between the two surfaces, in the frame of shape A.
  Vec3<S> position = detail::zero<Vec3<S>>();
  /// [m] Distance of the surfaces along the normal. Negative where they overlap.
  S gap = S(0);
  /// [-] Id of the pair of features that meet here. It is the same in the next step. So impulses
  /// persist as warm start.
  std::uint32_t feature = 0;
};

/// Points of contact that share one normal.
template <Scalar S>
struct ContactManifold {
  /// [-] Most points of a manifold.
  static constexpr std::size_t capacity = 8;
  /// [-] Most points of the contact of a round face. Four hold it against tilting to any side.
  static constexpr std::size_t round_capacity = 4;

  /// [1] Unit normal from shape A into shape B, in the frame of A.
  Vec3<S> normal = detail::unit_z<Vec3<S>>();
  /// Contact points. Only the first `size` are valid.
  std::array<ContactPoint<S>, capacity> points{};
  /// [-] Number of points.
  std::size_t size = 0;
  /// [m] Displacement of shape B from where it is, in the frame of A, at which the points lie as
  /// they do. Their gaps are those of the shapes where they are.
  Vec3<S> shift = detail::zero<Vec3<S>>();
  /// [-] Distinguishes the manifolds of one pair, as by a triangle's number. 0 if there is only
  /// one.
  std::uint32_t key = 0;

  /// Appends a point. Ignored if the manifold is full.
  void add(const ContactPoint<S>& point) {
    if (size < capacity) points[size++] = point;
  }
};

/// All manifolds of one pair of shapes. Reused from pair to pair, so it stops allocating.
template <Scalar S>
using ContactManifolds = detail::DynamicArray<ContactManifold<S>>;

/// Outcome of a contact query.
enum class ContactStatus {
  /// The manifolds are valid. There may be none.
  ok,
  /// The backend failed (threw, looped or returned nonsense). The manifolds are empty.
  failed
};

}  // namespace bristle::inline BRISTLE_ABI
