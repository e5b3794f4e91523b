"""From a recording to one row of numbers per run."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from slipctl.recording import Columns

UNITS = {
    "rms_position_error": "m",
    "max_position_error": "m",
    "final_position_error": "m",
    "rms_cross_track_error": "m",
    "rms_heading_error": "rad",
    "rms_robust_input": "m/s² (kinematic law) or m/s³ (dynamic law)",
    "command_variation": "rad/s (wheel_speed) or N·m (wheel_torque)",
    "max_slip_ratio": "1",
    "median_slip_ratio": "1",
    "saturation_fraction": "1",
    "guarantee_fraction": "1",
    "min_forward_speed": "m/s",
}
"""Every metric and its unit, in the order of tables."""


def measure(columns: Columns, world: int, last_row: int) -> dict[str, float | None]:
    """Return the metrics of one world over rows 0 … last_row.

    Parameters
    ----------
    columns : dict of (N, T) arrays
    world : int
        Row of the arrays.
    last_row : int
        The last row that counts.

    Returns
    -------
    dict
        Keys of `UNITS`. Values that are not finite, and a guarantee that the law does not give, are None.
    """

    def rows(name: str) -> NDArray:
        # a contiguous slice of its own, so that sums round alike in every batch
        return np.ascontiguousarray(columns[name][world, : last_row + 1])

    def rms(values: NDArray) -> float:
        return math.sqrt(float(np.mean(values * values)))

    error = rows("error.position")
    robust = rows("decision.robust_input.x"), rows("decision.robust_input.y")
    held = columns.get("guarantee.held")
    # of the commanded yaw rate, or of the right wheel's torque where torque is commanded
    commanded = "decision.yaw_rate" if "decision.yaw_rate" in columns else "wheel.torque_command.right"
    values = {
        "rms_position_error": rms(error),
        "max_position_error": float(error.max()),
        "final_position_error": float(error[-1]),
        "rms_cross_track_error": rms(rows("error.cross_track")),
        "rms_heading_error": rms(rows("error.heading")),
        "rms_robust_input": math.sqrt(float(np.mean(robust[0] ** 2 + robust[1] ** 2))),
        "command_variation": float(np.abs(np.diff(rows(commanded))).sum()),
        "max_slip_ratio": float(rows("slip.ratio").max()),
        "median_slip_ratio": float(np.median(rows("slip.ratio"))),
        "saturation_fraction": float(rows("decision.saturated").mean()),
        "guarantee_fraction": None
        if held is None or last_row == 0
        else float(np.ascontiguousarray(held[world, :last_row]).mean()),
        "min_forward_speed": float(rows("motion.forward_speed").min()),
    }
    return {
        name: value if value is not None and math.isfinite(value) else None for name, value in values.items()
    }
