"""Test that worlds end in the same states for any number of ranks of MPI."""
# SPDX-License-Identifier: BSD-3-Clause
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

try:
    import mpi4py  # noqa: F401
except ImportError:
    print("skipped: no mpi4py (Debian: python3-mpi4py)")
    sys.exit(77)
if not shutil.which("mpirun"):
    print("skipped: no mpirun (Debian: openmpi-bin)")
    sys.exit(77)

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCRIPT = ROOT / "examples" / "python" / "cluster_batch.py"


def run(ranks):
    return subprocess.run(
        [ROOT / "examples" / "cluster" / "launch", sys.executable, "--ranks", str(ranks), SCRIPT],
        capture_output=True, text=True)


class Cluster(unittest.TestCase):
    def test_the_number_of_ranks_does_not_matter(self):
        alone = subprocess.run([sys.executable, SCRIPT], capture_output=True, text=True, check=True)
        held, lost = map(float, re.findall(r"([0-9.]+) kg", alone.stdout))
        # mu N of both pads carry 1.02 kg. A part that is little heavier takes longer to slide off.
        self.assertLess(1.02, lost)
        self.assertLess(held, min(lost, 1.1))
        for ranks in 1, 2, 4:
            result = run(ranks)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(result.stdout, alone.stdout)

    def test_more_ranks_than_worlds_are_refused(self):
        result = run(21)
        self.assertNotEqual(result.returncode, 0)
        self.assertIn("21 ranks for 20 worlds", result.stderr)


if __name__ == "__main__":
    unittest.main()
