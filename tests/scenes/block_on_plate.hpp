/// @file
/// A plate with sensors and a block on it, in an engine that is not ours.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/hosts/host_sensors.hpp>
#include <bristle/sensors/placement.hpp>
#include <bristle/sensors/tuning.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace bristle::scenes {

/// A still plate whose sensors look up along +z, and a block without rotation that lies on it,
/// integrated by symplectic Euler.
template <typename S>
struct BlockOnPlate {
  BodyId plate{}, block_id{};
  Vec3<S> block = Vec3<S>(S(0), S(0), S(0.008));
  Vec3<S> velocity = Vec3<S>::Zero();
  Vec3<S> push = Vec3<S>::Zero();
  S mass = S(0.5);
  Wrench<S> on_plate{}, on_block{};
  int wrenches = 0;

  /// Mirrors both bodies; neither has a shape there.
  /// @return The patch on the plate.
  PatchId attach(HostSensors<S>& sensors, const PatchDef<S>& patch) {
    plate = sensors.world().add_body({.motion = Motion::kinematic});
    block_id = sensors.world().add_body({.motion = Motion::kinematic});
    return sensors.world().add_patch(plate, patch);
  }
  [[nodiscard]] Vec3<S> own_force() const { return push - Vec3<S>(S(0), S(0), S(9.81) * mass); }

  [[nodiscard]] HostBody<S> body(BodyId id) const {
    HostBody<S> b;
    if (id == plate) return b;
    b.pose.translation = b.center = block;
    b.twist.linear = velocity;
    b.acceleration.linear = own_force() / mass;
    return b;
  }
  [[nodiscard]] Mat6<S> mobility(BodyId i, BodyId) const {
    if (i == plate) return Mat6<S>::Zero();
    return free_mobility<S>(S(1) / mass, Mat3<S>::Zero());
  }
  void apply_wrench(BodyId id, const Wrench<S>& w) {
    ++wrenches;
    (id == plate ? on_plate : on_block) += w;
  }
  void step(S dt) {
    velocity += dt / mass * (own_force() + on_block.force);
    block += dt * velocity;
    on_plate = on_block = {};
  }
};

/// The same, with rays of its own.
template <typename S>
struct CastingBlockOnPlate : BlockOnPlate<S> {
  void cast_rays(BodyId, const RayBatch<S>& rays, RayHits<S>& hits) const {
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const S distance = this->block.z() - rays.origin_z[i];
      if (distance <= rays.length[i] + rays.extra_length) {
        hits.offer(i, {std::max(S(0), distance), -Vec3<S>::UnitZ()}, this->block_id.index);
      }
    }
  }
};

template <typename S>
PatchDef<S> plate_patch() {
  SensorGridDef<S> grid;
  grid.side_u = Vec3<S>(S(0.04), S(0), S(0));
  grid.side_v = Vec3<S>(S(0), S(0.04), S(0));
  grid.count_u = grid.count_v = 4;
  grid.depth = S(0);
  PatchDef<S> def;
  def.sensors = sensor_grid(grid);
  GripSpec<S> spec;
  spec.load = S(0.5 * 9.81);
  spec.mass = S(0.5);
  def.parameters = tuned_for(spec).parameters(def.sensors);
  return def;
}

}  // namespace bristle::scenes
