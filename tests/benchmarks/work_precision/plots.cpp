// SPDX-License-Identifier: BSD-3-Clause
#include "support/svg_plot.hpp"
#include "benchmarks/work_precision/plots.hpp"

#include "scenes/rigid/catalogue.hpp"


#include <algorithm>
#include <cmath>
#include <limits>

namespace bristle::work_precision {

using namespace figure;

namespace {

/// Where an error of zero is drawn: below what double precision can resolve.
constexpr double smallest_error = 1e-16;

/// One measurement in a plot.
struct Point {
  /// [ms/s] Processor time for a simulated second.
  double work = 0;
  double error = 0;
};

Point point_of(const Row& row) {
  return {1e-3 * row.best_us / row.dt, std::max(row.error, smallest_error)};
}

/// The points that no other one beats in both, from the least work on.
std::vector<Point> front(std::vector<Point> points) {
  std::ranges::sort(points, {}, &Point::work);
  std::vector<Point> kept;
  double least = std::numeric_limits<double>::infinity();
  for (const Point& point : points) {
    if (!(point.error < least)) continue;
    least = point.error;
    kept.push_back(point);
  }
  return kept;
}

PlotSeries series_of(std::string name, std::vector<Point> points) {
  std::ranges::sort(points, {}, &Point::work);
  PlotSeries series{.name = std::move(name), .x = {}, .y = {}, .has_dots = true};
  for (const Point& point : points) {
    series.x.push_back(point.work);
    series.y.push_back(point.error);
  }
  return series;
}

/// Rows of a scene by the name of their curve, in the order they come in.
struct Curve {
  std::string name;
  bool is_front = false;
  std::vector<Point> points{};
};

/// "slide: box slides to rest, stopping distance [m]".
std::string title_of(const std::string& scene) {
  for (const scenes::Recipe& recipe : scenes::catalogue()) {
    if (recipe.name == scene) return scene + ": " + recipe.description;
  }
  return scene;
}

}  // namespace

void write_plots(const std::vector<Row>& rows, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  std::vector<std::string> scenes;
  for (const Row& row : rows) {
    if (std::ranges::find(scenes, row.scene) == scenes.end()) scenes.push_back(row.scene);
  }
  for (const std::string& scene : scenes) {
    std::vector<Curve> curves;
    for (const Row& row : rows) {
      if (row.scene != scene || !std::isfinite(row.error) || !(row.best_us > 0)) continue;
      const std::string name = is_ours(row) ? row.engine + ' ' + row.setting : row.engine;
      const auto found = std::ranges::find(curves, name, &Curve::name);
      Curve& curve =
          found != curves.end() ? *found : curves.emplace_back(Curve{name, !is_ours(row)});
      curve.points.push_back(point_of(row));
    }
    SvgPlot plot{.title = title_of(scene),
                 .x_label = "work [ms of processor time a simulated second]",
                 .is_logarithmic = true,
                 .panel_height = 360};
    PlotPanel panel{.y_label = "error", .series = {}, .is_logarithmic = true};
    for (Curve& curve : curves) {
      panel.series.push_back(
          series_of(curve.name, curve.is_front ? front(curve.points) : curve.points));
    }
    plot.panels.push_back(std::move(panel));
    plot.write_svg(folder / (scene + ".svg"));
  }
}

}  // namespace bristle::work_precision
