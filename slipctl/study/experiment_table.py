"""The numbers of Section VI as lines for a terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

Row = dict[str, Any]

HEADING = "law                     RMS [95 %]               after 5 s   y 15–20 s   wheels alone"


def text_lines(summary: Sequence[Row], comparison: Sequence[Row]) -> list[str]:
    """Return the medians and comparisons of `slipctl.study.experiment`, in millimetres and degrees.

    Parameters
    ----------
    summary, comparison : sequences of dict
        Of the functions of these names.
    """
    lines: list[str] = []
    settings = dict.fromkeys((row["tick"], row["camera_gain"]) for row in summary)
    for tick, gain in settings:
        own = [row for row in summary if (row["tick"], row["camera_gain"]) == (tick, gain)]
        lines += [f"commands at {1 / tick:g} Hz, a fix corrects {gain:.0%}, {own[0]['runs']} seeds", HEADING]
        lines += [_medians(row) for row in own]
        lines.append(_fixes(own[0]))
        lines += [
            line
            for row in comparison
            if (row["tick"], row["camera_gain"]) == (tick, gain)
            for line in _compared(row)
        ]
        lines.append("")
    return lines


def _medians(row: Row) -> str:
    interval = f"{_mm(row['rms_position_error'])} [{_mm(row['lower'])}, {_mm(row['upper'])}] mm"
    return (
        f"{row['controller']:<18}{interval:>30}{_mm(row['moving_position_error']):>10} mm"
        f"{_mm(row['late_y_error']):>9} mm{_mm(row['odometry_error']):>12} mm"
    )


def _fixes(row: Row) -> str:
    return (
        f"pose error before and after a fix: "
        f"{_mm(row['position_before'])} → {_mm(row['position_after'])} mm, "
        f"{_degrees(row['heading_before'])} → {_degrees(row['heading_after'])}; "
        f"the wheels drift by {_mm(row['drift'])} mm between fixes"
    )


def _compared(row: Row) -> list[str]:
    return [
        f"{row['controller']} less {row['against']}: {_mm(row['rms_difference'], '+')} "
        f"[{_mm(row['lower'], '+')}, {_mm(row['upper'], '+')}] mm RMS, smaller in {_share(row['better'])} of "
        f"the seeds; after 5 s {_mm(row['moving_difference'], '+')} mm, smaller in "
        f"{_share(row['moving_better'])}",
        f"larger in y from 15 to 20 s: {_share(row['counter_example'])} at the same seed, "
        f"{_share(row['counter_example_apart'])} at different seeds, {_share(row['counter_example_seen'])} "
        "as the robots saw it",
    ]


def _mm(metres: float | None, sign: str = "") -> str:
    return "–" if metres is None else f"{1e3 * metres:{sign}.2f}"


def _degrees(radians: float | None) -> str:
    return "–" if radians is None else f"{np.degrees(radians):.2f}°"


def _share(value: float | None) -> str:
    return "–" if value is None else f"{value:.0%}"
