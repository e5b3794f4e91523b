"""Columns that follow from the recorded ones."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

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
    velocity, acceleration = _pair(columns, stem + "velocity"), _pair(columns, stem + "acceleration")
    speed, heading, _, yaw_rate = flat_to_state(velocity, acceleration)
    rate = columns.get("reference.path_rate", 1.0)
    columns["reference.heading"] = heading
    columns["reference.forward_speed"] = speed * rate
    columns["reference.yaw_rate"] = yaw_rate * rate
    for seen in ("motion", "sensed") if "sensed.fix" in columns else ("motion",):
        cosine, sine = columns.pop(f"{seen}.heading_vector.x"), columns.pop(f"{seen}.heading_vector.y")
        columns[f"{seen}.heading"] = np.arctan2(sine, cosine)
    columns["slip.ratio"] = slip_ratio(
        columns["slip.longitudinal"], columns["slip.lateral"], columns["motion.forward_speed"]
    )
    x = columns["motion.position.x"] - columns["reference.position.x"]
    y = columns["motion.position.y"] - columns["reference.position.y"]
    columns["error.position"] = np.sqrt(x * x + y * y)
    with np.errstate(invalid="ignore", divide="ignore"):
        columns["error.cross_track"] = (y * velocity[..., 0] - x * velocity[..., 1]) / speed
    turn = columns["motion.heading"] - heading
    columns["error.heading"] = np.arctan2(np.sin(turn), np.cos(turn))
    return columns


def _add_slip(columns: Columns) -> None:
    slip = explained_slip(
        (columns["motion.heading_vector.x"], columns["motion.heading_vector.y"]),
        (columns["motion.velocity.x"], columns["motion.velocity.y"]),
        columns["motion.heading_rate"],
        columns["motion.forward_speed"],
        columns["motion.yaw_rate"],
    )
    columns |= {"slip.longitudinal": slip.longitudinal, "slip.lateral": slip.lateral, "slip.yaw": slip.yaw}


def _pair(columns: Columns, stem: str) -> NDArray:
    return np.stack([columns[f"{stem}.x"], columns[f"{stem}.y"]], axis=-1)
