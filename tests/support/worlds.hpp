/// @file
/// The worlds that tests use, their haptic loops and backends. They are compiled once, in the files
/// beside this one, and not in every test: each takes a compiler about a minute. The groups that
/// simulate get this header by itself, with the precompiled ones; a unit test of the world includes
/// it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "support/compiled_backends.hpp"

#include <bristle/math/dual.hpp>
#include <bristle/world/world.hpp>

extern template class bristle::World<float>;
extern template class bristle::World<double>;
extern template class bristle::JointFlow<float>;
extern template class bristle::JointFlow<double>;
extern template class bristle::HapticLoop<float, bristle::AnalyticBackend>;
extern template class bristle::HapticLoop<double, bristle::AnalyticBackend>;

// Of programs that link bristle_dual_world, too.
extern template class bristle::World<bristle::Dual<double, 2>>;

#if defined(BRISTLE_WITH_FCL)
extern template class bristle::World<float, bristle::FclBackend>;
extern template class bristle::World<double, bristle::FclBackend>;
#endif
