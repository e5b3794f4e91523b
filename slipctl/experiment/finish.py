"""From finished chunks to the run folder: one table of metrics, one of signals, recordings, the manifest."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from slipctl import scenario as files
from slipctl.experiment import certified
from slipctl.experiment.batch import FAILED
from slipctl.experiment.chunk import Setup
from slipctl.experiment.machine import machine, versions
from slipctl.experiment.own import described
from slipctl.experiment.plan import Plan
from slipctl.experiment.rows import FAILURE

if TYPE_CHECKING:
    import pyarrow as pa
    import pyarrow.parquet as pq


def row_groups(plan: Plan, tables: Iterable[pa.Table]) -> Iterator[pa.Table]:
    """Yield what goes into each row group of the signals: as the plan says, however the chunks were cut.

    Parameters
    ----------
    plan : Plan
    tables : iterable of pyarrow.Table
        The signals of one run or of several, in order.
    """
    import pyarrow as pa

    worlds = np.asarray(plan.worlds)
    count, together = len(plan.entrants), plan.runs_per_row_group
    waiting: list[pa.Table] = []
    group = -1
    for table in tables:
        runs = table["run"].to_numpy()
        groups = (np.searchsorted(worlds, runs // count) * count + runs % count) // together
        cuts = [0, *(np.flatnonzero(np.diff(groups)) + 1).tolist(), len(groups)]
        for first, end in pairwise(cuts):
            if waiting and groups[first] != group:
                yield pa.concat_tables(waiting).combine_chunks()
                waiting = []
            group = groups[first]
            waiting.append(table.slice(first, end - first))
    if waiting:
        yield pa.concat_tables(waiting).combine_chunks()


def write_signals(file: IO[bytes], plan: Plan, tables: Iterable[pa.Table]) -> int:
    """Write the signals of all runs as Parquet; return how many rows there were.

    A file without any run, as all failed, has only the columns of time and run.
    """
    import pyarrow as pa

    writer: pq.ParquetWriter | None = None
    rows = 0
    for group in row_groups(plan, tables):
        if writer is None:
            writer = _writer(file, group.schema)
        writer.write_table(group, row_group_size=max(1, group.num_rows))
        rows += group.num_rows
    if writer is None:
        writer = _writer(file, pa.schema([("run", pa.int32()), ("time", pa.float64())]))
    writer.close()
    return rows


def _writer(file: IO[bytes], schema: pa.Schema) -> pq.ParquetWriter:
    import pyarrow as pa
    import pyarrow.parquet as pq

    # No dictionary: measured values hardly ever repeat. Their first bytes do, and splitting brings those
    # together: LZ4 then takes a third less room, and half of the time of zstd. Statistics of the run alone:
    # they are what a reader looks for.
    floats = [field.name for field in schema if field.type == pa.float64()]
    columns: Any = {"use_byte_stream_split": floats, "write_statistics": ["run"]}
    return pq.ParquetWriter(file, schema, compression="lz4", use_dictionary=False, **columns)


def write_metrics(file: IO[bytes], metrics: pa.Table) -> None:
    """Write the table of metrics as Parquet."""
    import pyarrow.parquet as pq

    pq.write_table(metrics, file)


def manifest(setup: Setup, *, resumed: bool = False) -> dict[str, Any]:
    """Return what can be said of an experiment before it runs.

    Parameters
    ----------
    setup : Setup
    resumed : bool
        Whether it goes on with what was begun before: its ``wall_time`` is then that of the last part alone.
    """
    plan, robot = setup.plan, setup.robot
    scenario = plan.scenario
    told = {
        "format": 1,
        "scenario": scenario.name,
        "scenario_id": files.scenario_id(scenario),
        "model_id": robot.model_id,
        "certified": certified.standing(plan.grid[0].scenario),
        "versions": versions(),
        "machine": machine(),
        "worlds": len(plan.worlds),
        "resumed": resumed,
        "controllers": [config.label for config in scenario.controller],
        "scenario_file": files.dump(scenario),
        "scenario_given": files.given(scenario),
    }
    if not isinstance(plan.worlds, range):
        told["only_worlds"] = list(plan.worlds)
    if setup.laws:
        told["own_laws"] = described(setup.laws)
    if robot.notes:
        told["robot_notes"] = list(robot.notes)
    return told


def failures(metrics: pa.Table, keys: Sequence[str]) -> list[dict[str, Any]]:
    """Return which runs failed and what they raised, from a table as of `run_table`."""
    import pyarrow as pa

    failed = [status == FAILED for status in metrics["status"].to_pylist()]
    if not any(failed):
        return []  # to filter, Arrow imports what takes a tenth of a short run
    rows = metrics.filter(pa.array(failed))
    return [
        {
            "world": row["world"],
            "controller": row["controller"],
            "varied": {key: row[key] for key in keys},
            "seed": row["seed"],
            "failure": row[FAILURE],
        }
        for row in rows.to_pylist()
    ]


def statuses(metrics: pa.Table) -> Mapping[str, int]:
    """Return how many runs ended with each status, the most frequent first."""
    return dict(Counter(metrics["status"].to_pylist()).most_common())
