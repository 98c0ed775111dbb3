/// @file
/// A heavy ball, or its hull of triangles, falls on a plane: how deep does the first step with
/// contact find it?
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scenes/rigid/measures.hpp"

#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace bristle::scenes {

using namespace bristle::detail;

/// A sphere as a closed convex mesh: an icosahedron whose triangles are split in four `splits`
/// times, 20 * 4^splits triangles.
[[nodiscard]] inline TriangleMesh<double> icosphere(int splits, double radius) {
  const double t = (1 + std::sqrt(5.0)) / 2;
  TriangleMesh<double> mesh;
  mesh.vertices = {{-1, t, 0},  {1, t, 0},  {-1, -t, 0}, {1, -t, 0}, {0, -1, t},  {0, 1, t},
                   {0, -1, -t}, {0, 1, -t}, {t, 0, -1},  {t, 0, 1},  {-t, 0, -1}, {-t, 0, 1}};
  mesh.triangles = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                    {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                    {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                    {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (int k = 0; k < splits; ++k) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto next = static_cast<std::uint32_t>(mesh.vertices.size());
      const auto [place, is_new] = middles.try_emplace(std::minmax(a, b), next);
      if (is_new) mesh.vertices.push_back(0.5 * (mesh.vertices[a] + mesh.vertices[b]));
      return place->second;
    };
    std::vector<std::array<std::uint32_t, 3>> finer;
    for (const auto& [a, b, c] : mesh.triangles) {
      const std::uint32_t ab = middle(a, b);
      const std::uint32_t bc = middle(b, c);
      const std::uint32_t ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(finer);
    for (Vector& v : mesh.vertices) v.normalize();
  }
  for (Vector& v : mesh.vertices) v *= radius / v.norm();
  return mesh;
}

/// 50 kg of 0.5 m radius fall 2 m, and by a little more in each of eight runs so that the touch
/// falls in other phases of the step. The error is the deepest the shape is in the plane [m].
class Drop : public Trial {
 public:
  static constexpr int phases = 8;

  /// @param splits  Of the icosahedron; < 0: a ball.
  Drop(int splits, int phase) : Trial(make(splits, phase)) {}

  void observe(const Engine& engine, const Instant& now) override {
    const BodyState body = engine.state(1);
    const double d = depth(scene().bodies[0], BodyState{}, scene().bodies[1], body);
    deepest_ = std::isfinite(d) ? std::max(deepest_, d) : std::numeric_limits<double>::infinity();
    lowest_ = std::min(lowest_, body.position.z());
    if (!now.is(scene().duration)) return;
    rest_depth_ = d;
    rest_height_ = body.position.z();
    kinetic_ = kinetic_energy(scene().bodies[1], body);
  }
  [[nodiscard]] Outcome outcome() const override {
    return {deepest_,
            deepest_ < 0.01,
            {{"rest_depth", rest_depth_},
             {"below_rest", rest_height_ - lowest_},
             {"KE_end", kinetic_}}};
  }

 private:
  static Scene make(int splits, int phase) {
    constexpr double radius = 0.5;
    constexpr std::array<double, phases> extra{0,      0.0047, 0.0113, 0.0231,
                                               0.0377, 0.0291, 0.0179, 0.0419};
    Scene scene;
    scene.duration = 3;
    scene.add(floor_body(0.5));
    SceneBody body =
        ball_body(radius, 50, {0, 0, 2.5 + extra[static_cast<std::size_t>(phase)]}, 0.5);
    if (splits >= 0) body.shape = icosphere(splits, radius);
    scene.add(body);
    return scene;
  }

  double deepest_ = 0;
  double lowest_ = std::numeric_limits<double>::infinity();
  double rest_depth_ = 0;
  double rest_height_ = 0;
  double kinetic_ = 0;
};

}  // namespace bristle::scenes
