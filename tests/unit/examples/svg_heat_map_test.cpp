// SPDX-License-Identifier: BSD-3-Clause
#include "support/svg_heat_map.hpp"
#include "support/numbers.hpp"
#include "support/texts.hpp"


#include <doctest/doctest.h>

#include <cstddef>
#include <limits>
#include <string>
#include <string_view>

using namespace bristle;
using namespace figure;
using bristle::test::count;
using bristle::test::error_of;
using bristle::test::nan_;

namespace {

std::string figure_error(const SvgHeatMaps& figure) {
  return error_of([&] { (void)figure.svg(); });
}

/// Two rows of three cells on a scale from 0 to 1.
SvgHeatMaps small_figure() {
  SvgHeatMaps figure{.title = "Maps & more"};
  figure.map_width = 30;
  figure.maps.push_back({.title = "one",
                         .label = "depth [1]",
                         .columns = 3,
                         .values = {0, 0.5, 1, 2, nan_, -1},
                         .low = 0,
                         .high = 1});
  return figure;
}

}  // namespace

TEST_CASE("heat_colour: runs from dark to light and knows the ends") {
  CHECK(heat_colour(0) == "#440154");
  CHECK(heat_colour(1) == "#fde725");
  CHECK(heat_colour(-3) == heat_colour(0));
  CHECK(heat_colour(3) == heat_colour(1));
  CHECK(heat_colour(0.5) == "#21908d");
  CHECK(heat_colour(0.0625) == "#461767");  // half way between the first two stops
  CHECK(heat_colour(nan_) == "#bbbbbb");
}

TEST_CASE("SvgHeatMaps: a cell a value, the first row at the bottom") {
  const std::string svg = small_figure().svg();
  // Cells are squares of 10, a little larger; the map is 20 high.
  CHECK(count(svg, "width=\"10.7\" height=\"10.7\"") == 6);
  CHECK(count(svg, "<rect x=\"0\" y=\"10\" width=\"10.7\" height=\"10.7\" fill=\"#440154\"") == 1);
  CHECK(count(svg, "<rect x=\"20\" y=\"10\" width=\"10.7\" height=\"10.7\" fill=\"#fde725\"") == 1);
  // Beyond the scale, not a number, below the scale.
  CHECK(count(svg, "<rect x=\"0\" y=\"0\" width=\"10.7\" height=\"10.7\" fill=\"#fde725\"") == 1);
  CHECK(count(svg, "<rect x=\"10\" y=\"0\" width=\"10.7\" height=\"10.7\" fill=\"#bbbbbb\"") == 1);
  CHECK(count(svg, "<rect x=\"20\" y=\"0\" width=\"10.7\" height=\"10.7\" fill=\"#440154\"") == 1);
  CHECK(count(svg, "Maps &amp; more") == 2);
  CHECK(count(svg, ">depth [1]<") == 1);
  CHECK(svg == small_figure().svg());
}

TEST_CASE("SvgHeatMaps: takes its scale from the values, and stands equal ones") {
  SvgHeatMaps figure = small_figure();
  figure.maps[0].low.reset();
  figure.maps[0].high.reset();
  CHECK(count(figure.svg(), "y=\"0\" width=\"10.7\" height=\"10.7\" fill=\"#fde725\"") == 1);
  figure.maps[0].values.assign(6, 7.0);
  CHECK_NOTHROW((void)figure.svg());
  figure.maps[0].values.assign(6, nan_);
  CHECK(count(figure.svg(), "fill=\"#bbbbbb\"") == 6);
}

TEST_CASE("SvgHeatMaps: maps stand in rows") {
  SvgHeatMaps figure = small_figure();
  for (int i = 0; i < 2; ++i) figure.maps.push_back(figure.maps[0]);
  const std::string svg = figure.svg();
  CHECK(count(svg, "<svg x=\"12\" y=\"56\"") == 1);
  CHECK(count(svg, "<svg x=\"152\" y=\"56\"") == 1);
  CHECK(count(svg, "<svg x=\"12\" y=\"112\"") == 1);
}

TEST_CASE("SvgHeatMaps: refuses what makes no figure") {
  CHECK(figure_error({}).find("SvgHeatMaps::maps") != std::string::npos);
  SvgHeatMaps figure = small_figure();
  figure.map_width = 0;
  CHECK(figure_error(figure).find("SvgHeatMaps::map_width") != std::string::npos);
  figure = small_figure();
  figure.maps_in_row = 0;
  CHECK(figure_error(figure).find("SvgHeatMaps::maps_in_row") != std::string::npos);
  figure = small_figure();
  figure.maps[0].columns = 0;
  CHECK(figure_error(figure).find("HeatMap::columns") != std::string::npos);
  figure.maps[0].columns = 4;
  CHECK(figure_error(figure).find("HeatMap::values") != std::string::npos);
  figure = small_figure();
  figure.maps[0].high = nan_;
  CHECK(figure_error(figure).find("end of the scale") != std::string::npos);
  figure.maps[0].high = 0;
  CHECK(figure_error(figure).find("HeatMap::high") != std::string::npos);
}
