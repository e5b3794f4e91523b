"""Where the recorded runs drove: thinned tracks beside a baseline, for looking at side by side."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from pathlib import Path
from typing import IO, TYPE_CHECKING

import numpy as np

from slipctl.experiment import durable

if TYPE_CHECKING:
    import pyarrow as pa

    from slipctl.experiment import Result

ROWS = 200
"""A track has at most so many rows, and the last one."""

SIGNALS = (
    "time",
    "motion.position.x",
    "motion.position.y",
    "motion.heading",
    "error.position",
    "error.cross_track",
)
"""Columns of `signals.parquet` that are kept, under their names."""


def tracks_file(baseline: Path) -> Path:
    """Say where the tracks of a baseline lie: beside it."""
    return baseline.with_name(f"{baseline.stem}.tracks.parquet")


def ticks_of_runs(result: Result) -> list[int]:
    """Return the number of ticks that each run of a result lasted, in the order of its runs."""
    _, rows = np.unique(result.signals["run"].to_numpy(), return_counts=True)
    return [int(count) - 1 for count in rows]


def write_tracks(result: Result, path: Path, about: Mapping[str, str]) -> None:
    """Write the thinned tracks of every run, one row group per run, beside the place and rename.

    Parameters
    ----------
    result : Result
    path : pathlib.Path
    about : mapping of str to str
        Written into the file's metadata, so that a reader knows which baseline the tracks belong to.

    Raises
    ------
    OSError
        The folder is not writable.
    """
    import pyarrow.parquet as pq

    rows = result.metrics.to_pylist()
    if not rows:
        return
    tables = (
        _thinned(result.run_signals(row["run"]), row).replace_schema_metadata(dict(about)) for row in rows
    )

    def fill(file: IO[bytes]) -> None:
        first = next(tables)
        with pq.ParquetWriter(file, first.schema, compression="zstd") as writer:
            for table in itertools.chain([first], tables):
                writer.write_table(table, row_group_size=table.num_rows)

    path.parent.mkdir(parents=True, exist_ok=True)
    durable.write(path, fill)


def _thinned(signals: pa.Table, run: Mapping[str, object]) -> pa.Table:
    import pyarrow as pa

    rows = signals.num_rows
    step = max(1, -(-(rows - 1) // ROWS))
    kept = np.append(np.arange(0, rows - 1, step), rows - 1)
    columns: dict[str, pa.Array] = {
        "run": pa.array(np.full(len(kept), run["run"], dtype=np.int32)),
        "controller": pa.array([run["controller"]] * len(kept), pa.string()),
        "world": pa.array(np.full(len(kept), run["world"], dtype=np.int32)),
    }
    for name in SIGNALS:
        columns[name] = pa.array(signals[name].to_numpy()[kept].astype(np.float32))
    units = {name: signals.schema.field(name).metadata for name in SIGNALS}
    fields = [pa.field(name, array.type, metadata=units.get(name)) for name, array in columns.items()]
    return pa.Table.from_arrays(list(columns.values()), schema=pa.schema(fields))
