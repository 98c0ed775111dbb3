"""Tests of what the package reads and writes: scenes, recordings, plots, and the demo."""
# SPDX-License-Identifier: BSD-3-Clause
import contextlib
import io
import json
import os
import pathlib
import shutil
import struct
import sys
import tempfile
import unittest
from unittest import mock

try:
    import numpy as np
except ImportError:
    print("skipped: no numpy")
    sys.exit(77)

import bristle
import bristle.float32 as bristle32
from bristle import demo

SCENES = pathlib.Path(__file__).resolve().parents[2] / "examples" / "scenes"


def gltf(path):
    """The JSON of a .glb file."""
    data = pathlib.Path(path).read_bytes()
    magic, version, length = struct.unpack_from("<4sII", data)
    assert (magic, version, length) == (b"glTF", 2, len(data))
    size, kind = struct.unpack_from("<I4s", data, 12)
    assert kind == b"JSON"
    return json.loads(data[20:20 + size])


class InFolder(unittest.TestCase):
    """Tests in a folder of their own."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)


class Recorders(InFolder):
    def test_a_recording_has_the_frames_bodies_and_forces(self):
        for module in (bristle, bristle32):
            world = module.World(time_step=1e-2)
            floor = world.add_body(motion=bristle.Motion.fixed, shape=module.HalfSpace())
            shape = module.Box((0.03, 0.03, 0.03))
            box = world.add_body(mass=0.5, shape=shape, position=(0, 0, 0.1))
            layout = module.sensor_grid(center=(0, 0, -0.03), side_u=(0, 0.06, 0),
                                        side_v=(0.06, 0, 0), count_u=2, count_v=2)
            skin = world.add_patch(box, layout, module.tuned_for(load=5).parameters(layout))
            recorder = module.Recorder(rate=50)
            with self.assertRaisesRegex(bristle.InvalidArgument, "on a body that is recorded"):
                recorder.add_patch(world, skin, "skin")
            with self.assertRaisesRegex(bristle.InvalidArgument, r"times.size\(\) = 0"):
                recorder.write_glb(str(self.folder / "empty.glb"))
            recorder.add_body(world, floor, module.HalfSpace(), "floor", plane_size=0.5)
            recorder.add_body(world, box, shape, "falling box")
            recorder.add_patch(world, skin, "skin")
            with self.assertRaisesRegex(bristle.InvalidArgument, "recorded already"):
                recorder.add_body(world, box, shape, "again")
            for _ in range(40):
                world.step()
                recorder.observe(world)
            np.testing.assert_allclose(recorder.times, np.arange(1, 40, 2) * 1e-2, rtol=1e-5)
            path = self.folder / "fall.glb"
            recorder.write_glb(str(path), longest_arrow=0.05)
            scene = gltf(path)
            names = [node.get("name") for node in scene["nodes"]]
            self.assertIn("falling box", names)
            self.assertIn("floor", names)
            # Four arrows, one for each sensor that ever pushed.
            self.assertEqual(sum("newton_per_metre" in node.get("extras", {})
                                 for node in scene["nodes"]), 4)
            self.assertEqual(len(scene["animations"]), 1)
        with self.assertRaises(bristle.IoError):
            recorder.write_glb(str(self.folder / "none" / "fall.glb"))
        with self.assertRaises(bristle.InvalidArgument):
            bristle.Recorder(rate=0)

    def test_the_demo_writes_what_it_can(self):
        def write(*arguments):
            out, err = io.StringIO(), io.StringIO()
            with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
                return demo.main(list(map(str, arguments))), out.getvalue(), err.getvalue()

        recording, text, _ = write(self.folder / "grip.glb", "--seed", 1)
        self.assertIn(": held", text)
        names = [node.get("name") for node in gltf(recording)["nodes"]]
        self.assertIn("left finger", names)
        # Without npm there is the recording, and a sentence.
        page = self.folder / "grip.html"
        with mock.patch.object(shutil, "which", return_value=None):
            written, _, complaint = write(page, "--page-tool", "page")
        self.assertEqual((written, page.exists()), (self.folder / "grip.glb", False))
        self.assertIn("needs npm", complaint)
        # A tool that copies stands for the one that makes pages, which examples.replay tests.
        tool = self.folder / "page"
        tool.write_text("#!/bin/sh\ncp \"$1\" \"$2\"\n")
        tool.chmod(0o755)
        with mock.patch.object(shutil, "which", return_value="npm"):
            written, _, _ = write(page, "--page-tool", tool)
        self.assertEqual(written.read_bytes(), (self.folder / "grip.glb").read_bytes())
        with self.assertRaises(SystemExit):
            write(self.folder / "grip.mp4")


class Scenes(InFolder):
    def load(self, module=bristle, path=SCENES / "parallel_gripper.yaml", **options):
        world = module.World(time_step=1e-3)
        try:
            return world, module.add_scene(world, str(path), **options)
        except NotImplementedError:
            self.skipTest("built without yaml-cpp")

    def test_a_gripper_grips(self):
        # As examples/17_adf_scene.cpp does.
        for module in (bristle, bristle32):
            world, scene = self.load(module)
            self.assertIn("Part", scene.bodies)
            self.assertEqual(set(scene.joints), {"Left", "Right", "Lift"})
            self.assertIn("unsupported", scene.report)
            for finger in ("Left", "Right"):
                world.set_motor(scene.joints[finger], mode=bristle.MotorMode.position, target=0.03,
                                max_force=5, max_speed=0.2)
            world.step(500)
            start = world.position(scene.bodies["Part"])[2]
            world.set_motor(scene.joints["Lift"], mode=bristle.MotorMode.position, target=0.1,
                            max_force=50, max_speed=0.2)
            world.step(1500)
            # From the stop at -10 mm to 100 mm.
            rise = world.position(scene.bodies["Part"])[2] - start
            self.assertAlmostEqual(rise, 0.110, delta=1e-3)
            for patch in scene.patches.values():
                self.assertAlmostEqual(world.reading(patch).total_normal, 5, delta=0.05)

    def test_what_is_wrong_is_named_and_the_world_is_as_before(self):
        self.load()
        world = bristle.World()
        before = world.state_hash()
        wrong = self.folder / "wrong.yaml"
        text = (SCENES / "parallel_gripper.yaml").read_text()
        wrong.write_text(text.replace("mass: 0.1", "mass: -1"))
        with self.assertRaisesRegex(bristle.IoError, r"wrong\.yaml:\d+: .*mass = -1"):
            bristle.add_scene(world, str(wrong))
        with self.assertRaises(OSError):
            bristle.add_scene(world, str(self.folder / "none.yaml"))
        self.assertEqual(world.state_hash(), before)


class Plots(InFolder):
    def test_curves_are_drawn_and_wrong_ones_refused(self):
        path = self.folder / "curves.svg"
        bristle.write_plot(str(path), {"height [m]": {"rising": ([0, 1, 2], np.arange(3)),
                                                      "falling": ([0, 2], [2.0, 0.0])}},
                           "time [s]", title="Heights")
        text = path.read_text()
        for word in ("<svg", "rising", "falling", "height [m]", "time [s]", "Heights"):
            self.assertIn(word, text)
        for curve in (([0, 1], [0, 1, 2]), ([0, 1],), ([0, 1], ["a", "b"]), ([0], [[1], [1, 2]])):
            with self.assertRaises((ValueError, TypeError)):
                bristle.write_plot(str(self.folder / "wrong.svg"), {"y": {"wrong": curve}}, "x")
        self.assertFalse((self.folder / "wrong.svg").exists())


if __name__ == "__main__":
    os.environ.pop("BRISTLE_PAGE_TOOL", None)
    unittest.main()
