"""Grips parts of unknown mass and friction by what the pads feel, in 64 worlds at once."""
from bristle.demo import press_by_feel
from bristle.grip import ACTIONS_PER_EPISODE, GripVectorEnv

env = GripVectorEnv(64, threads=2)
observations, infos = env.reset(seed=1)
ended = held = 0
for _ in range(2 * ACTIONS_PER_EPISODE):
    actions = press_by_feel(observations)
    observations, rewards, terminations, truncations, infos = env.step(actions)
    ended += (terminations | truncations).sum()
    held += (truncations & infos["held"]).sum()
print(f"{held} of {ended} parts are held")
