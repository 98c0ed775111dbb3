// One of the worlds of worlds.hpp, with every member compiled.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/compiled_backends.hpp"

#include <bristle/world/world.hpp>

template class bristle::World<float>;
template class bristle::JointFlow<float>;
template class bristle::HapticLoop<float, bristle::AnalyticBackend>;
