/// @file
/// Soft blocks between bodies of which only the mobility is known.
///
/// A world knows the mass of its bodies. It solves for the velocities that minimise a convex
/// function (proximal_solver.hpp). Of a host's bodies only the response to impulses is known. A
/// finger on a slide moves along one axis. The links of an arm move each other. Let V be the twists
/// of all bodies about their centres of mass, W their mobility and f the impulses of the blocks:
///
///     V = V_free + W f,   f_i = sum over blocks of -s_i G_i^T p,   p = offset + matrix u,
///     u = sum over the two bodies of s_i G_i V_i,   s = +1 for A and -1 for B,
///
/// where G_i maps a twist from the centre of mass to the block's point. W need not have an inverse.
/// The solver finds V from (1 + W Q) V = V_free + W q, with Q = sum s_i s_j G_i^T matrix G_j. W and
/// Q are positive semidefinite. So 1 + W Q has no eigenvalue below 1.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/disjoint_sets.hpp>
#include <bristle/core/dynamic_array.hpp>
#include <bristle/dynamics/solver/soft_block.hpp>
#include <bristle/math/elimination.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>

namespace bristle::inline BRISTLE_ABI::detail {

/// Solves for the motion of such bodies. Bodies are numbered in the order of `add_body`.
/// Unconnected groups are solved apart. Systems of floats are solved in double. In float W Q of a
/// stiff block has no digits left.
template <Scalar S>
class SoftSystem {
 public:
  /// Starts a new system.
  void clear() {
    free_.clear();
    couplings_.clear();
  }
  /// Adds a body.
  /// @param free  [m/s, rad/s] Its twist without the blocks.
  /// @return      [-] Its number.
  std::uint32_t add_body(const Twist<S>& free) {
    free_.push_back(stacked(free));
    return static_cast<std::uint32_t>(free_.size() - 1);
  }
  /// Sets the mobility from body j to body i. It is the change of the twist of body i per impulse
  /// on body j about its centre of mass. A mobility that is not set is zero.
  /// @param mobility  [1/kg and products with 1/m] Symmetric, positive semidefinite for i = j. Its
  ///                  transpose is the mobility from body i to body j.
  void set_mobility(std::uint32_t i, std::uint32_t j, const Mat6<S>& mobility) {
    couplings_.push_back({i, j, mobility});
    if (i != j) couplings_.push_back({j, i, transposed(mobility)});
  }
  /// Adds a known impulse about the centre of mass of a body.
  /// @param impulse  [N s, N m s]
  void apply_impulse(std::uint32_t body, const Wrench<S>& impulse) {
    const Vec6<S> known = stacked(impulse);
    for (const Coupling& c : couplings_) {
      if (c.to == body) free_[c.from] += c.mobility * known;
    }
  }

  /// Finds the motion of all blocks. It is not finite if the input was not.
  void solve(std::span<SoftBlock<S>> blocks);

 private:
  using Real = std::conditional_t<std::is_same_v<S, float>, double, S>;
  using Matrix = Eigen::Matrix<Real, 6, 6, Eigen::DontAlign>;
  using Vector = Eigen::Matrix<Real, 6, 1, Eigen::DontAlign>;
  using Map = Eigen::Map<Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;

  struct Coupling {
    std::uint32_t from = 0;
    std::uint32_t to = 0;
    Mat6<S> mobility = zero<Mat6<S>>();
  };
  /// A body of a block: its number, and s G.
  struct Side {
    std::uint32_t body = 0;
    Matrix G = zero<Matrix>();
  };

  [[nodiscard]] static std::array<Side, 2> sides_of(const SoftBlock<S>& block) {
    return {Side{block.body_a, shift_matrix<Real>(block.arm_a.template cast<Real>())},
            Side{block.body_b, -shift_matrix<Real>(block.arm_b.template cast<Real>())}};
  }

  void find_sets(std::span<const SoftBlock<S>> blocks);
  void solve_set(std::uint32_t set, std::span<const SoftBlock<S>> blocks);

  DynamicArray<Vec6<S>> free_;
  DynamicArray<Coupling> couplings_;
  DisjointSets sets_;
  /// Members of the present set, the place of each body in it, and all twists.
  DynamicArray<std::uint32_t> members_;
  DynamicArray<Eigen::Index> place_;
  DynamicArray<Vector> twist_;
  DynamicArray<Real> left_, stiffness_, right_, load_;
};

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
void SoftSystem<S>::solve(std::span<SoftBlock<S>> blocks) {
  twist_.resize(free_.size());
  place_.resize(free_.size());
  for (std::size_t i = 0; i < free_.size(); ++i) twist_[i] = free_[i].template cast<Real>();
  find_sets(blocks);
  for (std::uint32_t i = 0; i < free_.size(); ++i) {
    if (sets_.find(i) == i) solve_set(i, blocks);
  }
  for (SoftBlock<S>& block : blocks) {
    Vector motion = zero<Vector>();
    for (const Side& side : sides_of(block)) motion += side.G * twist_[side.body];
    block.motion = motion.template cast<S>();
  }
}

template <Scalar S>
void SoftSystem<S>::find_sets(std::span<const SoftBlock<S>> blocks) {
  sets_.reset(free_.size());
  // A body without mobility passes nothing on.
  std::fill(place_.begin(), place_.end(), Eigen::Index(-1));
  for (const Coupling& c : couplings_) {
    if (c.from == c.to) place_[c.to] = 0;
    sets_.join(c.from, c.to);
  }
  for (const SoftBlock<S>& block : blocks) {
    if (place_[block.body_a] == 0 && place_[block.body_b] == 0) {
      sets_.join(block.body_a, block.body_b);
    }
  }
}

template <Scalar S>
void SoftSystem<S>::solve_set(std::uint32_t set, std::span<const SoftBlock<S>> blocks) {
  std::fill(place_.begin(), place_.end(), Eigen::Index(-1));
  members_.clear();
  for (const Coupling& c : couplings_) {
    if (c.from != c.to || sets_.find(c.from) != set) continue;
    place_[c.from] = static_cast<Eigen::Index>(6 * members_.size());
    members_.push_back(c.from);
  }
  if (members_.empty()) return;
  const auto size = static_cast<Eigen::Index>(6 * members_.size());
  const auto cells = static_cast<std::size_t>(size * size);
  left_.assign(cells, Real(0));
  stiffness_.assign(cells, Real(0));
  right_.assign(static_cast<std::size_t>(size), Real(0));
  load_.assign(static_cast<std::size_t>(size), Real(0));
  Map left(left_.data(), size, size), Q(stiffness_.data(), size, size);
  Map right(right_.data(), size, 1), q(load_.data(), size, 1);
  for (const SoftBlock<S>& block : blocks) {
    if (place_[block.body_a] < 0 && place_[block.body_b] < 0) continue;
    const std::array<Side, 2> sides = sides_of(block);
    const Matrix A = block.matrix.template cast<Real>();
    Vector constant = block.offset.template cast<Real>();
    for (const Side& side : sides) {
      if (place_[side.body] < 0) constant += A * (side.G * twist_[side.body]);
    }
    for (const Side& i : sides) {
      if (place_[i.body] < 0) continue;
      const Matrix across = i.G.transpose() * A;
      q.template block<6, 1>(place_[i.body], 0) -= i.G.transpose() * constant;
      for (const Side& j : sides) {
        if (place_[j.body] < 0) continue;
        Q.template block<6, 6>(place_[i.body], place_[j.body]) += across * j.G;
      }
    }
  }
  for (const std::uint32_t body : members_) {
    right.template block<6, 1>(place_[body], 0) = twist_[body];
  }
  for (Eigen::Index i = 0; i < size; ++i) left(i, i) = Real(1);
  for (const Coupling& c : couplings_) {
    if (place_[c.from] < 0 || place_[c.to] < 0) continue;
    const Matrix W = c.mobility.template cast<Real>();
    right.template block<6, 1>(place_[c.from], 0) += W * q.template block<6, 1>(place_[c.to], 0);
    for (Eigen::Index column = 0; column < size; column += 6) {
      left.template block<6, 6>(place_[c.from], column) +=
          W * Q.template block<6, 6>(place_[c.to], column);
    }
  }
  eliminate(left, right);
  for (const std::uint32_t body : members_) {
    twist_[body] = right.template block<6, 1>(place_[body], 0);
  }
}

}  // namespace bristle::inline BRISTLE_ABI::detail
