// Those of worlds.hpp in this scalar, with every member compiled. Those of both backends share most
// of their code, which is why they share a file.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/compiled_backends.hpp"

#include <bristle/world/world.hpp>

template class bristle::World<float>;
template class bristle::JointFlow<float>;
template class bristle::HapticLoop<float, bristle::AnalyticBackend>;
#if defined(BRISTLE_WITH_FCL)
template class bristle::World<float, bristle::FclBackend>;
#endif
