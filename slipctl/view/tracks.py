"""Signals of one run as arrays, and how many of their rows a recording keeps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from slipctl.view.content import RecordingError, RunInfo, short_labels

Array = NDArray[np.float64]

PLOT_RATE = 200.0  # Hz; above it a plot of a minute shows the same and the file grows
SCENE_RATE = 50.0  # Hz; the viewer interpolates nothing, but no eye sees more
TRAIL_PIECES = 250  # per run; every visible piece costs the viewer about 65 µs a frame
REQUIRED = ("motion.position.x", "motion.position.y", "motion.heading")


@dataclass(frozen=True)
class Track:
    """The rows of one run.

    Attributes
    ----------
    info : RunInfo
        Whose rows they are.
    name : str
        What legends and pictures call it.
    table : pyarrow.Table
        The rows, in the order of time.
    time : (T,) array
        [s].
    units : dict of str to str
        Unit of each column as the field's metadata say; missing where they do not.
    """

    info: RunInfo
    name: str
    table: pa.Table
    time: Array
    units: dict[str, str]

    def has(self, *names: str) -> bool:
        """Return whether all the columns exist and hold at least one value each."""
        return all(
            name in self.table.column_names and self.table[name].null_count < len(self.table)
            for name in names
        )

    def values(self, name: str) -> Array:
        """Return a column as a (T,) float array; NaN where it is null, booleans as 0 and 1."""
        return _floats(self.table[name])

    def pair(self, stem: str, ends: tuple[str, str] = ("x", "y")) -> Array:
        """Return two columns ``stem.x`` and ``stem.y`` (or other ends) as a (T, 2) array."""
        return np.stack([self.values(f"{stem}.{end}") for end in ends], axis=1)

    def norm(self, stem: str) -> Array:
        """Return the length of the vector ``stem.x``, ``stem.y``, (T,)."""
        pair = self.pair(stem)
        return np.sqrt(pair[:, 0] * pair[:, 0] + pair[:, 1] * pair[:, 1])


def read_tracks(signals: pa.Table, runs: Sequence[RunInfo]) -> list[Track]:
    """Split the signals of one world into its runs.

    Parameters
    ----------
    signals : pyarrow.Table
        Columns ``run``, ``time`` and whatever was recorded; rows of other runs are ignored.
    runs : sequence of RunInfo
        At least one; labels must be unique.

    Returns
    -------
    list of Track
        In the order of `runs`.

    Raises
    ------
    RecordingError
        No runs, a label twice, a column missing or a run without rows.
    """
    if not runs:
        raise RecordingError("nothing to record: the world has no runs")
    labels = [run.label for run in runs]
    if len(set(labels)) != len(labels):
        raise RecordingError(f"labels must be unique within a world, found {', '.join(labels)}")
    missing = [name for name in ("run", "time", *REQUIRED) if name not in signals.column_names]
    if missing:
        raise RecordingError(f"the signals lack the columns {', '.join(missing)}")
    units = {
        field.name: field.metadata[b"unit"].decode()
        for field in signals.schema
        if field.metadata and b"unit" in field.metadata
    }
    names = short_labels(labels)
    tracks = []
    for run in runs:
        rows = signals.filter(pc.field("run") == run.run)
        if len(rows) == 0:
            raise RecordingError(f"the signals have no rows of run {run.run} ({run.label})")
        tracks.append(Track(run, names[run.label], rows, _floats(rows["time"]), units))
    return tracks


def nanoseconds(time: Array) -> NDArray[np.timedelta64]:
    """Return times [s] as whole nanoseconds, rounded: truncation would put 2 % of them 1 ns low."""
    return np.round(time * 1e9).astype("timedelta64[ns]")


def stride(time: Array, rate: float) -> int:
    """Return the smallest whole stride that keeps at most `rate` rows per second."""
    if len(time) < 2 or time[-1] <= time[0]:
        return 1
    recorded = (len(time) - 1) / float(time[-1] - time[0])
    return max(1, int(np.ceil(recorded / rate - 1e-6)))


def kept(time: Array, step: int) -> NDArray[np.intp]:
    """Return the indices of every `step`-th row and of the last one: how a run ended is never lost."""
    rows = np.arange(0, len(time), step)
    return rows if rows[-1] == len(time) - 1 else np.append(rows, len(time) - 1)


def nice(value: float) -> float:
    """Return the largest of 1, 2, 5 times a power of ten that is not above `value` (> 0)."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(max(step * power for step in (1, 2, 5) if step * power <= value * (1 + 1e-9)))


def _floats(column: pa.ChunkedArray) -> Array:
    if pa.types.is_boolean(column.type):
        column = column.cast(pa.uint8())
    return column.cast(pa.float64()).to_numpy()
