/// @file
/// Shape backend over FCL 0.7 and libccd: rays and contacts of all shapes over FCL's geometry.
///
/// Link `bristle::fcl`. The umbrella header includes this only with BRISTLE_WITH_FCL.
///
/// FCL computes in double, whatever the user's scalar. Rays are cast in S. FCL types that Eigen
/// aligns by the machine (Transform3d, CollisionObject) never cross into libfcl. So either may be
/// built with any -march.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/backends/fcl_geometry.hpp>
#include <bristle/geometry/backends/shape_backend.hpp>
#include <bristle/geometry/shapes/visit_shape.hpp>
#include <bristle/math/finite.hpp>

#include <cstdint>
#include <memory>

namespace bristle::inline BRISTLE_ABI {

/// Satisfies `ShapeBackend` for float and double.
///
/// Contacts are found as in solid_contacts.hpp, over FCL's GJK (fcl_contact_normal.hpp). FCL's own
/// contacts of meshes have no meaningful depth (fcl#106, #491, #574) and are not used. Every pair
/// is known except two half-spaces.
///
/// `collide` allocates only space in `out`; `cast_rays` allocates nothing. FCL's GJK works on the
/// stack. Exceptions of FCL are caught, and supports check its results. All loops are bounded.
struct FclBackend {
  /// A shape prepared for FCL. Copies share it.
  template <Scalar S>
  class Collidable;

  /// `cast_rays` casts only the rays of `RayBatch::range`.
  static constexpr bool asks_ranges = true;

  /// Prepares a shape.
  /// @throws InvalidArgument as `validate` and `to_fcl`.
  template <Scalar S>
  [[nodiscard]] static Collidable<S> make(const Shape<S>& shape);

  /// Kind of the shape.
  template <Scalar S>
  [[nodiscard]] static ShapeKind kind(const Collidable<S>& c);
  /// [m] Box around the shape, in its own frame. Infinite for a half-space.
  template <Scalar S>
  [[nodiscard]] static Aabb<S> bounds(const Collidable<S>& c);
  /// Mass properties at unit density, in the shape's own frame.
  template <Scalar S>
  [[nodiscard]] static MassProperties<S> mass_properties(const Collidable<S>& c);

  /// Returns true for all pairs but two half-spaces.
  [[nodiscard]] static bool can_collide(ShapeKind a, ShapeKind b) {
    return a != ShapeKind::half_space || b != ShapeKind::half_space;
  }

  /// Appends the manifolds of A and B, as `ShapeBackend` requires. Returns `failed` for an unknown
  /// pair, a pose or margin that is not finite, and if FCL throws or gives invalid numbers.
  template <Scalar S>
  [[nodiscard]] static ContactStatus collide(const Collidable<S>& a, const Collidable<S>& b,
                                             const Transform<S>& X_AB, S margin,
                                             ContactManifolds<S>& out) noexcept;

  /// Offers the nearest hit of each ray to `hits`, as `ShapeBackend` requires.
  template <Scalar S>
  static void cast_rays(const Collidable<S>& c, const Transform<S>& X_RC, const RayBatch<S>& rays,
                        std::uint32_t tag, RayHits<S>& hits) noexcept;

  /// Early out for meshes. False for other shapes.
  template <Scalar S>
  [[nodiscard]] static bool is_clear(const Collidable<S>& c, const Transform<S>& X_RC,
                                     const RayBatch<S>& rays) noexcept;

  /// As FCL keeps it, in double.
  template <Scalar S>
  [[nodiscard]] static Shape<S> shape(const Collidable<S>& c);

  /// Calls `visit` with the solid: a HalfSpace, a ConvexView or a MeshSurface, in double.
  template <Scalar S, typename Visit>
  static void visit_solid(const Collidable<S>& c, Visit&& visit);
};

/// A shape prepared by the FCL backend. Copies share one immutable preparation. A
/// default-constructed one is empty and may only be assigned to.
template <Scalar S>
class FclBackend::Collidable {
 public:
  Collidable() = default;

  /// FCL geometry of the shape, for use with FCL itself.
  [[nodiscard]] const detail::FclGeometry& geometry() const;

 private:
  friend struct FclBackend;
  struct Data;

  explicit Collidable(const Shape<S>& shape);

  std::shared_ptr<const Data> data_;
};

}  // namespace bristle::inline BRISTLE_ABI

// Implementation ----------------------------------------------------------------------------------

#if BRISTLE_HAS_DEFINITIONS
#include <bristle/geometry/backends/fcl_contact_normal.hpp>
#include <bristle/geometry/backends/fcl_rays.hpp>
#include <bristle/geometry/backends/fcl_shapes.hpp>
#include <bristle/geometry/contacts/contact_clip.hpp>
#include <bristle/geometry/contacts/contact_sink.hpp>
#include <bristle/geometry/contacts/plane_mesh_contacts.hpp>
#include <bristle/geometry/contacts/shape_cast.hpp>
#include <bristle/geometry/contacts/solid_contacts.hpp>
#include <bristle/geometry/shapes/shape_properties.hpp>

#include <optional>
#include <type_traits>
#include <variant>

namespace bristle::inline BRISTLE_ABI {

/// The immutable preparation that the copies of a `Collidable` share.
template <Scalar S>
struct FclBackend::Collidable<S>::Data {
  /// @throws InvalidArgument as `to_fcl`.
  explicit Data(const Shape<S>& shape);
  Data(const Data&) = delete;
  Data& operator=(const Data&) = delete;

  /// Kind of the shape.
  ShapeKind kind;
  /// [m] Box around the shape, in its own frame. Infinite for a half-space.
  Aabb<S> bounds;
  /// Mass properties at unit density, in the shape's own frame.
  MassProperties<S> mass_properties;
  /// The shape as rays are cast at it. It also owns the geometry.
  detail::FclRayTarget<S> rays;
  /// View of the solid for contacts. It points into `rays`. Empty for a half-space.
  detail::SolidView<double, detail::FclMeshTree<double>> solid;
};

template <Scalar S>
FclBackend::Collidable<S>::Collidable(const Shape<S>& shape)
    : data_(std::make_shared<const Data>(shape)) {}

template <Scalar S>
const detail::FclGeometry& FclBackend::Collidable<S>::geometry() const {
  return data_->rays.geometry();
}

namespace detail {

/// A half-space for clipping: a square of its surface that is larger than the solid above it.
struct SurfacePatch {
  Vec3<double> center;
  Vec3<double> normal;
  double half_width;
};

[[nodiscard]] inline Vec3<double> support_point(const SurfacePatch& patch, const Vec3<double>&) {
  return patch.center;
}
[[nodiscard]] inline SupportFeature<double> support_face(const SurfacePatch& patch,
                                                         const Vec3<double>& direction) {
  SupportFeature<double> face;
  face.normal = patch.normal;
  face.cosine = patch.normal.dot(direction);
  Vec3<double> t1;
  Vec3<double> t2;
  tangent_basis(patch.normal, t1, t2);
  face.add(patch.center - patch.half_width * (t1 + t2), 0);
  face.add(patch.center + patch.half_width * (t1 - t2), 1);
  face.add(patch.center + patch.half_width * (t1 + t2), 2);
  face.add(patch.center - patch.half_width * (t1 - t2), 3);
  return face;
}
[[nodiscard]] inline SupportFeature<double> support_edge(const SurfacePatch& patch,
                                                         const Vec3<double>& direction) {
  return support_face(patch, direction);
}

/// Adds the contacts of a half-space with a convex solid, in the solid's frame. `plane` is given in
/// that frame, too. Normals run from the half-space to the solid.
template <Scalar S>
void collide_plane(const HalfSpace<double>& plane, const ConvexView<double>& convex, double margin,
                   ContactSink<S>& sink) {
  const double height = plane.normal.dot(convex.center) - plane.offset;
  if (height - convex.reach > margin) return;
  const SurfacePatch patch{convex.center - height * plane.normal, plane.normal, 2.0 * convex.reach};
  sink.add(contact_manifold(patch, convex, Transform<double>{}, plane.normal, margin));
}

}  // namespace detail

template <Scalar S>
FclBackend::Collidable<S>::Data::Data(const Shape<S>& shape)
    : kind(kind_of(shape)),
      bounds(local_bounds(shape)),
      mass_properties(unit_mass_properties(shape)),
      rays(detail::to_fcl(shape)) {
  detail::visit_shape(
      [this](const auto& view) {
        using View = std::remove_cvref_t<decltype(view)>;
        if constexpr (std::is_same_v<View, detail::FclMeshTree<double>>) {
          solid.mesh.emplace(view);
        } else if constexpr (!std::is_same_v<View, HalfSpace<double>>) {
          solid.convex.emplace(detail::convex_view(view));
        }
      },
      rays.view());
}

/// As declared: throws InvalidArgument as `validate` and `to_fcl`.
template <Scalar S>
auto FclBackend::make(const Shape<S>& shape) -> Collidable<S> {
  validate(shape);
  return Collidable<S>(shape);
}

template <Scalar S>
ShapeKind FclBackend::kind(const Collidable<S>& c) {
  return c.data_->kind;
}

template <Scalar S>
Aabb<S> FclBackend::bounds(const Collidable<S>& c) {
  return c.data_->bounds;
}

template <Scalar S>
MassProperties<S> FclBackend::mass_properties(const Collidable<S>& c) {
  return c.data_->mass_properties;
}

namespace detail {

/// One contact query in double: A and B with their preparations, and the pose of B.
template <Scalar S, typename Data>
class FclContactQuery {
 public:
  FclContactQuery(const Data& a, const Data& b, const Transform<double>& X_AB, double margin,
                  ContactSink<S>& sink)
      : a_(a), b_(b), X_AB_(X_AB), margin_(margin), sink_(sink) {}

  /// Returns false if nothing is known.
  bool run() {
    if (a_.kind == ShapeKind::half_space) return on_plane(a_, b_, X_AB_, X_AB_, false);
    if (b_.kind == ShapeKind::half_space) return on_plane(b_, a_, X_AB_.inverse(), {}, true);
    return collide_solids<FclDistance>(a_.solid, b_.solid, X_AB_, margin_, sink_);
  }

 private:
  /// @param X_PO      Pose of the other solid in the frame of the half-space.
  /// @param X_AO      Its pose in the frame of A, the frame of the results.
  /// @param is_second True if the half-space is B.
  bool on_plane(const Data& plane, const Data& other, const Transform<double>& X_PO,
                const Transform<double>& X_AO, bool is_second) {
    const auto& plane_P = std::get<HalfSpace<double>>(plane.rays.view());
    sink_.set_frame(X_AO, is_second);
    if (other.solid.mesh) {
      collide_plane_mesh(plane_P, *other.solid.mesh, X_PO, margin_, sink_);
    } else {
      collide_plane(seen_from(X_PO, plane_P), *other.solid.convex, margin_, sink_);
    }
    return true;
  }

  const Data& a_;
  const Data& b_;
  const Transform<double>& X_AB_;
  double margin_;
  ContactSink<S>& sink_;
};

}  // namespace detail

template <Scalar S>
ContactStatus FclBackend::collide(const Collidable<S>& a, const Collidable<S>& b,
                                  const Transform<S>& X_AB, S margin,
                                  ContactManifolds<S>& out) noexcept {
  using std::isfinite;
  const Transform<double> X = X_AB.template cast<double>();
  if (!detail::all_finite(X.translation) || !detail::all_finite(X.rotation.coeffs()) ||
      !isfinite(margin)) {
    return ContactStatus::failed;
  }
  if (!can_collide(kind(a), kind(b))) return ContactStatus::failed;
  detail::ContactSink<S> sink(out);
  try {
    using Data = typename Collidable<S>::Data;
    detail::FclContactQuery<S, Data> query(*a.data_, *b.data_, X, double(margin), sink);
    if (query.run() && sink.is_sound()) return ContactStatus::ok;
  } catch (...) {
    // FCL throws std::logic_error and more. The kind does not matter within a step.
  }
  sink.clear();
  return ContactStatus::failed;
}

template <Scalar S>
void FclBackend::cast_rays(const Collidable<S>& c, const Transform<S>& X_RC,
                           const RayBatch<S>& rays, std::uint32_t tag, RayHits<S>& hits) noexcept {
  c.data_->rays.cast_rays(X_RC, rays, tag, hits);
}

template <Scalar S>
bool FclBackend::is_clear(const Collidable<S>& c, const Transform<S>& X_RC,
                          const RayBatch<S>& rays) noexcept {
  return c.data_->rays.misses(X_RC, rays);
}

template <Scalar S, typename Visit>
void FclBackend::visit_solid(const Collidable<S>& c, Visit&& visit) {
  const auto& solid = c.data_->solid;
  if (solid.mesh) {
    visit(*solid.mesh);
  } else if (solid.convex) {
    visit(*solid.convex);
  } else {
    visit(std::get<HalfSpace<double>>(c.data_->rays.view()));
  }
}

template <Scalar S>
Shape<S> FclBackend::shape(const Collidable<S>& c) {
  return detail::visit_shape(
      [](const auto& view) -> Shape<S> {
        using View = std::remove_cvref_t<decltype(view)>;
        if constexpr (std::is_same_v<View, detail::FclMeshTree<double>>) {
          return view.template mesh<S>();
        } else {
          return detail::ShapeCast<S, double>{}(view);
        }
      },
      c.data_->rays.view());
}

}  // namespace bristle::inline BRISTLE_ABI
#endif

#if defined(BRISTLE_COMPILED) && BRISTLE_HAS_DEFINITIONS
namespace bristle::inline BRISTLE_ABI {

extern template class FclBackend::Collidable<float>;
extern template class FclBackend::Collidable<double>;
BRISTLE_BACKEND_QUERIES(extern template, FclBackend, float)
BRISTLE_BACKEND_QUERIES(extern template, FclBackend, double)
BRISTLE_BACKEND_MAKERS(extern template, FclBackend, float)
BRISTLE_BACKEND_MAKERS(extern template, FclBackend, double)

}  // namespace bristle::inline BRISTLE_ABI
#endif
