"""Tests of worlds against closed forms: pushes, damping, belts, compounds, contacts, sleep, joints,
events, rays and sets of points, in double and in float."""
# SPDX-License-Identifier: BSD-3-Clause
import sys
import unittest

try:
    import numpy as np
except ImportError:
    print("skipped: no numpy")
    sys.exit(77)

import bristle
import bristle.float32 as bristle32

# A module and what its rounding leaves of a relative error after some hundred steps.
SCALARS = ((bristle, 1e-9), (bristle32, 1e-4))
GRAVITY = 9.81
UPRIGHT = (0, 0, 0, 1)


def free_ball(module, mass=2.0, radius=0.1, **options):
    """A ball where nothing pulls."""
    world = module.World(time_step=1e-3, gravity=(0, 0, 0))
    return world, world.add_body(mass=mass, shape=module.Sphere(radius), **options)


def turned(q, v):
    """A vector turned by x, y, z, w."""
    u = np.asarray(q[:3], float)
    return v + 2 * np.cross(u, np.cross(u, v) + q[3] * np.asarray(v, float))


class Pushes(unittest.TestCase):
    def test_an_impulse_and_a_wrench_change_the_velocity_by_their_parts_of_mass_and_inertia(self):
        for module, error in SCALARS:
            mass, radius = 2.0, 0.1
            inertia = 0.4 * mass * radius**2
            world, ball = free_ball(module, mass, radius, position=(1, 2, 3))
            impulse, arm = np.array([0.3, -0.2, 0.1]), np.array([0.0, 0.05, 0.1])
            world.apply_impulse(ball, impulse, np.array([1, 2, 3]) + arm)
            linear, angular = world.velocity(ball)
            np.testing.assert_allclose(linear, impulse / mass, rtol=error)
            np.testing.assert_allclose(angular, np.cross(arm, impulse) / inertia, rtol=error)
            world, ball = free_ball(module, mass, radius)
            world.apply_wrench(ball, (4, 0, -2), (0, 0.008, 0))
            self.assertEqual(world.velocity(ball)[0].tolist(), [0, 0, 0])
            world.step(2)  # the second step has none
            linear, angular = world.velocity(ball)
            np.testing.assert_allclose(linear, 1e-3 * np.array([2, 0, -1]), rtol=error)
            np.testing.assert_allclose(angular, [0, 1e-3 * 0.008 / inertia, 0], rtol=error)

    def test_velocities_decay_exponentially(self):
        for module, error in SCALARS:
            for as_definition in (True, False):
                rates = dict(linear_damping=3, angular_damping=5)
                world, ball = free_ball(module, velocity=(1, 0, 0), angular_velocity=(0, 0, 2),
                                        **(rates if as_definition else {}))
                if not as_definition:
                    world.set_damping(ball, linear=3, angular=5)
                world.step(500)
                linear, angular = world.velocity(ball)
                np.testing.assert_allclose(linear[0], np.exp(-3 * 0.5), rtol=error)
                np.testing.assert_allclose(angular[2], 2 * np.exp(-5 * 0.5), rtol=error)

    def test_gravity_is_scaled(self):
        for module, error in SCALARS:
            world = module.World(time_step=1e-3, gravity=(0, 0, -GRAVITY))
            light = world.add_body(mass=1, shape=module.Sphere(0.1), gravity_scale=0.25)
            rising = world.add_body(mass=1, shape=module.Sphere(0.1), position=(1, 0, 0))
            world.set_gravity_scale(rising, -2)
            world.step(200)
            self.assertAlmostEqual(world.velocity(light)[0][2] / (-0.25 * GRAVITY * 0.2), 1,
                                   delta=error)
            self.assertAlmostEqual(world.velocity(rising)[0][2] / (2 * GRAVITY * 0.2), 1,
                                   delta=error)

    def test_a_belt_drags_by_friction_up_to_its_speed(self):
        for module, error in SCALARS:
            for as_definition in (True, False):
                world = module.World(time_step=1e-3, gravity=(0, 0, -GRAVITY))
                speed = {"surface_velocity": (0.8, 0, 0)} if as_definition else {}
                belt = world.add_body(motion=bristle.Motion.fixed, friction=0.4,
                                      shape=module.Box((2, 1, 0.5)), position=(0, 0, -0.5), **speed)
                crate = world.add_body(mass=1, shape=module.Box((0.1, 0.1, 0.02)), friction=0.4,
                                       position=(0, 0, 0.02))
                if not as_definition:
                    world.set_material(belt, 0.4, surface_velocity=(0.8, 0, 0))
                world.step(100)
                self.assertAlmostEqual(world.velocity(crate)[0][0], 0.4 * GRAVITY * 0.1,
                                       delta=max(1e-6, 10 * error))
                world.step(400)
                self.assertAlmostEqual(world.velocity(crate)[0][0], 0.8, delta=max(1e-6, 10 * error))


class Compounds(unittest.TestCase):
    def test_a_dumbbell_has_the_mass_and_the_inertia_of_its_parts(self):
        for module, error in SCALARS:
            radius, reach = 0.05, 0.2
            ball = module.Sphere(radius)
            for parts in ({"shapes": [(ball, (0, reach, 0), UPRIGHT), (ball, (0, -reach, 0), UPRIGHT)]},
                          {"shape": ball, "shapes": [(ball, (0, 2 * reach, 0), UPRIGHT)],
                           "position": (0, -reach, 0)}):
                world = module.World(gravity=(0, 0, 0))
                dumbbell = world.add_body(**parts)  # as dense as water
                one = 1000 * 4 / 3 * np.pi * radius**3
                world.apply_impulse(dumbbell, (3, 0, 0), (0, reach, 0))
                linear, angular = world.velocity(dumbbell)
                np.testing.assert_allclose(linear, [3 / (2 * one), 0, 0], rtol=error)
                inertia = 2 * one * (0.4 * radius**2 + reach**2)
                np.testing.assert_allclose(angular, [0, 0, -3 * reach / inertia], rtol=error)

    def test_parts_are_turned_as_they_are_told(self):
        for module, error in SCALARS:
            world = module.World(gravity=(0, 0, 0))
            half = np.sqrt(0.5)
            # A long box along x, turned to stand on z.
            world.add_body(motion=bristle.Motion.fixed,
                           shapes=[(module.Box((0.5, 0.1, 0.1)), (1, 0, 0), (0, half, 0, half))])
            hits = world.cast_rays([(1, 0, 5), (5, 0, 0)], [(0, 0, -1), (-1, 0, 0)])
            np.testing.assert_allclose(hits.distance, [4.5, 3.9], rtol=error)

    def test_what_is_in_a_trigger_is_told_and_not_pushed(self):
        for module, error in SCALARS:
            gate_shape = module.Box((0.1, 1, 1))
            for shapes in ({"shape": gate_shape}, {"shapes": [(gate_shape, (0, 0, 0), UPRIGHT)]}):
                world = module.World(time_step=1e-3, gravity=(0, 0, 0), keeps_contact_events=True)
                gate = world.add_body(motion=bristle.Motion.fixed, is_trigger=True, **shapes)
                ball = world.add_body(mass=1, shape=module.Sphere(0.1), position=(-0.5, 0, 0),
                                      velocity=(1, 0, 0))
                self.assertEqual(world.contact_events(), [])
                told = []
                for step in range(1000):
                    world.step()
                    told += [(step, event) for event in world.contact_events()]
                    world.clear_contact_events()
                (entry, enters), (exit, leaves) = told
                self.assertEqual((enters.begins, leaves.begins), (True, False))
                self.assertEqual({enters.body_a, enters.body_b}, {gate, ball})
                self.assertEqual((enters.shape_a, enters.shape_b), (leaves.shape_a, leaves.shape_b))
                self.assertTrue(world.contains(enters.shape_b))
                # From 0.3 m on to 0.7 m, in steps of 1 mm.
                self.assertAlmostEqual(entry, 300, delta=1)
                self.assertAlmostEqual(exit, 700, delta=1)
                np.testing.assert_allclose(world.velocity(ball)[0], [1, 0, 0], rtol=error)
                self.assertRegex(repr(leaves), r"^ContactEvent\(body_a=BodyId\{0, 0\}, "
                                               r".*begins=False\)$")
                # A ray does not meet it unless it is told to.
                for meets, distance in ((False, np.inf), (True, 4.9)):
                    hits = world.cast_rays((5, 0.5, 0.5), (-1, 0, 0), meets_triggers=meets)
                    np.testing.assert_allclose(hits.distance, [distance], rtol=error)


# The solver leaves 1e-8 and 1e-5 of what gravity gives to a velocity in a step: a hundred times that.
AT_REST = {bristle: 1e-6, bristle32: 1e-3}


class Contacts(unittest.TestCase):
    def test_points_share_a_load_as_levers_say(self):
        for module, _ in SCALARS:
            at_rest = AT_REST[module]
            step, mass, pull = 1e-3, 2.0, 2.0
            world = module.World(time_step=step, gravity=(pull, 0, -GRAVITY))
            # Balls of 50 mm carry a plank of 0.1 m: two at -0.3 m, one at 0.1 m from its middle.
            left_1, left_2, right = (
                world.add_body(motion=bristle.Motion.fixed, shape=module.Sphere(0.05),
                               position=(x, y, -0.05), friction=0.6)
                for x, y in ((-0.3, 0.1), (-0.3, -0.1), (0.1, 0)))
            plank = world.add_body(mass=mass, shape=module.Box((0.4, 0.2, 0.05)),
                                   position=(0, 0, 0.05), friction=0.6)
            self.assertEqual((world.contacts().gap.shape, world.contacts().normal.shape),
                             ((0,), (0, 3)))
            world.step(1000)
            load = mass * step
            contacts = world.contacts()
            self.assertEqual(set(contacts.body_a) | set(contacts.body_b),
                             {left_1, left_2, right, plank})
            self.assertTrue((contacts.body_b == plank).all())
            np.testing.assert_allclose(contacts.normal, [[0, 0, 1]] * 3, atol=at_rest)
            np.testing.assert_allclose(contacts.gap, 0, atol=at_rest)
            np.testing.assert_allclose(contacts.impulse.sum(0), [-load * pull, 0, load * GRAVITY],
                                       rtol=at_rest, atol=load * at_rest)
            # Friction acts 50 mm below the middle, and turns the plank onto the right ball.
            on_right = load * (0.3 * GRAVITY + 0.05 * pull) / 0.4
            impulse, moment = world.contact_impulse(plank, right)
            self.assertAlmostEqual(impulse[2] / on_right, 1, delta=10 * at_rest)
            arm = contacts.position - world.position(plank)
            moments = np.cross(arm, contacts.impulse)
            there = contacts.body_a == right
            np.testing.assert_allclose(impulse, contacts.impulse[there].sum(0), atol=load * at_rest)
            np.testing.assert_allclose(moment, moments[there].sum(0), atol=load * at_rest)
            self.assertAlmostEqual(moment[1] / (-0.1 * on_right - 0.05 * impulse[0]), 1,
                                   delta=10 * at_rest)
            total, moment = world.contact_impulse(plank)
            np.testing.assert_allclose(total, contacts.impulse.sum(0), atol=load * at_rest)
            np.testing.assert_allclose(moment, 0, atol=load * at_rest)
            reaction, _ = world.contact_impulse(right)
            np.testing.assert_allclose(reaction, -impulse, atol=load * at_rest)

    def test_filters_say_which_bodies_meet(self):
        for module, _ in SCALARS:
            world = module.World(time_step=1e-3)
            world.add_body(motion=bristle.Motion.fixed, shape=module.Box((1, 1, 0.1)),
                           position=(0, 0, -0.1), filter=bristle.CollisionFilter(category=2))
            balls = [world.add_body(mass=1, shape=module.Sphere(0.1), position=(0.5 * i, 0, 0.1),
                                    filter=bristle.CollisionFilter(mask=mask))
                     for i, mask in enumerate((0xffffffff, 2, 1))]
            world.step(200)
            self.assertEqual([world.position(b)[2] > 0.09 for b in balls], [True, True, False])
            world.set_filter(balls[0], bristle.CollisionFilter(mask=4))
            world.step(200)
            self.assertEqual([world.position(b)[2] > 0.09 for b in balls], [False, True, False])
            with self.assertRaises(TypeError):
                bristle.CollisionFilter(mask=-1)

    def test_bodies_of_one_negative_group_never_meet(self):
        for module, _ in SCALARS:
            for group, meet in ((-1, False), (1, True)):
                world = module.World(time_step=1e-3, gravity=(0, 0, 0))
                of_group = bristle.CollisionFilter(group=group)
                self.assertEqual((of_group.category, of_group.mask, of_group.group),
                                 (1, 0xffffffff, group))
                still = world.add_body(mass=1, shape=module.Sphere(0.1), filter=of_group)
                world.add_body(mass=1, shape=module.Sphere(0.1), position=(0.3, 0, 0),
                               velocity=(-1, 0, 0), filter=of_group)
                world.step(200)
                self.assertEqual(world.velocity(still)[0][0] < 0, meet)


class Rest(unittest.TestCase):
    def test_what_rests_sleeps_after_the_time_given(self):
        for module, _ in SCALARS:
            world = module.World(time_step=1e-3, sleep_time=0.1)
            world.add_body(motion=bristle.Motion.fixed, shape=module.Box((1, 1, 0.1)),
                           position=(0, 0, -0.1))
            box = world.add_body(mass=1, shape=module.Box((0.1, 0.1, 0.1)), position=(0, 0, 0.1))
            world.step(90)
            self.assertFalse(world.is_asleep(box))
            world.step(30)
            self.assertTrue(world.is_asleep(box))
            world.wake(box)
            self.assertFalse(world.is_asleep(box))
            world.step(120)
            self.assertTrue(world.is_asleep(box))
            world.set_filter(box, bristle.CollisionFilter(mask=2))
            self.assertFalse(world.is_asleep(box))
            restless = module.World(time_step=1e-3, sleep_time=0.1, gravity=(0, 0, 0),
                                    sleep_linear_speed=0.5, sleep_angular_speed=0.1)
            balls = [restless.add_body(mass=1, shape=module.Sphere(0.1), position=(0, y, 0),
                                       velocity=(speed, 0, 0), angular_velocity=(spin, 0, 0))
                     for y, speed, spin in ((0, 0.6, 0), (5, 0.4, 0), (10, 0, 0.4), (15, 0, 0.05))]
            restless.step(150)
            self.assertEqual([restless.is_asleep(b) for b in balls], [False, True, False, True])
            with self.assertRaisesRegex(bristle.InvalidArgument, "SleepDef::time"):
                module.World(sleep_time=-1)

    def test_a_patch_that_is_off_feels_nothing(self):
        for module, _ in SCALARS:
            world = module.World(time_step=1e-3, gravity=(0, 0, 0))
            box = world.add_body(mass=1, shape=module.Box((0.1, 0.1, 0.1)))
            world.add_body(motion=bristle.Motion.fixed, shape=module.Box((0.1, 0.1, 0.1)),
                           position=(0, 0, 0.205))
            layout = module.SensorLayout()
            layout.add((0, 0, 0.1), (0, 0, 1), 0.01)
            tuning = module.tuned_for(friction=0.5, creep=1e-3, load=5)
            skin = world.add_patch(box, layout, tuning.parameters(layout))
            world.step()
            self.assertEqual((world.is_active(skin), world.reading(skin).touching), (True, 1))
            world.set_active(skin, False)
            world.step()
            self.assertEqual((world.is_active(skin), world.reading(skin).touching), (False, 0))
            world.set_active(skin, True)
            world.step()
            self.assertEqual(world.reading(skin).touching, 1)


class Joints(unittest.TestCase):
    def test_a_pendulum_hangs_from_the_world(self):
        for module, error in SCALARS:
            for world_first in (True, False):
                world = module.World(time_step=1e-3, gravity=(0, 0, -GRAVITY))
                mass, radius, length = 1.0, 0.05, 0.5
                ball = world.add_body(mass=mass, shape=module.Sphere(radius),
                                      position=(length, 0, 1))
                ends = dict(anchor_a=(0, 0, 1), anchor_b=(-length, 0, 0))
                if not world_first:
                    ends = dict(anchor_a=(-length, 0, 0), anchor_b=(0, 0, 1))
                world.add_joint(bristle.JointKind.ball, *((None, ball) if world_first else
                                                          (ball, None)), **ends)
                speed = 0
                while True:
                    world.step()
                    now = np.linalg.norm(world.velocity(ball)[0])
                    if now < speed:
                        break
                    speed = now
                np.testing.assert_allclose(np.linalg.norm(world.position(ball) - (0, 0, 1)), length,
                                           rtol=max(error, 1e-6))
                # What fell is in the turn about the world's point.
                inertia = mass * (0.4 * radius**2 + length**2)
                self.assertAlmostEqual(speed, length * np.sqrt(2 * mass * GRAVITY * length / inertia),
                                       delta=1e-3)

    def test_a_cone_stops_the_swing(self):
        for module, _ in SCALARS:
            # Gravity along x lifts what hangs by the angle that the cone lets it.
            world = module.World(time_step=1e-3, gravity=(GRAVITY, 0, 0))
            ball = world.add_body(mass=1, shape=module.Sphere(0.05), position=(0, 0, -0.5),
                                  linear_damping=5)
            down = (0, np.sqrt(0.5), 0, np.sqrt(0.5))  # the frame's x axis
            world.add_joint(bristle.JointKind.cone_twist, None, ball, anchor_b=(0, 0, 0.5),
                            rotation_a=down, rotation_b=down, swing_limit=0.3, lower=0, upper=0)
            world.step(3000)
            np.testing.assert_allclose(world.position(ball),
                                       [0.5 * np.sin(0.3), 0, -0.5 * np.cos(0.3)], atol=1e-4)

    def test_a_bushing_sags_by_its_stiffness(self):
        for module, _ in SCALARS:
            world = module.World(time_step=1e-3, gravity=(0, 0, -GRAVITY))
            ball = world.add_body(mass=1, shape=module.Sphere(0.05))
            world.add_joint(bristle.JointKind.six_dof, None, ball,
                            bushing_stiffness=(100, 100, 400, 1, 1, 1),
                            bushing_damping=(20, 20, 40, 1, 1, 1))
            world.step(2000)
            np.testing.assert_allclose(world.position(ball), [0, 0, -GRAVITY / 400], atol=1e-6)

    def test_limits_and_springs_change(self):
        for module, _ in SCALARS:
            world = module.World(time_step=1e-3, gravity=(-GRAVITY, 0, 0))
            ball = world.add_body(mass=1, shape=module.Sphere(0.05))
            slide = world.add_joint(bristle.JointKind.prismatic, None, ball, lower=-0.1)
            world.step(500)
            self.assertAlmostEqual(world.joint_state(slide)[0], -0.1, delta=1e-5)
            world.set_limits(slide, lower=-0.3, upper=1)
            world.step(500)
            self.assertAlmostEqual(world.joint_state(slide)[0], -0.3, delta=1e-5)
            world.set_limits(slide)
            world.set_spring(slide, stiffness=100, damping=20, rest=0.2)
            world.step(2000)
            self.assertAlmostEqual(world.joint_state(slide)[0], 0.2 - GRAVITY / 100, delta=1e-5)
            world.remove_joint(slide)
            self.assertFalse(world.contains(slide))
            world.step(100)
            self.assertAlmostEqual(world.velocity(ball)[0][0], -GRAVITY * 0.1, delta=1e-4)


class Touches(unittest.TestCase):
    def drop(self, module):
        """A ball above sensors that look up 10 mm from a fixed plate."""
        world = module.World(time_step=1e-3, gravity=(0, 0, -GRAVITY))
        plate = world.add_body(motion=bristle.Motion.fixed)
        layout = module.sensor_grid(center=(0, 0, 0), side_u=(0.04, 0, 0), side_v=(0, 0.04, 0),
                                    count_u=5, count_v=5, depth=0, range=0.01)
        skin = world.add_patch(plate, layout, module.tuned_for(load=GRAVITY).parameters(layout))
        ball = world.add_body(mass=1, shape=module.Sphere(0.05), position=(0, 0, 0.11))
        return world, plate, skin, ball

    def test_events_on_a_drop(self):
        for module, _ in SCALARS:
            world, _, skin, ball = self.drop(module)
            world.step(5)
            self.assertEqual(world.touch_events(), [])
            world.keep_touch_events(True)
            steps = 5
            while not world.touch_events():
                world.step()
                steps += 1
            # From 60 mm the bottom of the ball falls to 10 mm, the end of the rays.
            self.assertAlmostEqual(steps, 1e3 * np.sqrt(2 * 0.05 / GRAVITY), delta=2)
            (event,) = world.touch_events()
            self.assertEqual((event.patch, event.body, event.begins), (skin, ball, True))
            self.assertGreater(world.reading(skin).touching, 0)
            self.assertRegex(repr(event), r"^TouchEvent\(patch=PatchId\{0, 0\}, body=BodyId\{1, 0\}, "
                                          r"begins=True\)$")
            world.step(10)
            self.assertEqual(len(world.touch_events()), 1)
            world.clear_touch_events()
            self.assertEqual(world.touch_events(), [])
            world.set_pose(ball, (0, 0, 1))
            world.step()
            (event,) = world.touch_events()
            self.assertEqual((event.body, event.begins), (ball, False))
            world.keep_touch_events(False)
            self.assertEqual(world.touch_events(), [])

    def test_an_event_outlives_its_body_which_the_world_no_longer_contains(self):
        world, plate, skin, ball = self.drop(bristle)
        world.keep_touch_events()
        world.step(150)
        self.assertTrue(all(map(world.contains, (plate, skin, ball))))
        world.remove_body(ball)
        world.step()
        self.assertEqual([(e.body, e.begins) for e in world.touch_events()],
                         [(ball, True), (ball, False)])
        self.assertFalse(world.contains(ball))
        self.assertTrue(world.contains(skin))

    def test_a_patch_that_is_removed_lets_go(self):
        for module, _ in SCALARS:
            world, _, skin, ball = self.drop(module)
            world.keep_touch_events()
            world.step(150)
            world.remove_patch(skin)
            self.assertFalse(world.contains(skin))
            falls = world.velocity(ball)[0][2]
            world.step()
            self.assertEqual([(e.patch, e.begins) for e in world.touch_events()],
                             [(skin, True), (skin, False)])
            self.assertAlmostEqual(world.velocity(ball)[0][2], falls - 1e-3 * GRAVITY, delta=1e-5)

    def test_contacts_are_told_when_the_world_was_made_to(self):
        for module, _ in SCALARS:
            for keeps in (True, False):
                world = module.World(keeps_contact_events=keeps)
                floor = world.add_body(motion=bristle.Motion.fixed, shape=module.HalfSpace())
                box = world.add_body(mass=1, shape=module.Box((0.1, 0.1, 0.1)), position=(0, 0, 0.2))
                world.step(120)
                self.assertEqual([({e.body_a, e.body_b}, e.begins) for e in world.contact_events()],
                                 [({floor, box}, True)] if keeps else [])


class Points(unittest.TestCase):
    def grip(self, module):
        """A ball that two pads hold, one of them turned."""
        world = module.World(time_step=1e-3)
        part = world.add_body(mass=0.2, shape=module.Sphere(0.03))
        layout = module.sensor_grid(center=(0.01, 0, 0), side_u=(0, 0.03, 0), side_v=(0, 0, 0.03),
                                    count_u=4, count_v=4)
        constants = module.tuned_for(friction=0.8, load=10, press=0.35, radius=0.03)
        pads = []
        for turn, x in ((UPRIGHT, -0.0425), ((0, 0, 1, 0), 0.0425)):
            finger = world.add_body(motion=bristle.Motion.kinematic, position=(x, 0, 0),
                                    orientation=turn)
            pads.append((finger, world.add_patch(finger, layout, constants.parameters(layout))))
        return world, part, pads

    def test_forces_sum_to_that_of_the_reading_and_skins_give_way_by_its_depth(self):
        for module, error in SCALARS:
            world, _, pads = self.grip(module)
            world.step(100)
            for finger, pad in pads:
                points, felt = world.taxel_points(pad), world.reading(pad)
                self.assertEqual((points.shape, points.dtype), ((16, 6), felt.depth.dtype))
                self.assertGreater(felt.total_normal, 0.1)
                total = turned(world.orientation(finger), points[:, 3:].sum(axis=0))
                np.testing.assert_allclose(total, felt.force, rtol=error, atol=10 * error)
                # Rays of 10 mm along x.
                np.testing.assert_allclose(points[:, 0], -0.01 * felt.depth, rtol=10 * error,
                                           atol=1e-9)
                np.testing.assert_allclose(points[:, 3], -felt.normal_force, rtol=10 * error)
                self.assertTrue((points[~felt.touches] == 0).all())

    def test_batches_write_them_in_place(self):
        for module, _ in SCALARS:
            world, part, pads = self.grip(module)
            pads = [pad for _, pad in pads]
            batch = module.WorldBatch(world, 3, threads=2)
            batch.set_mass(part, [0.1, 0.2, 0.3])
            batch.step(50)
            points = batch.points(pads)
            self.assertEqual(points.shape, (3, 2, 16, 6))
            for i in range(3):
                for k, pad in enumerate(pads):
                    np.testing.assert_array_equal(points[i, k], batch[i].taxel_points(pad))
            self.assertTrue((points[0] != points[1]).any())
            out = np.zeros_like(points)
            self.assertIs(batch.points(pads, out=out), out)
            np.testing.assert_array_equal(out, points)
            with self.assertRaisesRegex(bristle.InvalidArgument, r"must be \(3, 2, 16, 6\)"):
                batch.points(pads, out=out[:, :1].copy())
            with self.assertRaises(TypeError):
                batch.points(pads, out=out.astype(np.float16))
            with self.assertRaises(bristle.InvalidArgument):
                bristle.World().taxel_points(pads[0])


class Rays(unittest.TestCase):
    def test_a_ball_and_a_floor_are_hit_where_they_are(self):
        for module, error in SCALARS:
            world = module.World()
            floor = world.add_body(motion=bristle.Motion.fixed, shape=module.HalfSpace())
            center, radius = np.array([0.2, -0.1, 1.0]), 0.3
            ball = world.add_body(mass=1, shape=module.Sphere(radius), position=center)
            random = np.random.default_rng(7)
            origin = np.array([0.5, 0.5, 2.5])
            directions = random.normal(size=(2000, 3))
            directions /= np.linalg.norm(directions, axis=1)[:, None]
            hits = world.cast_rays(origin, directions)
            with np.errstate(divide="ignore", invalid="ignore"):
                along = directions @ (center - origin)
                aside = np.sum((center - origin)**2) - along**2
                to_ball = np.where((aside < radius**2) & (along > 0),
                                   along - np.sqrt(radius**2 - aside), np.inf)
                to_floor = np.where(directions[:, 2] < 0, -origin[2] / directions[:, 2], np.inf)
            distance = np.minimum(to_ball, to_floor)
            # Where a ray grazes the ball rounding decides.
            clear = np.abs(aside - radius**2) > 1e-3
            np.testing.assert_allclose(hits.distance[clear], distance[clear], rtol=10 * error)
            self.assertEqual(hits.distance.dtype, hits.point.dtype)
            np.testing.assert_array_equal(hits.is_hit, np.isfinite(hits.distance))
            on_ball, on_floor = hits.body == ball, hits.body == floor
            np.testing.assert_array_equal(on_ball[clear], (to_ball < to_floor)[clear])
            self.assertGreater(on_ball.sum(), 10)
            np.testing.assert_array_equal(on_ball | on_floor, hits.is_hit)
            self.assertEqual({body for body in hits.body[~hits.is_hit]}, {None})
            np.testing.assert_allclose(hits.normal[on_floor], [[0, 0, 1]] * on_floor.sum())
            np.testing.assert_allclose(hits.normal[on_ball],
                                       (hits.point[on_ball] - center) / radius, atol=10 * error)

    def test_one_row_is_for_all_and_bodies_are_excluded(self):
        for module, error in SCALARS:
            world = module.World()
            balls = [world.add_body(motion=bristle.Motion.fixed, shape=module.Sphere(0.5),
                                    position=(x, 0, 0)) for x in (2, 4)]
            hits = world.cast_rays((0, 0, 0), (1, 0, 0))
            self.assertEqual((hits.distance.shape, hits.point.shape, list(hits.body)),
                             ((1,), (1, 3), balls[:1]))
            hits = world.cast_rays([(0, 0, 0), (0, 0.3, 0), (0, 2, 0)], (1, 0, 0))
            np.testing.assert_allclose(hits.distance, [1.5, 1.6, np.inf], rtol=error)
            hits = world.cast_rays((0, 0, 0), (1, 0, 0), excluded=balls[:1])
            np.testing.assert_allclose(hits.distance, [3.5], rtol=error)
            hits = world.cast_rays((0, 0, 0), [(1, 0, 0)] * 2, max_distance=[1.4, 1.6])
            self.assertEqual(hits.is_hit.tolist(), [False, True])
            hits = world.cast_rays((2, 0, 0), (0, 1, 0))
            self.assertEqual((hits.distance[0], hits.normal[0].tolist()), (0, [0, -1, 0]))
            self.assertEqual(len(world.cast_rays(np.empty((0, 3)), (1, 0, 0)).body), 0)


class Refusals(unittest.TestCase):
    def test_what_was_removed_is_named(self):
        for module, _ in SCALARS:
            world = module.World()
            ball, gone = (world.add_body(mass=1, shape=module.Sphere(0.1), position=(x, 0, 0))
                          for x in (0, 3))
            layout = module.SensorLayout()
            layout.add((0, 0, 0.1), (0, 0, 1), 0.01)
            tuning = module.tuned_for(friction=0.5, creep=1e-3, load=5)
            skin = world.add_patch(gone, layout, tuning.parameters(layout))
            world.remove_body(gone)
            before = world.state_hash()
            for call, name in ((lambda: world.contact_impulse(gone), "BodyId"),
                               (lambda: world.contact_impulse(ball, gone), "BodyId"),
                               (lambda: world.set_filter(gone, bristle.CollisionFilter()), "BodyId"),
                               (lambda: world.is_asleep(gone), "BodyId"),
                               (lambda: world.wake(gone), "BodyId"),
                               (lambda: world.set_active(skin, False), "PatchId"),
                               (lambda: world.is_active(skin), "PatchId")):
                with self.assertRaisesRegex(bristle.InvalidArgument, name):
                    call()
            self.assertEqual(world.state_hash(), before)

    def test_what_is_wrong_is_named_and_nothing_changes(self):
        for module, _ in SCALARS:
            world = module.World()
            ball = world.add_body(mass=1, shape=module.Sphere(0.1))
            hand = world.add_body(motion=bristle.Motion.kinematic, position=(1, 0, 0))
            slide = world.add_joint(bristle.JointKind.prismatic, hand, ball)
            socket = world.add_joint(bristle.JointKind.ball, hand, ball)
            gone = world.add_body(mass=1, shape=module.Sphere(0.1), position=(3, 0, 0))
            world.remove_body(gone)
            before = world.state_hash()
            shape, nan = module.Sphere(0.1), float("nan")
            kind = bristle.JointKind
            invalid, mistyped = bristle.InvalidArgument, TypeError
            for call, error, words in (
                    (lambda: world.apply_impulse(ball, (nan, 0, 0), (0, 0, 0)), invalid, "impulse"),
                    (lambda: world.apply_impulse(hand, (1, 0, 0), (0, 0, 0)), invalid, "dynamic"),
                    (lambda: world.apply_impulse(gone, (1, 0, 0), (0, 0, 0)), invalid, "BodyId"),
                    (lambda: world.apply_impulse(ball, (1, 0), (0, 0, 0)), mistyped, "apply_impulse"),
                    (lambda: world.apply_wrench(ball, (0, 0, 0), (0, nan, 0)), invalid, "torque"),
                    (lambda: world.set_damping(ball, -1), invalid, "set_damping: linear"),
                    (lambda: world.set_damping(ball, 0, nan), invalid, "set_damping: angular"),
                    (lambda: world.set_gravity_scale(ball, nan), invalid, "set_gravity_scale"),
                    (lambda: world.set_gravity_scale(hand, 1), invalid, "dynamic"),
                    (lambda: world.set_limits(slide, 1, 0), invalid, "lower_limit"),
                    (lambda: world.set_limits(socket, 0, 1), invalid, "needs a revolute"),
                    (lambda: world.set_spring(slide, stiffness=-1), invalid, "stiffness"),
                    (lambda: world.set_spring(socket, stiffness=1), invalid, "needs a revolute"),
                    (lambda: world.set_material(ball, 0.5, surface_velocity=(nan, 0, 0)), invalid,
                     "surface_velocity"),
                    (lambda: world.add_body(mass=1, shape=shape, linear_damping=-1), invalid,
                     "linear_damping"),
                    (lambda: world.add_body(mass=1, shape=shape, gravity_scale=nan), invalid,
                     "gravity_scale"),
                    (lambda: world.add_body(mass=1, shape=shape, is_trigger=True), invalid,
                     "must be set where there is no shape"),
                    (lambda: world.add_body(shapes=[(shape, (nan, 0, 0), UPRIGHT)]), invalid,
                     "X_BS.translation"),
                    (lambda: world.add_body(shapes=[(shape, (0, 0, 0), (0, 0, 0, 2))]), invalid,
                     "X_BS.rotation"),
                    (lambda: world.add_body(shapes=[(shape, (0, 0, 0))]), mistyped, "add_body"),
                    (lambda: world.add_body(shapes=[shape]), mistyped, "add_body"),
                    (lambda: world.add_joint(kind.ball, None, None), invalid, "body_b"),
                    (lambda: world.add_joint(kind.ball, None, hand), invalid, "must be dynamic"),
                    (lambda: world.add_joint(kind.ball, None, ball, swing_limit=1), invalid,
                     "needs a cone_twist"),
                    (lambda: world.add_joint(kind.cone_twist, None, ball, swing_limit=0), invalid,
                     "swing_limit"),
                    (lambda: world.add_joint(kind.six_dof, None, ball, bushing_damping=[-1] * 6),
                     invalid, r"damping\[0\]"),
                    (lambda: world.add_joint(kind.six_dof, None, ball, bushing_damping=[1] * 5),
                     mistyped, "add_joint"),
                    (lambda: world.contains("ball"), mistyped, "contains"),
                    (lambda: world.cast_rays((0, 0, 0), (2, 0, 0)), invalid, "must have length 1"),
                    (lambda: world.cast_rays((nan, 0, 0), (1, 0, 0)), invalid, "Ray::origin"),
                    (lambda: world.cast_rays((0, 0, 0), (1, 0, 0), 0), invalid, "Ray::length"),
                    (lambda: world.cast_rays((0, 0, 0), (1, 0, 0), nan), invalid, "Ray::length"),
                    (lambda: world.cast_rays([(0, 0, 0)] * 2, [(1, 0, 0)] * 3), invalid,
                     r"origins.shape = \(2, 3\): must be \(3, 3\), a row for each ray"),
                    (lambda: world.cast_rays((0, 0), (1, 0, 0)), invalid, r"origins.shape = \(2,\)"),
                    (lambda: world.cast_rays([(0, 0, 0), (0, 0)], (1, 0, 0)), invalid,
                     "equally long"),
                    (lambda: world.cast_rays((0, 0, 0), ("a", "b", "c")), mistyped, "real numbers"),
                    (lambda: world.cast_rays((0, 0, 0), (1, 0, 0), [1, 2]), invalid,
                     r"max_distance.shape = \(2,\)"),
                    (lambda: world.cast_rays((0, 0, 0), (1, 0, 0), excluded=[slide]), mistyped,
                     "cast_rays")):
                with self.assertRaisesRegex(error, words):
                    call()
            self.assertEqual(world.state_hash(), before)


if __name__ == "__main__":
    unittest.main()
