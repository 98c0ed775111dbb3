// One grip in twenty worlds: how heavy a part does it hold?
//
// Two pads press a cube with N = 10 N each. Bristles that drag hold shear up to mu N, so parts of
// up to 2 mu N / g = 1.02 kg stay; the part of world i weighs 0.1 kg (i + 1).
//
// Expected output: 18_batch.expected
// SPDX-License-Identifier: BSD-3-Clause
#define BRISTLE_WITH_THREADS 1  // for ThreadPool
#include <bristle/bristle.hpp>

#include <cstdio>
#include <vector>

using namespace bristle;

int main() {
  World<float> scene({.time_step = 1e-3f});
  const BodyId part =
      scene.add_body({.mass = 0.1f, .shape = Box<float>{.half_extents = {0.03f, 0.03f, 0.03f}}});
  std::vector<PatchId> pads;
  for (const float inwards : {1.0f, -1.0f}) {
    const BodyId finger =
        scene.add_body({.motion = Motion::kinematic, .position = {-0.0415f * inwards, 0.0f, 0.0f}});
    // Rays reach 15 mm in from the finger, 3.5 of them into the part: e = 3.5 mm / 10 mm.
    SensorLayout<float> sensors;
    for (int i = 0; i < 36; ++i) {
      const float y = 0.006f * (float(i % 6) - 2.5f), z = 0.006f * (float(i / 6) - 2.5f);
      sensors.add({0.005f * inwards, y, z}, {inwards, 0.0f, 0.0f}, 0.010f);
    }
    PatchDef<float> pad;
    pad.parameters =
        tuned_for<float>({.friction = 0.5f, .creep = 1e-3f, .load = 10.0f, .press = 0.35f})
            .parameters(sensors);
    pad.sensors = sensors;
    pad.options.reset = SlipReset::drag;
    pads.push_back(scene.add_patch(finger, pad));
  }

  ThreadPool pool(2);
  WorldBatch<float> batch(scene, 20, pool.hook());
  batch.for_each(
      [&](std::size_t i, World<float>& world) { world.set_mass(part, 0.1f * float(i + 1)); });
  for (int i = 0; i < 250; ++i) batch.step(8);

  std::vector<float> bodies(batch.size() * 13);
  const BodyId parts[] = {part};
  batch.gather_bodies(parts, bodies);
  std::puts("mass [kg]  after 2 s");
  for (std::size_t i = 0; i < batch.size(); ++i) {
    const bool is_held = bodies[13 * i + 2] > -0.01f;
    std::printf("%9.1f  %s\n", 0.1 * double(i + 1), is_held ? "held" : "lost");
  }
}
