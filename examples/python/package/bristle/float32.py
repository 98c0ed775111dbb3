"""Worlds, sensors and batches in float."""
# SPDX-License-Identifier: BSD-3-Clause
from ._core._float32 import *  # noqa: F403
