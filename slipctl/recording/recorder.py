"""Rows of a simulation, turned into columns."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from slipctl.recording.signals import SIGNALS, Columns
from slipctl.simulate import Row
from slipctl.tick import Reference

ROWS_AT_ONCE = 16384
"""Rows times worlds that the recorder turns at once: what a processor's cache holds of every signal."""

ROWS_LATER = 16
"""Rows of an engine of which all that no law made is read at once: between two ticks the same takes twice as
long, because the engine leaves nothing of it in the cache. Where there is no engine it is still there."""

AT_ONCE = ("decision.", "sensed.", "wheel.rate_command", "wheel.torque_command")
"""Signals that are read at their tick: a law of one's own might change its arrays afterwards."""


@dataclass(frozen=True)
class _Slot:
    """Where a signal goes: rows as they come, and the columns (worlds, rows) that they become."""

    read: Callable[[Row], NDArray | None]
    rows: NDArray
    columns: list[NDArray]


@dataclass
class Recorder:
    """Collects rows in memory; a simulation's `write`.

    Rows come one after the other and columns hold one world after the other, so rows are turned in blocks.

    Attributes
    ----------
    rows, worlds : int
        Rows including both ends, and worlds.
    planned : Reference or None
        All rows of the plan, arrays (rows, worlds, 2), which need not be collected then.
    """

    rows: int
    worlds: int
    planned: Reference | None = None
    _at_once: list[_Slot] = field(default_factory=list)
    _later: list[_Slot] = field(default_factory=list)
    _waiting: list[Row] = field(default_factory=list)
    _columns: Columns = field(default_factory=dict)
    _block: int = 1
    _first: int = 0
    _next: int = 0

    def write(self, k: int, row: Row) -> None:
        """Keep row `k`; rows come in order."""
        if k == 0:
            self._open(row)
        elif k - self._first == self._block:
            self._turn()
        here = k - self._first
        for slot in self._at_once:
            slot.rows[here] = slot.read(row)
        self._next = k + 1
        if self._later:
            self._waiting.append(row)
            if len(self._waiting) == ROWS_LATER:
                self._catch_up()

    def _open(self, row: Row) -> None:
        engine = row.details is not None
        self._block = min(self.rows, max(8, ROWS_AT_ONCE // self.worlds))
        for signal in SIGNALS:
            value = None if signal.read is None else signal.read(row)
            if signal.read is None or value is None:
                continue
            names = [signal.name + part for part in signal.parts]
            if self.planned is not None and signal.name.startswith("reference."):
                every = np.asarray(signal.read(replace(row, reference=self.planned)))
                parts = [every] if every.ndim == 2 else [every[:, :, part] for part in range(len(names))]
                self._columns |= dict(zip(names, map(_column, parts), strict=True))
                continue
            columns = [np.empty((self.worlds, self.rows), dtype=value.dtype) for _ in names]
            self._columns |= dict(zip(names, columns, strict=True))
            # in memory one part after the other, each with all worlds
            rows = np.zeros((self._block, *value.T.shape), dtype=value.dtype)
            slot = _Slot(signal.read, np.moveaxis(rows, 1, -1) if value.ndim > 1 else rows, columns)
            later = engine and not signal.name.startswith(AT_ONCE)
            (self._later if later else self._at_once).append(slot)

    def _catch_up(self) -> None:
        last = self._next - self._first
        for slot in self._later:
            for here, row in enumerate(self._waiting, last - len(self._waiting)):
                slot.rows[here] = slot.read(row)
        self._waiting.clear()

    def _turn(self) -> None:
        self._catch_up()
        first, count = self._first, self._next - self._first
        for slot in (*self._at_once, *self._later):
            for part, column in enumerate(slot.columns):
                rows = slot.rows if slot.rows.ndim == 2 else slot.rows[:, :, part]
                column[:, first : first + count] = rows[:count].T
        self._first = self._next

    @property
    def written(self) -> int:
        """Number of rows that were kept."""
        return self._next

    def columns(self) -> Columns:
        """Return the recorded signals as (worlds, rows) arrays, by column name."""
        self._turn()
        if self._next < self.rows:  # zeros and not NaN: rows after a world's end are never read
            for slot in (*self._at_once, *self._later):
                for column in slot.columns:
                    column[:, self._next :] = 0
        return dict(self._columns)


def _column(rows: NDArray) -> NDArray:
    """Return rows (rows, worlds) as a column (worlds, rows), kept once where all worlds share it."""
    if rows.strides[1] == 0:
        return np.broadcast_to(np.ascontiguousarray(rows[:, 0]), rows.T.shape)
    return np.ascontiguousarray(rows.T)
