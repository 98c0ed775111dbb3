// SPDX-License-Identifier: BSD-3-Clause
#include "support/svg_plot.hpp"
#include "support/numbers.hpp"
#include "support/relative.hpp"
#include "support/texts.hpp"


#include <doctest/doctest.h>

#include <charconv>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

using namespace bristle;
using namespace figure;
using bristle::test::count;
using bristle::test::error_of;
using bristle::test::nan_;

namespace {

/// Coordinates of the k-th polyline of the text.
std::vector<std::pair<double, double>> curve(const std::string& svg, std::size_t k) {
  std::size_t at = 0;
  for (std::size_t i = 0; i <= k; ++i) at = svg.find("<polyline", at + 1);
  const std::string_view points = " points=\"";
  const char* next = svg.data() + svg.find(points, at) + points.size();
  std::vector<std::pair<double, double>> found;
  while (*next != '"') {
    if (*next == ' ') ++next;
    double x = 0, y = 0;
    next = std::from_chars(next, svg.data() + svg.size(), x).ptr + 1;
    next = std::from_chars(next, svg.data() + svg.size(), y).ptr;
    found.emplace_back(x, y);
  }
  return found;
}

SvgPlot plot_of(PlotSeries series) {
  SvgPlot plot{.title = "Test", .x_label = "time [s]"};
  plot.panels.push_back({.y_label = "height [m]", .series = {std::move(series)}});
  return plot;
}

}  // namespace

TEST_CASE("SvgPlot: draws a curve from left to right across its frame") {
  SvgPlot plot = plot_of({"", {0, 1, 2}, {0, 1, 0}});
  plot.panels[0].y_low = 0;
  plot.panels[0].y_high = 1;
  const std::string svg = plot.svg();
  CHECK(svg.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\""));
  CHECK(svg.ends_with("</svg>\n"));
  CHECK(svg.find(">Test</text>") != std::string::npos);
  CHECK(svg.find(">time [s]</text>") != std::string::npos);
  CHECK(svg.find(">height [m]</text>") != std::string::npos);
  const auto points = curve(svg, 0);
  REQUIRE(points.size() == 3);
  CHECK(points[0].first == 0);
  CHECK(points[1].first == test::relative(0.5 * points[2].first).epsilon(1e-4));
  CHECK(points[0].second == plot.panel_height);  // y points down
  CHECK(points[1].second == 0);
  CHECK(points[2].second == plot.panel_height);
}

TEST_CASE("SvgPlot: every element that is opened is closed") {
  SvgPlot plot = plot_of({"a", {0, 1, 2}, {1, 2, 3}, true});
  plot.panels.push_back(plot.panels[0]);
  plot.phases = {{0, 1, "lift"}, {1, 2, "hold"}};
  const std::string svg = plot.svg();
  CHECK(count(svg, "<svg") == count(svg, "</svg>"));
  CHECK(count(svg, "<text") == count(svg, "</text>"));
  CHECK(count(svg, "<svg") == 3);
  CHECK(count(svg, "<circle") == 2 * (3 + 1));  // on the points and in the legends
}

TEST_CASE("SvgPlot: values that are not finite are gaps") {
  const double inf = std::numeric_limits<double>::infinity();
  const std::string svg =
      plot_of({"", {0, 1, 2, 3, 4, 5, 6, 7}, {1, 2, nan_, 3, 4, inf, 5, 6}}).svg();
  CHECK(count(svg, "<polyline") == 3);
  CHECK(svg.find("nan") == std::string::npos);
  CHECK(svg.find("inf") == std::string::npos);
  CHECK(count(plot_of({"", {0, nan_, 2}, {1, 2, 3}}).svg(), "<polyline") == 0);
}

TEST_CASE("SvgPlot: values that are not positive are gaps on a logarithmic axis") {
  SvgPlot plot = plot_of({"", {1, 2, 3, 4, 5}, {0.1, 1, 0, 1, 10}});
  plot.panels[0].is_logarithmic = true;
  CHECK(count(plot.svg(), "<polyline") == 2);
  plot.is_logarithmic = true;
  plot.panels[0].series[0].x[1] = -1;
  CHECK(count(plot.svg(), "<polyline") == 1);
}

TEST_CASE("SvgPlot: many points cost few bytes, and extremes survive") {
  std::vector<double> x, y;
  for (int i = 0; i < 100000; ++i) {
    x.push_back(i);
    y.push_back(std::sin(0.01 * i));
  }
  y[54321] = 5;
  y[54322] = -5;
  SvgPlot plot = plot_of({"", x, y});
  plot.panels[0].y_low = -5;
  plot.panels[0].y_high = 5;
  const auto points = curve(plot.svg(), 0);
  // At most four points in each half pixel of 680.
  CHECK(points.size() <= 4 * 2 * 680);
  double low = 1e9, high = -1e9;
  for (std::size_t i = 0; i < points.size(); ++i) {
    low = std::min(low, points[i].second);
    high = std::max(high, points[i].second);
    if (i > 0) CHECK(points[i].first >= points[i - 1].first);
  }
  CHECK(low == 0);
  CHECK(high == plot.panel_height);
}

TEST_CASE("SvgPlot: curves of a panel differ in colour and in stroke") {
  SvgPlot plot = plot_of({"a", {0, 1}, {0, 1}});
  plot.panels[0].series.push_back({"b", {0, 1}, {1, 2}});
  const std::string svg = plot.svg();
  CHECK(count(svg, "stroke=\"#0072b2\"") == 2);  // the curve and its sample in the legend
  CHECK(count(svg, "stroke=\"#d55e00\" stroke-dasharray=\"7 3\"") == 2);
  CHECK(svg.find(">a</text>") < svg.find(">b</text>"));
}

TEST_CASE("SvgPlot: shows references and phases with their captions, in the range of the axes") {
  SvgPlot plot = plot_of({"", {0, 1}, {0, 1}});
  plot.panels[0].references = {{20, "limit 20 N"}};
  plot.phases = {{0, 1, "lift"}, {1, 4, "hold"}, {4, 4.01, "slip"}, {4.01, 4.02, "catch"}};
  const std::string svg = plot.svg();
  CHECK(count(svg, "class=\"reference\"") == 1);
  CHECK(svg.find(">limit 20 N</text>") != std::string::npos);
  CHECK(svg.find(">20</text>") != std::string::npos);   // the y axis reaches it
  CHECK(svg.find(">4.0</text>") != std::string::npos);  // the x axis reaches the last phase
  for (const char* caption : {">lift<", ">hold<", ">slip<", ">catch<"}) {
    CHECK(svg.find(caption) != std::string::npos);
  }
}

TEST_CASE("SvgPlot: escapes text, and keeps what is not ASCII") {
  SvgPlot plot = plot_of({"a<b>&\"c\"'d'", {0, 1}, {0, 1}});
  plot.title = "20 \u00b5m\x01";
  const std::string svg = plot.svg();
  CHECK(svg.find(">a&lt;b&gt;&amp;&quot;c&quot;&apos;d&apos;</text>") != std::string::npos);
  CHECK(svg.find(">20 \u00b5m </text>") != std::string::npos);
}

TEST_CASE("SvgPlot: draws nothing out of nothing, and hostile numbers within bounds") {
  SvgPlot plot;
  plot.panels.push_back({});
  CHECK(count(plot.svg(), "<polyline") == 0);
  const double most = std::numeric_limits<double>::max();
  const double least = std::numeric_limits<double>::denorm_min();
  for (const bool is_logarithmic : {false, true}) {
    for (const std::vector<double>& y : {std::vector<double>{most, -most, 1},
                                         {least, -least, least},
                                         {0, 1e-149, 1e-151},
                                         {1e149, -1e149, 0}}) {
      SvgPlot hostile = plot_of({"x", y, y});
      hostile.is_logarithmic = hostile.panels[0].is_logarithmic = is_logarithmic;
      hostile.width = 1;
      const std::string svg = hostile.svg();
      CHECK(svg.find("nan") == std::string::npos);
      CHECK(svg.find("inf") == std::string::npos);
      CHECK(svg.size() < 100000);
    }
  }
}

TEST_CASE("SvgPlot: names what breaks a rule") {
  const SvgPlot good = plot_of({"a", {1, 2}, {1, 2}});
  const auto error = [&](auto&& change) {
    SvgPlot plot = good;
    change(plot);
    return error_of([&] { (void)plot.svg(); });
  };
  CHECK(error([](SvgPlot&) {}) == "");
  CHECK(error([](SvgPlot& p) { p.panels.clear(); }) == "SvgPlot::panels: size = 0: must be > 0");
  CHECK(error([](SvgPlot& p) { p.width = 0; }) == "SvgPlot::width = 0: must be finite and > 0");
  CHECK(error([](SvgPlot& p) { p.panel_height = nan_; }) ==
        "SvgPlot::panel_height = nan: must be finite and > 0");
  CHECK(error([](SvgPlot& p) { p.panels[0].series[0].y.pop_back(); }) ==
        "PlotSeries \"a\": size of y = 1: must be the size of x, 2");
  CHECK(error([](SvgPlot& p) {
          p.phases = {{nan_, 1, ""}};
        }) == "PlotPhase::begin = nan: must have a place on the x axis");
  CHECK(error([](SvgPlot& p) {
          p.phases = {{2, 1, ""}};
        }) == "PlotPhase::end = 1: must be finite and >= begin");
  CHECK(error([](SvgPlot& p) {
          p.panels[0].references = {{nan_, ""}};
        }) == "PlotReference::y = nan: must have a place on the y axis");
  CHECK(error([](SvgPlot& p) { p.panels[0].y_low = nan_; }) ==
        "PlotPanel: end of the y range = nan: must have a place on the y axis");
  CHECK(error([](SvgPlot& p) {
          p.panels[0].is_logarithmic = true;
          p.panels[0].y_high = 0;
        }) == "PlotPanel: end of the y range = 0: must have a place on the y axis");
  CHECK(error([](SvgPlot& p) {
          p.panels[0].y_low = 2;
          p.panels[0].y_high = 1;
        }) == "PlotPanel::y_high = 1: must be > y_low");
}

TEST_CASE("SvgPlot: is written to a file, or says which file cannot be written") {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / "bristle_svg_plot_test.svg";
  const SvgPlot plot = plot_of({"a", {1, 2}, {1, 2}});
  plot.write_svg(file);
  CHECK(read_file(file) == plot.svg());
  std::filesystem::remove(file);
  CHECK_THROWS_AS(plot.write_svg(file / "no_such_folder" / "plot.svg"), IoError);
}
