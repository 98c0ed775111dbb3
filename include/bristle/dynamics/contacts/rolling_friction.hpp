/// @file
/// Rolling friction of contacts as rows.
///
/// The pressure under a rolling body is larger in front of its middle. So the normal force N acts
/// ahead by a lever of up to delta, and resists with a torque of up to delta N about axes in the
/// plane of contact (Coulomb's law of rolling; K. L. Johnson, Contact Mechanics, chapter 9). It
/// holds a body that does not roll. A ball of radius R that rolls on a plane slows down by
///
///     5/7 g delta / R,
///
/// and stays on a slope up to tan(angle) = delta / R.
///
/// Rows hold the angular velocity along and across the torque that is expected. A body that rolls
/// on needs the whole of it along, so nothing is left across. Their bounds come from the normal
/// impulses of the last step. So they are those of the present load where it is steady, and a new
/// contact rolls freely for one step. In the step in which a torque arises or turns, it may be up
/// to sqrt(2) delta N. A row only resists, by any bounds.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/collision/contact_cache.hpp>
#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/no_index.hpp>
#include <bristle/dynamics/bodies/body.hpp>
#include <bristle/dynamics/solver/solver_types.hpp>
#include <bristle/math/types.hpp>

#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// Adds the blocks of a manifold's rolling friction. Adds none where it carried no load.
/// @param lever   [m] `Material::rolling_friction` of the pair.
/// @param slot_a  [-] Slots of the bodies.
template <Scalar S>
void add_rolling_friction(CachedManifold<S>& manifold, const DynamicArray<CachedPoint<S>>& points,
                          const S& lever, const Body<S>& a, const Body<S>& b, std::uint32_t slot_a,
                          std::uint32_t slot_b, Constraints<S>& out) {
  using std::max;
  using std::min;
  using std::sqrt;
  S load = S(0);
  for (std::uint32_t i = manifold.first; i < manifold.first + manifold.count; ++i) {
    load += points[i].impulse[0];
  }
  const S most = lever * load;
  if (!(most > S(0)) || !(most <= largest_number<S>)) return;
  const Vec3<S>& n = manifold.normal;
  const auto in_plane = [&](const Vec3<S>& v) -> Vec3<S> { return v - n.dot(v) * n; };
  const Vec3<S> held = in_plane(manifold.rolling_impulse);
  const Vec3<S> rolling = in_plane(b.twist.angular - a.twist.angular);
  const S response =
      rolling.dot(a.inverse_inertia_W() * rolling) + rolling.dot(b.inverse_inertia_W() * rolling);
  // A step of projected gradient from the last torque, as friction takes one (`solve_friction`). A
  // body that is held has no velocity there, and for one that rolls on the velocity decides.
  const S stiffness = response > S(0) ? S(rolling.squaredNorm() / response) : S(0);
  const Vec3<S> expected = held - stiffness * rolling;
  const S size = sqrt(expected.squaredNorm());
  Vec3<S> along, across;
  tangent_basis<S>(n, along, across);
  if (size > S(0) && size <= largest_number<S>) {
    along = (S(1) / size) * expected;
    across = n.cross(along);
  }
  const auto add = [&](const Vec3<S>& axis, const S& bound) {
    if (!(bound > S(0))) return;
    ConstraintRow<S> row;
    row.angular_a = row.angular_b = axis;
    row.impulse = min(max(axis.dot(held), -bound), bound);
    ConstraintBlock<S> block;
    block.body_a = slot_a;
    block.body_b = slot_b;
    block.first = static_cast<std::uint32_t>(out.rows.size());
    block.count = 1;
    block.kind = BlockKind::bounded;
    block.joint = no_index;
    block.lower = -bound;
    block.upper = bound;
    out.rows.push_back(row);
    out.blocks.push_back(block);
  };
  manifold.rolling_block = static_cast<std::uint32_t>(out.blocks.size());
  add(along, most);
  add(across, size < most ? S(sqrt(most * most - size * size)) : S(0));
  manifold.rolling_blocks = static_cast<std::uint32_t>(out.blocks.size()) - manifold.rolling_block;
}

/// [N m s] Impulse of a manifold's rolling friction on b, about any point.
template <Scalar S>
[[nodiscard]] Vec3<S> rolling_impulse(const CachedManifold<S>& manifold,
                                      const Constraints<S>& constraints) {
  Vec3<S> sum = zero<Vec3<S>>();
  for (std::uint32_t i = 0; i < manifold.rolling_blocks; ++i) {
    const ConstraintBlock<S>& block = constraints.blocks[manifold.rolling_block + i];
    const ConstraintRow<S>& row = constraints.rows[block.first];
    sum += row.impulse * row.angular_b;
  }
  return sum;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
