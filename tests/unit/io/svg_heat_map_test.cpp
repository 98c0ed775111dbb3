// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/io/svg_heat_map.hpp>

#include <doctest/doctest.h>

#include <cstddef>
#include <limits>
#include <string>
#include <string_view>

using namespace bristle;

namespace {

std::size_t count(const std::string& text, std::string_view part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
    ++found;
  }
  return found;
}

std::string error_of(const SvgHeatMaps& figure) {
  try {
    (void)figure.svg();
  } catch (const InvalidArgument& error) {
    return error.what();
  }
  return {};
}

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// Two rows of three cells on a scale from 0 to 1.
SvgHeatMaps small_figure() {
  SvgHeatMaps figure{.title = "Maps & more"};
  figure.map_width = 30;
  figure.maps.push_back({.title = "one",
                         .label = "depth [1]",
                         .columns = 3,
                         .values = {0, 0.5, 1, 2, not_a_number, -1},
                         .low = 0,
                         .high = 1});
  return figure;
}

}  // namespace

TEST_CASE("heat_colour: runs from dark to light and knows the ends") {
  CHECK(detail::heat_colour(0) == "#440154");
  CHECK(detail::heat_colour(1) == "#fde725");
  CHECK(detail::heat_colour(-3) == detail::heat_colour(0));
  CHECK(detail::heat_colour(3) == detail::heat_colour(1));
  CHECK(detail::heat_colour(0.5) == "#21908d");
  CHECK(detail::heat_colour(0.0625) == "#461767");  // half way between the first two stops
  CHECK(detail::heat_colour(not_a_number) == "#bbbbbb");
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
  figure.maps[0].values.assign(6, not_a_number);
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
  CHECK(error_of({}).find("SvgHeatMaps::maps") != std::string::npos);
  SvgHeatMaps figure = small_figure();
  figure.map_width = 0;
  CHECK(error_of(figure).find("SvgHeatMaps::map_width") != std::string::npos);
  figure = small_figure();
  figure.maps_in_row = 0;
  CHECK(error_of(figure).find("SvgHeatMaps::maps_in_row") != std::string::npos);
  figure = small_figure();
  figure.maps[0].columns = 0;
  CHECK(error_of(figure).find("HeatMap::columns") != std::string::npos);
  figure.maps[0].columns = 4;
  CHECK(error_of(figure).find("HeatMap::values") != std::string::npos);
  figure = small_figure();
  figure.maps[0].high = not_a_number;
  CHECK(error_of(figure).find("end of the scale") != std::string::npos);
  figure.maps[0].high = 0;
  CHECK(error_of(figure).find("HeatMap::high") != std::string::npos);
}
