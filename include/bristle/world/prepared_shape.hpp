/// @file
/// A shape as a backend prepared it, without the backend's type.
///
/// The stages of a step call a backend once for a pair of shapes, or for a patch and a shape. They
/// reach it through a table of functions, so they are compiled once for all backends.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/backends/shape_backend.hpp>

#include <cstdint>
#include <memory>

namespace bristle::inline BRISTLE_ABI::detail {

/// Queries of a step about the collidables of a backend, compiled for each instruction set.
/// Pointers are to collidables. See `ShapeBackend`.
template <Scalar S>
struct ShapeQueries {
  ContactStatus (*collide)(const void* a, const void* b, const Transform<S>& X_AB, S margin,
                           ContactManifolds<S>& out) noexcept;
  void (*cast_rays)(const void* c, const Transform<S>& X_RC, const RayBatch<S>& rays,
                    std::uint32_t tag, RayHits<S>& hits) noexcept;
  bool (*is_surely_clear)(const void* c, const Transform<S>& X_RC,
                          const RayBatch<S>& rays) noexcept;
  bool asks_ranges;
};

/// The queries of a backend, in this file's instruction set.
template <Scalar S, typename Backend>
[[nodiscard]] const ShapeQueries<S>& own_shape_queries() {
  using Collidable = typename Backend::template Collidable<S>;
  static constexpr auto as = [](const void* c) -> const Collidable& {
    return *static_cast<const Collidable*>(c);
  };
  static constexpr ShapeQueries<S> own{
      .collide = [](const void* a, const void* b, const Transform<S>& X_AB, S margin,
                    ContactManifolds<S>& out) noexcept -> ContactStatus {
        return Backend::collide(as(a), as(b), X_AB, margin, out);
      },
      .cast_rays =
          [](const void* c, const Transform<S>& X_RC, const RayBatch<S>& rays, std::uint32_t tag,
             RayHits<S>& hits) noexcept { Backend::cast_rays(as(c), X_RC, rays, tag, hits); },
      .is_surely_clear = [](const void* c, const Transform<S>& X_RC,
                            const RayBatch<S>& rays) noexcept -> bool {
        return bristle::is_surely_clear<S, Backend>(as(c), X_RC, rays);
      },
      .asks_ranges = bristle::asks_ranges<Backend>};
  return own;
}

/// A collidable and the functions that query it. Copies share the collidable, which never changes.
template <Scalar S>
class PreparedShape {
 public:
  PreparedShape() = default;
  template <typename Collidable>
  PreparedShape(const ShapeQueries<S>& queries, Collidable collidable)
      : queries_(&queries),
        collidable_(std::make_shared<const Collidable>(std::move(collidable))) {}

  /// The collidable. `Collidable` must be the type that the shape was made with.
  template <typename Collidable>
  [[nodiscard]] const Collidable& as() const noexcept {
    return *static_cast<const Collidable*>(collidable_.get());
  }

  // Queries, as of `ShapeBackend`. All shapes of a world are of one backend.

  ContactStatus collide(const PreparedShape& other, const Transform<S>& X_AB, S margin,
                        ContactManifolds<S>& out) const noexcept {
    return queries_->collide(collidable_.get(), other.collidable_.get(), X_AB, margin, out);
  }
  void cast_rays(const Transform<S>& X_RC, const RayBatch<S>& rays, std::uint32_t tag,
                 RayHits<S>& hits) const noexcept {
    queries_->cast_rays(collidable_.get(), X_RC, rays, tag, hits);
  }
  [[nodiscard]] bool is_surely_clear(const Transform<S>& X_RC,
                                     const RayBatch<S>& rays) const noexcept {
    return queries_->is_surely_clear(collidable_.get(), X_RC, rays);
  }
  [[nodiscard]] bool asks_ranges() const noexcept { return queries_->asks_ranges; }

 private:
  const ShapeQueries<S>* queries_ = nullptr;
  std::shared_ptr<const void> collidable_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
