/// @file
/// A plate with sensors and a block on it, in an engine that is not ours.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/hosts/sensor_host.hpp>
#include <bristle/sensors/placement.hpp>
#include <bristle/sensors/tuning.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace bristle::scenes {

/// Body 0 is a still plate whose sensors look up along +z; body 1 a block without rotation that
/// lies on it, integrated by symplectic Euler.
template <typename S>
struct BlockOnPlate {
  Vec3<S> block = Vec3<S>(S(0), S(0), S(0.008));
  Vec3<S> velocity = Vec3<S>::Zero();
  Vec3<S> push = Vec3<S>::Zero();
  S mass = S(0.5);
  Vec3<S> added = Vec3<S>::Zero();
  int wrenches = 0;

  [[nodiscard]] Vec3<S> own_force() const { return push - Vec3<S>(S(0), S(0), S(9.81) * mass); }
  HostBody<S> body(std::uint32_t i) const {
    HostBody<S> b;
    if (i == 0) return b;
    b.motion.pose.translation = block;
    b.motion.twist.linear = velocity;
    b.inverse_mass = S(1) / mass;
    b.inverse_inertia_W = S(1e-6) * Mat3<S>::Identity();
    b.acceleration = own_force() / mass;
    return b;
  }
  void cast_rays(std::uint32_t, const RayBatch<S>& rays, RayHits<S>& hits) const {
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const S distance = block.z() - rays.origin_z[i];
      if (distance <= rays.length[i]) {
        hits.offer(i, {std::max(S(0), distance), -Vec3<S>::UnitZ()}, 1);
      }
    }
  }
  void apply_wrench(std::uint32_t i, const Wrench<S>& w) {
    ++wrenches;
    if (i == 1) added += w.force;
  }
  void step(S dt) {
    velocity += dt / mass * (own_force() + added);
    block += dt * velocity;
    added.setZero();
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
  GripWants<S> wants;
  wants.load = S(0.5 * 9.81);
  wants.mass = S(0.5);
  def.parameters = tuned_for(wants).parameters(def.sensors);
  return def;
}

}  // namespace bristle::scenes
