"""Worlds that were set aside, as they had ended the processes that simulated them, tried once more.

Out of memory, somebody killed the worker: the machine may be to blame. What a run raises itself it raises
again, and is not tried again.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from itertools import groupby, pairwise
from operator import itemgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from slipctl.experiment.chunk import Output, ended_its_process
from slipctl.experiment.errors import ResumeError, StorageError
from slipctl.experiment.folder import MANIFEST, METRICS, SIGNALS, OutputError
from slipctl.experiment.plan import Chunk, Plan
from slipctl.experiment.rows import FAILURE, joined, run_table
from slipctl.experiment.store import Store, plan_of, set_aside_of

if TYPE_CHECKING:
    import pyarrow as pa

OTHERS = "its runs are not those of the plan, in order"
"""Said of results that belong to something else."""


def plan_to_retry(folder: Path) -> dict[str, Any] | None:
    """Return the plan of a finished run folder in which worlds were set aside; None for any other folder.

    Raises
    ------
    ResumeError
        Where its manifest or its plan cannot be read.
    """
    return plan_of(folder) if set_aside_of(folder) else None


def copied(folder: Path, content: dict[str, Any], plan: Plan) -> Store:
    """Make an unfinished folder beside a finished one, with a chunk of each of its: nothing is changed there.

    Parameters
    ----------
    folder : pathlib.Path
        A run folder.
    content, plan
        Its plan, as of `plan_to_retry` and as read.

    Raises
    ------
    ResumeError
        Where results of it are not there, or damaged.
    OutputError
        Where nothing can be written beside it.
    StorageError
        Where there is no room. Nothing is left then.
    """
    refused, beside = f"{folder} cannot be copied to be gone on with", folder.resolve().parent
    try:
        store = Store.create(beside, plan.scenario.name, content)
    except OutputError as error:
        reason = getattr(error.__cause__, "strerror", None) or error
        raise OutputError(
            f"{refused}: nothing can be written into {beside} ({reason}); "
            "copy the run folder to where that is allowed, and name the copy"
        ) from error
    try:
        rows = _rows(folder, plan)
        parts = groupby(_signals(folder, plan), key=itemgetter(0))
        index, tables = next(parts, (None, iter(())))
        count, first = len(plan.entrants), 0
        for chunk in plan.chunks():
            kept: list[pa.Table] = []
            if index == chunk.index:
                kept = [table for _, table in tables]
                index, tables = next(parts, (None, iter(())))
            length = len(chunk.worlds) * count
            store.keep(Output(chunk, rows.slice(first, length), tuple(kept)))
            first += length
        if index is not None:
            raise ResumeError(f"{folder / SIGNALS} cannot be read: {OTHERS}")
    except StorageError as error:
        store.discard()
        reason = str(error).splitlines()[0].split(";")[0]
        raise StorageError(f"{refused}: {reason}; it is as it was") from error
    except ResumeError as error:
        store.discard()
        raise ResumeError(f"{refused}: {error}") from error
    except BaseException:
        store.discard()
        raise
    return store


def set_aside(kept: Iterable[Chunk], store: Store) -> Iterator[Chunk]:
    """Yield the worlds of each kept chunk that were set aside, as a piece of it."""
    for chunk in kept:
        table = store.metrics(chunk)
        if table is None:
            continue
        failures = table[FAILURE].to_pylist()
        ended = {
            world
            for world, failure in zip(table["world"].to_pylist(), failures, strict=True)
            if ended_its_process(failure)
        }
        if ended:
            yield Chunk(chunk.index, sorted(ended))


def put_in(plan: Plan, store: Store, again: Output) -> bool:
    """Put what came of worlds that were tried again in the place of what was said of them.

    Returns
    -------
    bool
        Whether one of them no longer ended its process.
    """
    import pyarrow as pa

    place = again.chunk.index * plan.chunk_worlds
    chunk = Chunk(again.chunk.index, plan.worlds[place : place + plan.chunk_worlds])
    before = store.metrics(chunk)
    assert before is not None, "it was read to know which worlds to try again"
    others = before.filter(pa.array(~np.isin(before["world"].to_numpy(), again.chunk.worlds)))
    assert others.num_rows + again.metrics.num_rows == before.num_rows
    metrics = joined([others, again.metrics]).sort_by("run")
    # they had no signals, so that those there are stay
    tables = [*store.signals(chunk, mapped=False), *again.signals]
    signals = sorted((run for table in tables for run in _runs(table)), key=itemgetter(0))
    store.keep(Output(chunk, metrics, tuple(table for _, table in signals)))
    return not all(map(ended_its_process, again.metrics[FAILURE].to_pylist()))


def _runs(table: pa.Table) -> Iterator[tuple[int, pa.Table]]:
    """Yield the signals of every run in a table with its index."""
    runs = table["run"].to_numpy()
    for first, end in pairwise([0, *(np.flatnonzero(np.diff(runs)) + 1).tolist(), len(runs)]):
        yield int(runs[first]), table.slice(first, end - first)


@contextmanager
def _reading(path: Path) -> Iterator[None]:
    """Say of what is raised that a file of the results is not as it was."""
    import pyarrow as pa

    try:
        yield
    except (OSError, ValueError, KeyError, TypeError, pa.ArrowException) as error:
        what = error if path.is_file() else "there is none"
        raise ResumeError(f"{path} cannot be read: {what}") from error


def _rows(folder: Path, plan: Plan) -> pa.Table:
    """Return the rows of metrics of a run folder as they are kept with chunks."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    with _reading(folder / MANIFEST):
        manifest = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
        said = {(entry["world"], entry["controller"]): entry["failure"] for entry in manifest["failures"]}
    count = len(plan.entrants)
    numbers = (np.asarray(plan.worlds)[:, None] * count + np.arange(count)).ravel()
    with _reading(folder / METRICS):
        table = pq.read_table(folder / METRICS)
        if not np.array_equal(table["run"].to_numpy(), numbers):
            raise ValueError(OTHERS)
    runs = zip(table["world"].to_pylist(), table["controller"].to_pylist(), strict=True)
    schema = run_table([], plan.grid).schema
    failures = pa.array([said.get(run) for run in runs], pa.string())
    return table.append_column(schema.field(FAILURE), failures).select(schema.names).cast(schema)


def _signals(folder: Path, plan: Plan) -> Iterator[tuple[int, pa.Table]]:
    """Yield the signals of a run folder in order, each with the index of the chunk that they belong to."""
    import pyarrow.parquet as pq

    if plan.signals == "none":
        return
    worlds, count = np.asarray(plan.worlds), len(plan.entrants)
    with _reading(folder / SIGNALS), pq.ParquetFile(folder / SIGNALS) as file:
        for group in range(file.num_row_groups):
            table = file.read_row_group(group)
            places = np.searchsorted(worlds, table["run"].to_numpy() // count)
            chunks = places // plan.chunk_worlds
            cuts = [0, *(np.flatnonzero(np.diff(chunks)) + 1).tolist(), len(chunks)]
            for first, end in pairwise(cuts):
                yield int(chunks[first]), table.slice(first, end - first)
