"""A foot steps on a slope of numpy: where the ground is, when the sole touches it, what it feels."""
import numpy as np
import bristle

x = np.linspace(-1, 1, 41)
heights = np.tile(0.2 * x, (21, 1))  # [along y, along x]
surface = bristle.height_field_mesh(size=(2, 1), heights=heights)

world = bristle.World(time_step=1e-3)
ground = world.add_body(motion=bristle.Motion.fixed,
                        shape=bristle.extruded_mesh(surface, offset=(0, 0, -0.3)))
foot = world.add_body(mass=0.5, shape=bristle.Box((0.05, 0.05, 0.02)), position=(0.2, 0, 0.1))
sole = bristle.sensor_grid(center=(0, 0, -0.02), side_u=(0, 0.09, 0), side_v=(0.09, 0, 0),
                           count_u=5, count_v=5)
tuning = bristle.tuned_for(friction=0.8, creep=1e-3, load=5)
skin = world.add_patch(foot, sole, tuning.parameters(sole))

down = world.cast_rays(origins=[(0, 0, 1), (0.2, 0, 1), (5, 0, 1)], directions=(0, 0, -1))
print("ground at", down.point[down.body == ground, 2].round(3), "m, foot at",
      down.point[down.body == foot, 2].round(3), "m")

world.keep_touch_events()
for step in range(1, 1001):
    world.step()
    for event in world.touch_events():
        print(f"{step} ms: the sole", "touches" if event.begins else "leaves", "the ground")
    world.clear_touch_events()

displacements, forces = np.split(world.taxel_points(skin), 2, axis=1)
along, _, upwards = forces.sum(axis=0)
print(f"force on the sole: {along:.2f} N along it, {upwards:.2f} N across")
