// Puts a patch of sensors into somebody else's engine: here a point-mass toy that knows nothing of
// bristle but three functions. A 0.5 kg block is held against a wall that moves sideways; the patch
// drags it along and reports the force it applies.
//
// The engine integrates m dv/dt = F by itself; the patch only adds wrenches. It must know what else
// the engine will add (`HostBody::acceleration`), since it solves for the end of the step. In
// steady motion the shear equals m g and the normal force the squeeze.
//
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/bristle.hpp>

#include <cstdio>

using namespace bristle;

namespace {

/// Two bodies: 0 is a plate at x = 0 whose sensors look along +x, 1 a block that cannot turn, with
/// its face at `face`.
struct ToyEngine {
  Vec3<double> plate{0, 0, 0}, plate_velocity{0, 0, 0};
  Vec3<double> block{0.03, 0, 0}, block_velocity{0, 0, 0};
  Vec3<double> added{0, 0, 0};
  static constexpr double mass = 0.5;
  static constexpr double half_width = 0.02;
  static constexpr double squeeze = 10;

  /// What acts on the block without the patch: gravity and a squeeze towards the plate.
  Vec3<double> own_force() const { return {-squeeze, 0, -9.81 * mass}; }

  HostBody<double> body(std::uint32_t i) const {
    HostBody<double> b;
    b.motion.pose.translation = i == 0 ? plate : block;
    b.motion.twist.linear = i == 0 ? plate_velocity : block_velocity;
    if (i == 1) {
      b.inverse_mass = 1 / mass;
      b.inverse_inertia_W = 1e-9 * Mat3<double>::Identity();
      b.acceleration = own_force() / mass;
    }
    return b;
  }
  void cast_rays(std::uint32_t, const RayBatch<double>& rays, RayHits<double>& hits) const {
    const double face = block.x() - half_width - plate.x();
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const double distance = face - rays.origin_x[i];
      if (distance <= rays.length[i]) {
        hits.offer(i, {std::max(0.0, distance), -Vec3<double>::UnitX()}, 1);
      }
    }
  }
  void apply_wrench(std::uint32_t i, const Wrench<double>& w) {
    if (i == 1) added += w.force;
  }
  void step(double dt) {
    block_velocity += dt / mass * (own_force() + added);
    block += dt * block_velocity;
    plate += dt * plate_velocity;
    added.setZero();
  }
};

}  // namespace

int main() {
  PatchDef<double> def;
  for (int i = 0; i < 25; ++i) {
    const double y = 0.004 * (i % 5 - 2);
    const double z = 0.004 * (i / 5 - 2);
    def.sensors.add({0, y, z}, {0.012, y, z});
  }
  def.parameters = tuned_for<double>({.friction = 0.8, .load = ToyEngine::squeeze, .mass = 0.5})
                       .parameters(def.sensors);
  HostPatch<double> patch(0, def);

  ToyEngine engine;
  engine.plate_velocity = {0, 0.05, 0};
  const double dt = 1.0 / 60;
  for (int i = 0; i < 300; ++i) {
    patch.step(engine, dt);
    engine.step(dt);
  }
  const auto felt = patch.reading();
  std::printf("normal force   %6.3f N (squeeze %.3f N)\n", felt.total_normal(), engine.squeeze);
  std::printf("shear          %6.3f N (m g %.3f N)\n", felt.total_shear(), engine.mass * 9.81);
  std::printf("carried along  %6.3f m of %.3f m\n", engine.block.y(), engine.plate.y());
  std::printf("slipping       %zu of %zu\n", felt.slipping(), felt.size());
  return 0;
}
