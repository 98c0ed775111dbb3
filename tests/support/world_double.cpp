// Those of worlds.hpp in this scalar, with every member compiled. Those of both backends share most
// of their code, which is why they share a file.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/compiled_backends.hpp"

#include <bristle/world/world.hpp>

template class bristle::World<double>;
template class bristle::JointFlow<double>;
template class bristle::HapticLoop<double, bristle::AnalyticBackend>;
#if defined(BRISTLE_WITH_FCL)
template class bristle::World<double, bristle::FclBackend>;
#endif
