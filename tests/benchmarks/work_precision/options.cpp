// SPDX-License-Identifier: BSD-3-Clause
#include "benchmarks/work_precision/options.hpp"

#include "benchmarks/work_precision/row.hpp"

#include <cstdlib>
#include <sstream>
#include <stdexcept>

namespace bristle::work_precision {

Options parse_options(int argc, const char* const* argv) {
  Options options;
  const auto to_regex = [](const std::string& option, const std::string& text) {
    try {
      return std::regex(text);
    } catch (const std::regex_error&) {
      throw std::invalid_argument(option + ": '" + text + "' is no regular expression");
    }
  };
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    const auto value = [&] {
      if (i + 1 >= argc) throw std::invalid_argument(option + " needs a value");
      return std::string(argv[++i]);
    };
    if (option == "--scenes") {
      options.scenes = to_regex(option, value());
    } else if (option == "--engines") {
      options.engines = to_regex(option, value());
    } else if (option == "--dt") {
      std::istringstream list(value());
      for (std::string part; std::getline(list, part, ',');) {
        options.time_steps.push_back(parse_time_step(part));
        if (options.time_steps.back() == 0) {
          throw std::invalid_argument("--dt: '" + part + "' must be a step such as 1/240 or 0.01");
        }
      }
    } else if (option == "--quick") {
      options.is_quick = true;
    } else if (option == "--optional") {
      options.has_optional = true;
    } else if (option == "--timeout") {
      const std::string text = value();
      options.timeout = static_cast<unsigned>(std::strtoul(text.c_str(), nullptr, 10));
      if (options.timeout == 0) throw std::invalid_argument("--timeout: must be > 0 s");
    } else if (option == "--report") {
      options.report = value();
    } else if (option == "--plots") {
      options.plots = value();
    } else if (option == "--markdown") {
      options.wants_markdown = true;
    } else if (option == "--list") {
      options.wants_list = true;
    } else if (option == "--help" || option == "-h") {
      options.wants_help = true;
    } else {
      throw std::invalid_argument("unknown option '" + option + "'; see --help");
    }
  }
  return options;
}

std::string help() {
  return R"(Usage: benchmark_work_precision [--scenes REGEX] [--engines REGEX] [--dt LIST] [--quick]
       benchmark_work_precision --report CSV [--plots FOLDER] [--markdown]

Runs scenes of rigid bodies and prints a line of CSV for each engine, setting and step: how wrong
the result is, and what it costs. tests/benchmarks/run compares with other engines in one go.

  --scenes REGEX   scenes, as searched for in group/name: 'matrix/', '^unseen/', 'grip90pct$'
  --engines REGEX  engines and settings, as searched for in engine/setting: 'bristle64/def'
  --dt LIST        steps instead of those of the scene: 1/60,1/240,0.001
  --quick          one timed run instead of three to five, two variations instead of 8 or 20
  --optional       also the scenes that run for minutes
  --timeout S      a run that takes longer counts as crashed (default 900)
  --list           names of all scenes, with what they are and the unit of their error
  --report CSV     compares the rows of a file: a line for each scene and step, the stability
                   matrix, and the count of its cells
  --plots FOLDER   with --report: a plot of error against work for each scene
  --markdown       with --report: a table in markdown of all rows, with their times, instead

The scenes of the group `unseen` are kept for judging: nothing in the library is tuned on them.
They are groove, rollers, tug, coin, cradle, dominoes, overhang, lintel, wedge, toss, turntable,
shaker and servo.
)";
}

}  // namespace bristle::work_precision
