"""The table of metrics: one row per run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from slipctl.experiment.batch import Run
from slipctl.guarantee import METRIC_UNITS
from slipctl.metrics import UNITS
from slipctl.scenario.units import key_unit

if TYPE_CHECKING:
    import pyarrow as pa

    from slipctl.scenario import Grid

FAILURE = "failure"
"""Column that is kept with a chunk: what a run raised. It goes to the manifest, not to `metrics.parquet`."""


def run_table(runs: Sequence[Run], grid: Grid) -> pa.Table:
    """Return one row per run, with units in the field metadata; the last column is `FAILURE`.

    Parameters
    ----------
    runs : sequence of Run
    grid : Grid
        All worlds.
    """
    import pyarrow as pa

    columns: list[tuple[pa.Field, Any]] = []

    def add(name: str, values: list, kind: pa.DataType, unit: str = "1") -> None:
        columns.append((pa.field(name, kind, metadata={"unit": unit}), pa.array(values, type=kind)))

    varied = [grid.varied(run.world) for run in runs]
    seed = grid.scenario.seed
    add("run", [run.index for run in runs], pa.int32())
    add("world", [run.world for run in runs], pa.int32())
    add("controller", [run.label for run in runs], pa.string())
    add("kind", [run.kind for run in runs], pa.string())
    for key in grid.keys:
        if key != "seed":
            add(key, [values[key] for values in varied], pa.float64(), key_unit(grid[0].scenario, key))
    add("seed", [values.get("seed", seed) for values in varied], pa.int64())
    add("status", [run.status for run in runs], pa.string())
    add("end_time", [run.end_time for run in runs], pa.float64(), "s")
    for name, unit in UNITS.items():
        add(name, [run.metrics[name] for run in runs], pa.float64(), unit)
    add("first_violation", [run.guarantee["first_violation"] for run in runs], pa.string())
    for name, unit in METRIC_UNITS.items():
        add(name, [run.guarantee[name] for run in runs], pa.float64(), unit)
    add(FAILURE, [run.failure for run in runs], pa.string())
    return pa.Table.from_arrays(
        [array for _, array in columns], schema=pa.schema([column for column, _ in columns])
    )


def joined(tables: Sequence[pa.Table]) -> pa.Table:
    """Return the rows of all chunks in one piece, so that a file of them has always the same bytes."""
    import pyarrow as pa

    return pa.concat_tables([table.replace_schema_metadata(None) for table in tables]).combine_chunks()


def with_recordings(table: pa.Table, recordings: Mapping[int, str]) -> pa.Table:
    """Return the table of `metrics.parquet`: without what was raised, with the files of the recordings.

    Parameters
    ----------
    table : pyarrow.Table
        As of `run_table`.
    recordings : mapping
        File name of the recording of a world, by world index.
    """
    import pyarrow as pa

    names = pa.array([recordings.get(world) for world in table["world"].to_pylist()], pa.string())
    column = pa.field("recording", pa.string(), metadata={"unit": "1"})
    return table.drop_columns([FAILURE]).append_column(column, names)
