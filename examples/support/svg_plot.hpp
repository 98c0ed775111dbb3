/// @file
/// Line plots as SVG: stacked panels over one x axis, good enough for a paper.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "support/plot_axis.hpp"
#include "support/svg_writer.hpp"

#include <bristle/bristle.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace figure {

/// One curve. A point whose coordinate is not finite, or not positive on a logarithmic axis, is a
/// gap in it.
struct PlotSeries {
  /// [-] Name in the legend. Empty for no entry.
  std::string name;
  /// [-] Coordinates of its points, equally many.
  std::vector<double> x;
  std::vector<double> y;
  /// [-] A dot on every point; for few points.
  bool has_dots = false;
};

/// A horizontal line to compare with: a predicted value, a limit.
struct PlotReference {
  /// [-] Its position. Finite, and > 0 on a logarithmic axis.
  double y = 0;
  /// [-] Text on the line.
  std::string caption;
};

/// A stretch of the x axis that is shaded in all panels and named on top: "lift", "hold", "slip".
struct PlotPhase {
  /// [-] Its ends. Finite, begin <= end.
  double begin = 0;
  double end = 0;
  /// [-] Name above the stretch.
  std::string caption;
};

/// One frame of curves with a y axis of its own.
struct PlotPanel {
  /// [-] Label of the y axis, with its unit: "creep [m]".
  std::string y_label;
  /// [-] Its curves. Colours and strokes follow their order.
  std::vector<PlotSeries> series;
  /// [-] Lines to compare with.
  std::vector<PlotReference> references{};
  /// [-] True for a logarithmic y axis.
  bool is_logarithmic = false;
  /// [-] Range of y; unset: that of the curves and references, with a margin.
  std::optional<double> y_low{};
  std::optional<double> y_high{};
};

/// A figure.
///
///     SvgPlot plot{.title = "Free fall", .x_label = "time [s]"};
///     plot.panels.push_back({.y_label = "height [m]", .series = {{"centre", t, z}}});
///     plot.write_svg("fall.svg");
struct SvgPlot {
  /// [-] Text above the figure. Empty for none.
  std::string title{};
  /// [-] Label of the x axis, with its unit.
  std::string x_label{};
  /// [-] Panels from top to bottom, at least one.
  std::vector<PlotPanel> panels{};
  /// [-] Shaded stretches of the x axis.
  std::vector<PlotPhase> phases{};
  /// [-] True for a logarithmic x axis.
  bool is_logarithmic = false;
  /// [-] Width of the figure and height of each panel's frame, in CSS pixels (96 an inch), > 0.
  double width = 680;
  double panel_height = 180;

  /// Returns the text of the SVG file. The same data give the same bytes, in every locale.
  /// @throws InvalidArgument that names the panel or the field that breaks a rule.
  [[nodiscard]] std::string svg() const;

  /// Writes `svg` to a file, replacing an existing one.
  /// @throws IoError if it cannot be written in full.
  void write_svg(const std::filesystem::path& path) const { bristle::write_file(path, svg()); }
};

// Implementation ----------------------------------------------------------------------------------

/// Checks that a figure can be drawn.
/// @throws InvalidArgument that names the field that breaks a rule.
inline void validate_plot(const SvgPlot& plot) {
  bristle::detail::require_positive("SvgPlot::width", plot.width);
  bristle::detail::require_positive("SvgPlot::panel_height", plot.panel_height);
  bristle::detail::require(!plot.panels.empty(), "SvgPlot::panels: size", 0, "must be > 0");
  for (const PlotPhase& phase : plot.phases) {
    bristle::detail::require(PlotAxis(plot.is_logarithmic).shows(phase.begin), "PlotPhase::begin",
                             phase.begin, "must have a place on the x axis");
    bristle::detail::require(std::isfinite(phase.end) && phase.end >= phase.begin, "PlotPhase::end",
                             phase.end, "must be finite and >= begin");
  }
  for (const PlotPanel& panel : plot.panels) {
    const PlotAxis y(panel.is_logarithmic);
    for (const PlotSeries& series : panel.series) {
      bristle::detail::require(series.x.size() == series.y.size(),
                               "PlotSeries \"" + series.name + "\": size of y", series.y.size(),
                               "must be the size of x, " + std::to_string(series.x.size()));
    }
    for (const PlotReference& reference : panel.references) {
      bristle::detail::require(y.shows(reference.y), "PlotReference::y", reference.y,
                               "must have a place on the y axis");
    }
    for (const std::optional<double>& end : {panel.y_low, panel.y_high}) {
      bristle::detail::require(!end || y.shows(*end), "PlotPanel: end of the y range",
                               end.value_or(0), "must have a place on the y axis");
    }
    if (panel.y_low && panel.y_high) {
      bristle::detail::require(*panel.y_low < *panel.y_high, "PlotPanel::y_high", *panel.y_high,
                               "must be > y_low");
    }
  }
}

/// Draws one figure, top to bottom.
class PlotPainter {
 public:
  explicit PlotPainter(const SvgPlot& plot) : plot_(plot), x_axis_(plot.is_logarithmic) {}

  [[nodiscard]] std::string paint() {
    settle_axes();
    if (!plot_.title.empty()) {
      svg_.text(left_, 24, plot_.title, "class=\"title\"");
      top_ = 34;
    }
    for (std::size_t i = 0; i < plot_.panels.size(); ++i) paint_panel(i);
    svg_.text(left_ + 0.5 * width_, top_ + 36, x_axis_.caption(plot_.x_label),
              "text-anchor=\"middle\"");
    return svg_.document(plot_.width, top_ + 46, plot_.title);
  }

 private:
  [[nodiscard]] double x_of(double value) const { return width_ * x_axis_.place(value); }

  void settle_axes() {
    for (const PlotPanel& panel : plot_.panels) {
      PlotAxis y(panel.is_logarithmic);
      for (const PlotSeries& series : panel.series) {
        for (std::size_t i = 0; i < series.x.size(); ++i) {
          if (!x_axis_.shows(series.x[i]) || !y.shows(series.y[i])) continue;
          x_axis_.include(series.x[i]);
          y.include(series.y[i]);
        }
      }
      for (const PlotReference& reference : panel.references) y.include(reference.y);
      y.finish({0.06, plot_.panel_height / 32, panel.y_low, panel.y_high});
      y_axes_.push_back(y);
    }
    for (const PlotPhase& phase : plot_.phases) {
      x_axis_.include(phase.begin);
      x_axis_.include(phase.end);
    }
    double widest = 0;
    for (const PlotAxis& y : y_axes_) {
      for (const PlotTick& tick : y.ticks()) widest = std::max(widest, text_width(tick.label));
    }
    left_ = std::ceil(widest) + 40;
    width_ = std::max(plot_.width - left_ - 18, 1.0);
    x_axis_.finish({plot_.is_logarithmic ? 0.03 : 0.0, width_ / 64});
  }

  void paint_panel(std::size_t index) {
    const PlotPanel& panel = plot_.panels[index];
    const PlotAxis& y = y_axes_[index];
    paint_legend(panel);
    if (index == 0) paint_captions();
    top_ += 6;
    svg_.open_frame(left_, top_, width_, plot_.panel_height);
    for (std::size_t i = 0; i < plot_.phases.size(); ++i) {
      const double begin = x_of(plot_.phases[i].begin);
      // Neighbours differ in shade, so that their border shows.
      svg_.rectangle(begin, 0, x_of(plot_.phases[i].end) - begin, plot_.panel_height,
                     i % 2 == 0 ? "#f5f5f5" : "#eaeaea");
    }
    const auto y_of = [&](double value) { return plot_.panel_height * (1 - y.place(value)); };
    for (const PlotTick& tick : y.ticks()) {
      if (!tick.label.empty())
        svg_.line(0, y_of(tick.value), width_, y_of(tick.value), "class=\"grid\"");
    }
    for (const PlotReference& r : panel.references) {
      svg_.line(0, y_of(r.y), width_, y_of(r.y), "class=\"reference\"");
    }
    for (std::size_t i = 0; i < panel.series.size(); ++i) paint_series(panel.series[i], i, y, y_of);
    for (const PlotReference& r : panel.references) {
      // Above the line if it fits, else below it.
      const double at = y_of(r.y);
      svg_.text(width_ - 5, at > 16 ? at - 4 : at + 13, r.caption,
                "class=\"note halo\" text-anchor=\"end\"");
    }
    svg_.close_frame();
    paint_axes(panel, y, index + 1 == plot_.panels.size());
    top_ += plot_.panel_height;
  }

  template <typename YOf>
  void paint_series(const PlotSeries& series, std::size_t number, const PlotAxis& y,
                    const YOf& y_of) {
    const CurveLook look = look_of_curve(number);
    std::vector<std::pair<double, double>> run;
    for (std::size_t i = 0; i <= series.x.size(); ++i) {
      if (i < series.x.size() && x_axis_.shows(series.x[i]) && y.shows(series.y[i])) {
        run.emplace_back(x_of(series.x[i]), y_of(series.y[i]));
        if (series.has_dots) svg_.dot(run.back().first, run.back().second, look.colour);
      } else {
        svg_.polyline(run, look);
        run.clear();
      }
    }
  }

  void paint_legend(const PlotPanel& panel) {
    double x = left_;
    bool is_open = false;
    for (std::size_t i = 0; i < panel.series.size(); ++i) {
      const std::string& name = panel.series[i].name;
      if (name.empty()) continue;
      const double length = 30 + text_width(name) + 18;
      if (!is_open || x + length > plot_.width) {
        x = left_;
        top_ += 18;
        is_open = true;
      }
      const CurveLook look = look_of_curve(i);
      svg_.polyline({{x, top_ - 4}, {x + 24, top_ - 4}}, look);
      if (panel.series[i].has_dots) svg_.dot(x + 12, top_ - 4, look.colour);
      svg_.text(x + 30, top_, name, "");
      x += length;
    }
    if (!is_open) top_ += 6;
  }

  /// Paints the names of the phases above the first panel. A name that would hide another goes to a
  /// further row.
  void paint_captions() {
    std::vector<double> row_ends;
    for (const PlotPhase& phase : plot_.phases) {
      const double half = 0.5 * text_width(phase.caption) * 11 / 12;
      double middle = left_ + 0.5 * (x_of(phase.begin) + x_of(phase.end));
      middle = std::clamp(middle, std::min(left_ + half, plot_.width - 4 - half),
                          plot_.width - 4 - half);
      std::size_t row = 0;
      while (row < row_ends.size() && row_ends[row] + 6 > middle - half) ++row;
      if (row == row_ends.size()) row_ends.push_back(0);
      row_ends[row] = middle + half;
      svg_.text(middle, top_ + 15 + 13 * static_cast<double>(row), phase.caption,
                "class=\"note\" text-anchor=\"middle\"");
    }
    top_ += row_ends.empty() ? 0 : 5 + 13 * static_cast<double>(row_ends.size());
  }

  void paint_axes(const PlotPanel& panel, const PlotAxis& y, bool is_last) {
    const double bottom = top_ + plot_.panel_height;
    for (const PlotTick& tick : y.ticks()) {
      const double at = bottom - plot_.panel_height * y.place(tick.value);
      const double length = tick.label.empty() ? 3 : 5;
      svg_.line(left_ - length, at, left_, at, "class=\"axis\"");
      svg_.text(left_ - 8, at + 4, tick.label, "text-anchor=\"end\"");
    }
    for (const PlotTick& tick : x_axis_.ticks()) {
      const double at = left_ + x_of(tick.value);
      svg_.line(at, bottom, at, bottom + (tick.label.empty() ? 3 : 5), "class=\"axis\"");
      if (is_last) svg_.text(at, bottom + 18, tick.label, "text-anchor=\"middle\"");
    }
    svg_.upright_text(14, top_ + 0.5 * plot_.panel_height, y.caption(panel.y_label));
  }

  const SvgPlot& plot_;
  PlotAxis x_axis_;
  std::vector<PlotAxis> y_axes_;
  SvgWriter svg_;
  /// [-] Left edge and width of all frames. Painted height of the figure so far.
  double left_ = 0;
  double width_ = 0;
  double top_ = 6;
};

inline std::string SvgPlot::svg() const {
  validate_plot(*this);
  return PlotPainter(*this).paint();
}

}  // namespace figure
