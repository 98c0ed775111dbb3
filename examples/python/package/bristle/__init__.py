"""Simulated hands that hold things: worlds, sensors and batches of worlds.

Worlds here are in double; `bristle.float32` has the same in float. `bristle.grip` is an environment
for reinforcement learning.
"""
# SPDX-License-Identifier: BSD-3-Clause
from . import float32  # noqa: F401
from ._core import *  # noqa: F403
from ._core import __version__  # noqa: F401
