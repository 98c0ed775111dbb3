/// @file
/// A large fixed patch with two bodies on it, one of them a mesh: enough sensors for several
/// ranges.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/sensors/neighbour_order.hpp>
#include <bristle/sensors/placement.hpp>
#include <bristle/sensors/tuning.hpp>
#include <bristle/world/world.hpp>

#include <cstdint>

namespace bristle::scenes {

using namespace bristle::detail;

/// The built scene.
template <Scalar S, typename Backend = AnalyticBackend>
struct Skin {
  World<S, Backend> world;
  BodyId ball{};
  BodyId plate{};
  PatchId patch{};
};

/// Builds the scene: 100 x 100 sensors on 140 x 60 mm, in rows or in neighbour order; a bumpy mesh
/// and a box slide over them. Rays are cast every `cast_every` steps.
template <Scalar S, typename Backend = AnalyticBackend>
[[nodiscard]] Skin<S, Backend> make_skin(WorldDef<S> def, Integration integration,
                                         std::uint32_t cast_every = 1, bool in_rows = true) {
  def.time_step = S(1e-3);
  Skin<S, Backend> skin{World<S, Backend>(def)};
  const BodyId floor = skin.world.add_body({.motion = Motion::fixed});
  PatchDef<S> patch;
  patch.sensors = sensor_grid<S>(
      {.side_u = {S(0.14), 0, 0}, .side_v = {0, S(0.06), 0}, .count_u = 100, .count_v = 100});
  if (!in_rows) patch.sensors = in_order(patch.sensors, neighbour_order(patch.sensors));
  patch.parameters = tuned_for<S>({.load = S(20), .mass = S(2)}).parameters(patch.sensors);
  patch.integration = integration;
  patch.cast_every = cast_every;
  skin.patch = skin.world.add_patch(floor, patch);
  skin.ball = skin.world.add_body({.mass = S(1),
                                   .shape = sphere_mesh<S>(S(0.03), 12),
                                   .position = {S(-0.03), 0, S(0.031)},
                                   .velocity = {S(-0.02), S(0.01), 0}});
  skin.plate = skin.world.add_body({.mass = S(1),
                                    .shape = Box<S>{{S(0.028), S(0.028), S(0.01)}},
                                    .position = {S(0.03), 0, S(0.011)},
                                    .velocity = {S(-0.01), S(0.02), 0}});
  return skin;
}

}  // namespace bristle::scenes
