/// @file
/// Where the scene files of the examples lie.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

namespace bristle::test {

inline const std::filesystem::path example_scenes = BRISTLE_SCENES_DIR;

}  // namespace bristle::test
