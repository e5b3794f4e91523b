"""A line of past values, for signals that arrive late."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipctl.tick import Array

Ticks = NDArray[np.int64]


@dataclass(frozen=True)
class DelayLine:
    """The last values of a signal, newest first.

    Attributes
    ----------
    past : (D + 1, N, components) array
        Before there is a past, the first value stands for it.
    """

    past: Array

    @classmethod
    def filled(cls, value: Array, longest: int) -> DelayLine:
        """Return a line, for delays up to `longest` ticks, in which `value` (N, components) always was."""
        return cls(np.repeat(value[None], longest + 1, axis=0))

    def push(self, value: Array) -> DelayLine:
        """Return the line one tick later."""
        return DelayLine(np.concatenate([value[None], self.past[:-1]]))

    def at(self, ticks: Ticks) -> Array:
        """Return the value that is `ticks` (N,) old in each world, (N, components)."""
        return self.past[ticks, np.arange(len(ticks))]


def whole_ticks(delay: Array, tick: float) -> Ticks:
    """Return delays (N,) [s] in ticks, rounded to the nearest."""
    return np.rint(delay / tick).astype(np.int64)


def ticks_until(delay: Array, tick: float) -> Ticks:
    """Return the first tick, (N,), at which something that takes `delay` [s] has arrived."""
    return np.ceil(delay / tick - 1e-9).astype(np.int64)
