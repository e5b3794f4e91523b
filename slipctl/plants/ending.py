"""When a world of an ODE plant ends."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipctl.tick import Array, Status


def judged(
    status: NDArray[np.int8], position: Array, finite: NDArray[np.bool_], arena: Array
) -> tuple[NDArray[np.int8], NDArray[np.bool_]]:
    """Return the new status of every world, and which worlds take their new state.

    Parameters
    ----------
    status : (N,) int8 array
        Before the step.
    position : (N, 2) array
        After it [m].
    finite : (N,) bool array
        Whether everything else of the new state is finite.
    arena : (N,) array
        Distance from the world's origin at which a run ends [m].

    Returns
    -------
    status : (N,) int8 array
    moves : (N,) bool array
        Worlds that ended stay where they are; one that diverged keeps its last finite state.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        distance = np.sqrt(position[:, 0] * position[:, 0] + position[:, 1] * position[:, 1])
        outside = distance > arena
    finite = finite & np.isfinite(distance)
    running = status == int(Status.RUNNING)  # numpy takes six times as long for a member
    if not np.count_nonzero(outside | ~finite):
        return status, running
    new = status.copy()
    new[running & outside] = Status.LEFT_THE_ARENA
    new[running & ~finite] = Status.DIVERGED
    return new, running & finite
