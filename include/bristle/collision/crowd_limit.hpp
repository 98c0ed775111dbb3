/// @file
/// A bound on the pairs of a crowd: many bodies at one place, as after a bad spawn.
///
/// A thousand bodies at one point are half a million pairs, of which a few push everything apart as
/// well. Those are solved first. The next steps find the others, as far as they still overlap.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/collision/broadphase.hpp>
#include <bristle/core/dynamic_array.hpp>
#include <bristle/geometry/shapes/inner_ball.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <tuple>

namespace bristle::inline BRISTLE_ABI::detail {

/// Puts off pairs of shapes that have their middles in each other's inner balls. Bodies that touch,
/// and small ones in a large one, are no such pairs, nor is any overlap of less than a radius. So a
/// scene without a crowd loses nothing.
template <Scalar S>
class CrowdLimit {
 public:
  /// [-] As many balls of one size can touch one (the kissing number, Schuette and van der Waerden
  /// 1953). A shape with more others in its middle is in a crowd.
  static constexpr std::size_t most = 12;

  /// Removes those crowded pairs that are among the `most` nearest of neither shape.
  /// @param slots    [-] Upper bound of the tags.
  /// @param ball_of  Callable: `InnerBall<S> ball_of(tag)` in one frame for all tags. A radius of 0
  ///                 stands for a shape that takes part in no crowd.
  /// @return Number of pairs removed. The others stay in their order.
  template <typename BallOf>
  std::size_t thin(DynamicArray<ShapePair>& pairs, std::size_t slots, const BallOf& ball_of);

 private:
  /// Another shape in the middle of a shape.
  struct Near {
    S distance2 = S(0);       // [m2] Between the middles.
    std::uint32_t apart = 0;  // [-] Between the tags. Shapes at one point take their neighbours.
    std::uint32_t pair = 0;

    friend bool operator<(const Near& x, const Near& y) {
      return std::tie(x.distance2, x.apart, x.pair) < std::tie(y.distance2, y.apart, y.pair);
    }
  };
  /// The nearest, in order.
  struct Nearest {
    std::array<Near, most> list;
    std::size_t size = 0;

    void insert(const Near& near) {
      if (size == most && !(near < list[most - 1])) return;
      if (size < most) ++size;
      std::size_t place = size - 1;
      for (; place > 0 && near < list[place - 1]; --place) list[place] = list[place - 1];
      list[place] = near;
    }
  };

  DynamicArray<Near> crowded_;
  DynamicArray<Nearest> nearest_;  // By tag.
  DynamicArray<bool> stays_;       // By pair.
};

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
template <typename BallOf>
std::size_t CrowdLimit<S>::thin(DynamicArray<ShapePair>& pairs, std::size_t slots,
                                const BallOf& ball_of) {
  crowded_.clear();
  for (std::uint32_t i = 0; i < pairs.size(); ++i) {
    const ShapePair& pair = pairs[i];
    const InnerBall<S> a = ball_of(pair.a);
    if (!(a.radius > S(0))) continue;
    const InnerBall<S> b = ball_of(pair.b);
    const S distance2 = (b.center - a.center).squaredNorm();
    const S reach = std::min(a.radius, b.radius);
    if (!(reach > S(0) && distance2 < reach * reach)) continue;
    crowded_.push_back({distance2, std::max(pair.a, pair.b) - std::min(pair.a, pair.b), i});
  }
  if (crowded_.size() <= most) return 0;
  nearest_.assign(slots, Nearest{});
  for (const Near& near : crowded_) {
    nearest_[pairs[near.pair].a].insert(near);
    nearest_[pairs[near.pair].b].insert(near);
  }
  stays_.assign(pairs.size(), true);
  for (const Near& near : crowded_) stays_[near.pair] = false;
  for (const Nearest& nearest : nearest_) {
    for (std::size_t k = 0; k < nearest.size; ++k) stays_[nearest.list[k].pair] = true;
  }
  std::size_t count = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (stays_[i]) pairs[count++] = pairs[i];
  }
  const std::size_t removed = pairs.size() - count;
  pairs.resize(count);
  return removed;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
