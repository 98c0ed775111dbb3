/// @file
/// Shape backend over FCL 0.7 and libccd: rays and contacts of all shapes over FCL's geometry.
///
/// Link `bristle::fcl`; the umbrella header includes this only with BRISTLE_WITH_FCL.
///
/// Everything FCL is asked is asked in double, whatever the user's scalar; rays are cast in S. No
/// FCL type that Eigen aligns by the machine (Transform3d, CollisionObject) crosses into libfcl, so
/// it does not matter with which -march either was built.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/backends/fcl_geometry.hpp>
#include <bristle/geometry/backends/shape_backend.hpp>
#include <bristle/math/finite.hpp>

#include <cstdint>
#include <memory>

namespace bristle::inline BRISTLE_ABI {

/// Satisfies `ShapeBackend` for float and double.
///
/// Contacts as solid_contacts.hpp finds them, over FCL's GJK (fcl_contact_normal.hpp) and FCL's
/// mesh trees. What FCL itself reports for a mesh has no meaningful depth (fcl#106, #491, #574) and
/// is not used. Every pair is known except two half-spaces.
///
/// `collide` allocates nothing but room in `out`, `cast_rays` nothing at all: FCL's GJK works on
/// the stack. What FCL may throw is caught, what it answers is checked with supports; there is no
/// loop without bound on the way.
struct FclBackend {
  template <Scalar S>
  class Collidable;

  static constexpr bool asks_slices = true;

  /// @throws InvalidArgument as `validate` and `to_fcl` do.
  template <Scalar S>
  [[nodiscard]] static Collidable<S> make(const Shape<S>& shape);

  template <Scalar S>
  [[nodiscard]] static ShapeKind kind(const Collidable<S>& c);
  template <Scalar S>
  [[nodiscard]] static Aabb<S> bounds(const Collidable<S>& c);
  template <Scalar S>
  [[nodiscard]] static MassProperties<S> mass_properties(const Collidable<S>& c);

  /// All pairs but two half-spaces.
  [[nodiscard]] static bool can_collide(ShapeKind a, ShapeKind b) {
    return a != ShapeKind::half_space || b != ShapeKind::half_space;
  }

  /// As `ShapeBackend` says. `failed` for a pair it does not know, a pose or margin that is not
  /// finite, and for whatever of FCL throws or gives numbers that are none.
  template <Scalar S>
  [[nodiscard]] static ContactStatus collide(const Collidable<S>& a, const Collidable<S>& b,
                                             const Transform<S>& X_AB, S margin,
                                             ContactManifolds<S>& out) noexcept;

  template <Scalar S>
  static void cast_rays(const Collidable<S>& c, const Transform<S>& X_RC, const RayBatch<S>& rays,
                        std::uint32_t tag, RayHits<S>& hits) noexcept;

  /// Meshes only.
  template <Scalar S>
  [[nodiscard]] static bool is_clear(const Collidable<S>& c, const Transform<S>& X_RC,
                                     const RayBatch<S>& rays) noexcept;
};

/// A shape as the FCL backend holds it. Copies share one immutable preparation; the default-
/// constructed one holds nothing and may only be assigned to.
template <Scalar S>
class FclBackend::Collidable {
 public:
  Collidable() = default;

  /// The FCL geometry, for whoever wants to hand it to FCL.
  [[nodiscard]] const FclGeometry& geometry() const;

 private:
  friend struct FclBackend;
  struct Data;

  explicit Collidable(const Shape<S>& shape);

  std::shared_ptr<const Data> data_;
};

}  // namespace bristle::inline BRISTLE_ABI

// Implementation -----------------------------------------------------------------------------------

#if BRISTLE_HAS_DEFINITIONS
#include <bristle/geometry/backends/fcl_contact_normal.hpp>
#include <bristle/geometry/backends/fcl_rays.hpp>
#include <bristle/geometry/backends/fcl_shapes.hpp>
#include <bristle/geometry/contacts/contact_clip.hpp>
#include <bristle/geometry/contacts/contact_sink.hpp>
#include <bristle/geometry/contacts/solid_contacts.hpp>
#include <bristle/geometry/shapes/shape_properties.hpp>

#include <optional>
#include <type_traits>
#include <variant>

namespace bristle::inline BRISTLE_ABI {

template <Scalar S>
struct FclBackend::Collidable<S>::Data {
  explicit Data(const Shape<S>& shape);
  Data(const Data&) = delete;
  Data& operator=(const Data&) = delete;

  ShapeKind kind;
  Aabb<S> bounds;
  MassProperties<S> mass_properties;
  FclRayTarget<S> rays;
  // Points into `rays`; empty for a half-space.
  SolidView<double, FclMeshTree<double>> solid;
};

template <Scalar S>
FclBackend::Collidable<S>::Collidable(const Shape<S>& shape)
    : data_(std::make_shared<const Data>(shape)) {}

template <Scalar S>
const FclGeometry& FclBackend::Collidable<S>::geometry() const {
  return data_->rays.geometry();
}

namespace detail {

/// A half-space as the clip sees it: a square of its surface that is larger than what lies on it.
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

/// Adds the contacts of a half-space with a convex solid, in the solid's frame, where `plane` is
/// given. Normals point from the half-space to the solid.
template <Scalar S>
void collide_plane(const HalfSpace<double>& plane, const ConvexView<double>& convex, double margin,
                   ContactSink<S>& sink) {
  const double height = plane.normal.dot(convex.center) - plane.offset;
  if (height - convex.reach > margin) return;
  const SurfacePatch patch{convex.center - height * plane.normal, plane.normal, 2.0 * convex.reach};
  sink.add(contact_manifold(patch, convex, Transform<double>{}, plane.normal, margin));
}

/// The same for a mesh: its vertices within `margin`.
template <Scalar S>
void collide_plane(const HalfSpace<double>& plane,
                   const MeshSurface<double, FclMeshTree<double>>& mesh, double margin,
                   ContactSink<S>& sink) {
  sink.set_nearest(0.0);
  const Vec3<double>& n = plane.normal;
  const auto height = [&](const Vec3<double>& p) { return n.dot(p) - plane.offset; };
  ContactManifold<double> one;
  one.normal = n;
  one.size = 1;
  mesh.find(
      [&](const Aabb<double>& box) {
        return height((n.array() < 0.0).select(box.upper, box.lower)) <= margin;
      },
      [&](std::uint32_t i) {
        const Triangle<double> triangle = mesh.triangle(i);
        for (std::size_t k = 0; k < 3; ++k) {
          const Vec3<double>& corner = triangle.corners[k];
          const double gap = height(corner);
          if (!(gap <= margin)) continue;
          one.points[0] = {corner - 0.5 * gap * n, gap, triangle.names[k]};
          sink.add(one);
        }
        return true;
      });
}

/// A half-space given in frame A, seen from frame B that stands at X_AB.
[[nodiscard]] inline HalfSpace<double> seen_from(const Transform<double>& X_AB,
                                                 const HalfSpace<double>& plane_A) {
  return {X_AB.rotation.conjugate() * plane_A.normal,
          plane_A.offset - plane_A.normal.dot(X_AB.translation)};
}

}  // namespace detail

template <Scalar S>
FclBackend::Collidable<S>::Data::Data(const Shape<S>& shape)
    : kind(kind_of(shape)),
      bounds(local_bounds(shape)),
      mass_properties(unit_mass_properties(shape)),
      rays(to_fcl(shape)) {
  std::visit(
      [this](const auto& view) {
        using View = std::remove_cvref_t<decltype(view)>;
        if constexpr (std::is_same_v<View, FclMeshTree<double>>) {
          solid.mesh.emplace(view);
        } else if constexpr (!std::is_same_v<View, HalfSpace<double>>) {
          solid.convex.emplace(convex_view(view));
        }
      },
      rays.view());
}

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

/// One contact query in double: A and B, what is known of them, and where B stands.
template <Scalar S, typename Data>
class FclContactQuery {
 public:
  FclContactQuery(const Data& a, const Data& b, const Transform<double>& X_AB, double margin,
                  ContactSink<S>& sink)
      : a_(a), b_(b), X_AB_(X_AB), margin_(margin), sink_(sink) {}

  /// False where nothing is known.
  bool run() {
    if (a_.kind == ShapeKind::half_space) return on_plane(a_, b_, X_AB_, X_AB_, false);
    if (b_.kind == ShapeKind::half_space) return on_plane(b_, a_, X_AB_.inverse(), {}, true);
    return collide_solids<FclDistance>(a_.solid, b_.solid, X_AB_, margin_, sink_);
  }

 private:
  /// @param X_PO      Pose of the other solid in the frame of the half-space.
  /// @param X_AO      Its pose in the frame of A, in which the answer is due.
  /// @param is_second Whether the half-space is B.
  bool on_plane(const Data& plane, const Data& other, const Transform<double>& X_PO,
                const Transform<double>& X_AO, bool is_second) {
    const HalfSpace<double> plane_O =
        seen_from(X_PO, std::get<HalfSpace<double>>(plane.rays.view()));
    sink_.set_frame(X_AO, is_second);
    if (other.solid.mesh) {
      collide_plane(plane_O, *other.solid.mesh, margin_, sink_);
    } else {
      collide_plane(plane_O, *other.solid.convex, margin_, sink_);
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
  if (!all_finite(X.translation) || !all_finite(X.rotation.coeffs()) || !isfinite(margin)) {
    return ContactStatus::failed;
  }
  if (!can_collide(kind(a), kind(b))) return ContactStatus::failed;
  ContactSink<S> sink(out);
  try {
    using Data = typename Collidable<S>::Data;
    detail::FclContactQuery<S, Data> query(*a.data_, *b.data_, X, double(margin), sink);
    if (query.run() && sink.is_sound()) return ContactStatus::ok;
  } catch (...) {
    // FCL throws std::logic_error and more; which one it was helps nobody within a step.
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
  return c.data_->rays.is_clear(X_RC, rays);
}

}  // namespace bristle::inline BRISTLE_ABI
#endif

#if defined(BRISTLE_COMPILED) && BRISTLE_HAS_DEFINITIONS
namespace bristle::inline BRISTLE_ABI {

extern template class FclBackend::Collidable<float>;
extern template class FclBackend::Collidable<double>;
BRISTLE_BACKEND_FUNCTIONS(extern template, FclBackend, float)
BRISTLE_BACKEND_FUNCTIONS(extern template, FclBackend, double)

}  // namespace bristle::inline BRISTLE_ABI
#endif
