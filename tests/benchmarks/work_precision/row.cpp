// SPDX-License-Identifier: BSD-3-Clause
#include "benchmarks/work_precision/row.hpp"

#include <bristle/core/error.hpp>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <sstream>

namespace bristle::work_precision {

using namespace bristle::detail;

namespace {

std::string text_of(double value, const char* format = "%.6g") {
  std::array<char, 32> buffer{};
  std::snprintf(buffer.data(), buffer.size(), format, value);
  return buffer.data();
}

std::vector<std::string> split(std::string_view text, char separator) {
  std::vector<std::string> parts;
  std::istringstream stream{std::string(text)};
  for (std::string part; std::getline(stream, part, separator);) parts.push_back(part);
  return parts;
}

}  // namespace

std::string csv_header() {
  return "scene,engine,setting,dt [s],steps,error,passes,step best [us],step median [us],"
         "step p99 [us],step worst [us],sweeps,factorisations,allocations,further\n";
}

std::string csv_line(const Row& row) {
  std::string line = row.scene + ',' + row.engine + ',' + row.setting + ',' + text_of(row.dt) +
                     ',' + std::to_string(row.steps) + ',' + text_of(row.error) + ',' +
                     (row.passes ? '1' : '0');
  for (const double value : {row.best_us, row.median_us, row.p99_us, row.worst_us, row.sweeps,
                             row.factorisations, row.allocations}) {
    line += ',' + text_of(value);
  }
  line += ',';
  for (std::size_t i = 0; i < row.further.size(); ++i) {
    line += (i > 0 ? ";" : "") + row.further[i].name + '=' + text_of(row.further[i].value, "%.4g");
  }
  return line + '\n';
}

Row parse_row(std::string_view line) {
  const std::vector<std::string> parts = split(line, ',');
  if (parts.size() < 14) {
    throw InvalidArgument("row of the benchmark", std::string(line), "must have 14 or 15 columns");
  }
  const auto number = [&](std::size_t i) { return std::strtod(parts[i].c_str(), nullptr); };
  Row row;
  row.scene = parts[0];
  row.engine = parts[1];
  row.setting = parts[2];
  row.dt = number(3);
  row.steps = std::lround(number(4));
  row.error = number(5);
  row.passes = parts[6] == "1";
  row.best_us = number(7);
  row.median_us = number(8);
  row.p99_us = number(9);
  row.worst_us = number(10);
  row.sweeps = number(11);
  row.factorisations = number(12);
  row.allocations = number(13);
  if (parts.size() > 14) {
    for (const std::string& metric : split(parts[14], ';')) {
      const std::size_t at = metric.find('=');
      if (at == std::string::npos) continue;
      row.further.push_back({metric.substr(0, at), std::strtod(metric.c_str() + at + 1, nullptr)});
    }
  }
  return row;
}

double parse_time_step(const std::string& text) {
  const bool is_fraction = text.starts_with("1/");
  const double number = std::strtod(text.c_str() + (is_fraction ? 2 : 0), nullptr);
  if (!(number > 0)) return 0;
  return is_fraction ? 1 / number : number;
}

std::string time_step_text(double dt) {
  const double rate = std::round(1 / dt);
  // The file keeps six digits.
  if (std::abs(rate * dt - 1) < 1e-5) return "1/" + text_of(rate, "%.0f");
  return text_of(dt);
}

}  // namespace bristle::work_precision
