// A world drawn by a renderer of one's own, here into an SVG file: `for_each_drawn` tells it lines,
// triangles, points and text, as a game would ask for once a frame.
//
// A block of 0.5 kg stands on 16 sensors, beside it lies a ball of 0.2 kg. Forces are drawn 0.02 m
// long for a newton: the lines below the block add up to its weight, 4.905 N or 0.0981 m, and the
// one below the ball is 0.0392 m long.
//
// Writes 19_own_renderer.svg. Expected output: 19_own_renderer.expected
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/bristle.hpp>
#include <bristle/io/drawn_world.hpp>

#include <cstdio>
#include <map>
#include <string>
#include <string_view>

using namespace bristle;

/// Draws what it is told, seen from the side and a little from above, 2000 pixels a metre.
class SvgRenderer {
 public:
  void line(const Drawn& drawn, const Vec3<double>& a, const Vec3<double>& b) {
    ++counts[drawn.kind];
    sums.try_emplace(drawn.kind, Vec3<double>::Zero()).first->second += b - a;
    append("<line x1='%.1f' y1='%.1f' x2='%.1f' y2='%.1f' stroke='%s'/>\n", x(a), y(a), x(b), y(b),
           colour_of(drawn.kind));
  }
  void point(const Drawn& drawn, const Vec3<double>& p) {
    ++counts[drawn.kind];
    append("<circle cx='%.1f' cy='%.1f' r='2'/>\n", x(p), y(p));
  }
  void triangles(const Drawn& drawn, const TriangleMesh<double>& mesh,
                 const Transform<double>& X_WM) {
    ++counts[drawn.kind];
    for (const auto& triangle : mesh.triangles) {
      const Vec3<double> a = X_WM * mesh.vertices[triangle[0]];
      const Vec3<double> b = X_WM * mesh.vertices[triangle[1]];
      const Vec3<double> c = X_WM * mesh.vertices[triangle[2]];
      append("<path d='M%.1f %.1fL%.1f %.1fL%.1f %.1fz' fill='#8884' stroke='#8886'/>\n", x(a),
             y(a), x(b), y(b), x(c), y(c));
    }
  }
  void text(const Drawn& drawn, const Vec3<double>& p, std::string_view words) {
    ++counts[drawn.kind];
    append("<text x='%.1f' y='%.1f' font-size='12'>%s</text>\n", x(p), y(p),
           std::string(words).c_str());
  }

  void write(const char* path) const {
    write_file(path, "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 120 640 240'>\n" + svg_ +
                         "</svg>\n");
  }

  std::map<DrawnKind, int> counts;
  /// Of the vectors [m] from the begin of lines to their end.
  std::map<DrawnKind, Vec3<double>> sums;

 private:
  static const char* colour_of(DrawnKind kind) {
    if (kind == DrawnKind::touch_force) return "#c00";
    return kind == DrawnKind::contact_force ? "#070" : "#05c";
  }
  static double x(const Vec3<double>& p) { return 200 + 2000 * (p.x() + 0.3 * p.y()); }
  static double y(const Vec3<double>& p) { return 250 - 2000 * (0.95 * p.z() + 0.3 * p.y()); }
  template <typename... Values>
  void append(const char* format, Values... values) {
    char text[256];
    std::snprintf(text, sizeof text, format, values...);
    svg_ += text;
  }

  std::string svg_;
};

int main() {
  World<double> world({.time_step = 1e-3});
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
  const BodyId block = world.add_body(
      {.mass = 0.5, .shape = Box<double>{{0.03, 0.03, 0.01}}, .position = {0, 0, 0.0125}});
  SensorGridDef<double> grid;
  grid.center = {0, 0, -0.01};
  grid.side_u = {0.04, 0, 0};
  grid.side_v = {0, -0.04, 0};
  grid.count_u = grid.count_v = 4;
  grid.depth = 0.004;
  grid.range = 0.008;
  PatchDef<double> pad;
  pad.sensors = sensor_grid(grid);
  pad.parameters = {.normal_stiffness = 1, .normal_damping = 0.02, .static_friction = 1000};
  world.add_patch(block, pad);
  world.add_body(
      {.mass = 0.2, .shape = Sphere<double>{.radius = 0.02}, .position = {0.08, 0, 0.02}});
  for (int i = 0; i < 4000; ++i) world.step();

  SvgRenderer renderer;
  for_each_drawn(world, renderer, {.metres_per_newton = 0.02, .plane_size = 0.3});
  renderer.write("19_own_renderer.svg");
  std::printf("%d shapes that move, %d that do not, %d stuck sensors with %d forces\n",
              renderer.counts[DrawnKind::moving_shape], renderer.counts[DrawnKind::fixed_shape],
              renderer.counts[DrawnKind::stuck_sensor], renderer.counts[DrawnKind::touch_force]);
  std::printf("the block pushes down with %.4f m, the ball is pushed up with %.4f m\n",
              -renderer.sums.at(DrawnKind::touch_force).z(),
              renderer.sums.at(DrawnKind::contact_force).z());
}
