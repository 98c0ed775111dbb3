"""Drops a box with a skin of 25 sensors on a table, as 01_falling_box.cpp does."""
import bristle

world = bristle.World(time_step=1e-3)
world.add_body(motion=bristle.Motion.fixed, shape=bristle.HalfSpace())
box = world.add_body(mass=0.5, shape=bristle.Box((0.03, 0.03, 0.03)), position=(0, 0, 0.1))
sensors = bristle.sensor_grid(center=(0, 0, -0.03), side_u=(0, 0.06, 0), side_v=(0.06, 0, 0),
                              count_u=5, count_v=5)
tuning = bristle.tuned_for(friction=0.8, creep=1e-3, load=0.5 * 9.81)
skin = world.add_patch(box, sensors, tuning.parameters(sensors))
world.step(1000)
reading = world.reading(skin)
height = 1e3 * world.position(box)[2]
print(f"{height:.1f} mm, {reading.total_normal:.3f} N, {reading.touching} of {len(reading.depth)}")
