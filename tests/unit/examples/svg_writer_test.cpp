// SPDX-License-Identifier: BSD-3-Clause

#include "support/svg_writer.hpp"

#include <doctest/doctest.h>

#include <limits>
#include <string>

using namespace figure;

namespace {

std::string content_of(SvgWriter& svg) {
  const std::string text = svg.document(10, 10, "");
  const std::string last = "fill=\"#fff\"/>\n";
  const std::size_t begin = text.find(last) + last.size();
  return text.substr(begin, text.size() - begin - std::string("</svg>\n").size());
}

}  // namespace

TEST_CASE("SvgWriter: writes numbers with at most two decimals and no minus zero") {
  SvgWriter svg;
  svg.line(1.0, -0.001, 2.345, 1e300, "class=\"axis\"");
  CHECK(content_of(svg) == "<line x1=\"1\" y1=\"0\" x2=\"2.35\" y2=\"1000000\" class=\"axis\"/>\n");
}

TEST_CASE("SvgWriter: leaves out empty text and curves of one point") {
  SvgWriter svg;
  svg.text(1, 2, "", "");
  svg.upright_text(1, 2, "");
  svg.polyline({{1, 2}}, look_of_curve(0));
  CHECK(content_of(svg) == "");
}

TEST_CASE("SvgWriter: keeps first, lowest, highest and last of a column of points") {
  SvgWriter svg;
  svg.polyline({{0, 5}, {0.1, 9}, {0.2, 1}, {0.3, 4}, {0.4, 6}, {3, 0}}, look_of_curve(0));
  CHECK(content_of(svg) ==
        "<polyline stroke=\"#0072b2\" class=\"curve\" points=\"0,5 0.1,9 0.2,1 0.4,6 3,0\"/>\n");
}

TEST_CASE("look_of_curve: begins anew after nine curves") {
  CHECK(look_of_curve(9).colour == look_of_curve(0).colour);
  for (std::size_t i = 1; i < 9; ++i) {
    CHECK(look_of_curve(i).colour != look_of_curve(i - 1).colour);
    CHECK(look_of_curve(i).dashes != look_of_curve(i - 1).dashes);
  }
}

TEST_CASE("text_width: counts characters, not bytes") {
  CHECK(text_width("\u00b5m") == text_width("um"));
  CHECK(text_width("") == 0);
}
