"""Signals of one run as arrays, and how many of their rows a recording keeps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pyarrow as pa
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
        rows = len(self.table)
        return all(self._nulls.get(name, rows) < rows for name in names)

    def values(self, name: str) -> Array:
        """Return a column as a (T,) float array, not to be written to; NaN for null, booleans as 0 and 1."""
        if name not in self._read:
            self._read[name] = _floats(self.table[name])
        return self._read[name]

    def filled(self, name: str) -> NDArray[np.bool_] | None:
        """Return where a column (T,) holds a value; None = everywhere."""
        if self._nulls[name] == 0:
            return None
        return self.table[name].is_valid().to_numpy()

    def pair(self, stem: str, ends: tuple[str, str] = ("x", "y")) -> Array:
        """Return two columns ``stem.x`` and ``stem.y`` (or other ends) as a (T, 2) array."""
        return np.stack([self.values(f"{stem}.{end}") for end in ends], axis=1)

    def norm(self, stem: str) -> Array:
        """Return the length of the vector ``stem.x``, ``stem.y``, (T,)."""
        pair = self.pair(stem)
        return np.sqrt(pair[:, 0] * pair[:, 0] + pair[:, 1] * pair[:, 1])

    # Pictures ask for the same few columns again and again: each is counted and converted once.

    @cached_property
    def _nulls(self) -> dict[str, int]:
        columns = zip(self.table.column_names, self.table.columns, strict=True)
        return {name: column.null_count for name, column in columns}

    @cached_property
    def _read(self) -> dict[str, Array]:
        return {}


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
    names, owners = short_labels(labels), signals["run"].to_numpy()
    tracks = []
    for run in runs:
        rows = rows_of(signals, owners == run.run)
        if len(rows) == 0:
            raise RecordingError(f"the signals have no rows of run {run.run} ({run.label})")
        tracks.append(Track(run, names[run.label], rows, _floats(rows["time"]), units))
    return tracks


def rows_of(table: pa.Table, wanted: NDArray[np.bool_]) -> pa.Table:
    """Return the rows of a table that a mask (T,) wants; nothing is copied where they lie together."""
    places = np.flatnonzero(wanted)
    if len(places) and places[-1] - places[0] + 1 == len(places):
        return table.slice(places[0], len(places))
    return table.filter(pa.array(wanted))


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
    if column.type != pa.float64():
        column = column.cast(pa.float64())
    return column.to_numpy()
