/// @file
/// Distance of two convex cores by FCL's GJK over libccd, as a method of contact_normal.hpp.
///
/// What is used of FCL, and what is not, and why:
/// - `fcl::detail::GJKDistance`, the routine behind `fcl::distance`: every loop in it is bounded by
///   an iteration count, and it allocates nothing. It is asked with support functions of our own
///   because libccd compares squared areas of its simplex with an absolute 2.2e-16: millimetre
///   shapes in metres would count as touching or apart at random. Here the larger of the two solids
///   has the size 1 always.
/// - Not the contacts of `fcl::collide`: where FCL has no closed form they come from libccd's
/// portal
///   refinement, a loop without bound, along a normal that is not that of least depth (fcl#243,
///   libccd#71, fcl#545). Not the signed distance: its expanding polytope may loop for ever or
///   throw (fcl#578, fcl#493, drake#18704).
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/contacts/contact_normal.hpp>

#include <fcl/narrowphase/detail/convexity_based_algorithm/gjk_libccd.h>

namespace bristle::inline BRISTLE_ABI {

/// `contact_normal<FclDistance>` may throw where FCL does.
struct FclDistance {
  [[nodiscard]] GjkAnswer<double> operator()(PlacedConvex<double> a, PlacedConvex<double> b,
                                             const Vec3<double>& towards, double far) const;
};

// Implementation -----------------------------------------------------------------------------------

namespace detail {

/// What libccd calls: the object is a PlacedConvex.
inline void ccd_support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* result) {
  const Vec3<double> p = static_cast<const PlacedConvex<double>*>(object)->support(
      {direction->v[0], direction->v[1], direction->v[2]});
  ccdVec3Set(result, p.x(), p.y(), p.z());
}

}  // namespace detail

// FCL has no way to be told where to begin or when it is enough.
inline GjkAnswer<double> FclDistance::operator()(PlacedConvex<double> a, PlacedConvex<double> b,
                                                 const Vec3<double>&, double) const {
  constexpr unsigned max_iterations = 128;
  // GJK ends when a step gains less than this. Finer only brings degenerate simplices, with answers
  // that are worse; polyhedra end exactly whatever it is.
  constexpr double tolerance = 1024.0 * Tolerance<double>::round_off();
  double distance = 0.0;
  Vec3<double> on_a, on_b;
  if (!fcl::detail::GJKDistance<double>(&a, detail::ccd_support, &b, detail::ccd_support,
                                        max_iterations, tolerance, &distance, &on_a, &on_b)) {
    return {};
  }
  const Vec3<double> normal = (on_b - on_a).normalized();
  // Neither zero nor NaN.
  return {normal.squaredNorm() > 0.5, normal, distance};
}

}  // namespace bristle::inline BRISTLE_ABI
