/// @file
/// Several manifolds in the lanes of registers, and their motion.
///
/// A manifold has six numbers along its axes. They are the velocity of b relative to a at the
/// centre of pressure and the relative angular velocity. With the point's lever e = r x n about the
/// centre,
///     v_n = V_n + e_1 w_1 + e_2 w_2,
/// and a unit impulse there changes V_n, w_1, w_2 by three numbers that are known beforehand. So
/// two bodies are read once. All points and the friction are solved among these six numbers. One
/// force and one torque are then applied to the bodies. Their cost does not depend on the number of
/// points.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/math/lane_rows.hpp>
#include <bristle/math/pack3.hpp>
#include <bristle/math/spatial.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// Velocities of bodies. They are adjacent, and read and written in lanes.
template <Scalar S>
class VelocityTable {
 public:
  /// [-] Numbers per body: six velocities and two of padding.
  static constexpr std::uint32_t stride = row_stride;

  void resize(std::size_t bodies) { numbers_.resize(std::max(numbers_.size(), stride * bodies)); }
  void set(std::size_t body, const Twist<S>& v) {
    S* p = numbers_.data() + stride * body;
    for (std::size_t i = 0; i < 3; ++i) {
      p[i] = v.linear[static_cast<int>(i)];
      p[i + 3] = v.angular[static_cast<int>(i)];
    }
  }
  [[nodiscard]] Twist<S> operator[](std::size_t body) const {
    const S* p = numbers_.data() + stride * body;
    return {{p[0], p[1], p[2]}, {p[3], p[4], p[5]}};
  }
  /// Rows of the bodies from one on, each of `stride` numbers.
  [[nodiscard]] std::span<S> rows(std::size_t first, std::size_t count) {
    return {numbers_.data() + stride * first, stride * count};
  }
  /// Linear and angular velocity of a body for each lane.
  /// @param at  [-] Number of the body times `stride`.
  BRISTLE_FORCE_INLINE void load(const std::uint32_t* at, Pack3<S>& linear,
                                 Pack3<S>& angular) const {
    Pack<S> columns[6];
    load_rows(numbers_.data(), at, columns);
    linear = {columns[0], columns[1], columns[2]};
    angular = {columns[3], columns[4], columns[5]};
  }
  /// The inverse. Lanes with the same body overwrite each other.
  BRISTLE_FORCE_INLINE void store(const std::uint32_t* at, const Pack3<S>& linear,
                                  const Pack3<S>& angular) {
    const Pack<S> columns[] = {linear.x, linear.y, linear.z, angular.x, angular.y, angular.z};
    store_rows(numbers_.data(), at, columns);
  }

 private:
  LineArray<S> numbers_;
};

/// [-] Points of a manifold that are solved without the six numbers in between. The effect of one
/// impulse on the later points is known beforehand. So each point waits for two multiplications
/// instead of three.
inline constexpr std::uint32_t point_group = 4;

/// One point of each manifold of a block. It holds what each sweep reads of a `ContactConstraint`,
/// in lanes. Where a manifold has fewer points, nothing responds to impulses. So there are none.
/// @tparam n  [-] Lanes that the file is compiled for. It decides the layout of the type.
template <Scalar S, std::size_t n = lanes<S>>
struct alignas(64) ManifoldPoints {
  using Row = std::array<S, n>;
  /// Lever of a unit normal impulse about the centre of pressure, along the tangents.
  Row e1{}, e2{};
  /// Effect of that impulse on the normal velocity and the tangential rotation of the centre.
  Row linear{}, turn1{}, turn2{};
  Row response{}, inverse_response{};
  /// Effect of unit impulses at earlier points of its group on its own normal velocity.
  std::array<Row, point_group - 1> coupling{};
  /// Distance from the centre of pressure: the arm of torsion.
  Row radius{};
  Row target{}, impulse{};
  /// Position problem: velocity that closes the gap within the step, position impulse and its lower
  /// bound, and the counterpart of `inverse_response`. The last is 0 where bodies separate.
  Row position_target{}, position_impulse{}, least_position_impulse{}, inverse_position_response{};
};

/// Contact data of a block's points that sweeps seldom read. They are apart from `ManifoldPoints`
/// so that a sweep loads fewer cache lines. Fields named as in `ContactConstraint` have the same
/// meaning. Where a manifold has fewer points, the impulse stays zero. Other fields have no meaning
/// there.
template <Scalar S, std::size_t n = lanes<S>>
struct alignas(64) ManifoldContacts {
  using Row = std::array<S, n>;
  Row gap{}, restitution{}, restitution_share{}, position_excess{};
  /// [N s] Position impulse by the velocities.
  Row usual_impulse{};
  /// [N s] Impulses along the tangents. The normal impulse is `ManifoldPoints::impulse`.
  Row friction1{}, friction2{};
  /// [N s] Impulses along the normal and the tangents. They are sums over the substeps so far.
  std::array<Row, 3> total{};
  /// [-] Lanes with `is_impact`.
  std::uint32_t impacts = 0;
};

/// As many manifolds as a register has lanes. Unused lanes are zero and do nothing. Their inverse
/// determinant is not zero. So they stick. They do not trigger the slow branch for sliding lanes.
template <Scalar S, std::size_t n = lanes<S>>
struct alignas(64) ManifoldBlock {
  using Row = std::array<S, n>;
  struct Row3 {
    Row x{}, y{}, z{};

    void set(std::size_t lane, const Vec3<S>& v) {
      x[lane] = v[0];
      y[lane] = v[1];
      z[lane] = v[2];
    }
  };
  /// Response of a body's velocities to impulses. Velocities are read from `from` and written to
  /// `to`. These places are the same, but `to` is 0 for immovable bodies. The other fields are the
  /// arm to the centre of pressure, the inverse mass by axis and the upper part of the inverse
  /// inertia, by rows.
  struct Side {
    std::array<std::uint32_t, n> from{}, to{};
    Row3 arm{}, inverse_mass{};
    std::array<Row, 6> inverse_inertia{};
    /// True if only the first of the six counts. It then holds for all three axes.
    bool is_isotropic = true;
  };

  /// [-] Lanes in use. Range of their points, as many as the longest manifold has.
  std::uint32_t used = 0;
  std::uint32_t first_point = 0;
  std::uint32_t points = 0;
  /// [-] Contacts of each lane, by their number in the island.
  std::array<std::uint32_t, n> first_contact{}, contacts{};
  /// [-] Lanes with a body that moves with a mechanism.
  std::uint32_t follow_joints = 0;

  Side a, b;
  /// Normal and tangents, world axes.
  Row3 normal, tangent1, tangent2;
  /// Effect of normal impulses on the velocity along the tangents and the spin about the normal. It
  /// is per unit of force along the normal and of torque about the tangents.
  std::array<std::array<Row, 3>, 3> across{};
  Row friction{};
  Row most_impulse{};      // Of each of its points.
  Row drift1{}, drift2{};  // Velocity along the tangents at which surfaces stick.
  Row radius{};            // The largest of its points.
  /// Tangential part of the response to forces, as in `ContactResponse`. Response to torsion.
  Row response_a{}, response_b{}, response_c{}, inverse_determinant{};
  Row largest_response{}, inverse_largest{};
  Row torsion_response{}, inverse_torsion_response{};
  Row friction_impulse1{}, friction_impulse2{}, torsion{};
};

/// Motion of the bodies of one block. Effect of impulses on it.
template <Scalar S>
class ManifoldMotion {
 protected:
  using T = Pack<S>;
  using Block = ManifoldBlock<S>;
  using Points = ManifoldPoints<S>;
  using Row = typename Block::Row;

  /// @param points  Points of all blocks.
  ManifoldMotion(Block& block, std::span<Points> points)
      : m_(block), points_(points.subspan(block.first_point, block.points)) {}

  /// Velocities of the two bodies.
  struct Motion {
    Pack3<S> v_a, w_a, v_b, w_b;
  };
  /// Velocity of b relative to a at the centre, along the axes.
  struct Relative {
    T n, v1, v2;     // Along the normal and the tangents.
    T spin, w1, w2;  // About them.
  };
  /// Sums of normal impulses: force, torque about the tangents.
  struct Load {
    T n = S(0), l1 = S(0), l2 = S(0);

    BRISTLE_FORCE_INLINE void add(const Points& p, const T& x) {
      n += x;
      l1 += x * row(p.e1);
      l2 += x * row(p.e2);
    }
  };
  /// Sums of friction: force along the tangents, torque about the normal.
  struct Friction {
    T along1 = S(0), along2 = S(0), spin = S(0);

    BRISTLE_FORCE_INLINE void add(const Points& p, const T& x1, const T& x2) {
      along1 += x1;
      along2 += x2;
      spin -= row(p.e1) * x1 + row(p.e2) * x2;
    }
  };
  [[nodiscard]] BRISTLE_FORCE_INLINE static T row(const Row& r) { return T::load(r.data()); }
  [[nodiscard]] BRISTLE_FORCE_INLINE static Pack3<S> row(const typename Block::Row3& r) {
    return Pack3<S>::load(r.x.data(), r.y.data(), r.z.data());
  }
  [[nodiscard]] BRISTLE_FORCE_INLINE static T speed(const Points& p, const Relative& v) {
    return v.n + row(p.e1) * v.w1 + row(p.e2) * v.w2;
  }
  [[nodiscard]] BRISTLE_FORCE_INLINE Motion motion(const VelocityTable<S>& velocities) const {
    Motion of;
    velocities.load(m_.a.from.data(), of.v_a, of.w_a);
    velocities.load(m_.b.from.data(), of.v_b, of.w_b);
    return of;
  }
  [[nodiscard]] BRISTLE_FORCE_INLINE Relative relative(const Motion& of) const {
    const Pack3<S> v =
        (of.v_b - of.v_a) + (cross(of.w_b, row(m_.b.arm)) - cross(of.w_a, row(m_.a.arm)));
    const Pack3<S> w = of.w_b - of.w_a;
    const Pack3<S> n = row(m_.normal), t1 = row(m_.tangent1), t2 = row(m_.tangent2);
    return {dot(n, v), dot(t1, v), dot(t2, v), dot(n, w), dot(t1, w), dot(t2, w)};
  }
  /// Applies an impulse and an angular impulse to b at the centre. Applies their opposites to a.
  BRISTLE_FORCE_INLINE void apply_impulse(VelocityTable<S>& velocities, const Motion& before,
                                          const Load& load, const T& along1, const T& along2,
                                          const T& spin) const {
    const Pack3<S> n = row(m_.normal), t1 = row(m_.tangent1), t2 = row(m_.tangent2);
    const Pack3<S> force = load.n * n + along1 * t1 + along2 * t2;
    const Pack3<S> torque = spin * n + load.l1 * t1 + load.l2 * t2;
    apply_impulse(m_.a, velocities, before.v_a, before.w_a, -force, -torque);
    apply_impulse(m_.b, velocities, before.v_b, before.w_b, force, torque);
  }
  BRISTLE_FORCE_INLINE static void apply_impulse(const typename Block::Side& side,
                                                 VelocityTable<S>& velocities, const Pack3<S>& v,
                                                 const Pack3<S>& w, const Pack3<S>& force,
                                                 const Pack3<S>& torque) {
    const Pack3<S> l = torque + cross(row(side.arm), force);
    const auto& I = side.inverse_inertia;
    Pack3<S> turn = row(I[0]) * l;
    if (!side.is_isotropic) {
      const T xy = row(I[1]), xz = row(I[2]), yz = row(I[4]);
      turn.x += xy * l.y + xz * l.z;
      turn.y = xy * l.x + row(I[3]) * l.y + yz * l.z;
      turn.z = xz * l.x + yz * l.y + row(I[5]) * l.z;
    }
    const Pack3<S> m = row(side.inverse_mass);
    const Pack3<S> move{m.x * force.x, m.y * force.y, m.z * force.z};
    velocities.store(side.to.data(), v + move, w + turn);
  }

  Block& m_;
  std::span<Points> points_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
