"""The alarm: a slip ratio beyond its bound, seen by what the robot itself measures."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray

from slipctl.guarantee.hypotheses import LEAST_SPEED
from slipctl.tick import Array

TIME_CONSTANT = 0.15
"""Of the low-pass before the alarm [s]."""

MARGIN = 0.05
"""Above the bound [1]. Both make an alarm some 50 ms late, and free of 5 mm/s and 3 mrad of noise."""


def measured_ratio(columns: Mapping[str, NDArray]) -> Array:
    """Return |σ̂| = |Ḟ conj(E)/v − 1| (N, T) of what is sensed, else of the true motion."""
    if "sensed.velocity.x" not in columns:
        if "slip.ratio" in columns:
            return columns["slip.ratio"]  # the same
        along, across = columns["slip.longitudinal"], columns["slip.lateral"]
    else:
        cosine, sine = np.cos(columns["sensed.heading"]), np.sin(columns["sensed.heading"])
        x, y = columns["sensed.velocity.x"], columns["sensed.velocity.y"]
        along = cosine * x + sine * y - columns["motion.forward_speed"]
        across = sine * x - cosine * y
    speed = np.maximum(np.abs(columns["motion.forward_speed"]), LEAST_SPEED)
    return np.sqrt(along * along + across * across) / speed


FEW = 4
"""Fewer worlds than this are filtered without scipy.signal, whose import takes longer than a run."""


def low_pass(values: Array, tick: float) -> Array:
    """Return values (N, T) behind a first-order low-pass that starts at the first of them.

    The bits are the same for few worlds and for many.
    """
    share = -math.expm1(-tick / TIME_CONSTANT)
    rest = 1.0 - share
    if len(values) < FEW:
        told = share * values
        told[:, 0] += rest * values[:, 0]
        told[:, 1:] += 0.0 * values[:, :-1]  # after an infinity nothing is known, as with scipy
        return np.array(
            [list(accumulate(row, lambda before, now: rest * before + now)) for row in told.tolist()]
        )
    from scipy.signal import lfilter

    return lfilter([share], [1.0, -rest], values, axis=-1, zi=rest * values[:, :1])[0]
