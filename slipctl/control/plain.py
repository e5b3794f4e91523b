"""What a law gives that does not control the flat output."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipctl.tick import DecisionTrace


def plain_trace(saturated: NDArray[np.bool_]) -> DecisionTrace:
    """Return the trace of a law without flat inputs: they are NaN, and what is measured of them is null.

    Parameters
    ----------
    saturated : (N,) bool array
        Whether a limit changed the command.
    """
    nothing = np.full((len(saturated), 2), np.nan)
    return DecisionTrace(nominal_input=nothing, robust_input=nothing, saturated=saturated)
