/// @file
/// Where two shapes touch, as a backend reports it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/types.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// One point of contact.
template <Scalar S>
struct ContactPoint {
  /// [m] Halfway between the two surfaces, in the frame of shape A.
  Vec3<S> position = Vec3<S>::Zero();
  /// [m] Distance of the surfaces along the normal; negative where they overlap.
  S gap = S(0);
  /// [-] Which features meet here. The same features give the same number in the next step, which
  /// is how impulses are carried over.
  std::uint32_t feature = 0;
};

/// Points of contact that share one normal.
template <Scalar S>
struct ContactManifold {
  static constexpr std::size_t capacity = 8;

  /// [1] Unit normal from shape A into shape B, in the frame of A.
  Vec3<S> normal = Vec3<S>::UnitZ();
  std::array<ContactPoint<S>, capacity> points{};
  std::size_t size = 0;
  /// [-] Tells the manifolds of one pair apart (a triangle's number, say); 0 where there is only
  /// one.
  std::uint32_t key = 0;

  void add(const ContactPoint<S>& point) {
    if (size < capacity) points[size++] = point;
  }
};

/// All manifolds of one pair of shapes. Reused from pair to pair, so it stops allocating.
template <Scalar S>
using ContactManifolds = std::vector<ContactManifold<S>>;

/// How a contact query ended.
enum class ContactStatus {
  /// The manifolds are right; there may be none.
  ok,
  /// The backend failed (threw, looped or returned nonsense); the manifolds are empty.
  failed
};

}  // namespace bristle::inline BRISTLE_ABI
