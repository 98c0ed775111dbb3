/// @file
/// Error against work, one plot a scene.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "benchmarks/work_precision/row.hpp"

#include <filesystem>
#include <vector>

namespace bristle::work_precision {

using namespace bristle::detail;

/// Returns whether a row is of this library and not of a peer.
[[nodiscard]] inline bool is_ours(const Row& row) { return row.engine.starts_with("bristle"); }

/// Writes SCENE.svg for each scene. The curves of this library are its settings over the steps;
/// that of a peer is the best it does in any setting at any step.
/// @throws IoError
void write_plots(const std::vector<Row>& rows, const std::filesystem::path& folder);

}  // namespace bristle::work_precision
