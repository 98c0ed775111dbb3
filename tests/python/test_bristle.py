"""Tests of the Python module: the same bits as in C++, arrays, and errors."""
# SPDX-License-Identifier: BSD-3-Clause
import contextlib
import io
import os
import pathlib
import runpy
import struct
import subprocess
import sys
import threading
import time
import unittest

try:
    import numpy as np
except ImportError:
    print("skipped: no numpy")
    sys.exit(77)

import bristle
import bristle.float32 as bristle32

EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "examples"


def output_of(script):
    """What a script prints."""
    with contextlib.redirect_stdout(io.StringIO()) as text:
        names = runpy.run_path(str(EXAMPLES / "python" / script))
    return text.getvalue(), names


def small_grip(module=bristle):
    """Two pads of 3 x 3 sensors that hold a cube."""
    world = module.World(time_step=1e-3)
    part = world.add_body(mass=0.2, shape=module.Box((0.03, 0.03, 0.03)))
    pads = []
    for inwards in (1.0, -1.0):
        finger = world.add_body(motion=bristle.Motion.kinematic,
                                position=(-0.0415 * inwards, 0, 0))
        sensors = module.sensor_grid(center=(0.01 * inwards, 0, 0), side_u=(0, 0.03 * inwards, 0),
                                     side_v=(0, 0, 0.03), count_u=3, count_v=3)
        tuning = module.tuned_for(friction=0.8, load=10, press=0.35)
        pads.append(world.add_patch(finger, sensors, tuning.parameters(sensors)))
    return world, part, pads


class Scripts(unittest.TestCase):
    def test_falling_box_has_the_bits_of_cpp(self):
        text, names = output_of("falling_box.py")
        self.assertEqual(text, "32.0 mm, 4.905 N, 25 of 25\n")
        reference = subprocess.run([os.environ["BRISTLE_REFERENCE"]], check=True,
                                   capture_output=True, text=True).stdout.split()
        self.assertEqual(f"{names['world'].state_hash():x}", reference[0])
        forces = [struct.unpack("<Q", struct.pack("<d", x))[0] for x in names["reading"].normal_force]
        self.assertEqual([f"{x:x}" for x in forces], reference[1:])

    def test_batch_prints_what_the_cpp_example_does(self):
        text, _ = output_of("batch.py")
        self.assertEqual(text, (EXAMPLES / "18_batch.expected").read_text())

    def test_a_foot_on_a_slope_feels_its_weight(self):
        text, names = output_of("slope.py")
        self.assertEqual(text, "ground at [0.] m, foot at [0.12] m\n"
                               "77 ms: the sole touches the ground\n"
                               "force on the sole: 1.07 N along it, 4.79 N across\n")
        self.assertAlmostEqual(np.linalg.norm(names["forces"].sum(axis=0)), 0.5 * 9.81, delta=1e-3)

    def test_parts_are_gripped_by_feel(self):
        text, names = output_of("grip_by_feel.py")
        self.assertEqual(text, f"{names['held']} of {names['ended']} parts are held\n")
        self.assertGreater(names["ended"], 127)
        self.assertGreater(names["held"], 0.9 * names["ended"])


class Pads(unittest.TestCase):
    def test_constants_for_a_ball_and_warnings(self):
        for module in (bristle, bristle32):
            for radius, deepest in ((0.03, 0.3), (0, 1)):
                world = module.World(time_step=1e-3)
                pad = world.add_body(motion=bristle.Motion.fixed, shape=module.HalfSpace())
                # 10 mm of rays, 5 mm above the plane.
                world.add_body(mass=1, shape=module.Sphere(0.03), position=(0, 0, 0.045))
                layout = module.sensor_grid(center=(0, 0, 0.005), side_u=(0.06, 0, 0),
                                            side_v=(0, 0.06, 0), count_u=21, count_v=21,
                                            depth=0, range=0.01)
                skin = world.add_patch(pad, layout, module.tuned_for(
                    load=9.81, radius=radius).parameters(layout))
                self.assertEqual(world.patch_warnings(skin), [])
                world.step(2000)
                reading = world.reading(skin)
                self.assertAlmostEqual(reading.depth.max(), deepest, delta=0.01)
                self.assertEqual(reading.bottomed_out, (reading.depth >= 1).sum())
                self.assertEqual(reading.bottomed_out > 0, radius == 0)
                self.assertEqual(len(world.patch_warnings(skin)), 1 if radius == 0 else 0)


class Batches(unittest.TestCase):
    def test_worlds_of_a_batch_are_worlds(self):
        for module, dtype in ((bristle, np.float64), (bristle32, np.float32)):
            world, part, pads = small_grip(module)
            batch = module.WorldBatch(world, 5, threads=2)
            batch.set_mass(part, np.linspace(0.1, 0.5, 5))
            batch.step(40)
            taxels, bodies = batch.taxels(pads), batch.bodies([part])
            self.assertEqual((taxels.dtype, taxels.shape), (dtype, (5, 2, 4, 9)))
            for i in range(5):
                alone = world.copy()
                alone.set_mass(part, np.linspace(0.1, 0.5, 5)[i])
                alone.step(40)
                self.assertEqual(alone.state_hash(), batch[i].state_hash())
                for k, pad in enumerate(pads):
                    felt = alone.reading(pad)
                    rows = (felt.depth, felt.normal_force, felt.shear_1, felt.shear_2)
                    np.testing.assert_array_equal(taxels[i, k], np.stack(rows))
                np.testing.assert_array_equal(bodies[i, 0, :3], alone.position(part))
                np.testing.assert_array_equal(bodies[i, 0, 3:7], alone.orientation(part))
            self.assertGreater(taxels[:, :, 1].sum(), 0)

    def test_reset_of_a_mask(self):
        world, _, _ = small_grip()
        batch = bristle.WorldBatch(world, 4)
        batch.step(5)
        batch.reset([True, False, False, True])
        start = world.state_hash()
        self.assertEqual([batch[i].state_hash() == start for i in range(4)],
                         [True, False, False, True])
        self.assertFalse(batch.failed.any())

    def test_arrays_are_written_in_place(self):
        world, part, pads = small_grip(bristle32)
        batch = bristle32.WorldBatch(world, 3)
        batch.step(3)
        out = np.full((3, 2, 4, 9), -1, np.float32)
        self.assertIs(batch.taxels(pads, out=out), out)
        np.testing.assert_array_equal(out, batch.taxels(pads))
        with self.assertRaisesRegex(TypeError, "out: dtype float64: must be float32"):
            batch.taxels(pads, out=out.astype(np.float64))
        with self.assertRaisesRegex(TypeError, "out: .*list.*: must be an array"):
            batch.taxels(pads, out=[0.0])
        for wrong in (np.zeros((3, 2, 4, 18), np.float32)[:, :, :, ::2], np.asfortranarray(out)):
            with self.assertRaisesRegex(bristle.InvalidArgument, "must be C-contiguous"):
                batch.taxels(pads, out=wrong)
        with self.assertRaisesRegex(bristle.InvalidArgument, r"must be \(3, 2, 4, 9\)"):
            batch.taxels(pads, out=out[:2])
        out.flags.writeable = False
        with self.assertRaisesRegex(bristle.InvalidArgument, "must be writeable"):
            batch.taxels(pads, out=out)

    def test_a_tensor_on_another_device_is_refused_in_its_own_words(self):
        class OnDevice:
            def __array__(self, *_args, **_names):
                raise TypeError("can't convert cuda:0 device type tensor to numpy")

        world, part, pads = small_grip(bristle)
        batch = bristle.WorldBatch(world, 3)
        with self.assertRaisesRegex(bristle.InvalidArgument, "masses.*cuda:0"):
            batch.set_mass(part, OnDevice())

    def test_worlds_of_a_mask_go_on_from_another_world(self):
        world, part, _ = small_grip(bristle)
        batch = bristle.WorldBatch(world, 3)
        start = np.array([w[0, 2] for w in batch.bodies([part])])
        world.step(5)
        batch.reset([False, True, False], start=world)
        position = np.array([w[0, 2] for w in batch.bodies([part])])
        self.assertEqual(list(position != start), [False, True, False])
        self.assertEqual(position[1], bristle.WorldBatch(world, 1).bodies([part])[0, 0, 2])

    def test_a_world_outlives_the_name_of_its_batch(self):
        world, part, _ = small_grip()
        batch = bristle.WorldBatch(world, 2)
        one = batch[1]
        del batch
        one.step(3)
        self.assertLess(abs(one.position(part)[2]), 0.01)

    def test_other_threads_run_meanwhile(self):
        # Had they to wait for the step, one wait would be as long as all of it.
        world, _, _ = small_grip()
        stepper = threading.Thread(target=world.step, args=(100000,))
        start = last = time.perf_counter()
        stepper.start()
        longest = 0
        while stepper.is_alive():
            now = time.perf_counter()
            longest, last = max(longest, now - last), now
        self.assertLess(longest, (time.perf_counter() - start) / 2)

    def test_surfaces_are_set(self):
        world = bristle.World(gravity=(3, 0, -9))
        world.add_body(motion=bristle.Motion.fixed, shape=bristle.HalfSpace())
        box = world.add_body(mass=1, shape=bristle.Box((0.1, 0.1, 0.02)), position=(0, 0, 0.02))
        world.step(60)
        self.assertLess(world.velocity(box)[0][0], 1e-9)
        world.set_material(box, friction=0)
        world.step(60)
        self.assertAlmostEqual(world.velocity(box)[0][0], 3 * 60 / 240, places=6)


class Errors(unittest.TestCase):
    def test_what_is_wrong_is_named_and_nothing_changes(self):
        world, part, pads = small_grip()
        before = world.state_hash()
        with self.assertRaisesRegex(bristle.InvalidArgument, "BodyDef::mass = -1"):
            world.add_body(mass=-1, shape=bristle.Sphere(0.1))
        with self.assertRaisesRegex(ValueError, "set_mass: mass"):
            world.set_mass(part, float("nan"))
        other = bristle.World()
        with self.assertRaises(bristle.InvalidArgument):
            other.reading(pads[0])
        with self.assertRaises(bristle.InvalidArgument):
            world.restore(b"half a snapshot")
        with self.assertRaises(TypeError):
            world.add_body(shape="a box")
        with self.assertRaises(OSError):
            bristle.TriangleMesh.load("no such file.stl")
        batch = bristle.WorldBatch(world, 2)
        for wrong in ([0.1], [[0.1, 0.2, 0.3]], [0.1, float("nan")]):
            with self.assertRaises(bristle.InvalidArgument):
                batch.set_mass(part, wrong)
        with self.assertRaises(IndexError):
            batch[2]
        for wrong in ([True], [], [True] * 3):
            with self.assertRaises(bristle.InvalidArgument):
                batch.reset(wrong)
        with self.assertRaises(bristle.InvalidArgument):
            bristle.WorldBatch(world, 0)
        self.assertEqual(world.state_hash(), before)

    def test_snapshots(self):
        world, _, _ = small_grip()
        state = world.snapshot()
        world.step(10)
        after = world.state_hash()
        world.restore(state)
        world.step(10)
        self.assertEqual(world.state_hash(), after)


if __name__ == "__main__":
    unittest.main()
