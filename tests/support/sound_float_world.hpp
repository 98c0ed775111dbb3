/// @file
/// For planted bugs: the world of floats and the backends are taken as they are compiled for the
/// tests, sound, so that only the world of doubles is compiled with the bug. It takes two thirds
/// off what a mutant costs.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/world/world.hpp>

extern template class bristle::World<float>;
