"""Ranks of MPI share a batch of worlds, by mpi4py; any number of them ends in the same states."""
import hashlib

from mpi4py import MPI
import bristle.float32 as bristle32
import numpy as np
import bristle

WORLDS = 20
ranks = MPI.COMM_WORLD

scene = bristle32.World(time_step=1e-3)
part = scene.add_body(mass=0.1, shape=bristle32.Box((0.03, 0.03, 0.03)))
for inwards in (1.0, -1.0):
    finger = scene.add_body(motion=bristle.Motion.kinematic, position=(-0.0415 * inwards, 0, 0))
    # Rays reach 3.5 mm into the part: each pad presses with 10 N.
    sensors = bristle32.sensor_grid(center=(0.010 * inwards, 0, 0), side_u=(0, 0.036 * inwards, 0),
                                    side_v=(0, 0, 0.036), count_u=6, count_v=6)
    tuning = bristle32.tuned_for(friction=0.5, creep=1e-3, load=10, press=0.35)
    scene.add_patch(finger, sensors, tuning.parameters(sensors), reset=bristle.SlipReset.drag)

# A rank owns a slab of the worlds. The number of a world is the seed of all that differs in it.
if ranks.size > WORLDS:
    raise SystemExit(f"cluster_batch.py: {ranks.size} ranks for {WORLDS} worlds: each needs one")
numbers = range(WORLDS * ranks.rank // ranks.size, WORLDS * (ranks.rank + 1) // ranks.size)
masses = np.array([np.random.default_rng(number).uniform(0.1, 2.0) for number in numbers])
batch = bristle32.WorldBatch(scene, len(numbers))
batch.set_mass(part, masses)
batch.step(2000)

# The first rank gets what it prints as arrays, and states as bytes that World.restore takes.
slabs = ranks.gather((masses, batch.bodies([part])[:, 0, 2],
                      [batch[i].snapshot() for i in range(len(batch))]))
if ranks.rank == 0:
    masses, heights = (np.concatenate(column) for column in list(zip(*slabs))[:2])
    held = heights > -0.01
    print(f"{held.sum()} of {WORLDS} held, up to {masses[held].max():.2f} kg")
    print(f"lost from {masses[~held].min():.2f} kg on")
    states = b"".join(state for _, _, slab in slabs for state in slab)
    print("states", hashlib.sha256(states).hexdigest()[:16])
