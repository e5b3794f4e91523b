"""What a run of an experiment gives back: two tables, a manifest, and the machine output."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from slipctl.experiment.batch import Run
from slipctl.guarantee import METRIC_UNITS
from slipctl.metrics import UNITS
from slipctl.scenario.units import key_unit

if TYPE_CHECKING:
    import pyarrow as pa

    from slipctl.scenario import World


@dataclass(frozen=True)
class Result:
    """Tables of an experiment.

    Attributes
    ----------
    folder : pathlib.Path or None
        The run folder; None where nothing was written.
    metrics : pyarrow.Table
        One row per run, ordered by world, then controller.
    signals : pyarrow.Table
        One row per run and tick; units in the field metadata. Memory-mapped where a folder was written.
    manifest : dict
        What ran: scenario, identities, versions, machine.
    varied : tuple of str
        The swept keys.
    recording_note : str
        How many recordings were written, and why.
    interrupted : bool
        Whether Ctrl-C ended it; the tables then hold what had finished.
    """

    folder: Path | None
    metrics: pa.Table
    signals: pa.Table
    manifest: dict[str, Any]
    varied: tuple[str, ...]
    recording_note: str
    interrupted: bool

    def run_signals(self, run: int) -> pa.Table:
        """Return the signals of the run with this index.

        Raises
        ------
        KeyError
            Where no such run finished.
        """
        runs = self.signals["run"].to_numpy()  # ascending
        first, end = np.searchsorted(runs, [run, run + 1])
        if first == end:
            raise KeyError(f"no run {run}: there are {self.metrics['run'].to_pylist()}")
        return self.signals.slice(first, end - first)

    def json(self) -> dict[str, Any]:
        """Return the machine output of `slipctl run --json`."""
        runs = []
        for row in self.metrics.to_pylist():
            recording = row["recording"]
            if recording is not None and self.folder is not None:
                recording = (self.folder / recording).as_posix()
            runs.append(
                {
                    "controller": row["controller"],
                    "varied": {key: row[key] for key in self.varied},
                    "seed": row["seed"],
                    "status": row["status"],
                    "metrics": {name: row[name] for name in UNITS},
                    "guarantee": {name: row[name] for name in ("first_violation", *METRIC_UNITS)},
                    "recording": recording,
                }
            )
        return {key: self.manifest[key] for key in ("scenario", "scenario_id", "model_id", "versions")} | {
            "runs": runs
        }


def metrics_table(runs: Sequence[Run], worlds: Sequence[World], recordings: dict[int, str]) -> pa.Table:
    """Return one row per run, with units in the field metadata.

    Parameters
    ----------
    runs : sequence of Run
    worlds : sequence of World
        All worlds in grid order.
    recordings : dict
        File name of the recording of a world, by world index.
    """
    import pyarrow as pa

    runs = sorted(runs, key=lambda run: run.index)
    columns: list[tuple[pa.Field, Any]] = []

    def add(name: str, values: list, kind: pa.DataType | None = None, unit: str = "1") -> None:
        array = pa.array(values, type=kind)
        columns.append((pa.field(name, array.type, metadata={"unit": unit}), array))

    add("run", [run.index for run in runs], pa.int32())
    add("world", [run.world for run in runs], pa.int32())
    add("controller", [run.label for run in runs], pa.string())
    add("kind", [run.kind for run in runs], pa.string())
    for key in varied_keys(worlds):
        if key != "seed":
            add(key, [worlds[run.world].varied[key] for run in runs], unit=key_unit(worlds[0].scenario, key))
    add("seed", [worlds[run.world].seed for run in runs], pa.int64())
    add("status", [run.status for run in runs], pa.string())
    add("end_time", [run.end_time for run in runs], pa.float64(), "s")
    for name, unit in UNITS.items():
        add(name, [run.metrics[name] for run in runs], pa.float64(), unit)
    add("first_violation", [run.guarantee["first_violation"] for run in runs], pa.string())
    for name, unit in METRIC_UNITS.items():
        add(name, [run.guarantee[name] for run in runs], pa.float64(), unit)
    add("recording", [recordings.get(run.world) for run in runs], pa.string())
    return pa.Table.from_arrays(
        [array for _, array in columns], schema=pa.schema([column for column, _ in columns])
    )


def varied_keys(worlds: Sequence[World]) -> tuple[str, ...]:
    """Return the swept keys, in the order of the file."""
    return tuple(worlds[0].varied)


def write_json(path: Path, value: dict[str, Any]) -> None:
    """Write an object as indented UTF-8 JSON; not-a-number is an error."""
    text = json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False)
    path.write_text(text + "\n", encoding="utf-8", newline="\n")
