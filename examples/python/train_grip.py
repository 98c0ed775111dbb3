"""Two policies learn to close on parts of unknown mass and friction, lift them and hold them.

One feels, the other is the same without readings of its pads. Both are trained by proximal policy
optimisation (Schulman et al. 2017) in `bristle.grip.GripVectorEnv`, and then tried on parts that
neither has met. Writes train_grip.svg, what they gained while they learned.
"""
# SPDX-License-Identifier: BSD-3-Clause
import argparse
import time

import numpy as np
import torch

import bristle
from bristle import grip

DISCOUNT = 0.99  # [1] of rewards, each action.
TRACE = 0.95  # [1] lambda of the generalised advantage estimate (Schulman et al. 2016).
CLIP = 0.2  # [1] by which an update may change the probability of an action.
PASSES = 6  # Over the actions of an iteration.
BATCH = 256  # Actions of one gradient.


class Frames:
    """What a policy sees: the last two observations, so that it knows what changes."""

    def __init__(self, observations):
        self.now = self.before = torch.from_dlpack(observations)

    def next(self, observations, starts):
        """Adds observations; `starts` says where another episode began."""
        self.before, self.now = self.now, torch.from_dlpack(observations)
        self.before = torch.where(torch.from_numpy(starts)[:, None], self.now, self.before)

    def __call__(self):
        return torch.cat([self.now, self.before], dim=1)


class Policy(torch.nn.Module):
    """Mean and spread of the next action, and the rewards to come, as networks."""

    def __init__(self, seen, actions):
        super().__init__()
        self.register_buffer("count", torch.tensor(1e-4))
        self.register_buffer("mean", torch.zeros(seen))
        self.register_buffer("square", torch.ones(seen))
        self.act = self._network(seen, actions, last=0.01)
        self.value = self._network(seen, 1, last=1.0)
        self.log_spread = torch.nn.Parameter(torch.full((actions,), -0.5))

    @staticmethod
    def _network(inputs, outputs, last):
        layers = [torch.nn.Linear(inputs, 64), torch.nn.Tanh(), torch.nn.Linear(64, 64),
                  torch.nn.Tanh(), torch.nn.Linear(64, outputs)]
        for layer, gain in zip(layers[::2], (2 ** 0.5, 2 ** 0.5, last)):
            torch.nn.init.orthogonal_(layer.weight, gain)
            torch.nn.init.zeros_(layer.bias)
        return torch.nn.Sequential(*layers)

    def meet(self, seen):
        """Learns the mean and the spread of what is seen."""
        self.count += len(seen)
        share = len(seen) / self.count
        self.mean += share * (seen.mean(0) - self.mean)
        self.square += share * ((seen - self.mean).square().mean(0) - self.square)

    def scaled(self, seen):
        return ((seen - self.mean) / (self.square + 1e-6).sqrt()).clamp(-5, 5)

    def action(self, scaled):
        return torch.distributions.Normal(self.act(scaled), self.log_spread.exp())


def collect(policy, env, frames, earned):
    """Lets a policy act as long as an episode lasts. Returns what it saw, did and gained, and the
    rewards of each episode that ended, in which `earned` has what was gained before."""
    rows, ended = [], []
    for _ in range(grip.ACTIONS_PER_EPISODE):
        seen = frames()
        with torch.no_grad():
            scaled = policy.scaled(seen)
            chosen = policy.action(scaled)
            action = chosen.sample()
            log_probability = chosen.log_prob(action).sum(1)
            value = policy.value(scaled)[:, 0]
        observations, rewards, terminations, truncations, _ = env.step(action.numpy())
        # How much time is left is seen, so that the end of an episode is one to learn from.
        over = terminations | truncations
        frames.next(observations, over)
        earned += rewards
        ended.extend(earned[over])
        earned[over] = 0
        rows.append((seen, action, log_probability, value, torch.from_numpy(rewards).float(),
                     torch.from_numpy(over).float()))
    return [torch.stack(column) for column in zip(*rows)], ended


def advantages(policy, frames, value, reward, over):
    """How much better each action was than expected, by the generalised advantage estimate."""
    with torch.no_grad():
        following = policy.value(policy.scaled(frames()))[:, 0]
    result = torch.zeros_like(reward)
    later = torch.zeros_like(following)
    for t in reversed(range(len(reward))):
        goes_on = 1 - over[t]
        surprise = reward[t] + DISCOUNT * goes_on * following - value[t]
        later = surprise + DISCOUNT * TRACE * goes_on * later
        result[t], following = later, value[t]
    return result


def improve(policy, optimiser, seen, action, log_probability, advantage, gain):
    """Some passes of clipped gradient steps over the actions of an iteration."""
    scaled = policy.scaled(seen)
    for _ in range(PASSES):
        for some in torch.randperm(len(seen)).split(BATCH):
            chosen = policy.action(scaled[some])
            ratio = (chosen.log_prob(action[some]).sum(1) - log_probability[some]).exp()
            a = advantage[some]
            a = (a - a.mean()) / (a.std() + 1e-8)
            loss = -torch.min(ratio * a, ratio.clamp(1 - CLIP, 1 + CLIP) * a).mean()
            loss += 0.5 * (policy.value(scaled[some])[:, 0] - gain[some]).square().mean()
            optimiser.zero_grad()
            loss.backward()
            torch.nn.utils.clip_grad_norm_(policy.parameters(), 0.5)
            optimiser.step()


def train(touch, iterations, worlds, threads, seed):
    """Trains a policy; returns it and, for each iteration, the mean reward of the episodes that
    ended in it, by the actions of a whole one."""
    torch.manual_seed(seed)
    env = grip.GripVectorEnv(worlds, threads=threads, touch=touch)
    observations, _ = env.reset(seed=seed)
    frames = Frames(observations)
    policy = Policy(frames().shape[1], env.single_action_space.shape[0])
    optimiser = torch.optim.Adam(policy.parameters(), lr=1e-3, eps=1e-5)
    curve, earned = [], np.zeros(worlds)
    start = time.perf_counter()
    for i in range(iterations):
        for group in optimiser.param_groups:
            group["lr"] = 1e-3 * (1 - i / iterations)
        rows, ended = collect(policy, env, frames, earned)
        seen, action, log_probability, value, reward, over = rows
        advantage = advantages(policy, frames, value, reward, over)
        gain = advantage + value
        flat = [x.flatten(0, 1) for x in (seen, action, log_probability, advantage, gain)]
        policy.meet(flat[0])
        improve(policy, optimiser, *flat)
        curve.append(float(np.mean(ended)) / grip.ACTIONS_PER_EPISODE)
        if (i + 1) % 10 == 0 or i + 1 == iterations:
            print(f"{'with' if touch else 'without'} touch: iteration {i + 1} of {iterations}, "
                  f"reward {curve[-1]:.3f}, {time.perf_counter() - start:.0f} s", flush=True)
    return policy, curve


def act_by(policy):
    """The policy without chance, as a function of frames."""
    def act(frames):
        with torch.no_grad():
            return policy.act(policy.scaled(frames())).numpy()
    return act


def press_with(force):
    """Presses with a force [N] that does not change, and lifts after half a second."""
    def act(frames):
        now = frames.now.numpy()
        action = np.zeros((len(now), 2), np.float32)
        action[:, 0] = (force - now[:, 5] * grip.MAX_FORCE) / grip.FORCE_RATE
        action[:, 1] = now[:, 6] < 0.75
        return action
    return act


def try_out(act, touch, parts, threads, seed, recording=None):
    """Lets a policy grip each part once. Returns reward an action, which are held at the end, which
    broke, mean force [N] and the forces [N] that the parts need."""
    env = grip.GripVectorEnv(parts, threads=threads, touch=touch, autoreset="Disabled")
    recorder = env.scene.new_recorder() if recording else None
    env.record(recorder)
    observations, infos = env.reset(seed=seed)
    needed = infos["needed_force"]
    frames = Frames(observations)
    reward, force = np.zeros(parts), np.zeros(parts)
    going = np.ones(parts, bool)
    held, broken = np.zeros(parts, bool), np.zeros(parts, bool)
    actions = np.zeros(parts)
    for _ in range(grip.ACTIONS_PER_EPISODE):
        observations, rewards, terminations, truncations, infos = env.step(act(frames))
        reward += going * rewards
        force += going * env.force
        actions += going
        held |= going & truncations & infos["held"]
        broken |= going & infos["broken"]
        over = terminations | truncations
        going &= ~over
        if over.any():  # What has ended starts again, and is not counted.
            observations, _ = env.reset(options={"reset_mask": over})
        frames.next(observations, over)
    if recorder is not None:
        recorder.write_glb(recording)
    return reward / grip.ACTIONS_PER_EPISODE, held, broken, force / actions, needed


NEEDS = ((0, 2), (2, 4), (4, 8), (8, 20))  # [N]


def print_row(name, reward, held, broken, force, needed):
    shares = ""
    for low, high in NEEDS:
        among = (needed >= low) & (needed < high)
        shares += f"{100 * held[among].mean():8.0f} %"
    print(f"{name:24}{reward.mean():7.3f}{100 * held.mean():7.0f} %{shares}"
          f"{100 * broken.mean():8.0f} %{force.mean():9.1f}")


def main(arguments=None):
    """Trains, tries out and prints; returns curves and results by name."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--iterations", type=int, default=30,
                        help="times that each world does 60 actions")
    parser.add_argument("--worlds", type=int, default=96, help="worlds that learn at once")
    parser.add_argument("--parts", type=int, default=1000, help="parts to be tried out on")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--plot", default="train_grip.svg", help="file of the curves")
    parser.add_argument("--replay", help=".glb file of the policy that feels, on one part")
    options = parser.parse_args(arguments)
    torch.set_num_threads(1)  # Networks this small are not worth a second one.

    curves, results = {}, {}
    for name, touch in (("with touch", True), ("without touch", False)):
        policy, curves[name] = train(touch, options.iterations, options.worlds, options.threads,
                                     options.seed)
        results[name] = try_out(act_by(policy), touch, options.parts, options.threads,
                                options.seed + 1)
        if touch and options.replay:
            try_out(act_by(policy), touch, 1, 1, options.seed + 1, options.replay)
    for force in (4, 8, 16):
        results[f"{force} N, whatever it is"] = try_out(press_with(force), False, options.parts,
                                                        options.threads, options.seed + 1)

    print(f"\n{options.parts} parts that are new to them; held, by the force that holds them [N]:")
    print(f"{'':24}{'reward':>7}{'held':>9}"
          + "".join(f"{f'{low} to {high}':>10}" for low, high in NEEDS)
          + f"{'broken':>10}{'force [N]':>11}")
    for name, result in results.items():
        print_row(name, *result)
    bristle.write_plot(options.plot, {"reward of an episode / 60 [1]": {
        name: (np.arange(1, 1 + len(curve)) * options.worlds, curve)
        for name, curve in curves.items()}}, "actions / 60 [1]", "Learning to grip")
    print(f"wrote {options.plot}")
    return curves, results


if __name__ == "__main__":
    main()
