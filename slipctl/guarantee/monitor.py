"""The alarm: a slip ratio beyond its bound, seen by what the robot itself measures."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from slipctl.guarantee.hypotheses import LEAST_SPEED
from slipctl.tick import Array

TIME_CONSTANT = 0.15
"""Of the low-pass before the alarm [s]."""

MARGIN = 0.05
"""Above the bound [1]. Both make an alarm some 50 ms late, and free of 5 mm/s and 3 mrad of noise."""


def measured_ratio(columns: Mapping[str, NDArray]) -> Array:
    """Return |σ̂| = |Ḟ conj(E)/v − 1| (N, T) of what is sensed, else of the true motion."""
    if "sensed.velocity.x" not in columns:
        along, across = columns["slip.longitudinal"], columns["slip.lateral"]
    else:
        cosine, sine = np.cos(columns["sensed.heading"]), np.sin(columns["sensed.heading"])
        x, y = columns["sensed.velocity.x"], columns["sensed.velocity.y"]
        along = cosine * x + sine * y - columns["motion.forward_speed"]
        across = sine * x - cosine * y
    speed = np.maximum(np.abs(columns["motion.forward_speed"]), LEAST_SPEED)
    return np.sqrt(along * along + across * across) / speed


def low_pass(values: Array, tick: float) -> Array:
    """Return values (N, T) behind a first-order low-pass that starts at the first of them."""
    share = -math.expm1(-tick / TIME_CONSTANT)
    state = (1.0 - share) * values[:, :1]
    return lfilter([share], [1.0, share - 1.0], values, axis=-1, zi=state)[0]
