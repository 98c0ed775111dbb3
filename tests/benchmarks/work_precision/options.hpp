/// @file
/// Options of the benchmark's command line.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <regex>
#include <string>
#include <string_view>
#include <vector>

namespace bristle::work_precision {

/// Parsed command line.
struct Options {
  /// [-] Scenes and engines to run, as searched for in "group/scene" and "engine/setting".
  std::regex scenes{"."};
  std::regex engines{"."};
  /// [s] Steps; empty: those of each scene.
  std::vector<double> time_steps;
  bool is_quick = false;
  /// [-] True to run optional scenes, too.
  bool has_optional = false;
  /// [s] After which a run counts as crashed.
  unsigned timeout = 900;
  /// [-] Actions instead of a run: print help or the list of scenes and engines, or report.
  bool wants_help = false;
  bool wants_list = false;
  std::string report;
  std::string plots;
  bool wants_markdown = false;
};

/// @throws std::invalid_argument with a sentence on what is wrong.
[[nodiscard]] Options parse_options(int argc, const char* const* argv);

/// Text of --help.
[[nodiscard]] std::string help();

}  // namespace bristle::work_precision
