/// @file
/// For planted bugs: the world of floats is taken as it is compiled for the tests, sound, so that
/// only the one of doubles is compiled with the bug. It halves what a mutant costs.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/world/world.hpp>

extern template class bristle::World<float>;
