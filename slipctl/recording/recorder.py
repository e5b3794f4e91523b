"""Rows of a simulation, turned into columns."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from slipctl.recording.signals import SIGNALS, Columns
from slipctl.simulate import Row

ROWS_AT_ONCE = 16384
"""Rows times worlds that the recorder turns at once: what a processor's cache holds of every signal."""


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
    """

    rows: int
    worlds: int
    _slots: list[_Slot] = field(default_factory=list)
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
        for slot in self._slots:
            slot.rows[here] = slot.read(row)
        self._next = k + 1

    def _open(self, row: Row) -> None:
        self._block = min(self.rows, max(8, ROWS_AT_ONCE // self.worlds))
        for signal in SIGNALS:
            value = signal.read(row)
            if value is None:
                continue
            # zeros and not NaN: rows after a world's end are never read
            columns = [np.zeros((self.worlds, self.rows), dtype=value.dtype) for _ in signal.parts]
            self._columns |= {
                signal.name + part: column for part, column in zip(signal.parts, columns, strict=True)
            }
            # in memory one part after the other, each with all worlds
            rows = np.zeros((self._block, *value.T.shape), dtype=value.dtype)
            self._slots.append(
                _Slot(signal.read, np.moveaxis(rows, 1, -1) if value.ndim > 1 else rows, columns)
            )

    def _turn(self) -> None:
        first, count = self._first, self._next - self._first
        for slot in self._slots:
            for part, column in enumerate(slot.columns):
                rows = slot.rows if slot.rows.ndim == 2 else slot.rows[:, :, part]
                column[:, first : first + count] = rows[:count].T
        self._first = self._next

    def columns(self) -> Columns:
        """Return the recorded signals as contiguous (worlds, rows) arrays, by column name."""
        self._turn()
        return dict(self._columns)
