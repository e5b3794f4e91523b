"""The results of many worlds: one paragraph per controller instead of one line per world."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from slipctl.report.table import ON_THE_PATH, number_text, value_text

if TYPE_CHECKING:
    import pyarrow as pa

SHOWN = 200
"""Up to so many worlds, each has a line of its own on the terminal."""

WORST = 5
"""Worlds that are named: those with the largest errors."""


def lines(metrics: pa.Table, varied: tuple[str, ...]) -> Iterator[str]:
    """Yield what is to be said of every controller, then the worlds with the largest errors.

    Parameters
    ----------
    metrics : pyarrow.Table
        One row per run, ordered by world, as of `slipctl.experiment.Result.metrics`.
    varied : tuple of str
        The swept keys.
    """
    labels = np.array(metrics["controller"].to_pylist())
    statuses = np.array(metrics["status"].to_pylist())
    rms = metrics["rms_position_error"].to_numpy()
    largest = metrics["max_position_error"].to_numpy()
    for label in dict.fromkeys(labels.tolist()):
        own = labels == label
        done = own & (statuses == "completed")
        ends = Counter(statuses[own & ~done].tolist())
        early = "".join(f", {count} {status}" for status, count in ends.most_common())
        yield f"{label}: {done.sum():,} of {own.sum():,} runs completed{early}"
        known = done & np.isfinite(rms)
        if known.any():
            middle, high = np.quantile(rms[known], [0.5, 0.95])
            yield (
                f"  of {known.sum():,} completed: RMS error {_mm(middle)} mm in the middle, {_mm(high)} mm "
                f"at most in 95 % of them, {_mm(rms[known].max())} mm at worst; "
                f"{(largest[known] <= ON_THE_PATH).sum():,} stay within {1e3 * ON_THE_PATH:.0f} mm"
            )
    finite = np.where(np.isfinite(largest), largest, -1.0)
    order = [index for index in np.argsort(-finite, kind="stable")[:WORST].tolist() if finite[index] >= 0.0]
    if order:
        yield "largest errors:"
    for row in metrics.take(order).to_pylist():
        where = ", ".join([row["status"], *(f"{key} {value_text(row[key])}" for key in varied)])
        error = _mm(row["max_position_error"])
        yield f"  world {row['world']}, {row['controller']}: {error} mm ({where})"


def _mm(metres: float) -> str:
    return number_text(1e3 * float(metres))
