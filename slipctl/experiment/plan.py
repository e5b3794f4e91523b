"""What an experiment will do, decided before its first tick: worlds, chunks and what is kept of each run."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipctl import scenario as files
from slipctl.experiment import assemble
from slipctl.experiment.own import KIND, OwnLaws

LARGEST_CHUNK = 512
"""Most worlds of a chunk. They share a batch where they are alike, and the more do, the less each costs."""

ROWS_IN_MEMORY = 1_000_000
"""Rows of signals that all processes of a machine together hold at a time: about 1 GB."""

ALL_ROWS = 10_000_000
"""Up to so many rows of all runs together, all are kept unless told otherwise: about 5 GB on disk."""

SAMPLES = 50
"""Intervals into which a run is divided where its signals are sampled."""

GROUP_ROWS = 20_000
"""Rows that a row group of the signals has about: fewer cost time for every column, more cost whoever reads
one run."""

ROW_GROUPS = 1_000
"""About so many row groups the signals have at most: each takes 0.1 MB of memory while it is written."""

CHUNKS_PER_WORKER = 4
"""At least so many chunks for every worker, so that none is idle for long at the end."""

SIGNALS = ("auto", "none", "sampled", "all")


class SignalsChoiceError(Exception):
    """The choice of signals cannot be understood."""


@dataclass(frozen=True)
class Chunk:
    """Worlds that are simulated, put on disk and lost together.

    Attributes
    ----------
    index : int
        Place in the plan.
    worlds : sequence of int
        Indices in grid order.
    """

    index: int
    worlds: Sequence[int]


@dataclass(frozen=True)
class Plan:
    """What an experiment will do. Results depend on none of it but scenario, worlds, record and signals.

    Attributes
    ----------
    scenario : Scenario
    entrants : tuple of (str, str)
        Label and kind of every controller, in the order of the runs of a world.
    worlds : sequence of int
        Indices of the worlds to simulate, ascending.
    record : str
        As for `slipctl.experiment.run`.
    signals : str
        ``all``, ``sampled`` or ``none``.
    signals_note : str
        A sentence on what is kept, and why.
    chunk_worlds : int
        Worlds of a chunk.
    keep_going : bool
        Whether a run whose simulation raises is given the status ``failed``, or ends the experiment.
    keep_failed_rows : bool
        Whether such a run keeps the rows before; one that has any then ends no experiment.
    """

    scenario: files.Scenario
    entrants: tuple[tuple[str, str], ...]
    worlds: Sequence[int]
    record: str
    signals: str
    signals_note: str
    chunk_worlds: int
    keep_going: bool
    keep_failed_rows: bool = False

    @cached_property
    def grid(self) -> files.Grid:
        """All worlds of the scenario."""
        return files.worlds(self.scenario)

    @cached_property
    def ticks(self) -> NDArray[np.int64]:
        """Ticks of every world to simulate, in the order of `worlds`."""
        return _ticks(self.grid, self.worlds)

    @property
    def run_count(self) -> int:
        """Number of runs: worlds times controllers."""
        return len(self.worlds) * len(self.entrants)

    @property
    def runs_per_row_group(self) -> int:
        """Runs that share a row group of the signals."""
        rows = (int(self.ticks.max()) if self.signals == "all" else SAMPLES) + 1
        wanted = max(GROUP_ROWS // rows, -(-self.run_count // ROW_GROUPS))
        return max(1, min(wanted, ROWS_IN_MEMORY // 2 // rows))

    def chunks(self) -> Iterator[Chunk]:
        """Yield all chunks in order."""
        for index, first in enumerate(range(0, len(self.worlds), self.chunk_worlds)):
            yield Chunk(index, self.worlds[first : first + self.chunk_worlds])

    def steps(self, chunk: Chunk) -> int:
        """Return the ticks of all runs of a chunk, or of some worlds of it."""
        whole = slice(chunk.index * self.chunk_worlds, (chunk.index + 1) * self.chunk_worlds)
        ticks = self.ticks[whole]
        if len(chunk.worlds) < len(ticks):
            ticks = ticks[np.isin(self.worlds[whole], chunk.worlds)]
        return int(ticks.sum()) * len(self.entrants)

    def json(self) -> dict[str, Any]:
        """Return what `read_plan` makes the same plan of, as JSON-able values."""
        everything = isinstance(self.worlds, range)
        return {
            "scenario_given": files.given(self.scenario),
            "record": self.record,
            "signals": self.signals,
            "signals_note": self.signals_note,
            "chunk_worlds": self.chunk_worlds,
            "keep_going": self.keep_going,
            "keep_failed_rows": self.keep_failed_rows,
            "worlds": None if everything else list(self.worlds),
        }


def read_plan(content: Mapping[str, Any]) -> Plan:
    """Make the plan that `Plan.json` wrote; own laws have none.

    Raises
    ------
    KeyError, TypeError, pydantic.ValidationError
        Where it is none.
    """
    scenario = files.reread(content["scenario_given"])
    chosen = content["worlds"]
    return Plan(
        scenario=scenario,
        entrants=entrants(scenario, {}),
        worlds=range(len(files.worlds(scenario))) if chosen is None else tuple(chosen),
        record=content["record"],
        signals=content["signals"],
        signals_note=content["signals_note"],
        chunk_worlds=content["chunk_worlds"],
        keep_going=content["keep_going"],
        keep_failed_rows=content["keep_failed_rows"],
    )


def make_plan(
    scenario: files.Scenario,
    laws: OwnLaws,
    *,
    record: str,
    signals: str,
    worlds: Sequence[int] | None,
    keep_going: bool,
    workers: int,
    keep_failed_rows: bool = False,
) -> Plan:
    """Decide what an experiment will do.

    Parameters
    ----------
    scenario, laws, record, signals, worlds, keep_going, workers, keep_failed_rows
        As for `slipctl.experiment.run`.

    Raises
    ------
    SignalsChoiceError
        Where `signals` is no choice.
    slipctl.scenario.ScenarioError
        Where the grid has no such world.
    """
    check_signals(signals)
    grid = files.worlds(scenario)
    chosen = range(len(grid)) if worlds is None else _existing(worlds, grid)
    names = entrants(scenario, laws)
    ticks = _ticks(grid, chosen)
    kept, note = _kept(signals, int((ticks + 1).sum()) * len(names))
    rows = (int(ticks.max()) + 1) * (len(names) if kept == "all" else 1)
    largest = max(1, min(LARGEST_CHUNK, ROWS_IN_MEMORY // workers // rows))
    if workers > 1:
        fair = -(-len(chosen) // (CHUNKS_PER_WORKER * workers))
        largest = min(largest, max(fair, 1))
    return Plan(scenario, names, chosen, record, kept, note, largest, keep_going, keep_failed_rows)


def check_signals(signals: str) -> None:
    """Refuse what is no choice of signals.

    Raises
    ------
    SignalsChoiceError
        Always then.
    """
    if signals not in SIGNALS:
        raise SignalsChoiceError(f"signals: found {signals!r}, allowed are {', '.join(SIGNALS)}")


def entrants(scenario: files.Scenario, laws: OwnLaws) -> tuple[tuple[str, str], ...]:
    """Return label and kind of every controller: the listed ones, then the own ones."""
    listed = [(config.label, config.kind) for config in scenario.controller]
    return (*listed, *((label, KIND) for label in laws))


def sampled_rows(ticks: int, last_row: int) -> list[int]:
    """Return the rows that are kept of a run where its signals are sampled: evenly spaced, and the last.

    Parameters
    ----------
    ticks : int
        Of the whole run; the spacing follows from it.
    last_row : int
        The last row that counts.
    """
    rows = list(range(0, last_row + 1, max(1, -(-ticks // SAMPLES))))
    return rows if rows[-1] == last_row else [*rows, last_row]


def _existing(worlds: Sequence[int], grid: files.Grid) -> tuple[int, ...]:
    missing = [world for world in worlds if not 0 <= world < len(grid)]
    if missing or not worlds:
        found = f"world {missing[0]}" if missing else "no world"
        allowed = f"0 to {len(grid) - 1}: the scenario has {len(grid)} worlds"
        raise files.ScenarioError(grid.scenario.name, [files.Problem("", found, allowed)])
    return tuple(sorted(set(worlds)))


def _kept(signals: str, rows: int) -> tuple[str, str]:
    if signals == "none":
        return "none", "no signals: told so by signals none"
    if signals == "all" or (signals == "auto" and rows <= ALL_ROWS):
        return "all", "signals: every row of every run"
    note = f"signals: at most {SAMPLES + 1} rows of each run"
    if signals == "auto":
        note += f", as all {rows:,} rows are more than {ALL_ROWS:,} (all of them with signals all)"
    return "sampled", note


def _ticks(grid: files.Grid, worlds: Sequence[int]) -> NDArray[np.int64]:
    # only these keys decide how long a run is, so that not every world has to be made to know it
    keys = [key for key in grid.keys if key in ("tick", "duration") or key.startswith("reference.")]
    known: dict[tuple[float, ...], int] = {}

    def ticks(index: int) -> int:
        varied = grid.varied(index) if keys else {}
        values = tuple(varied[key] for key in keys)
        if values not in known:
            known[values] = assemble.tick_count(grid[index].scenario)
        return known[values]

    return np.fromiter((ticks(index) for index in worlds), dtype=np.int64, count=len(worlds))


def canonical_json(value: Mapping[str, Any]) -> str:
    """Write an object as indented JSON text; not-a-number is an error."""
    return json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
