// Puts sensors into somebody else's engine: here a toy that knows nothing of bristle but three
// functions. Two pads on slides pinch a 45 g part with 12 N; then gravity comes.
//
// The engine integrates m dv/dt = F by itself; the sensors only add wrenches, those of both pads
// solved together. They must know how each body answers a push (`mobility`) and what else the
// engine will add (`HostBody::acceleration`), since they solve for the end of the step. Held at
// 1/60 s, the part sags by m g / (mu_S sum F_N), its bristles' stretch, and then does not creep.
//
// Expected output: 07_own_engine.expected
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/bristle.hpp>

#include <cmath>
#include <cstdio>
#include <utility>

using namespace bristle;

namespace {

/// The pads move along x only, the part in all directions but does not turn.
struct ToyEngine {
  struct Body {
    BodyId id;
    Vec3<double> position, velocity, inverse_mass, force, added;
  };
  Body bodies[3];  // Two pads, and the part.

  HostBody<double> body(BodyId id) const {
    const Body& b = find(id);
    HostBody<double> state;
    state.pose.translation = state.center = b.position;
    state.twist.linear = b.velocity;
    state.acceleration.linear = b.inverse_mass.cwiseProduct(b.force);
    return state;
  }
  Mat6<double> mobility(BodyId id, BodyId) const {
    return free_mobility<double>(find(id).inverse_mass, Mat3<double>::Zero());
  }
  void apply_wrench(BodyId id, const Wrench<double>& w) { find(id).added += w.force; }

  void step(double dt) {
    for (Body& b : bodies) {
      b.velocity += dt * b.inverse_mass.cwiseProduct(b.force + b.added);
      b.position += dt * b.velocity;
      b.added.setZero();
    }
  }

  const Body& find(BodyId id) const {
    int i = 0;
    while (bodies[i].id != id) ++i;
    return bodies[i];
  }
  Body& find(BodyId id) { return const_cast<Body&>(std::as_const(*this).find(id)); }
};

/// Rays from 3 mm below the face of a pad to 5 mm beyond it.
PatchDef<double> pad(double side) {
  PatchDef<double> def;
  for (int i = 0; i < 36; ++i) {
    const double y = 0.003 * (i % 6 - 2.5);
    const double z = 0.003 * (i / 6 - 2.5);
    def.sensors.add({side * 0.002, y, z}, {side * 0.010, y, z});
  }
  def.parameters =
      tuned_for<double>({.friction = 0.7, .load = 12, .mass = 0.045}).parameters(def.sensors);
  return def;
}

}  // namespace

int main() {
  HostSensors<double> sensors;
  World<double>& mirror = sensors.world();
  const BodyDef<double> box{.motion = Motion::kinematic, .shape = Box<double>{{0.005, 0.01, 0.01}}};
  const Vec3<double> rest = Vec3<double>::Zero();
  const Vec3<double> slide{1 / 0.1, 0, 0};
  const Vec3<double> part = Vec3<double>::Constant(1 / 0.045);
  ToyEngine engine{{{mirror.add_body(box), {-0.0101, 0, 0}, rest, slide, {12, 0, 0}, rest},
                    {mirror.add_body(box), {0.0101, 0, 0}, rest, slide, {-12, 0, 0}, rest},
                    {mirror.add_body(box), {0, 0, 0}, rest, part, rest, rest}}};
  const PatchId left = mirror.add_patch(engine.bodies[0].id, pad(1));
  const PatchId right = mirror.add_patch(engine.bodies[1].id, pad(-1));

  const double dt = 1.0 / 60;
  const auto run = [&](int steps) {
    for (int i = 0; i < steps; ++i) {
      sensors.step(engine, dt);
      engine.step(dt);
    }
    return engine.bodies[2].position.z();
  };
  const double start = run(60);
  engine.bodies[2].force = {0, 0, -9.81 * 0.045};
  const double there = run(60);
  const double later = run(600);
  const auto felt_left = mirror.reading(left), felt_right = mirror.reading(right);
  const double normal = felt_left.total_normal() + felt_right.total_normal();
  const double mu_S = mirror.patch(left).def.parameters.static_friction;
  std::printf("normal forces  %8.4f N (squeeze 2 x 12 N)\n", normal);
  std::printf("shear          %8.3f N (m g %.3f N)\n",
              felt_left.total_shear() + felt_right.total_shear(), 9.81 * 0.045);
  std::printf("sag            %8.4f um (m g / (mu_S sum F_N) %.4f um)\n", 1e6 * (start - there),
              1e6 * 9.81 * 0.045 / (mu_S * normal));
  std::printf("creep in 10 s  %8.4f um\n", 1e6 * std::abs(there - later));
  return 0;
}
