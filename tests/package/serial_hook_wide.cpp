// Asks for the default hook in code for wider registers.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/core/parallel.hpp>

bool is_known_elsewhere(const bristle::ParallelFor& hook);
bool is_known_elsewhere(const bristle::ParallelFor& hook) { return bristle::is_serial(hook); }
