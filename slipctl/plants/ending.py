"""When a world of an ODE plant ends."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipctl.tick import Array, Status


def judged(
    status: NDArray[np.int8], position: Array, rest: Array, arena: Array
) -> tuple[NDArray[np.int8], NDArray[np.bool_] | None]:
    """Return the new status of every world, and which worlds take their new state.

    The caller lets numpy overflow silently.

    Parameters
    ----------
    status : (N,) int8 array
        Before the step.
    position : (N, 2) array
        After it [m].
    rest : (N,) array
        A sum of everything else of the new state, which is finite where that is.
    arena : (N,) array
        Distance from the world's origin at which a run ends [m].

    Returns
    -------
    status : (N,) int8 array
    moves : (N,) bool array or None
        Worlds that ended stay where they are; one that diverged keeps its last finite state. None where every
        world moves on.
    """
    squares = position * position
    distance = np.sqrt(squares[:, 0] + squares[:, 1])
    # one count tells that all is well with every world; where it is not, each is looked at
    well = distance <= arena
    well &= np.isfinite(rest + distance)  # an endless arena holds an infinite distance
    if np.count_nonzero(well) == len(well) and not np.count_nonzero(status):
        return status, None
    running = status == int(Status.RUNNING)
    outside, finite = distance > arena, np.isfinite(rest) & np.isfinite(distance)
    if not np.count_nonzero(running & (outside | ~finite)):
        return status, running
    new = status.copy()
    new[running & outside] = Status.LEFT_THE_ARENA
    new[running & ~finite] = Status.DIVERGED
    return new, running & finite
