"""What a run of an experiment gives back: two tables, a manifest, and the machine output."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from slipctl.experiment.folder import SIGNALS
from slipctl.experiment.replay import replay_command
from slipctl.guarantee import METRIC_UNITS
from slipctl.metrics import UNITS

if TYPE_CHECKING:
    import pyarrow as pa

ROWS_AT_A_TIME = 1000
"""Rows of metrics that are made into Python objects at a time."""


@dataclass(frozen=True)
class Result:
    """Tables of an experiment.

    Attributes
    ----------
    folder : pathlib.Path or None
        The run folder; None where nothing was written.
    metrics : pyarrow.Table
        One row per run, ordered by world, then controller.
    manifest : dict
        What ran: scenario, identities, versions, machine.
    varied : tuple of str
        The swept keys.
    recording_note, signals_note : str
        How many recordings and which rows of the signals were kept, and why.
    failures : tuple of dict
        Runs with the status ``failed``: ``world``, ``controller``, ``varied``, ``seed`` and ``failure``, what
        was raised.
    interrupted : bool
        Whether Ctrl-C ended it; the tables then hold what had finished. Only where nothing was written.
    """

    folder: Path | None
    metrics: pa.Table
    manifest: dict[str, Any]
    varied: tuple[str, ...]
    recording_note: str
    signals_note: str
    failures: tuple[dict[str, Any], ...] = ()
    interrupted: bool = False
    in_memory: pa.Table | None = field(default=None, repr=False)

    @cached_property
    def signals(self) -> pa.Table:
        """One row per run and tick that is kept; units in the field metadata.

        It is read when it is asked for, all of it; `run_signals` reads one run.
        """
        return self._read(None)

    def run_signals(self, run: int) -> pa.Table:
        """Return the signals of the run with this index.

        Raises
        ------
        KeyError
            Where no signals of such a run were kept.
        """
        rows = self._read(run)
        if not rows.num_rows:
            raise KeyError(f"no signals of a run {run}: there are {self.metrics['run'].to_pylist()}")
        return rows

    def _read(self, run: int | None) -> pa.Table:
        import pyarrow as pa

        if self.in_memory is not None:
            if run is None:
                return self.in_memory
            first, end = np.searchsorted(self.in_memory["run"].to_numpy(), [run, run + 1])  # ascending
            return self.in_memory.slice(first, end - first)
        if self.folder is None or not (self.folder / SIGNALS).is_file():
            return pa.table({"run": pa.array([], pa.int32()), "time": pa.array([], pa.float64())})
        import pyarrow.parquet as pq

        chosen = None if run is None else [("run", "=", run)]
        return pq.read_table(self.folder / SIGNALS, memory_map=True, filters=chosen)

    def json(self) -> dict[str, Any]:
        """Return the machine output of `slipctl run --json`."""
        return {**self.json_head(), "runs": list(self.json_runs())}

    def json_head(self) -> dict[str, Any]:
        """Return the machine output without its runs.

        ``folder`` is the run folder or None. Each of ``failures`` has, beside what `failures` here holds,
        ``replay``: the command that runs its world alone, None where there is no folder.
        """
        folder = self.folder
        return {
            **{key: self.manifest[key] for key in ("scenario", "scenario_id", "model_id", "versions")},
            "folder": None if folder is None else folder.as_posix(),
            "failures": [
                {**failed, "replay": None if folder is None else replay_command(folder, failed["world"])}
                for failed in self.failures
            ],
        }

    def json_runs(self) -> Iterator[dict[str, Any]]:
        """Yield the runs of the machine output: many of them never stand in memory together."""
        for batch in self.metrics.to_batches(max_chunksize=ROWS_AT_A_TIME):
            for row in batch.to_pylist():
                recording = row["recording"]
                if recording is not None and self.folder is not None:
                    recording = (self.folder / recording).as_posix()
                yield {
                    "controller": row["controller"],
                    "varied": {key: row[key] for key in self.varied},
                    "seed": row["seed"],
                    "status": row["status"],
                    "metrics": {name: row[name] for name in UNITS},
                    "guarantee": {name: row[name] for name in ("first_violation", *METRIC_UNITS)},
                    "recording": recording,
                }
