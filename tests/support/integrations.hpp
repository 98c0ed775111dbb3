/// @file
/// Both ways of integrating sensors, for tests that hold for either.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/sensors/sensor_parameters.hpp>

namespace bristle::test {

inline constexpr Integration both_integrations[] = {Integration::explicit_, Integration::implicit};

}  // namespace bristle::test
