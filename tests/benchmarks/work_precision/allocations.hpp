/// @file
/// Counts allocations of this thread, those of C libraries included.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

namespace bristle::work_precision {

/// [-] Allocations of this thread so far; nothing where they cannot be counted (allocations.cpp).
[[nodiscard]] std::optional<long> allocations();

}  // namespace bristle::work_precision
