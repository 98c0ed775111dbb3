/// @file
/// Compares the rows of a CSV file: tables as text, plots as SVG.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

namespace bristle::work_precision {

/// Tables of a file: for each scene and step the library against the best peer, the stability
/// matrix, and the count of its cells.
/// With `is_markdown` one table in markdown with a line for each row of the file instead.
/// @param plots  Folder for one plot a scene; empty for none. It is made if it is not there.
/// @throws IoError, InvalidArgument when the file cannot be read or is none of this program.
[[nodiscard]] std::string report(const std::filesystem::path& csv,
                                 const std::filesystem::path& plots, bool is_markdown = false);

}  // namespace bristle::work_precision
