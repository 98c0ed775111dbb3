"""Test that a policy learns to grip within seconds, and that it grips by what it feels."""
# SPDX-License-Identifier: BSD-3-Clause
import pathlib
import sys
import tempfile
import unittest

try:
    import numpy as np
    import torch
except ImportError as error:
    print(f"skipped: no {error.name} (Debian: python3-torch)")
    sys.exit(77)

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "examples" / "python"))
import train_grip

WORLDS, ITERATIONS, PARTS = 48, 14, 200


class Learning(unittest.TestCase):
    def test_a_policy_learns_to_grip_by_feel(self):
        # What fourteen iterations reach depends on chance: one seed in five learns next to nothing,
        # here the first. Two of three must learn, and where two have the third is not tried.
        torch.set_num_threads(1)
        bounds = (0.15, 0.2, 0.1)
        tried = []
        for seed in (2, 3, 1):
            tried.append(self.gains(seed))
            if sum(np.greater(gains, bounds).all() for gains in tried) == 2:
                return
        self.fail(f"{tried}, where two of three are above {bounds}")

    def gains(self, seed):
        """Rewards that a policy gained: in its curve, over an untrained one, over itself numb."""
        policy, curve = train_grip.train(True, ITERATIONS, WORLDS, threads=2, seed=seed)
        untrained, _ = train_grip.train(True, 0, WORLDS, threads=2, seed=seed)
        results = {name: train_grip.try_out(train_grip.act_by(p), touch, PARTS, 2, seed=2)
                   for name, p, touch in (("trained", policy, True),
                                          # The same policy without its readings.
                                          ("numb", policy, False),
                                          ("untrained", untrained, True))}
        for name, result in results.items():
            train_grip.print_row(name, *result)
        reward = {name: result[0].mean() for name, result in results.items()}
        return (curve[-1] - curve[0], reward["trained"] - reward["untrained"],
                reward["trained"] - reward["numb"])

    def test_the_same_seed_learns_the_same(self):
        curves = [train_grip.train(True, 2, 4, threads=threads, seed=3)[1] for threads in (1, 2)]
        self.assertEqual(*curves)

    def test_all_of_it_runs(self):
        with tempfile.TemporaryDirectory() as folder:
            plot, replay = pathlib.Path(folder, "plot.svg"), pathlib.Path(folder, "grip.glb")
            curves, results = train_grip.main(
                ["--iterations", "2", "--worlds", "4", "--parts", "20", "--plot", str(plot),
                 "--replay", str(replay)])
            self.assertIn("without touch", plot.read_text())
            self.assertEqual(replay.read_bytes()[:4], b"glTF")
        self.assertEqual([len(curve) for curve in curves.values()], [2, 2])
        for result in results.values():
            self.assertEqual({column.shape for column in result}, {(20,)})
            self.assertTrue(all(np.isfinite(column).all() for column in result))


if __name__ == "__main__":
    unittest.main()
