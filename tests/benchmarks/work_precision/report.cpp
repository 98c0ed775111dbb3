// SPDX-License-Identifier: BSD-3-Clause
#include "benchmarks/work_precision/report.hpp"

#include "benchmarks/work_precision/plots.hpp"
#include "benchmarks/work_precision/row.hpp"
#include "scenes/rigid/catalogue.hpp"

#include <bristle/io/file.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <sstream>

namespace bristle::work_precision {

using namespace bristle::detail;

namespace {

/// Errors below this are round-off of some engine: they count as equal.
constexpr double error_floor = 1e-9;

/// Rows of a file; of several of the same run the quickest. A run that is repeated has the same
/// error, but for engines that are not deterministic: the larger one counts.
std::vector<Row> read_rows(const std::filesystem::path& csv) {
  std::map<std::string, std::size_t> places;
  std::vector<Row> rows;
  std::istringstream lines(read_file(csv));
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line.starts_with("scene,")) continue;
    Row row = parse_row(line);
    const std::string key = row.scene + ',' + row.who() + ',' + time_step_text(row.dt);
    const auto [place, is_new] = places.try_emplace(key, rows.size());
    if (is_new) {
      rows.push_back(std::move(row));
      continue;
    }
    Row& kept = rows[place->second];
    kept.best_us = std::fmin(kept.best_us, row.best_us);
    kept.median_us = std::fmin(kept.median_us, row.median_us);
    kept.p99_us = std::fmin(kept.p99_us, row.p99_us);
    kept.worst_us = std::fmin(kept.worst_us, row.worst_us);
    kept.error = std::max(kept.error, row.error);
    kept.passes = kept.passes && row.passes;
  }
  return rows;
}

/// All rows of one scene at one step.
struct Cell {
  std::string scene;
  double dt = 0;
  std::vector<const Row*> rows{};

  [[nodiscard]] const Row* of(const std::string& who) const {
    const auto found = std::ranges::find_if(rows, [&](const Row* r) { return r->who() == who; });
    return found == rows.end() ? nullptr : *found;
  }
  /// The peer with the least error; of those within the floor the quickest.
  [[nodiscard]] const Row* best_peer() const {
    const Row* best = nullptr;
    for (const Row* row : rows) {
      if (is_ours(*row)) continue;
      if (best == nullptr) {
        best = row;
        continue;
      }
      const double error = std::max(row->error, error_floor);
      const double least = std::max(best->error, error_floor);
      if (error < least || (error == least && row->best_us < best->best_us)) best = row;
    }
    return best;
  }
};

std::vector<Cell> cells_of(const std::vector<Row>& rows) {
  std::vector<Cell> cells;
  for (const Row& row : rows) {
    const auto found = std::ranges::find_if(
        cells, [&](const Cell& c) { return c.scene == row.scene && c.dt == row.dt; });
    Cell& cell = found != cells.end() ? *found : cells.emplace_back(Cell{row.scene, row.dt});
    cell.rows.push_back(&row);
  }
  return cells;
}

/// "1.2e-05" and "0.53" in columns.
std::string figures(const Row& row) {
  std::array<char, 64> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%9.2e %10.4g us %c", row.error, row.best_us,
                row.passes ? 'y' : '.');
  return buffer.data();
}

std::string padded(std::string text, std::size_t width) {
  if (text.size() < width) text.append(width - text.size(), ' ');
  return text;
}

constexpr const char* ours = "bristle64/def";

std::string comparison(const std::vector<Cell>& cells) {
  std::string text = padded("scene", 16) + padded("dt", 8) + padded(ours, 27) + "  best peer\n";
  for (const Cell& cell : cells) {
    const Row* own = cell.of(ours);
    const Row* peer = cell.best_peer();
    text += padded(cell.scene, 16) + padded(time_step_text(cell.dt), 8);
    text += padded(own != nullptr ? figures(*own) : "not run", 27);
    if (peer != nullptr) text += "  " + padded(figures(*peer), 27) + "  " + peer->who();
    text += '\n';
  }
  return text;
}

/// "0.0123" or "1.2e-05".
std::string number_text(double value) {
  std::array<char, 32> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%.3g", value);
  return buffer.data();
}

/// A row of a table in markdown for each row of the file.
std::string markdown(const std::vector<Cell>& cells) {
  std::string text =
      "| scene | dt [s] | engine | error | passes | mean [us] | p99 [us] | worst [us] |\n"
      "|---|---|---|---|---|---|---|---|\n";
  for (const Cell& cell : cells) {
    for (const Row* row : cell.rows) {
      text += "| " + cell.scene + " | " + time_step_text(cell.dt) + " | " + row->who() + " | " +
              number_text(row->error) + " | " + (row->passes ? "yes" : "no");
      for (const double time : {row->best_us, row->p99_us, row->worst_us}) {
        text += " | " + (std::isfinite(time) ? number_text(time) : std::string("-"));
      }
      text += " |\n";
    }
  }
  return text;
}

std::string matrix(const std::vector<Row>& rows, const std::vector<Cell>& cells) {
  std::vector<std::string> scenes;
  for (const scenes::Recipe& recipe : scenes::catalogue()) {
    const bool is_there =
        std::ranges::any_of(cells, [&](const Cell& c) { return c.scene == recipe.name; });
    if (recipe.group == "matrix" && is_there) scenes.push_back(recipe.name);
  }
  if (scenes.empty()) return {};
  std::vector<std::string> engines;
  for (const Row& row : rows) {
    if (std::ranges::find(engines, row.who()) == engines.end()) engines.push_back(row.who());
  }
  std::string text = "\nStability: y passed, . failed, - not run; steps from long to short\n";
  text += padded("", 18);
  for (const std::string& scene : scenes) text += ' ' + padded(scene, 5);
  text += '\n';
  for (const std::string& who : engines) {
    text += padded(who, 18);
    int passed = 0;
    for (const std::string& scene : scenes) {
      std::vector<std::pair<double, char>> marks;
      for (const Cell& cell : cells) {
        if (cell.scene != scene) continue;
        const Row* row = cell.of(who);
        marks.emplace_back(-cell.dt, row == nullptr ? '-' : row->passes ? 'y' : '.');
        if (row != nullptr && row->passes) ++passed;
      }
      std::ranges::sort(marks);
      std::string shown;
      for (const auto& [step, mark] : marks) shown += mark;
      text += ' ' + padded(shown, std::max<std::size_t>(scene.size(), 5));
    }
    text += ' ' + std::to_string(passed) + '\n';
  }
  return text;
}

/// The last line: how many cells of the matrix pass, and in how many no peer is better.
std::string verdict(const std::vector<Cell>& cells) {
  std::map<std::string, bool> is_matrix;
  for (const scenes::Recipe& recipe : scenes::catalogue()) {
    is_matrix[recipe.name] = recipe.group == "matrix";
  }
  int count = 0;
  int passed = 0;
  int compared = 0;
  int no_worse = 0;
  for (const Cell& cell : cells) {
    const Row* own = cell.of(ours);
    if (!is_matrix[cell.scene] || own == nullptr) continue;
    ++count;
    if (own->passes) ++passed;
    const Row* peer = cell.best_peer();
    if (peer == nullptr) continue;
    ++compared;
    if (own->error <= std::max(peer->error, error_floor)) ++no_worse;
  }
  if (count == 0) return {};
  std::string text =
      "\nmatrix: " + std::to_string(passed) + " of " + std::to_string(count) + " pass";
  if (compared > 0) {
    text += "; " + std::to_string(no_worse) + " of " + std::to_string(compared) +
            " no worse than the best peer (floor 1e-9)";
  }
  return text + '\n';
}

}  // namespace

std::string report(const std::filesystem::path& csv, const std::filesystem::path& plots,
                   bool is_markdown) {
  const std::vector<Row> rows = read_rows(csv);
  const std::vector<Cell> cells = cells_of(rows);
  if (!plots.empty()) write_plots(rows, plots);
  if (is_markdown) return markdown(cells);
  return comparison(cells) + matrix(rows, cells) + verdict(cells);
}

}  // namespace bristle::work_precision
