/// @file
/// Output of iterative contact methods. It converts manifolds from the frame and precision of their
/// computation to those of the user. It merges manifolds and points that belong together.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/contacts/contact_manifold.hpp>
#include <bristle/math/finite.hpp>
#include <bristle/math/transform.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// Appends the manifolds of one pair to a list. Manifolds with the same key are merged. So are
/// coinciding points in them.
template <Scalar S>
class ContactSink {
 public:
  /// Scalar that manifolds are computed in.
  using P = Precise<S>;

  /// @param out  Manifolds that it already holds stay unchanged.
  explicit ContactSink(ContactManifolds<S>& out) : out_(out), start_(out.size()) {}

  /// Sets the frame of further manifolds: F at X_AF in the frame of A. Their normals run from A to
  /// B or, if `is_reversed`, from B to A.
  void set_frame(const Transform<P>& X_AF, bool is_reversed) {
    X_AF_ = X_AF;
    sign_ = is_reversed ? P(-1) : P(1);
  }

  /// Sets the distance [m] below which points with the same key are merged. 0 by default: only
  /// equal ones are.
  void set_nearest(P distance) { nearest_ = S(distance); }

  /// Adds a manifold. One without points is ignored.
  void add(const ContactManifold<P>& manifold) {
    if (manifold.size == 0) return;
    ContactManifold<S>& target = manifold_of(manifold);
    for (std::size_t i = 0; i < manifold.size; ++i) {
      const ContactPoint<P>& p = manifold.points[i];
      const Vec3<P> position = X_AF_ * p.position;
      join(target, {position.template cast<S>(), S(p.gap), p.feature});
    }
  }

  /// Returns whether nothing was added.
  [[nodiscard]] bool is_empty() const { return out_.size() == start_; }
  /// Returns whether some point has a gap of at most `gap` [m].
  [[nodiscard]] bool reaches(P gap) const {
    for (std::size_t i = start_; i < out_.size(); ++i) {
      for (std::size_t k = 0; k < out_[i].size; ++k) {
        if (P(out_[i].points[k].gap) <= gap) return true;
      }
    }
    return false;
  }
  /// Removes all that was added.
  void clear() { out_.resize(start_); }

  /// Returns whether all added numbers are finite and all normals unit.
  [[nodiscard]] bool is_sound() const {
    using std::abs;
    using std::isfinite;
    for (std::size_t i = start_; i < out_.size(); ++i) {
      const ContactManifold<S>& m = out_[i];
      if (!(abs(m.normal.squaredNorm() - S(1)) <= Tolerance<S>::equal())) return false;
      for (std::size_t k = 0; k < m.size; ++k) {
        if (!all_finite(m.points[k].position) || !isfinite(m.points[k].gap)) return false;
      }
    }
    return true;
  }

 private:
  [[nodiscard]] ContactManifold<S>& manifold_of(const ContactManifold<P>& like) {
    for (std::size_t i = start_; i < out_.size(); ++i) {
      if (out_[i].key == like.key) return out_[i];
    }
    const Vec3<P> normal = X_AF_.rotate(sign_ * like.normal);
    ContactManifold<S>& fresh = out_.emplace_back();
    fresh.normal = normal.template cast<S>().normalized();
    fresh.key = like.key;
    return fresh;
  }

  /// Adds a point. If the manifold is full, the deeper of the two closest points stays. Of equals,
  /// the one farther from the middle stays. So the deepest of all and the outer corners are never
  /// lost.
  void join(ContactManifold<S>& manifold, const ContactPoint<S>& point) const {
    for (std::size_t i = 0; i < manifold.size; ++i) {
      if ((manifold.points[i].position - point.position).squaredNorm() <= nearest_ * nearest_) {
        if (point.gap < manifold.points[i].gap) manifold.points[i] = point;
        return;
      }
    }
    if (manifold.size < ContactManifold<S>::capacity) {
      manifold.add(point);
      return;
    }
    const std::size_t loser = loser_of(manifold, point);
    if (loser < manifold.size) manifold.points[loser] = point;
  }

  /// Index of the point that a full manifold drops for another. Its size if it drops the other.
  [[nodiscard]] static std::size_t loser_of(const ContactManifold<S>& manifold,
                                            const ContactPoint<S>& point) {
    const auto at = [&](std::size_t i) -> const ContactPoint<S>& {
      return i < manifold.size ? manifold.points[i] : point;
    };
    const S share = S(1) / S(manifold.size + 1);
    Vec3<S> middle = zero<Vec3<S>>();
    for (std::size_t i = 0; i <= manifold.size; ++i) middle += share * at(i).position;
    std::size_t first = 0;
    std::size_t second = 0;
    S least = infinity<S>;
    S size2 = S(0);
    for (std::size_t i = 0; i <= manifold.size; ++i) {
      size2 = std::max(size2, (at(i).position - middle).squaredNorm());
      for (std::size_t j = i + 1; j <= manifold.size; ++j) {
        const S distance2 = (at(i).position - at(j).position).squaredNorm();
        if (distance2 < least) {
          least = distance2;
          first = i;
          second = j;
        }
      }
    }
    using std::abs;
    using std::sqrt;
    if (abs(at(first).gap - at(second).gap) > Tolerance<S>::equal() * sqrt(size2)) {
      return at(first).gap < at(second).gap ? second : first;
    }
    return (at(first).position - middle).squaredNorm() <
                   (at(second).position - middle).squaredNorm()
               ? first
               : second;
  }

  ContactManifolds<S>& out_;
  std::size_t start_;
  Transform<P> X_AF_;
  P sign_ = P(1);
  S nearest_ = S(0);
};

}  // namespace bristle::inline BRISTLE_ABI::detail
