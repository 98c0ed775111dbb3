// The program around a driver: each run in a process of its own, so that an engine that crashes
// costs one row.
// SPDX-License-Identifier: BSD-3-Clause
#include "benchmarks/work_precision/measure.hpp"
#include "benchmarks/work_precision/options.hpp"
#include "benchmarks/work_precision/report.hpp"
#include "scenes/rigid/catalogue.hpp"

#include <array>
#include <cstdio>
#include <exception>
#include <optional>
#include <stdexcept>
#include <sys/wait.h>
#include <unistd.h>

using namespace bristle;

using namespace bristle::detail;
using namespace bristle::work_precision;

namespace {

constexpr int unsupported_code = 3;

/// Runs the task in the child process; the row is its only output.
[[noreturn]] void run_child(const Task& task, int pipe_end) {
  int code = 0;
  try {
    const std::string line = csv_line(measure(task));
    const ssize_t written = write(pipe_end, line.data(), line.size());
    if (written != static_cast<ssize_t>(line.size())) code = 1;
  } catch (const scenes::Unsupported& e) {
    std::fprintf(stderr, "%s leaves out %s: %s\n", task.family->name.c_str(),
                 task.recipe->name.c_str(), e.what());
    code = unsupported_code;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s on %s: %s\n", task.family->name.c_str(), task.recipe->name.c_str(),
                 e.what());
    code = 1;
  }
  // Engines are left as they are: some do not survive their own clean-up.
  _exit(code);
}

/// Line of a task; nothing where the engine does not know the scene.
std::optional<std::string> line_of(const Task& task, unsigned timeout) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) throw std::runtime_error("no pipe for a run");
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("no process for a run");
  if (child == 0) {
    close(ends[0]);
    alarm(timeout);
    run_child(task, ends[1]);
  }
  close(ends[1]);
  std::string line;
  std::array<char, 4096> buffer{};
  for (ssize_t count = 0; (count = read(ends[0], buffer.data(), buffer.size())) > 0;) {
    line.append(buffer.data(), static_cast<std::size_t>(count));
  }
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (WIFEXITED(status) && WEXITSTATUS(status) == unsupported_code) return std::nullopt;
  return line.ends_with('\n') ? line : csv_line(crashed(task));
}

void list_scenes(const Options& options) {
  for (const scenes::Recipe& recipe : scenes::catalogue()) {
    const std::string name = recipe.group + '/' + recipe.name;
    if (!std::regex_search(name, options.scenes)) continue;
    std::printf("%-26s %s%s\n", name.c_str(), recipe.description.c_str(),
                recipe.is_optional ? " (--optional)" : "");
  }
  std::printf("\nEngines of this program:\n");
  for (const EngineFamily& family : engine_families()) {
    for (const std::string& setting : family.settings) {
      std::printf("%s/%s\n", family.name.c_str(), setting.c_str());
    }
  }
}

void run_scenes(const Options& options) {
  const std::vector<EngineFamily> families = engine_families();
  std::fputs(csv_header().c_str(), stdout);
  for (const scenes::Recipe& recipe : scenes::catalogue()) {
    if (!std::regex_search(recipe.group + '/' + recipe.name, options.scenes)) continue;
    if (recipe.is_optional && !options.has_optional) continue;
    for (const double dt : options.time_steps.empty() ? recipe.time_steps : options.time_steps) {
      for (const EngineFamily& family : families) {
        for (const std::string& setting : family.settings) {
          if (!std::regex_search(family.name + '/' + setting, options.engines)) continue;
          const auto line =
              line_of({&recipe, &family, setting, dt, options.is_quick}, options.timeout);
          if (line) std::fputs(line->c_str(), stdout);
          std::fflush(stdout);
        }
      }
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const Options options = parse_options(argc, argv);
    if (options.wants_help) {
      std::fputs(help().c_str(), stdout);
    } else if (options.wants_list) {
      list_scenes(options);
    } else if (!options.report.empty()) {
      std::fputs(report(options.report, options.plots, options.wants_markdown).c_str(), stdout);
    } else {
      run_scenes(options);
    }
  } catch (const std::exception& e) {
    std::fprintf(stderr, "benchmark_work_precision: %s\n", e.what());
    return 2;
  }
}
