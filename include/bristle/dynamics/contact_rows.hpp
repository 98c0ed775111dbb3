/// @file
/// From points of contact to rows: normal and two tangents each.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/collision/contact_cache.hpp>
#include <bristle/dynamics/material.hpp>
#include <bristle/dynamics/solver_types.hpp>
#include <bristle/math/rotation.hpp>

namespace bristle {

/// Adds one block for every point of a manifold, warm with the impulses it has.
///
/// Surfaces may approach by their gap within the step and no more (a speculative contact), so
/// nothing tunnels and nothing stops short. With restitution e a point that would be hit in this
/// step aims at -e times its approach speed, unless that is below `restitution_speed` [m/s].
template <Scalar S>
void add_contact_rows(const CachedManifold<S>& manifold, const std::vector<CachedPoint<S>>& points,
                      const Material<S>& material, std::uint32_t slot_a, std::uint32_t slot_b,
                      const SolverBody<S>& a, const SolverBody<S>& b, S restitution_speed, S dt,
                      Constraints<S>& out) {
  Vec3<S> t1, t2;
  tangent_basis<S>(manifold.normal, t1, t2);
  const Vec3<S> directions[3] = {manifold.normal, t1, t2};
  for (std::uint32_t i = manifold.first; i < manifold.first + manifold.count; ++i) {
    const CachedPoint<S>& point = points[i];
    ConstraintBlock<S> block;
    block.body_a = slot_a;
    block.body_b = slot_b;
    block.first = static_cast<std::uint32_t>(out.rows.size());
    block.count = 3;
    block.kind = BlockKind::contact;
    block.friction = material.friction;
    out.blocks.push_back(block);
    for (std::size_t k = 0; k < 3; ++k) {
      ConstraintRow<S> row;
      row.direction = directions[k];
      row.angular_a = point.arm_a.cross(directions[k]);
      row.angular_b = point.arm_b.cross(directions[k]);
      row.impulse = point.impulse[k];
      out.rows.push_back(row);
    }
    ConstraintRow<S>& normal = out.rows[block.first];
    normal.error = point.gap;
    normal.target = point.gap > S(0) ? -point.gap / dt : S(0);
    if (material.restitution > S(0)) {
      const S approach = normal.velocity(a.start, b.start);
      const bool hits = point.gap + dt * normal.velocity(a.free, b.free) < S(0);
      if (hits && approach < -restitution_speed) {
        normal.target = std::max(normal.target, -material.restitution * approach);
      }
    }
  }
}

}  // namespace bristle
