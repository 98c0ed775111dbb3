/// @file
/// Distance of two convex cores by FCL's GJK over libccd, as a method of contact_normal.hpp.
///
/// Parts of FCL that are used, and parts that are not:
/// - `fcl::detail::GJKDistance`, the routine behind `fcl::distance`, is used. An iteration count
///   bounds every loop in it, and it allocates nothing. It gets support functions of our own, in
///   which the larger solid always has the size 1. Otherwise libccd, which compares squared areas
///   of its simplex with an absolute 2.2e-16, would take millimetre shapes in metres as touching or
///   apart at random.
/// - The contacts of `fcl::collide` are not used. If FCL has no closed form they come from libccd's
///   portal refinement. That is an unbounded loop, along a normal that is not that of least depth
///   (fcl#243, libccd#71, fcl#545).
/// - The signed distance is not used. Its expanding polytope may loop for ever or throw (fcl#578,
///   fcl#493, drake#18704).
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/contacts/contact_normal.hpp>
#include <bristle/geometry/geometry_constants.hpp>

#include <fcl/narrowphase/detail/convexity_based_algorithm/gjk_libccd.h>

namespace bristle::inline BRISTLE_ABI::detail {

/// Distance method of FCL. `contact_normal<FclDistance>` may throw if FCL does.
struct FclDistance {
  [[nodiscard]] GjkResult<double> operator()(PlacedConvex<double> a, PlacedConvex<double> b,
                                             const Vec3<double>& towards, double far) const;
};

// Implementation ----------------------------------------------------------------------------------

/// Support function that libccd calls; `object` is a PlacedConvex.
inline void ccd_support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* result) {
  const Vec3<double> p = static_cast<const PlacedConvex<double>*>(object)->support(
      {direction->v[0], direction->v[1], direction->v[2]});
  ccdVec3Set(result, p.x(), p.y(), p.z());
}

// FCL takes neither a starting direction nor a sufficient distance.
inline GjkResult<double> FclDistance::operator()(PlacedConvex<double> a, PlacedConvex<double> b,
                                                 const Vec3<double>&, double) const {
  // GJK ends when a step gains less than this. Polyhedra end exactly with any value.
  const double tolerance = chosen::ccd_gain * Tolerance<double>::round_off();
  double distance = 0.0;
  Vec3<double> on_a, on_b;
  if (!fcl::detail::GJKDistance<double>(&a, ccd_support, &b, ccd_support, chosen::ccd_iterations,
                                        tolerance, &distance, &on_a, &on_b)) {
    return {};
  }
  const Vec3<double> normal = (on_b - on_a).normalized();
  // False for zero and for NaN.
  return {normal.squaredNorm() > 0.5, normal, distance};
}

}  // namespace bristle::inline BRISTLE_ABI::detail
