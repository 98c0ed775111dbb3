/// @file
/// A world that computes derivatives by two numbers, compiled once: of programs that link
/// bristle_dual_world.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/dual.hpp>
#include <bristle/world/world.hpp>

extern template class bristle::World<bristle::Dual<double, 2>>;
