/// @file
/// Heat maps as SVG: numbers in rows and columns as coloured cells, such as the readings of a
/// patch.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "support/plot_axis.hpp"
#include "support/svg_writer.hpp"

#include <bristle/bristle.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace figure {

/// One map with a colour scale of its own.
struct HeatMap {
  /// [-] Text above the map.
  std::string title{};
  /// [-] Label of the scale, with its unit: "depth [1]".
  std::string label{};
  /// [-] Cells in a row, > 0.
  std::size_t columns = 0;
  /// [-] Values row by row, whole rows. The first row is at the bottom, as y points up. A value
  /// that is not finite is a grey cell.
  std::vector<double> values{};
  /// [-] Ends of the colour scale, finite; unset: those of the values.
  std::optional<double> low{};
  std::optional<double> high{};
};

/// A figure of maps beside and below each other. Colours go from dark blue over green to yellow,
/// after viridis (van der Walt and Smith 2015). They get evenly lighter to the eye, with any colour
/// vision, and in print.
struct SvgHeatMaps {
  /// [-] Text above the figure. Empty for none.
  std::string title{};
  /// [-] The maps, row by row, at least one.
  std::vector<HeatMap> maps{};
  /// [-] Maps in a row, > 0.
  std::size_t maps_in_row = 2;
  /// [-] Width of each map without its scale, in CSS pixels (96 an inch), > 0. Cells are squares.
  double map_width = 280;

  /// Returns the text of the SVG file. The same data give the same bytes, in every locale.
  /// @throws InvalidArgument that names the field that breaks a rule.
  [[nodiscard]] std::string svg() const;

  /// Writes `svg` to a file, replacing an existing one.
  /// @throws IoError if it cannot be written in full.
  void write_svg(const std::filesystem::path& path) const { bristle::write_file(path, svg()); }
};

// Implementation ----------------------------------------------------------------------------------

/// Colour of a position on the scale, 0 to 1. Positions outside take the colour of the nearer end.
[[nodiscard]] inline std::string heat_colour(double place) {
  if (!std::isfinite(place)) return "#bbbbbb";
  static constexpr std::array<std::array<int, 3>, 9> stops{{{68, 1, 84},
                                                            {71, 44, 122},
                                                            {59, 81, 139},
                                                            {44, 113, 142},
                                                            {33, 144, 141},
                                                            {39, 173, 129},
                                                            {92, 200, 99},
                                                            {170, 220, 50},
                                                            {253, 231, 37}}};
  const double at = std::clamp(place, 0.0, 1.0) * (stops.size() - 1);
  const std::size_t below = std::min(static_cast<std::size_t>(at), stops.size() - 2);
  const double part = at - static_cast<double>(below);
  char text[8];
  std::array<unsigned, 3> mixed{};
  for (std::size_t c = 0; c < 3; ++c) {
    const double value = stops[below][c] + part * (stops[below + 1][c] - stops[below][c]);
    mixed[c] = static_cast<unsigned>(std::lround(value)) & 0xffu;
  }
  std::snprintf(text, sizeof text, "#%02x%02x%02x", mixed[0], mixed[1], mixed[2]);
  return text;
}

inline void validate_heat_maps(const SvgHeatMaps& figure) {
  bristle::detail::require_positive("SvgHeatMaps::map_width", figure.map_width);
  bristle::detail::require(figure.maps_in_row > 0, "SvgHeatMaps::maps_in_row", figure.maps_in_row,
                           "must be > 0");
  bristle::detail::require(!figure.maps.empty(), "SvgHeatMaps::maps: size", 0, "must be > 0");
  for (const HeatMap& map : figure.maps) {
    bristle::detail::require(map.columns > 0, "HeatMap::columns", map.columns, "must be > 0");
    bristle::detail::require(!map.values.empty() && map.values.size() % map.columns == 0,
                             "HeatMap::values: size", map.values.size(),
                             "must be whole rows, at least one");
    for (const std::optional<double>& end : {map.low, map.high}) {
      bristle::detail::require(!end || PlotAxis().shows(*end), "HeatMap: end of the scale",
                               end.value_or(0), "must be finite");
    }
    if (map.low && map.high) {
      bristle::detail::require(*map.low < *map.high, "HeatMap::high", *map.high, "must be > low");
    }
  }
}

/// Draws a map with its upper left corner at a point, and its scale beside it.
inline void paint_heat_map(SvgWriter& svg, const HeatMap& map, double left, double top,
                           double width) {
  const std::size_t rows = map.values.size() / map.columns;
  const double cell = width / static_cast<double>(map.columns);
  const double height = cell * static_cast<double>(rows);
  PlotAxis scale;
  for (const double value : map.values) scale.include(value);
  scale.finish({0, height / 32, map.low, map.high});

  svg.text(left, top - 8, map.title, "");
  svg.open_frame(left, top, width, height);
  for (std::size_t i = 0; i < map.values.size(); ++i) {
    const double x = cell * static_cast<double>(i % map.columns);
    const double y = height - cell * static_cast<double>(i / map.columns + 1);
    // A little more than the cell, so that no seams shine through.
    svg.rectangle(x, y, cell + 0.7, cell + 0.7, heat_colour(scale.place(map.values[i])));
  }
  svg.close_frame();

  const double bar = left + width + 10;
  constexpr int shades = 48;
  svg.open_frame(bar, top, 12, height);
  for (int i = 0; i < shades; ++i) {
    svg.rectangle(0, height * (shades - 1 - i) / shades, 12, height / shades + 0.7,
                  heat_colour((i + 0.5) / shades));
  }
  svg.close_frame();
  double widest = 0;
  for (const PlotTick& tick : scale.ticks()) {
    widest = std::max(widest, text_width(tick.label));
    const double y = top + height * (1 - scale.place(tick.value));
    svg.line(bar + 12, y, bar + 16, y, "class=\"axis\"");
    svg.text(bar + 19, y + 4, tick.label, "");
  }
  svg.upright_text(bar + 36 + widest, top + 0.5 * height, scale.caption(map.label));
}

inline std::string SvgHeatMaps::svg() const {
  validate_heat_maps(*this);
  SvgWriter svg;
  const double column = map_width + 110;
  double top = 8;
  if (!title.empty()) {
    svg.text(12, 24, title, "class=\"title\"");
    top = 34;
  }
  for (std::size_t first = 0; first < maps.size(); first += maps_in_row) {
    double tallest = 0;
    for (std::size_t i = first; i < std::min(first + maps_in_row, maps.size()); ++i) {
      const HeatMap& map = maps[i];
      const double left = 12 + column * static_cast<double>(i - first);
      paint_heat_map(svg, map, left, top + 22, map_width);
      const auto rows = static_cast<double>(map.values.size() / map.columns);
      tallest = std::max(tallest, map_width * rows / static_cast<double>(map.columns));
    }
    top += tallest + 36;
  }
  const double columns = static_cast<double>(std::min(maps_in_row, maps.size()));
  return svg.document(12 + column * columns, top, title);
}

}  // namespace figure
