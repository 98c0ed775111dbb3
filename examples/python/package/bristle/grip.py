"""An environment for reinforcement learning: two fingers lift parts of unknown mass and friction.

`GripVectorEnv` is a vector environment as gymnasium has them, over a `WorldBatch`. It is one where
gymnasium is installed, and works without it.
"""
# SPDX-License-Identifier: BSD-3-Clause
import numpy as np

from . import MotorMode, InvalidArgument, float32
from .grip_scene import (FINGER_SPEED, FINGER_START, HEAVIEST, LIGHTEST, MAX_FORCE, PAD_ROWS,
                         TIME_STEP, GripScene)
from .gym import AutoresetMode, Box, VectorEnv, batch_space

STEPS_PER_ACTION = 8
ACTIONS_PER_EPISODE = 60  # Two seconds.
FORCE_RATE = 2.0  # [N] that the force of the fingers changes by in an action, at most.
START_FORCE = 1.0  # [N]
LIFT_SPEED = 0.15  # [m/s] of the palm, at most.
LIFT_HEIGHT = 0.05  # [m] to which the part is to be lifted.
LOST_BELOW = 0.020  # [m] that a part may slip down in the hand before it is lost.
BREAKS_AT = 4.0  # [1] Times its weight: what a part stands of a finger.
LEAST_FRICTION, MOST_FRICTION = 0.2, 0.9  # [1]
PROPRIOCEPTION = 7  # Observations that do not come from the pads.
GRAVITY = 9.81  # [m/s^2]


class GripVectorEnv(VectorEnv):
    """Two fingers with tactile pads close on a part, lift it and hold it, in many worlds at once.

    An action is two numbers from -1 to 1: how the force of the fingers changes (by `FORCE_RATE`)
    and how fast the palm rises (`LIFT_SPEED`). An observation is one row of float32:

    ====== ==================================================================================
    0, 1   distance that each finger has closed by [cm]
    2, 3   velocity of each finger [dm/s]
    4      height of the palm above its start [dm]
    5      force that the fingers are told to press with, of `MAX_FORCE` [1]
    6      time that is left of the episode [1]
    7 ...  readings [pad, channel, sensor]: depth [1], normal force, shear 1 and 2 [N]
    ====== ==================================================================================

    The reward of an action is the height that the part is held at, of `LIFT_HEIGHT` and at most 1,
    less the force that the fingers are told, of `MAX_FORCE`, times `effort`. An episode terminates
    when the part has slipped down in the hand by `LOST_BELOW`, when it is broken, since a pad
    pressed with more than `BREAKS_AT` times its weight at the end of an action, or when a step could not be
    computed. It is truncated after `ACTIONS_PER_EPISODE`.

    Mass and friction of the part are drawn anew in each episode: the mass from 0.1 to 0.8 kg,
    the friction from 0.2 to 0.9. `infos` have them as "mass" [kg] and "friction" [1], and with them
    "needed_force" [N], the least that holds the part, "lift" [m] and "slip" [m] of the part,
    "broken", "held", whether it is whole, at four fifths of `LIFT_HEIGHT` and has not slipped by
    half of `LOST_BELOW`, and "failed". What is drawn in world i depends on the seed, on i and on the
    number of the episode alone.
    """

    metadata = {"autoreset_mode": AutoresetMode.SAME_STEP, "render_modes": []}

    def __init__(self, num_envs, *, threads=1, touch=True, effort=0.25,
                 autoreset=AutoresetMode.SAME_STEP):
        """Makes `num_envs` worlds that step on `threads` threads.

        touch      Whether there are readings; without, their place holds zeros.
        autoreset  A mode of gymnasium, or its name. SAME_STEP: a world whose episode is over starts
                   the next one in the same step; `infos["final_obs"]` has what was seen last, and
                   `infos["_final_obs"]` where. NEXT_STEP: in the next step, which ignores the
                   action. DISABLED: by `reset(options={"reset_mask": mask})`, before the next step.
        """
        self.autoreset_mode = AutoresetMode(getattr(autoreset, "value", autoreset))
        self.metadata = {**self.metadata, "autoreset_mode": self.autoreset_mode}
        self.num_envs = num_envs
        self.touch = touch
        self.effort = effort
        self.scene = GripScene()
        self.batch = float32.WorldBatch(self.scene.world, num_envs, threads)
        sensors = PAD_ROWS * PAD_ROWS
        self._taxels = np.zeros((num_envs, 2, 4, sensors), np.float32)
        self._bodies = np.zeros((num_envs, 2, 13), np.float32)
        self._joints = np.zeros((num_envs, 2, 2), np.float32)
        self.single_action_space = Box(-1.0, 1.0, (2,), np.float32)
        self.single_observation_space = Box(-np.inf, np.inf, (PROPRIOCEPTION + 8 * sensors,),
                                            np.float32)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._generators = None
        self._recorder = None
        self._is_over = np.zeros(num_envs, bool)
        self._actions_done = np.zeros(num_envs, np.int64)
        self.mass = np.zeros(num_envs, np.float32)
        self.friction = np.zeros(num_envs, np.float32)
        self.force = np.full(num_envs, START_FORCE, np.float32)
        self._pad_parameters = [self.scene.pad_parameters(MOST_FRICTION)] * num_envs

    def reset(self, *, seed=None, options=None):
        """Starts an episode in all worlds, or in those of `options["reset_mask"]`.

        A seed starts the random numbers of these worlds anew. Returns observations of all worlds,
        and infos.
        """
        mask = np.ones(self.num_envs, bool)
        if options is not None and "reset_mask" in options:
            mask = np.asarray(options["reset_mask"])
            if mask.dtype != bool or mask.shape != (self.num_envs,):
                raise InvalidArgument(f"reset_mask = {mask.dtype} of shape {mask.shape}: must be "
                                      f"bool of shape ({self.num_envs},)")
        if self._generators is None and not mask.all():
            raise InvalidArgument("reset_mask: must be of all worlds the first time")
        if seed is not None or self._generators is None:
            drawn = np.random.SeedSequence(seed).entropy
            fresh = [np.random.default_rng([drawn, i]) for i in range(self.num_envs)]
            old = self._generators or fresh
            self._generators = [f if m else o for m, f, o in zip(mask, fresh, old)]
        self._start(mask)
        return self._observe(), self._infos()

    def step(self, actions):
        """Does one action in each world: [world, 2], beyond -1 and 1 as -1 and 1.

        Returns observations, rewards, terminations, truncations and infos. What is no number raises
        InvalidArgument, and nothing has moved then.
        """
        actions = self._checked(actions)
        if self._generators is None:
            raise RuntimeError("GripVectorEnv.step: reset must be called first")
        if self.autoreset_mode is AutoresetMode.DISABLED and self._is_over.any():
            raise RuntimeError("GripVectorEnv.step: reset must be called first for worlds "
                               f"{np.flatnonzero(self._is_over).tolist()}, whose episodes are over")
        self._act(actions)
        self._advance()
        self._actions_done += 1

        starts = np.zeros(self.num_envs, bool)
        if self.autoreset_mode is AutoresetMode.NEXT_STEP and self._is_over.any():
            starts |= self._is_over
            self._start(starts)
        self._gather()
        rewards = np.clip(self.lift / LIFT_HEIGHT, 0, 1) - self.effort * self.force / MAX_FORCE
        failed = self.batch.failed
        terminations = ((self.slip > LOST_BELOW) | self.broken | failed) & ~starts
        truncations = (self._actions_done >= ACTIONS_PER_EPISODE) & ~terminations
        rewards[terminations | starts] = 0
        self._is_over = terminations | truncations
        infos = {**self._infos(), "failed": failed}
        observations = self._assembled()
        if self.autoreset_mode is AutoresetMode.SAME_STEP and self._is_over.any():
            over = self._is_over.copy()
            infos |= {"final_obs": observations, "_final_obs": over}
            self._start(over)
            observations = self._observe()
        return observations, rewards.astype(np.float64), terminations, truncations, infos

    def record(self, recorder):
        """Lets a recorder of `self.scene.new_recorder()` observe world 0; None: no more."""
        self._recorder = recorder

    @staticmethod
    def split(observations):
        """Views of observations [..., number]: proprioception [..., 7] and readings
        [..., pad, channel, row, column]."""
        return (observations[..., :PROPRIOCEPTION],
                observations[..., PROPRIOCEPTION:].reshape(
                    *observations.shape[:-1], 2, 4, PAD_ROWS, PAD_ROWS))

    def _checked(self, actions):
        try:
            actions = np.asarray(actions)
        except ValueError as error:
            raise InvalidArgument(f"actions: must be an array: {error}") from None
        if actions.shape != (self.num_envs, 2) or actions.dtype.kind not in "fiu":
            raise InvalidArgument(f"actions = {actions.dtype} of shape {actions.shape}: must be "
                                  f"numbers of shape ({self.num_envs}, 2)")
        wrong = ~np.isfinite(actions).all(axis=1)
        if wrong.any():
            world = int(np.flatnonzero(wrong)[0])
            raise InvalidArgument(f"actions[{world}] = {actions[world]}: must be finite")
        return np.clip(actions, -1, 1).astype(np.float32)

    def _start(self, mask):
        """Puts a part of another mass and friction before the open fingers."""
        self.batch.reset(mask)
        for i in np.flatnonzero(mask):
            a, b = self._generators[i].uniform(size=2)
            self.mass[i] = LIGHTEST + (HEAVIEST - LIGHTEST) * a
            self.friction[i] = LEAST_FRICTION + (MOST_FRICTION - LEAST_FRICTION) * b
            self._pad_parameters[i] = self.scene.pad_parameters(float(self.friction[i]))
        scene = self.scene
        self.batch.set_mass(scene.part, self.mass, mask)
        self.batch.set_material(scene.part, self.friction, mask=mask)
        for pad in scene.pads:
            self.batch.set_parameters(pad, self._pad_parameters, mask)
        self.force[mask] = START_FORCE
        self._actions_done[mask] = 0
        self._is_over[mask] = False

    def _act(self, actions):
        self.force = np.clip(self.force + FORCE_RATE * actions[:, 0], 0, MAX_FORCE)
        for joint in self.scene.joints:
            self.batch.set_motor(joint, mode=MotorMode.velocity, target=FINGER_SPEED,
                                 max_force=self.force)
        # The palm stays between its start and a little above where the part is to be.
        height = self._bodies[:, 0, 2] - np.float32(self.scene.palm_height)
        duration = STEPS_PER_ACTION * TIME_STEP
        velocity = np.zeros((self.num_envs, 3), np.float32)
        velocity[:, 2] = np.clip(LIFT_SPEED * actions[:, 1], -height / duration,
                                 (1.2 * LIFT_HEIGHT - height) / duration)
        self.batch.set_velocity(self.scene.palm, velocity)

    def _advance(self):
        if self._recorder is None:
            self.batch.step(STEPS_PER_ACTION)
            return
        for _ in range(STEPS_PER_ACTION):
            self.batch.step()
            world = self.batch[0]
            self._recorder.follow(world)  # A batch gives a copy each time.
            self._recorder.observe(world)

    def _gather(self):
        scene = self.scene
        self.batch.bodies([scene.palm, scene.part], out=self._bodies)
        self.batch.joints(scene.joints, out=self._joints)
        self.batch.taxels(scene.pads, out=self._taxels)
        pressed = self._taxels[:, :, 1].sum(axis=2).max(axis=1)
        self.broken = pressed > BREAKS_AT * GRAVITY * self.mass
        palm = self._bodies[:, 0, 2] - np.float32(scene.palm_height)
        self.lift = self._bodies[:, 1, 2] - np.float32(scene.rest_height)
        self.slip = palm - self.lift

    def _assembled(self):
        observations = np.empty(self.observation_space.shape, np.float32)
        observations[:, 0:2] = 100 * self._joints[:, :, 0]
        observations[:, 2:4] = 10 * self._joints[:, :, 1]
        observations[:, 4] = 10 * (self.slip + self.lift)
        observations[:, 5] = self.force / MAX_FORCE
        observations[:, 6] = 1 - self._actions_done / ACTIONS_PER_EPISODE
        observations[:, PROPRIOCEPTION:] = (self._taxels.reshape(self.num_envs, -1) if self.touch
                                            else 0)
        return observations

    def _observe(self):
        self._gather()
        return self._assembled()

    def _infos(self):
        return {"mass": self.mass.copy(), "friction": self.friction.copy(),
                "needed_force": self.mass * GRAVITY / (2 * self.friction),
                "lift": self.lift.copy(), "slip": self.slip.copy(),
                "broken": self.broken.copy(),
                "held": ((self.lift > 0.8 * LIFT_HEIGHT) & (self.slip < 0.5 * LOST_BELOW)
                         & ~self.broken)}
