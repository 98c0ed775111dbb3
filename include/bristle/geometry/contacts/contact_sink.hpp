/// @file
/// Where iterative methods put manifolds: brings them from the frame and precision they were
/// computed in to those of the user, and joins what belongs together.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/contacts/contact_manifold.hpp>
#include <bristle/math/finite.hpp>
#include <bristle/math/transform.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI {

/// Appends the manifolds of one pair to a list. Manifolds with the same key become one, and points
/// of it that coincide too.
template <Scalar S>
class ContactSink {
 public:
  /// What manifolds are computed in.
  using P = Precise<S>;

  /// @param out  Manifolds there before are left alone.
  explicit ContactSink(ContactManifolds<S>& out) : out_(out), start_(out.size()) {}

  /// How manifolds are given from here on: in a frame F that stands at X_AF in the frame of A, with
  /// normals from A to B or, where `is_reversed`, from B to A.
  void set_frame(const Transform<P>& X_AF, bool is_reversed) {
    X_AF_ = X_AF;
    sign_ = is_reversed ? P(-1) : P(1);
  }

  /// Points closer than this [m] with the same key are one. 0 by default: only equal ones are.
  void set_nearest(P distance) { nearest_ = S(distance); }

  /// Takes a manifold; one without points is ignored.
  void add(const ContactManifold<P>& manifold) {
    if (manifold.size == 0) return;
    ContactManifold<S>& target = manifold_of(manifold);
    for (std::size_t i = 0; i < manifold.size; ++i) {
      const ContactPoint<P>& p = manifold.points[i];
      const Vec3<P> position = X_AF_ * p.position;
      join(target, {position.template cast<S>(), S(p.gap), p.feature});
    }
  }

  /// Whether nothing was added.
  [[nodiscard]] bool is_empty() const { return out_.size() == start_; }
  /// Whether some point has a gap of at most this [m].
  [[nodiscard]] bool reaches(P gap) const {
    for (std::size_t i = start_; i < out_.size(); ++i) {
      for (std::size_t k = 0; k < out_[i].size; ++k) {
        if (P(out_[i].points[k].gap) <= gap) return true;
      }
    }
    return false;
  }
  /// Takes back all that was added.
  void clear() { out_.resize(start_); }

  /// Whether all numbers that were added are finite and all normals have length 1.
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

  /// Adds a point. One too many makes the closest two fight: the deeper stays, or of equals the one
  /// farther from the middle. So the deepest of all is never lost, nor are the outer corners.
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

  /// Which of a full manifold's points has to go for another; its size where it is the other.
  [[nodiscard]] static std::size_t loser_of(const ContactManifold<S>& manifold,
                                            const ContactPoint<S>& point) {
    const auto at = [&](std::size_t i) -> const ContactPoint<S>& {
      return i < manifold.size ? manifold.points[i] : point;
    };
    const S share = S(1) / S(manifold.size + 1);
    Vec3<S> middle = Vec3<S>::Zero();
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

}  // namespace bristle::inline BRISTLE_ABI
