"""Noise that belongs to a world: drawn from its seed alone, before the first tick."""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum

import numpy as np

from slipctl.tick import Array


class Stream(IntEnum):
    """Every source of chance in a world; each draws from a generator of its own.

    So a noise that is switched on changes no other, and every controller meets the same.
    """

    CAMERA_PHASE = 0
    CAMERA = 1
    POSITION = 2
    HEADING = 3
    VELOCITY = 4
    ACCELERATION = 5
    YAW_RATE = 6


def white(
    seeds: Sequence[int], stream: Stream, deviation: Array, count: int, components: int
) -> Array | None:
    """Draw white noise for all worlds.

    Parameters
    ----------
    seeds : sequence of int
        One per world, not negative.
    stream : Stream
    deviation : (N,) array
        Standard deviations.
    count, components : int
        Draws per world, and numbers per draw.

    Returns
    -------
    (count, N, components) array or None
        None where no world has any. Draw `i` of a world is the same whatever `count` and the other worlds.
    """
    if not deviation.any():
        return None
    return np.stack(
        [
            np.random.default_rng([seed, stream]).standard_normal((count, components)) * scale
            for seed, scale in zip(seeds, deviation.tolist(), strict=True)
        ],
        axis=1,
    )


def phases(seeds: Sequence[int]) -> Array:
    """Draw where in its period the camera of each world is at t = 0, uniform in [0, 1), as (N,)."""
    return np.array([np.random.default_rng([seed, Stream.CAMERA_PHASE]).random() for seed in seeds])
