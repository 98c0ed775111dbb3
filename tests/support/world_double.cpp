// One of the worlds of worlds.hpp, with every member compiled.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/compiled_backends.hpp"

#include <bristle/world/world.hpp>

template class bristle::World<double>;
template class bristle::JointFlow<double>;
template class bristle::HapticLoop<double, bristle::AnalyticBackend>;
