"""Spaces and the base of environments: gymnasium's where it is installed, else our own."""
# SPDX-License-Identifier: BSD-3-Clause
try:
    from gymnasium.spaces import Box
    from gymnasium.vector import AutoresetMode, VectorEnv
    from gymnasium.vector.utils import batch_space
except ImportError:  # Not installed, or older than 1.1.
    from .minimal_gym import AutoresetMode, Box, VectorEnv, batch_space

__all__ = ["AutoresetMode", "Box", "VectorEnv", "batch_space"]
