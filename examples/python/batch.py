"""How heavy a part does a grip hold? Twenty worlds on two threads, as 18_batch.cpp has them."""
import bristle.float32 as bristle32
import numpy as np
import bristle

scene = bristle32.World(time_step=1e-3)
part = scene.add_body(mass=0.1, shape=bristle32.Box((0.03, 0.03, 0.03)))
pads = []
for inwards in (1.0, -1.0):
    finger = scene.add_body(motion=bristle.Motion.kinematic, position=(-0.0415 * inwards, 0, 0))
    sensors = bristle32.SensorLayout()
    for i in range(36):
        y, z = 0.006 * (i % 6 - 2.5), 0.006 * (i // 6 - 2.5)
        sensors.add((0.005 * inwards, y, z), (inwards, 0, 0), 0.010)
    tuning = bristle32.tuned_for(friction=0.5, creep=1e-3, load=10, press=0.35)
    pads.append(scene.add_patch(finger, sensors, tuning.parameters(sensors),
                                reset=bristle.SlipReset.drag))

batch = bristle32.WorldBatch(scene, 20, threads=2)
masses = 0.1 * np.arange(1, 21)
batch.set_mass(part, masses)
for _ in range(250):
    batch.step(8)

heights = batch.bodies([part])[:, 0, 2]
print("mass [kg]  after 2 s")
for mass, height in zip(masses, heights):
    print(f"{mass:9.1f}  {'held' if height > -0.01 else 'lost'}")
