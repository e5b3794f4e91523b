"""Columns that follow from the recorded ones."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipctl.pairs import pair
from slipctl.recording.signals import Columns
from slipctl.theory.flatness import flat_to_state
from slipctl.theory.slip import explained_slip, slip_ratio


def with_errors(columns: Columns) -> Columns:
    """Add what follows from the recorded columns: reference state, heading, slip and errors.

    Parameters
    ----------
    columns : dict of (N, T) arrays

    Returns
    -------
    dict of (N, T) arrays
        Heading vectors replaced by `motion.heading` and `sensed.heading`; the position error is the distance
        to the reference at the same time, cross-track its component along the reference's left normal,
        heading error wrapped to (−π, π].
    """
    columns = dict(columns)
    _add_slip(columns)
    # a path that rests has a heading in its own time only
    stem = "reference.path_" if "reference.path_time" in columns else "reference."
    ahead = columns[stem + "velocity.x"], columns[stem + "velocity.y"]
    planned = *ahead, columns[stem + "acceleration.x"], columns[stem + "acceleration.y"]
    speed, heading, yaw_rate = _reference(*planned)
    columns["reference.heading"] = heading
    columns["reference.forward_speed"], columns["reference.yaw_rate"] = speed, yaw_rate
    if "reference.path_rate" in columns:
        columns["reference.forward_speed"] = speed * columns["reference.path_rate"]
        columns["reference.yaw_rate"] = yaw_rate * columns["reference.path_rate"]
    for seen in ("motion", "sensed") if "sensed.fix" in columns else ("motion",):
        cosine, sine = columns.pop(f"{seen}.heading_vector.x"), columns.pop(f"{seen}.heading_vector.y")
        columns[f"{seen}.heading"] = np.arctan2(sine, cosine)
    columns["slip.ratio"] = slip_ratio(
        columns["slip.longitudinal"], columns["slip.lateral"], columns["motion.forward_speed"]
    )
    x = columns["motion.position.x"] - columns["reference.position.x"]
    y = columns["motion.position.y"] - columns["reference.position.y"]
    squares = x * x
    squares += y * y
    columns["error.position"] = np.sqrt(squares, out=squares)
    y *= ahead[0]
    x *= ahead[1]
    y -= x
    with np.errstate(invalid="ignore", divide="ignore"):
        y /= speed
    columns["error.cross_track"] = y
    turn = columns["motion.heading"] - heading
    sine = np.sin(turn)
    columns["error.heading"] = np.arctan2(sine, np.cos(turn, out=turn), out=sine)
    return columns


def _reference(*planned: NDArray) -> tuple[NDArray, NDArray, NDArray]:
    """Return speed, heading and yaw rate (N, T) of the components of planned velocity and acceleration.

    Where all worlds share one path, and so one row of memory, they are worked out once.
    """
    shape = planned[0].shape
    if all(column.strides[0] == 0 for column in planned):
        planned = tuple(column[:1] for column in planned)
    speed, heading, _, yaw_rate = flat_to_state(pair(*planned[:2]), pair(*planned[2:]))
    return np.broadcast_to(speed, shape), np.broadcast_to(heading, shape), np.broadcast_to(yaw_rate, shape)


def _add_slip(columns: Columns) -> None:
    slip = explained_slip(
        (columns["motion.heading_vector.x"], columns["motion.heading_vector.y"]),
        (columns["motion.velocity.x"], columns["motion.velocity.y"]),
        columns["motion.heading_rate"],
        columns["motion.forward_speed"],
        columns["motion.yaw_rate"],
    )
    columns |= {"slip.longitudinal": slip.longitudinal, "slip.lateral": slip.lateral, "slip.yaw": slip.yaw}
