"""As much of gymnasium's interface as environments here need, for where it is not installed.

Names, attributes and values are those of gymnasium 1.1 and later. `bristle.gym` has these or
gymnasium's own.
"""
# SPDX-License-Identifier: BSD-3-Clause
import enum

import numpy as np


class AutoresetMode(enum.Enum):
    """When a world whose episode is over starts the next one."""

    NEXT_STEP = "NextStep"
    SAME_STEP = "SameStep"
    DISABLED = "Disabled"


class Box:
    """Arrays of a shape and dtype whose entries are between `low` and `high`, both included."""

    is_np_flattenable = True

    def __init__(self, low, high, shape=None, dtype=np.float32, seed=None):
        """Bounds are numbers or arrays, infinite where there is none.

        Raises ValueError when a bound is NaN, `low` exceeds `high` or shapes do not fit together.
        """
        self.dtype = np.dtype(dtype)
        if shape is None:
            shape = np.broadcast_shapes(np.shape(low), np.shape(high))
        self.shape = tuple(int(n) for n in shape)
        self.low = np.broadcast_to(np.asarray(low, self.dtype), self.shape).copy()
        self.high = np.broadcast_to(np.asarray(high, self.dtype), self.shape).copy()
        if not np.all(self.low <= self.high):
            raise ValueError("Box: low must be <= high, and neither NaN")
        self.bounded_below = np.isfinite(self.low)
        self.bounded_above = np.isfinite(self.high)
        self.seed(seed)

    def seed(self, seed=None):
        """Starts the random numbers of `sample` anew; returns the seed."""
        sequence = np.random.SeedSequence(seed)
        self._np_random = np.random.Generator(np.random.PCG64(sequence))
        return sequence.entropy

    @property
    def np_random(self):
        """Generator of `sample`."""
        return self._np_random

    def sample(self):
        """Draws an array: uniform between two bounds, exponential from one, normal without any."""
        above, below = self.bounded_above, self.bounded_below
        drawn = np.empty(self.shape)
        free, low, high = ~below & ~above, below & ~above, ~below & above
        both = below & above
        drawn[free] = self.np_random.normal(size=free.sum())
        drawn[low] = self.low[low] + self.np_random.exponential(size=low.sum())
        drawn[high] = self.high[high] - self.np_random.exponential(size=high.sum())
        drawn[both] = self.np_random.uniform(self.low[both], self.high[both])
        return drawn.astype(self.dtype)

    def is_bounded(self, manner="both"):
        """Whether all entries have a bound: "below", "above" or "both"."""
        bounded = {"below": [self.bounded_below], "above": [self.bounded_above],
                   "both": [self.bounded_below, self.bounded_above]}
        if manner not in bounded:
            raise ValueError(f"Box.is_bounded: manner = {manner!r}: must be one of {list(bounded)}")
        return bool(np.all(bounded[manner]))

    def contains(self, x):
        """Whether `x` is an array of this shape, of a dtype that fits, within the bounds."""
        return (isinstance(x, np.ndarray) and np.can_cast(x.dtype, self.dtype)
                and x.shape == self.shape
                and bool(np.all(x >= self.low) and np.all(x <= self.high)))

    def __contains__(self, x):
        return self.contains(x)

    def __eq__(self, other):
        return (isinstance(other, Box) and self.shape == other.shape and self.dtype == other.dtype
                and np.array_equal(self.low, other.low) and np.array_equal(self.high, other.high))

    def __repr__(self):
        low, high = (bound.flat[0] if bound.size and np.all(bound == bound.flat[0]) else bound
                     for bound in (self.low, self.high))
        return f"Box({low}, {high}, {self.shape}, {self.dtype})"


def batch_space(space, n=1):
    """The Box of `n` entries of a Box."""
    return Box(np.repeat(space.low[None], n, axis=0), np.repeat(space.high[None], n, axis=0),
               dtype=space.dtype)


class VectorEnv:
    """Base of environments of several worlds."""

    metadata: dict = {}
    spec = None
    render_mode = None
    closed = False

    def close(self, **kwargs):
        """Says that the environment is not used any more."""
        self.closed = True

    @property
    def unwrapped(self):
        """The environment itself."""
        return self
