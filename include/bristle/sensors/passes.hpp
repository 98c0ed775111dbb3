/// @file
/// Former name of solve_passes.hpp, for bristle.hpp alone.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/sensors/solve_passes.hpp>
