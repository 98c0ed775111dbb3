// The world of worlds.hpp that computes derivatives by two numbers, with every member compiled.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/math/dual.hpp>
#include <bristle/world/world.hpp>

template class bristle::World<bristle::Dual<double, 2>>;
