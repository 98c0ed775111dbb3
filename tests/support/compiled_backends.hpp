/// @file
/// The backends' functions, which are compiled once like the worlds of worlds.hpp: a test that asks
/// a backend takes a compiler half a minute without.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/analytic_backend.hpp>

#if defined(BRISTLE_WITH_FCL)
#include <bristle/geometry/fcl_backend.hpp>
#endif

/// Declares (`extern template`) or makes (`template`) the functions of a backend in a scalar.
#define BRISTLE_TEST_BACKEND(instantiate, Backend, S)                                        \
  instantiate Backend::Collidable<S> Backend::make<S>(const Shape<S>&);                      \
  instantiate ContactStatus Backend::collide<S>(                                             \
      const Backend::Collidable<S>&, const Backend::Collidable<S>&, const Transform<S>&, S,  \
      ContactManifolds<S>&) noexcept;                                                        \
  instantiate void Backend::cast_rays<S>(const Backend::Collidable<S>&, const Transform<S>&, \
                                         const RayBatch<S>&, std::uint32_t, RayHits<S>&) noexcept;

namespace bristle {

BRISTLE_TEST_BACKEND(extern template, AnalyticBackend, float)
BRISTLE_TEST_BACKEND(extern template, AnalyticBackend, double)
#if defined(BRISTLE_WITH_FCL)
BRISTLE_TEST_BACKEND(extern template, FclBackend, float)
BRISTLE_TEST_BACKEND(extern template, FclBackend, double)
#endif

}  // namespace bristle
