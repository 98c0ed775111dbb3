/// @file
/// Line plots in Python.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "arrays.hpp"
#include "support/svg_plot.hpp"

#include <pybind11/pybind11.h>
#include <string>
#include <utility>
#include <vector>

namespace bristle_python {

[[nodiscard]] inline std::vector<double> coordinates(const std::string& name,
                                                     const py::handle& values) {
  const Array<double> array = numbers_of<double>(name, py::reinterpret_borrow<py::object>(values));
  return {array.data(), array.data() + array.size()};
}

inline void bind_plot(py::module_& m) {
  m.def(
      "write_plot",
      [](const std::string& path, const py::dict& panels, std::string x_label, std::string title) {
        figure::SvgPlot plot{.title = std::move(title), .x_label = std::move(x_label)};
        for (const auto& [y_label, curves] : panels) {
          figure::PlotPanel panel{.y_label = py::cast<std::string>(y_label), .series = {}};
          for (const auto& [name, points] : py::cast<py::dict>(curves)) {
            const auto xy = py::cast<py::tuple>(points);
            if (xy.size() != 2) {
              throw InvalidArgument("len(points)", std::to_string(xy.size()), "must be 2: x and y");
            }
            panel.series.push_back({.name = py::cast<std::string>(name),
                                    .x = coordinates("x", xy[0]),
                                    .y = coordinates("y", xy[1])});
          }
          plot.panels.push_back(std::move(panel));
        }
        plot.write_svg(path);
      },
      "path"_a, "panels"_a, "x_label"_a, "title"_a = "",
      "Writes curves as SVG: `panels` is {label of the y axis: {curve: (x, y)}}, drawn from top to "
      "bottom over one x axis.");
}

}  // namespace bristle_python
