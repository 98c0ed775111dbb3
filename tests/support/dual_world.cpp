// The world of dual_world.hpp, with every member compiled.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/dual_world.hpp"

template class bristle::World<bristle::Dual<double, 2>>;
