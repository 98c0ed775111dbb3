"""Grips a part by feel and writes a replay of it: python -m bristle.demo [FILE.html or FILE.glb]

A page is made where the tool for it is named, by --page-tool or in BRISTLE_PAGE_TOOL, and npm is
installed; the recording is written in any case.
"""
# SPDX-License-Identifier: BSD-3-Clause
import argparse
import os
import pathlib
import shutil
import subprocess
import sys

import numpy as np

from . import grip

FRICTION_EXPECTED = 1 / 6  # [1] Presses as hard as the shear calls for, were this the friction.
SPARE_FORCE = 0.5  # [N]
LEAST_FORCE = 1.5  # [N]
LIFT = 0.3  # [1] of the fastest: the shear grows while the part leaves the floor.


def press_by_feel(observations):
    """Actions that press as hard as the shear on the pads calls for, and lift after half a second.

    observations  [..., number], of a `GripVectorEnv`.
    """
    proprioception, taxels = grip.GripVectorEnv.split(observations)
    shear = np.linalg.norm(taxels[..., 2:, :, :].sum(axis=(-2, -1)), axis=-1).mean(axis=-1)
    wanted = np.maximum(shear / FRICTION_EXPECTED + SPARE_FORCE, LEAST_FORCE)
    actions = np.empty((*shear.shape, 2), np.float32)
    actions[..., 0] = (wanted - proprioception[..., 5] * grip.MAX_FORCE) / grip.FORCE_RATE
    actions[..., 1] = LIFT * (proprioception[..., 6] < 0.75)
    return actions


def record_grip(path, seed):
    """Grips one part and writes the recording to `path`. Returns the infos of the last action."""
    env = grip.GripVectorEnv(1, autoreset="Disabled")
    recorder = env.scene.new_recorder()
    observations, _ = env.reset(seed=seed)
    env.record(recorder)
    is_over = False
    while not is_over:
        observations, _, terminations, truncations, infos = env.step(press_by_feel(observations))
        is_over = terminations[0] or truncations[0]
    recorder.write_glb(str(path))
    return infos


def main(arguments=None):
    """Does what the command line asks for; returns the path of what it wrote last."""
    parser = argparse.ArgumentParser(prog="python -m bristle.demo",
                                     description="Grips a part by feel and writes a replay of it.")
    parser.add_argument("file", nargs="?", default="grip.html", type=pathlib.Path,
                        help="page, or recording if it ends in .glb (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="which part (default: %(default)s)")
    parser.add_argument("--page-tool", default=os.environ.get("BRISTLE_PAGE_TOOL"),
                        help="examples/replay/page of the source tree")
    options = parser.parse_args(arguments)
    if options.file.suffix not in (".html", ".glb"):
        parser.error(f"{options.file}: must end in .html or .glb")

    recording = options.file.with_suffix(".glb")
    infos = record_grip(recording, options.seed)
    fate = "held" if infos["held"][0] else "lost"
    print(f"a part of {infos['mass'][0]:.2f} kg and friction {infos['friction'][0]:.2f}: {fate}")
    print(f"wrote {recording}")
    if options.file.suffix == ".glb":
        return recording
    if not options.page_tool or not shutil.which("npm"):
        lacks = "npm" if options.page_tool else "the tool examples/replay/page of the source tree"
        print(f"no page: it needs {lacks}", file=sys.stderr)
        return recording
    subprocess.run([options.page_tool, recording, options.file], check=True)
    print(f"wrote {options.file}")
    return options.file


if __name__ == "__main__":
    main()
