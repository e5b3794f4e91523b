"""Columns that follow from the recorded ones."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipctl.pairs import pair
from slipctl.recording.signals import Columns
from slipctl.theory.flatness import flat_to_state
from slipctl.theory.slip import explained_slip, slip_ratio


def with_plan(columns: Columns) -> Columns:
    """Add heading, speed and yaw rate of the reference, which follow from its own columns.

    Parameters
    ----------
    columns : dict of (N, T) arrays

    Returns
    -------
    dict of (N, T) arrays
        Where all worlds share one path, and so one row of memory, they share what follows, too.
    """
    # a path that rests has a heading in its own time only
    stem = "reference.path_" if "reference.path_time" in columns else "reference."
    planned = [columns[f"{stem}{name}.{axis}"] for name in ("velocity", "acceleration") for axis in "xy"]
    shape = planned[0].shape
    if all(column.strides[0] == 0 for column in planned):
        planned = [column[:1] for column in planned]
    speed, heading, _, yaw_rate = flat_to_state(pair(*planned[:2]), pair(*planned[2:]))
    if "reference.path_rate" in columns:
        speed, yaw_rate = speed * columns["reference.path_rate"], yaw_rate * columns["reference.path_rate"]
    return columns | {
        "reference.heading": np.broadcast_to(heading, shape),
        "reference.forward_speed": np.broadcast_to(speed, shape),
        "reference.yaw_rate": np.broadcast_to(yaw_rate, shape),
    }


def with_errors(columns: Columns) -> Columns:
    """Add what follows from the recorded columns: reference state, heading, slip and errors.

    Parameters
    ----------
    columns : dict of (N, T) arrays
        What `with_plan` adds may be there.

    Returns
    -------
    dict of (N, T) arrays
        Heading vectors replaced by `motion.heading` and `sensed.heading`; the position error is the distance
        to the reference at the same time, cross-track its component along the reference's left normal,
        heading error wrapped to (−π, π].
    """
    columns = dict(columns) if "reference.heading" in columns else with_plan(columns)
    _add_slip(columns)
    ahead = _ahead(columns)
    columns["error.heading"] = _turn(
        ahead, (columns["motion.heading_vector.x"], columns["motion.heading_vector.y"])
    )
    for seen in ("motion", "sensed") if "sensed.fix" in columns else ("motion",):
        cosine, sine = columns.pop(f"{seen}.heading_vector.x"), columns.pop(f"{seen}.heading_vector.y")
        columns[f"{seen}.heading"] = np.arctan2(sine, cosine)
    columns["slip.ratio"] = slip_ratio(
        columns["slip.longitudinal"], columns["slip.lateral"], columns["motion.forward_speed"]
    )
    x = columns["motion.position.x"] - columns["reference.position.x"]
    y = columns["motion.position.y"] - columns["reference.position.y"]
    columns["error.position"] = _length(x, y)
    columns["error.cross_track"] = _across(
        ahead,
        _length(*ahead) if "reference.path_time" in columns else columns["reference.forward_speed"],
        x,
        y,
    )
    return columns


def _ahead(columns: Columns) -> tuple[NDArray, NDArray]:
    """Return x and y of a vector along the path, of no particular length."""
    stem = "reference.path_velocity" if "reference.path_time" in columns else "reference.velocity"
    return columns[f"{stem}.x"], columns[f"{stem}.y"]


def _turn(begin: tuple[NDArray, NDArray], end: tuple[NDArray, NDArray]) -> NDArray:
    """Return the angle from one vector to another; their lengths play no part."""
    across, along = begin[0] * end[1], begin[0] * end[0]
    across -= begin[1] * end[0]
    along += begin[1] * end[1]
    return np.arctan2(across, along, out=across)


def _across(ahead: tuple[NDArray, NDArray], speed: NDArray, x: NDArray, y: NDArray) -> NDArray:
    """Return the component of (x, y) along the left normal of the path; `speed` is the length of `ahead`."""
    across = y * ahead[0]
    across -= x * ahead[1]
    with np.errstate(invalid="ignore", divide="ignore"):
        across /= speed
    return across


def _length(x: NDArray, y: NDArray) -> NDArray:
    squares = x * x
    squares += y * y
    return np.sqrt(squares, out=squares)


def _add_slip(columns: Columns) -> None:
    slip = explained_slip(
        (columns["motion.heading_vector.x"], columns["motion.heading_vector.y"]),
        (columns["motion.velocity.x"], columns["motion.velocity.y"]),
        columns["motion.heading_rate"],
        columns["motion.forward_speed"],
        columns["motion.yaw_rate"],
    )
    columns |= {"slip.longitudinal": slip.longitudinal, "slip.lateral": slip.lateral, "slip.yaw": slip.yaw}
