"""Tests of the environment of grips: what it promises learners, and that touch is worth having."""
# SPDX-License-Identifier: BSD-3-Clause
import sys
import unittest
from unittest import mock

try:
    import numpy as np
except ImportError:
    print("skipped: no numpy")
    sys.exit(77)

import bristle
from bristle import grip, minimal_gym
from bristle.demo import press_by_feel
from bristle.grip import ACTIONS_PER_EPISODE, MAX_FORCE, GripVectorEnv

try:
    import gymnasium
except ImportError:
    gymnasium = None


def random_actions(worlds, count, seed=5):
    return np.random.default_rng(seed).uniform(-1, 1, (count, worlds, 2))


def press(observations, force):
    """Actions that bring the fingers to a force [N], and lift as `press_by_feel` does."""
    actions = np.zeros((len(observations), 2))
    actions[:, 0] = (force - observations[:, 5] * MAX_FORCE) / grip.FORCE_RATE
    actions[:, 1] = press_by_feel(observations)[:, 1]
    return actions


def episode(env, policy, seed):
    """Returns of the first part of each world the mean reward, whether it is held at the end, and
    the infos of its start."""
    observations, start = env.reset(seed=seed)
    rewards = np.zeros(env.num_envs)
    going = np.ones(env.num_envs, bool)
    for _ in range(ACTIONS_PER_EPISODE):
        observations, reward, terminations, truncations, infos = env.step(policy(observations))
        rewards += going * reward
        going &= ~terminations
    return rewards / ACTIONS_PER_EPISODE, going & infos["held"], start


class Interface(unittest.TestCase):
    def test_shapes_types_and_spaces(self):
        env = GripVectorEnv(3, threads=2)
        observations, infos = env.reset(seed=1)
        self.assertTrue(env.observation_space.contains(observations))
        self.assertEqual(env.observation_space.shape, (3, *env.single_observation_space.shape))
        env.action_space.seed(1)
        actions = env.action_space.sample()
        self.assertEqual((actions.shape, actions.dtype), ((3, 2), np.float32))
        observations, rewards, terminations, truncations, infos = env.step(actions)
        self.assertTrue(env.observation_space.contains(observations))
        self.assertEqual((rewards.dtype, rewards.shape), (np.float64, (3,)))
        for flags in (terminations, truncations, infos["failed"]):
            self.assertEqual((flags.dtype, flags.shape), (bool, (3,)))
        proprioception, taxels = env.split(observations)
        self.assertEqual((proprioception.shape, taxels.shape), ((3, 7), (3, 2, 4, 4, 4)))
        np.testing.assert_array_equal(taxels.reshape(3, 2, 4, 16), env.batch.taxels(env.scene.pads))
        env.close()
        self.assertTrue(env.closed)

    def test_what_was_returned_stays(self):
        env = GripVectorEnv(2)
        first, infos = env.reset(seed=1)
        kept = [first.copy(), infos["mass"].copy(), infos["lift"].copy()]
        for actions in random_actions(2, ACTIONS_PER_EPISODE + 1):
            env.step(actions)
        for now, then in zip((first, infos["mass"], infos["lift"]), kept):
            np.testing.assert_array_equal(now, then)

    def test_a_part_that_is_held_earns_its_height_less_the_effort(self):
        env = GripVectorEnv(16, effort=0.5)
        observations, infos = env.reset(seed=3)
        force = np.minimum(3 * infos["mass"] * grip.GRAVITY, MAX_FORCE)
        for _ in range(ACTIONS_PER_EPISODE - 1):
            observations, rewards, terminations, _, infos = env.step(press(observations, force))
            self.assertFalse(terminations.any())
        self.assertTrue(infos["held"].all())
        np.testing.assert_allclose(rewards, np.minimum(infos["lift"] / grip.LIFT_HEIGHT, 1)
                                   - 0.5 * force / MAX_FORCE, atol=1e-5)

    def test_coulomb_and_strength_decide_what_is_held(self):
        env = GripVectorEnv(96, threads=2)
        _, held, infos = episode(env, lambda o: press(o, 6), seed=4)
        strength = grip.BREAKS_AT * grip.GRAVITY * infos["mass"]
        # A load that comes with the lift makes what is close to its limit slip.
        can = (infos["needed_force"] < 0.85 * 6) & (strength > 1.05 * 6)
        slips, breaks = infos["needed_force"] > 1.05 * 6, strength < 0.95 * 6
        self.assertGreater(min(can.sum(), slips.sum(), breaks.sum()), 4)
        self.assertTrue(held[can].all())
        self.assertFalse(held[slips | breaks].any())


class Chance(unittest.TestCase):
    def test_a_world_depends_on_seed_and_number_alone(self):
        runs = []
        for worlds, threads in ((3, 1), (7, 2)):
            env = GripVectorEnv(worlds, threads=threads)
            rows = [env.reset(seed=11)[0][:3]]
            for actions in random_actions(7, ACTIONS_PER_EPISODE + 5):
                observations, rewards, _, _, infos = env.step(actions[:worlds])
                rows += [observations[:3], rewards[:3], infos["mass"][:3], infos["friction"][:3]]
            runs.append(rows)
        for a, b in zip(*runs):
            np.testing.assert_array_equal(a, b)
        self.assertEqual(len(set(env.mass)), 7)

    def test_parts_differ_from_episode_to_episode_and_seed_to_seed(self):
        env = GripVectorEnv(2)
        masses = [env.reset(seed=seed)[1]["mass"] for seed in (1, None, 2, 1)]
        np.testing.assert_array_equal(masses[0], masses[3])
        for a, b in ((0, 1), (0, 2), (1, 2)):
            self.assertFalse((masses[a] == masses[b]).any())
        self.assertFalse((env.reset()[1]["mass"] == GripVectorEnv(2).reset()[1]["mass"]).any())

    def test_drawn_numbers_are_those_of_the_worlds(self):
        env = GripVectorEnv(3)
        _, infos = env.reset(seed=5)
        self.assertTrue(((infos["mass"] >= 0.1) & (infos["mass"] <= 0.8)).all())
        self.assertTrue(((infos["friction"] >= 0.2) & (infos["friction"] <= 0.9)).all())
        # Pushed by 1 N for 1/240 s, a part in the air is as much faster as its mass says.
        part = env.scene.part
        env.batch.set_pose(part, (0, 0, 1))
        for i in range(3):
            env.batch[i].set_gravity((0, 0, 0))
            env.batch[i].apply_force(part, (1, 0, 0), (0, 0, 1))
        env.batch.step()
        np.testing.assert_allclose(env.batch.bodies([part])[:, 0, 7] * 240, 1 / infos["mass"],
                                   rtol=1e-5)


class Resets(unittest.TestCase):
    def test_a_mask_resets_its_worlds_and_no_other(self):
        env = GripVectorEnv(4, autoreset="Disabled")
        start, before = env.reset(seed=1)
        for actions in random_actions(4, 10):
            observations, *_ = env.step(0.2 * actions)
        hashes = [env.batch[i].state_hash() for i in range(4)]
        mask = np.array([True, False, False, True])
        after, infos = env.reset(options={"reset_mask": mask})
        np.testing.assert_array_equal(after[mask], start[mask])
        np.testing.assert_array_equal(after[~mask], observations[~mask])
        np.testing.assert_array_equal(infos["mass"] == before["mass"], ~mask)
        self.assertEqual([env.batch[i].state_hash() == hashes[i] for i in range(4)],
                         list(~mask))
        # With a seed, the worlds of the mask are as after a reset of all.
        _, infos = env.reset(seed=1, options={"reset_mask": mask})
        np.testing.assert_array_equal(infos["mass"], before["mass"])

    def test_same_step(self):
        env = GripVectorEnv(2)
        start, first = env.reset(seed=1)
        for k in range(ACTIONS_PER_EPISODE):
            observations, _, terminations, truncations, infos = env.step(np.zeros((2, 2)))
            self.assertEqual("final_obs" in infos, k == ACTIONS_PER_EPISODE - 1)
        self.assertTrue(truncations.all() and infos["_final_obs"].all())
        self.assertFalse(terminations.any())
        np.testing.assert_array_equal(infos["final_obs"][:, 6], 0)
        np.testing.assert_array_equal(observations, start)
        np.testing.assert_array_equal(infos["mass"], first["mass"])  # of what is over
        self.assertFalse((env.mass == first["mass"]).any())

    def test_next_step(self):
        env = GripVectorEnv(2, autoreset="NextStep")
        start, _ = env.reset(seed=1)
        for _ in range(ACTIONS_PER_EPISODE):
            observations, _, _, truncations, _ = env.step(np.zeros((2, 2)))
        self.assertTrue(truncations.all())
        np.testing.assert_array_equal(observations[:, 6], 0)
        observations, rewards, terminations, truncations, _ = env.step(np.ones((2, 2)))
        np.testing.assert_array_equal(observations, start)
        self.assertFalse(rewards.any() or terminations.any() or truncations.any())
        observations, *_ = env.step(np.ones((2, 2)))
        self.assertTrue((observations[:, 6] < 1).all())

    def test_disabled(self):
        env = GripVectorEnv(2, autoreset=grip.AutoresetMode.DISABLED)
        env.reset(seed=1)
        for _ in range(ACTIONS_PER_EPISODE):
            env.step(np.zeros((2, 2)))
        with self.assertRaisesRegex(RuntimeError, r"worlds \[0, 1\]"):
            env.step(np.zeros((2, 2)))

    def test_a_lost_part_ends_its_episode_alone(self):
        env = GripVectorEnv(2, autoreset="Disabled")
        env.reset(seed=1)
        actions = np.array([[-1, 1], [1, 0]])  # World 0 lifts with an open hand.
        for _ in range(ACTIONS_PER_EPISODE // 2):
            _, rewards, terminations, truncations, infos = env.step(actions)
            if terminations.any():
                break
        self.assertEqual(list(terminations), [True, False])
        self.assertFalse(truncations.any())
        self.assertGreater(infos["slip"][0], grip.LOST_BELOW)
        self.assertEqual(rewards[0], 0)


class Errors(unittest.TestCase):
    def test_wrong_actions_are_named_and_nothing_moves(self):
        env = GripVectorEnv(3)
        with self.assertRaisesRegex(RuntimeError, "reset must be called"):
            env.step(np.zeros((3, 2)))
        env.reset(seed=1)
        env.step(np.ones((3, 2)))
        hashes = [env.batch[i].state_hash() for i in range(3)]
        force = env.force.copy()
        bad = np.zeros((3, 2))
        bad[1, 0] = np.nan
        for actions, words in ((bad, r"actions\[1\].*must be finite"),
                               (np.full((3, 2), np.inf), "must be finite"),
                               (np.zeros((2, 2)), r"shape \(2, 2\): must be .*\(3, 2\)"),
                               (np.zeros(3), "must be"), ([[0, 0], [0], [0, 0]], "must be"),
                               (np.full((3, 2), "a"), "<U1"),
                               (np.zeros((3, 2), complex), "complex"),
                               (None, "object")):
            with self.assertRaisesRegex(bristle.InvalidArgument, words):
                env.step(actions)
        for mask in ([True], np.array([0, 1, 2]), np.ones((3, 1), bool)):
            with self.assertRaisesRegex(bristle.InvalidArgument, "reset_mask"):
                env.reset(options={"reset_mask": mask})
        self.assertEqual([env.batch[i].state_hash() for i in range(3)], hashes)
        np.testing.assert_array_equal(env.force, force)
        env.step(np.zeros((3, 2)))
        for wrong in (0, -1, "three"):
            with self.assertRaises((ValueError, TypeError)):
                GripVectorEnv(wrong)
        with self.assertRaises(ValueError):
            GripVectorEnv(1, autoreset="sometimes")
        with self.assertRaisesRegex(bristle.InvalidArgument, "the first time"):
            GripVectorEnv(2).reset(options={"reset_mask": np.array([True, False])})


class Touch(unittest.TestCase):
    def test_without_touch_readings_are_zero_and_all_else_is_the_same(self):
        rows = []
        for touch in (True, False):
            env = GripVectorEnv(4, touch=touch)
            observations, _ = env.reset(seed=2)
            for _ in range(20):
                observations, rewards, *_ = env.step(press(observations, 8))
            rows.append((observations, rewards))
        (felt, with_touch), (unfelt, without) = rows
        np.testing.assert_array_equal(with_touch, without)
        np.testing.assert_array_equal(felt[:, :7], unfelt[:, :7])
        self.assertGreater(felt[:, 7:].max(), 0.1)
        self.assertFalse(unfelt[:, 7:].any())

    def test_a_grip_by_feel_holds_what_no_force_without_touch_does(self):
        env = GripVectorEnv(96, threads=2)
        _, held, _ = episode(env, press_by_feel, seed=7)
        self.assertGreater(held.mean(), 0.9)
        for force in (4, 6, 8, 10, 14):
            _, held, _ = episode(env, lambda o: press(o, force), seed=7)
            self.assertLess(held.mean(), 0.8, f"{force} N")

    def test_a_broken_part_ends_its_episode(self):
        env = GripVectorEnv(8, autoreset="Disabled")
        observations, infos = env.reset(seed=1)
        strength = grip.BREAKS_AT * grip.GRAVITY * infos["mass"]
        for _ in range(ACTIONS_PER_EPISODE // 2):
            force = np.where(np.arange(8) < 4, 0.9, 1.1) * strength
            observations, rewards, terminations, _, infos = env.step(press(observations, force)
                                                                     * [1, 0])
            np.testing.assert_array_equal(terminations, infos["broken"])
            self.assertFalse(terminations[:4].any() or rewards[terminations].any())
            env.reset(options={"reset_mask": terminations}) if terminations.any() else None
            if terminations.any():
                break
        self.assertTrue(terminations[4:].any())


class Spaces(unittest.TestCase):
    def test_box(self):
        box = minimal_gym.Box([-1, -np.inf, 0, -np.inf], [1, np.inf, np.inf, 2], seed=3)
        self.assertEqual((box.shape, box.dtype), ((4,), np.float32))
        self.assertFalse(box.is_bounded() or box.is_bounded("above"))
        self.assertTrue(minimal_gym.Box(0, 1, (2, 2)).is_bounded())
        draws = np.array([box.sample() for _ in range(500)])
        self.assertTrue(all(box.contains(x) and x in box for x in draws))
        self.assertLess(np.abs(draws[:, 0].mean()), 0.1)
        self.assertGreater(draws[:, 2].mean(), 0.8)
        box.seed(3)
        np.testing.assert_array_equal(box.sample(), draws[0])
        for wrong in (np.zeros(3, np.float32), np.zeros(4), [0, 0, 0, 0],
                      np.array([2, 0, 0, 0], np.float32), np.array([np.nan] * 4, np.float32)):
            self.assertNotIn(wrong, box)
        self.assertEqual(minimal_gym.Box(0, 1, (2,)), minimal_gym.Box([0, 0], [1, 1]))
        self.assertNotEqual(minimal_gym.Box(0, 1, (2,)), minimal_gym.Box(0, 2, (2,)))
        for low, high in ((1, 0), (np.nan, 1)):
            with self.assertRaises(ValueError):
                minimal_gym.Box(low, high)
        with self.assertRaisesRegex(ValueError, "manner"):
            box.is_bounded("sideways")
        self.assertEqual(minimal_gym.batch_space(box, 3).shape, (3, 4))

    @unittest.skipIf(gymnasium is None, "no gymnasium")
    def test_our_own_box_is_as_gymnasiums(self):
        bounds = [-1, -np.inf, 0, -np.inf], [1, np.inf, np.inf, 2]
        ours = minimal_gym.Box(*(np.array(b, np.float32) for b in bounds), seed=3)
        theirs = gymnasium.spaces.Box(*(np.array(b, np.float32) for b in bounds), seed=3)
        for _ in range(10):
            np.testing.assert_array_equal(ours.sample(), theirs.sample())
        for name in ("low", "high", "shape", "dtype", "bounded_below", "bounded_above"):
            np.testing.assert_array_equal(getattr(ours, name), getattr(theirs, name))
        for manner in ("both", "below", "above"):
            self.assertEqual(ours.is_bounded(manner), theirs.is_bounded(manner))

    @unittest.skipIf(gymnasium is None, "no gymnasium")
    def test_gymnasium_takes_the_environment(self):
        env = GripVectorEnv(3)
        self.assertIsInstance(env, gymnasium.vector.VectorEnv)
        self.assertIsInstance(env.single_action_space, gymnasium.spaces.Box)
        wrapped = gymnasium.wrappers.vector.RecordEpisodeStatistics(
            gymnasium.wrappers.vector.ClipReward(env, -2.0, 2.0))
        wrapped.reset(seed=1)
        total = np.zeros(3)
        for _ in range(ACTIONS_PER_EPISODE):
            _, rewards, _, truncations, infos = wrapped.step(np.zeros((3, 2), np.float32))
            total += rewards
        self.assertTrue(truncations.all())
        np.testing.assert_allclose(infos["episode"]["r"], total, rtol=1e-6)
        np.testing.assert_array_equal(infos["episode"]["l"], ACTIONS_PER_EPISODE)

    def test_it_works_where_gymnasium_is_not_installed(self):
        names = [name for name in sys.modules if name.split(".")[0] == "gymnasium"]
        with mock.patch.dict(sys.modules, {**dict.fromkeys(names), "gymnasium": None}):
            for name in ("bristle.gym", "bristle.grip"):
                sys.modules.pop(name, None)
            from bristle.grip import GripVectorEnv as WithoutGymnasium
            env = WithoutGymnasium(2)
            self.assertIsInstance(env, minimal_gym.VectorEnv)
            self.assertIsInstance(env.action_space, minimal_gym.Box)
            self.assertIs(env.unwrapped, env)
            env.reset(seed=1)
            env.step(env.action_space.sample())


if __name__ == "__main__":
    unittest.main()
