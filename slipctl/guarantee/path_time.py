"""A law in the path's own time is checked in that time: its theorem is about rates per path time."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from slipctl.theory.time_scale import LEAST_RATE
from slipctl.tick import Array


def in_path_time(columns: Mapping[str, NDArray]) -> Mapping[str, NDArray]:
    """Return the columns with every rate per path time; the same columns where the law is in real time.

    Where the path's time hardly passes (`moves`), rates are those that the law holds, and slip is 0. The
    recorded slip ratio is left out: it is one of rates in real time where the robot is slow.

    Parameters
    ----------
    columns : mapping of (N, T) arrays
    """
    if "decision.path_speed" not in columns:
        return columns
    tells = columns["reference.path_rate"] >= LEAST_RATE
    rate = np.where(tells, columns["reference.path_rate"], 1.0)

    def per_path_time(name: str, otherwise: NDArray | float) -> NDArray:
        return np.where(tells, columns[name] / rate, otherwise)

    changed = {
        "motion.forward_speed": per_path_time("motion.forward_speed", columns["decision.path_speed"]),
        **{f"slip.{name}": per_path_time(f"slip.{name}", 0.0) for name in ("longitudinal", "lateral", "yaw")},
    }
    for axis in ("x", "y"):
        held = columns[f"decision.path_velocity.{axis}"]
        changed[f"motion.velocity.{axis}"] = per_path_time(f"motion.velocity.{axis}", held)
        if f"sensed.velocity.{axis}" in columns:
            changed[f"sensed.velocity.{axis}"] = held
        for name in ("velocity", "acceleration"):
            changed[f"reference.{name}.{axis}"] = columns[f"reference.path_{name}.{axis}"]
    return {**{name: values for name, values in columns.items() if name != "slip.ratio"}, **changed}


def steps(columns: Mapping[str, NDArray], tick: float) -> Array | float:
    """Return how long each tick lasts for the law [s]: (N, T - 1) in path time, else the tick."""
    if "decision.path_speed" not in columns:
        return tick
    return np.diff(columns["reference.path_time"], axis=1)


def moves(columns: Mapping[str, NDArray]) -> NDArray[np.bool_] | None:
    """Return on which ticks (N, T - 1) rates per path time can be told; None in real time, where all can."""
    if "decision.path_speed" not in columns:
        return None
    tells = columns["reference.path_rate"] >= LEAST_RATE
    return tells[:, 1:] & tells[:, :-1]
