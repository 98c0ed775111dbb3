/// @file
/// The scene files of AMBF itself, where they are at hand: the environment's BRISTLE_AMBF_DIR names
/// their folder.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

namespace bristle::test {

/// Returns AMBF's scene files in the order of their names. None, and says so, where they are not at
/// hand.
inline std::vector<std::filesystem::path> ambf_files() {
  std::vector<std::filesystem::path> files;
  const char* const folder = std::getenv("BRISTLE_AMBF_DIR");
  if (folder == nullptr) {
    MESSAGE("skipped: BRISTLE_AMBF_DIR is not set");
    return files;
  }
  std::error_code error;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder, error)) {
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  // A folder that is named and holds none is a slip.
  CHECK_MESSAGE(!files.empty(), "no scene files in ", std::string(folder));
  return files;
}

}  // namespace bristle::test
