"""Tests of what changes the worlds of a batch: all of a mask, or none; and of arrays without
copies."""
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

try:
    import torch
except ImportError:
    torch = None

COUNT = 5


def slide(module):
    """A ball on a driven slide that a kinematic body carries, with a pad beside a second ball."""
    world = module.World(time_step=1e-3, gravity=(0, 0, 0))
    hand = world.add_body(motion=bristle.Motion.kinematic)
    ball = world.add_body(mass=0.2, shape=module.Sphere(0.02), position=(0.1, 0, 0))
    joint = world.add_joint(bristle.JointKind.prismatic, hand, ball, anchor_a=(0.1, 0, 0))
    layout = module.sensor_grid(center=(0.02, 0, 0), side_u=(0, 0.02, 0), side_v=(0, 0, 0.02),
                                count_u=2, count_v=2)
    pad = world.add_patch(ball, layout, module.tuned_for().parameters(layout))
    return world, hand, ball, joint, pad, layout


class Changes(unittest.TestCase):
    def all_changes(self, module):
        """Name and arguments of each change, with numbers that differ from world to world, and what
        does the same to one world."""
        _, hand, ball, joint, pad, layout = slide(module)
        some = np.linspace(0.1, 0.5, COUNT)
        rows = np.stack([some, -some, 2 * some], axis=1)
        turns = np.stack([np.sin(some), 0 * some, 0 * some, np.cos(some)], axis=1)
        constants = [module.tuned_for(friction=float(mu)).parameters(layout) for mu in some]
        motor = dict(mode=bristle.MotorMode.position, target=some, max_speed=some,
                     max_force=10 * some)
        spring = dict(mode=bristle.MotorMode.spring, target=some, stiffness=5 * some, damping=some)

        def of(i, options):
            return {k: v if k == "mode" else v[i] for k, v in options.items()}

        return [
            ("set_mass", (ball, some), {}, lambda w, i: w.set_mass(ball, some[i])),
            ("set_material", (ball, some, some), {},
             lambda w, i: w.set_material(ball, some[i], some[i])),
            ("set_material", (ball, some), {"rolling_friction": 0.01 * some},
             lambda w, i: w.set_material(ball, some[i], rolling_friction=0.01 * some[i])),
            ("set_material", (ball, some), {"surface_velocity": rows},
             lambda w, i: w.set_material(ball, some[i], surface_velocity=rows[i])),
            ("set_damping", (ball, some, 2 * some), {},
             lambda w, i: w.set_damping(ball, some[i], 2 * some[i])),
            ("set_gravity_scale", (ball, -some), {},
             lambda w, i: w.set_gravity_scale(ball, -some[i])),
            ("set_parameters", (pad, constants), {},
             lambda w, i: w.set_parameters(pad, constants[i])),
            ("set_motor", (joint,), motor, lambda w, i: w.set_motor(joint, **of(i, motor))),
            ("set_motor", (joint,), spring, lambda w, i: w.set_motor(joint, **of(i, spring))),
            ("set_pose", (ball, rows, turns), {},
             lambda w, i: w.set_pose(ball, rows[i], turns[i])),
            ("move_to", (hand, rows, turns), {}, lambda w, i: w.move_to(hand, rows[i], turns[i])),
            ("set_velocity", (ball, rows, 2 * rows), {},
             lambda w, i: w.set_velocity(ball, rows[i], 2 * rows[i])),
            ("apply_force", (ball, rows, 2 * rows), {},
             lambda w, i: w.apply_force(ball, rows[i], 2 * rows[i])),
            ("apply_impulse", (ball, rows, 2 * rows), {},
             lambda w, i: w.apply_impulse(ball, rows[i], 2 * rows[i]))]

    def test_each_is_what_it_is_of_a_world(self):
        mask = np.array([True, False, True, True, False])
        for module in (bristle, bristle32):
            for name, arguments, options, alone in self.all_changes(module):
                world = slide(module)[0]
                batch = module.WorldBatch(world, COUNT, threads=2)
                getattr(batch, name)(*arguments, **options, mask=mask)
                batch.step(3)
                for i in range(COUNT):
                    single = world.copy()
                    if mask[i]:
                        alone(single, i)
                    single.step(3)
                    self.assertEqual(batch[i].state_hash(), single.state_hash(), (name, i))

    def test_one_row_is_for_all(self):
        world, _, ball, _, pad, layout = slide(bristle)
        batch, other = bristle.WorldBatch(world, 3), bristle.WorldBatch(world, 3)
        batch.set_mass(ball, 0.5)
        batch.set_velocity(ball, (1, 2, 3))
        constants = bristle.tuned_for(friction=0.3).parameters(layout)
        batch.set_parameters(pad, constants)
        other.set_mass(ball, [0.5] * 3)
        other.set_velocity(ball, [(1, 2, 3)] * 3)
        other.set_parameters(pad, [constants] * 3)
        for i in range(3):
            self.assertEqual(batch[i].state_hash(), other[i].state_hash())

    def test_what_one_world_refuses_changes_none(self):
        for module in (bristle, bristle32):
            world, hand, ball, joint, pad, layout = slide(module)
            batch = module.WorldBatch(world, COUNT)
            before = world.state_hash()
            for name, arguments, options, _ in self.all_changes(module):
                for bad in (np.nan, -np.inf):
                    # The last world's last number is wrong.
                    if name == "set_parameters":
                        wrong = [*arguments[1][:-1], module.SensorParameters(bad)]
                        bad_arguments, bad_options = (pad, wrong), {}
                    elif options:
                        key = list(options)[-1]
                        values = options[key].copy()
                        values[-1] = bad
                        bad_arguments, bad_options = arguments, {**options, key: values}
                    else:
                        values = arguments[-1].copy()
                        values.flat[-1] = bad
                        bad_arguments, bad_options = (*arguments[:-1], values), {}
                    with self.assertRaises(bristle.InvalidArgument, msg=(name, bad)):
                        getattr(batch, name)(*bad_arguments, **bad_options)
            masses = np.full(COUNT, 0.5)
            for call, error, words in (
                    (lambda: batch.set_mass(ball, masses[:2]), ValueError,
                     r"masses.shape = \(2,\)"),
                    (lambda: batch.set_mass(ball, masses[:, None]), ValueError, "masses.shape"),
                    (lambda: batch.set_mass(ball, [[1], [1, 2]]), ValueError, "equally long"),
                    (lambda: batch.set_mass(ball, ["1"] * COUNT), TypeError, "real numbers"),
                    (lambda: batch.set_mass(ball, masses + 1j), TypeError, "complex128"),
                    (lambda: batch.set_mass(ball, masses > 0), TypeError, "bool"),
                    (lambda: batch.set_mass(ball, None), TypeError, "real numbers"),
                    (lambda: batch.set_mass(hand, masses), ValueError, "dynamic"),
                    (lambda: batch.set_mass(ball, masses, [1, 0, 1, 0, 1]), TypeError, "mask"),
                    (lambda: batch.set_mass(ball, masses, [0, 4]), ValueError, "mask.shape"),
                    (lambda: batch.reset([0, 1, 0, 1, 0]), TypeError, "must be bool"),
                    (lambda: batch.set_velocity(ball, np.zeros((COUNT, 2))), ValueError,
                     r"must be \(5, 3\)"),
                    (lambda: batch.set_pose(ball, np.zeros(3), (0, 0, 0)), ValueError,
                     r"orientations.shape = \(3,\)"),
                    (lambda: batch.set_parameters(pad, []), ValueError, "must be 5"),
                    (lambda: batch.set_mass(joint, masses), TypeError, "BodyId"),
                    (lambda: batch[COUNT], IndexError, "must be from 0 to 4"),
                    (lambda: batch[-1], IndexError, "no world -1"),
                    (lambda: batch.step(-1), TypeError, "incompatible"),
                    (lambda: module.WorldBatch(world, -1), TypeError, "incompatible")):
                with self.assertRaisesRegex(error, words):
                    call()
            self.assertEqual([batch[i].state_hash() for i in range(COUNT)], [before] * COUNT)

    def test_what_is_too_much_in_the_state_of_one_world_changes_none(self):
        for module, dtype in ((bristle, np.float64), (bristle32, np.float32)):
            world, hand, ball, *_ = slide(module)
            center = world.position(ball)
            large = 0.35 * np.sqrt(float(np.finfo(dtype).max))  # twice of it is too large
            one = np.arange(COUNT) == 3
            start, push, way = ((large, 0, 0), (0.2 * large, 0, 0), (0, 0, large * 1e-3))
            for prepare, change in (
                    (lambda b: b.set_velocity(ball, start, mask=one),
                     lambda b: b.apply_impulse(ball, push, center)),
                    (lambda b: b.set_mass(ball, 0.01, mask=one),
                     lambda b: b.apply_impulse(ball, push, center)),
                    (lambda b: b.apply_force(ball, start, center, mask=one),
                     lambda b: b.apply_force(ball, start, center)),
                    (lambda b: b.set_pose(hand, np.negative(way), mask=one),
                     lambda b: b.move_to(hand, way))):
                batch = module.WorldBatch(world, COUNT)
                prepare(batch)
                before = [batch[i].state_hash() for i in range(COUNT)]
                with self.assertRaises(bristle.InvalidArgument):
                    change(batch)
                self.assertEqual([batch[i].state_hash() for i in range(COUNT)], before)
                # The others take it, however many they are.
                change(module.WorldBatch(world, COUNT))

    def test_a_body_that_one_world_lost(self):
        world, _, ball, *_ = slide(bristle)
        batch = bristle.WorldBatch(world, 3)
        batch[2].remove_body(ball)
        with self.assertRaisesRegex(bristle.InvalidArgument, "must name what all worlds have"):
            batch.set_mass(ball, [1, 2, 3])
        self.assertEqual(batch[0].state_hash(), world.state_hash())
        batch.set_mass(ball, [1, 2, 3], mask=[True, True, False])
        out = np.full((3, 1, 13), 7.0)
        with self.assertRaises(bristle.InvalidArgument):
            batch.bodies([ball], out=out)
        self.assertTrue((out == 7).all())


class Arrays(unittest.TestCase):
    def test_touching(self):
        world, _, ball, _, pad, _ = slide(bristle)
        world.add_body(motion=bristle.Motion.fixed, shape=bristle.Sphere(0.02),
                       position=(0.143, 0.005, 0.005))
        batch = bristle.WorldBatch(world, 2)
        batch.step()
        out = np.zeros((2, 1), np.uint32)
        self.assertIs(batch.touching([pad], out=out), out)
        self.assertEqual(out[0, 0], batch[0].reading(pad).touching)
        self.assertGreater(out[0, 0], 0)
        with self.assertRaises(TypeError):
            batch.touching([pad], out=out.astype(np.int64))

    def test_slices_of_a_history_are_written_in_place(self):
        world, _, ball, *_ = slide(bristle32)
        batch = bristle32.WorldBatch(world, COUNT)
        batch.set_velocity(ball, (0.1, 0, 0))
        history = np.zeros((4, COUNT, 1, 13), np.float32)
        for t in range(4):
            batch.step(10)
            batch.bodies([ball], out=history[t])
        np.testing.assert_allclose(history[:, :, 0, 0], 0.1 + 1e-3 * np.arange(1, 5)[:, None]
                                   * np.ones(COUNT), rtol=1e-4)

    def shares(self, from_dlpack, to_numpy):
        world, _, ball, *_ = slide(bristle32)
        batch = bristle32.WorldBatch(world, COUNT)
        array = batch.bodies([ball])
        shared = from_dlpack(array)
        batch.set_velocity(ball, (1, 0, 0))
        batch.step(10)
        batch.bodies([ball], out=array)
        np.testing.assert_array_equal(to_numpy(shared), array)
        self.assertGreater(array[0, 0, 0], 0.105)

    def test_dlpack_shares_what_is_gathered(self):
        self.shares(np.from_dlpack, np.asarray)

    @unittest.skipIf(torch is None, "no torch")
    def test_torch_shares_what_is_gathered_and_is_taken(self):
        self.shares(torch.from_dlpack, lambda t: t.numpy())
        world, _, ball, *_ = slide(bristle32)
        batch, other = (bristle32.WorldBatch(world, COUNT) for _ in range(2))
        batch.set_mass(ball, torch.linspace(0.1, 0.5, COUNT))
        other.set_mass(ball, np.linspace(0.1, 0.5, COUNT, dtype=np.float32))
        self.assertEqual(batch[4].state_hash(), other[4].state_hash())


if __name__ == "__main__":
    unittest.main()
