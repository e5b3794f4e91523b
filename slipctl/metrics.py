"""From a recording to one row of numbers per run."""

from __future__ import annotations

import math
from collections.abc import Sequence

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
    """Return the metrics of one world over rows 0 … last_row; see `measure_worlds`."""
    alone = {name: values[world : world + 1] for name, values in columns.items()}
    return measure_worlds(alone, [last_row])[0]


def measure_worlds(columns: Columns, last_rows: Sequence[int]) -> list[dict[str, float | None]]:
    """Return the metrics of every world over rows 0 … last_row, whatever the company.

    Parameters
    ----------
    columns : dict of (N, T) arrays
    last_rows : sequence of int
        The last row that counts, of every world.

    Returns
    -------
    list of dict
        Keys of `UNITS`. Values that are not finite, and a guarantee that the law does not give, are None.
    """
    medians = np.empty(len(last_rows))
    for last in set(last_rows):
        ending = [world for world, row in enumerate(last_rows) if row == last]
        medians[ending] = _medians(columns["slip.ratio"][ending, : last + 1])
    return [
        _measured(columns, world, last, float(median))
        for world, (last, median) in enumerate(zip(last_rows, medians, strict=True))
    ]


def _medians(rows: NDArray) -> NDArray:
    """Return the median of every row, NaN where the row has one; sorting takes a third of `np.median`."""
    ordered = np.sort(rows)
    middle = rows.shape[1] // 2
    medians = ordered[:, middle]
    if rows.shape[1] % 2 == 0:
        medians = (ordered[:, middle - 1] + medians) / 2.0
    return np.where(np.isnan(ordered[:, -1]), np.nan, medians)  # NaN is sorted to the end


def _measured(columns: Columns, world: int, last_row: int, median_ratio: float) -> dict[str, float | None]:
    count = last_row + 1

    def rows(name: str) -> NDArray:
        return columns[name][world, :count]

    def root_of_mean(squares: NDArray) -> float:
        # one row after the other: sums of many rows at once may round otherwise
        return math.sqrt(float(np.add.reduce(squares)) / count)

    def rms(values: NDArray) -> float:
        return root_of_mean(values * values)

    error = rows("error.position")
    robust = rows("decision.robust_input.x"), rows("decision.robust_input.y")
    held = columns.get("guarantee.held")
    # of the commanded yaw rate, or of the right wheel's torque where torque is commanded
    commanded = rows("decision.yaw_rate" if "decision.yaw_rate" in columns else "wheel.torque_command.right")
    values = {
        "rms_position_error": rms(error),
        "max_position_error": float(error.max()),
        "final_position_error": float(error[-1]),
        "rms_cross_track_error": rms(rows("error.cross_track")),
        "rms_heading_error": rms(rows("error.heading")),
        "rms_robust_input": root_of_mean(robust[0] * robust[0] + robust[1] * robust[1]),
        "command_variation": float(np.add.reduce(np.abs(commanded[1:] - commanded[:-1]))),
        "max_slip_ratio": float(rows("slip.ratio").max()),
        "median_slip_ratio": median_ratio,
        "saturation_fraction": np.count_nonzero(rows("decision.saturated")) / count,
        "guarantee_fraction": None
        if held is None or last_row == 0
        else np.count_nonzero(held[world, :last_row]) / last_row,
        "min_forward_speed": float(rows("motion.forward_speed").min()),
    }
    return {
        name: value if value is not None and math.isfinite(value) else None for name, value in values.items()
    }
