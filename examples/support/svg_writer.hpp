/// @file
/// The few elements of SVG that plots use.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/bristle.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace figure {

/// Appends text with the five special characters of XML escaped. XML cannot hold control
/// characters. They become spaces.
inline void append_escaped(std::string& xml, std::string_view text) {
  for (const char c : text) {
    switch (c) {
      case '&':
        xml += "&amp;";
        break;
      case '<':
        xml += "&lt;";
        break;
      case '>':
        xml += "&gt;";
        break;
      case '"':
        xml += "&quot;";
        break;
      case '\'':
        xml += "&apos;";
        break;
      default:
        xml += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
  }
}

/// Width of 12 px sans-serif text, estimated: fonts are the viewer's.
[[nodiscard]] inline double text_width(std::string_view text) {
  const auto count = std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xc0) != 0x80;  // bytes that begin a character of UTF-8
  });
  return 6.4 * static_cast<double>(count);
}

/// Style that distinguishes a curve from others.
struct CurveLook {
  /// Okabe and Ito (2008): distinct with all common kinds of colour vision.
  std::string_view colour;
  /// Lengths of strokes and gaps [px], which distinguish curves without colour.
  std::string_view dashes;
};

/// Style of the i-th curve of a frame. Repeats after nine.
[[nodiscard]] inline CurveLook look_of_curve(std::size_t i) {
  static constexpr CurveLook looks[] = {
      {"#0072b2", ""},        {"#d55e00", "7 3"},     {"#009e73", "2 2.5"},
      {"#cc79a7", "9 3 2 3"}, {"#e69f00", "12 4"},    {"#56b4e9", "4 2 1 2 1 2"},
      {"#333333", "1 3"},     {"#999933", "5 2 1 2"}, {"#882255", "14 3 2 3"}};
  return looks[i % std::size(looks)];
}

/// Collects SVG elements. Lengths are CSS pixels, y points down.
class SvgWriter {
 public:
  /// Opens a frame. Everything until `close_frame` is clipped to a rectangle and relative to its
  /// upper left corner.
  void open_frame(double x, double y, double width, double height) {
    tag("svg");
    attributes({{"x", x}, {"y", y}, {"width", width}, {"height", height}});
    body_ += ">\n";
    frame_ = {x, y, width, height};
  }
  /// Closes the frame and draws its border.
  void close_frame() {
    body_ += "</svg>\n";
    tag("rect");
    attributes(
        {{"x", frame_.x}, {"y", frame_.y}, {"width", frame_.width}, {"height", frame_.height}});
    end("class=\"axis\"");
  }

  void line(double x1, double y1, double x2, double y2, std::string_view style) {
    tag("line");
    attributes({{"x1", x1}, {"y1", y1}, {"x2", x2}, {"y2", y2}});
    end(style);
  }

  void rectangle(double x, double y, double width, double height, std::string_view fill) {
    tag("rect");
    attributes({{"x", x}, {"y", y}, {"width", width}, {"height", height}});
    attribute("fill", fill);
    end("");
  }

  void dot(double x, double y, std::string_view fill) {
    tag("circle");
    attributes({{"cx", x}, {"cy", y}, {"r", 2.6}});
    attribute("fill", fill);
    end("");
  }

  /// Writes text. Nothing if it is empty.
  void text(double x, double y, std::string_view content, std::string_view style) {
    if (content.empty()) return;
    tag("text");
    attributes({{"x", x}, {"y", y}});
    write_content(content, style);
  }

  /// Writes text that reads upwards, centred on a point.
  void upright_text(double x, double y, std::string_view content) {
    if (content.empty()) return;
    tag("text");
    body_ += " transform=\"translate(";
    number(x);
    body_ += ' ';
    number(y);
    body_ += ") rotate(-90)\"";
    write_content(content, "text-anchor=\"middle\"");
  }

  /// Draws a curve through points from left to right. Of many points in one half pixel's column
  /// only the first, the lowest, the highest and the last are kept, which looks the same.
  void polyline(const std::vector<std::pair<double, double>>& points, const CurveLook& look);

  /// Returns the whole file.
  [[nodiscard]] std::string document(double width, double height, std::string_view title);

 private:
  struct Frame {
    double x, y, width, height;
  };
  struct Attribute {
    std::string_view name;
    double value;
  };

  void tag(std::string_view name) { (body_ += '<') += name; }
  void attribute(std::string_view name, std::string_view value) {
    ((((body_ += ' ') += name) += "=\"") += value) += '"';
  }
  void attributes(std::initializer_list<Attribute> list) {
    for (const Attribute& a : list) {
      ((body_ += ' ') += a.name) += "=\"";
      number(a.value);
      body_ += '"';
    }
  }
  void end(std::string_view style) {
    if (!style.empty()) (body_ += ' ') += style;
    body_ += "/>\n";
  }
  void write_content(std::string_view content, std::string_view style) {
    if (!style.empty()) (body_ += ' ') += style;
    body_ += '>';
    append_escaped(body_, content);
    body_ += "</text>\n";
  }
  /// Writes a number with two decimals, without trailing zeros.
  void number(double value);

  std::string body_;
  Frame frame_{};
};

// Implementation ----------------------------------------------------------------------------------

inline void SvgWriter::number(double value) {
  // Far outside every frame the exact position does not matter.
  const double near = std::clamp(value, -1e6, 1e6);
  char buffer[32];
  const auto result =
      std::to_chars(buffer, buffer + sizeof buffer, near, std::chars_format::fixed, 2);
  std::string_view text(buffer, static_cast<std::size_t>(result.ptr - buffer));
  while (text.ends_with('0')) text.remove_suffix(1);
  if (text.ends_with('.')) text.remove_suffix(1);
  body_ += text == "-0" ? "0" : text;
}

inline void SvgWriter::polyline(const std::vector<std::pair<double, double>>& points,
                                const CurveLook& look) {
  if (points.size() < 2) return;
  tag("polyline");
  attribute("stroke", look.colour);
  if (!look.dashes.empty()) attribute("stroke-dasharray", look.dashes);
  body_ += " class=\"curve\" points=\"";
  const auto put = [&](std::size_t i) {
    number(points[i].first);
    body_ += ',';
    number(points[i].second);
    body_ += ' ';
  };
  for (std::size_t begin = 0; begin < points.size();) {
    const auto column = [&](std::size_t i) { return std::floor(2 * points[i].first); };
    std::size_t low = begin, high = begin, last = begin;
    for (; last + 1 < points.size() && column(last + 1) == column(begin); ++last) {
      if (points[last + 1].second < points[low].second) low = last + 1;
      if (points[last + 1].second > points[high].second) high = last + 1;
    }
    std::size_t keep[] = {begin, std::min(low, high), std::max(low, high), last};
    for (std::size_t k = 0; k < 4; ++k) {
      if (k == 0 || keep[k] != keep[k - 1]) put(keep[k]);
    }
    begin = last + 1;
  }
  body_.pop_back();
  body_ += "\"/>\n";
}

inline std::string SvgWriter::document(double width, double height, std::string_view title) {
  const std::string content = std::exchange(body_, {});
  body_ = R"(<svg xmlns="http://www.w3.org/2000/svg" role="img")";
  attributes({{"width", width}, {"height", height}});
  body_ += " viewBox=\"0 0 ";
  number(width);
  body_ += ' ';
  number(height);
  body_ += "\">\n";
  if (!title.empty()) {
    body_ += "<title>";
    append_escaped(body_, title);
    body_ += "</title>\n";
  }
  body_ += R"(<style>
text { font: 12px Helvetica, Arial, "Liberation Sans", "DejaVu Sans", sans-serif; fill: #222 }
.title { font-size: 14px; font-weight: bold }
.note { font-size: 11px; fill: #444 }
.halo { stroke: #fff; stroke-width: 3px; stroke-linejoin: round; paint-order: stroke }
.axis { fill: none; stroke: #444; stroke-width: 1 }
.grid { stroke: #ddd; stroke-width: 0.8 }
.reference { stroke: #555; stroke-width: 1; stroke-dasharray: 5 3 }
.curve { fill: none; stroke-width: 1.6; stroke-linejoin: round }
</style>
<rect width="100%" height="100%" fill="#fff"/>
)";
  return std::exchange(body_, {}) + content + "</svg>\n";
}

}  // namespace figure
