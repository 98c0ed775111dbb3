/// @file
/// Constants of the core that no formula gives.
///
/// `tests/constants` runs scenes with each at half and at twice its value.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <cstddef>

namespace bristle::inline BRISTLE_ABI::detail::chosen {

/// [-] Turns of a loop for each worker. A smaller value lets workers wait for one long turn of
/// another. A greater one takes turns more often.
inline constexpr std::size_t turns_of_worker = 8;

/// [-] Looks for work before a thread yields: some twenty microseconds on an AMD EPYC (Zen 5). A
/// smaller value yields between loops of a step, which costs 0.45 us each (log 0026). A greater one
/// keeps a core busy.
inline constexpr int looks_before_yield = 800;

/// [-] Yields before a thread sleeps: some fifty microseconds there. A smaller value sleeps between
/// loops, and waking takes ten microseconds (log 0026). A greater one keeps a core busy.
inline constexpr int yields_before_sleep = 100;

}  // namespace bristle::inline BRISTLE_ABI::detail::chosen
