"""The end of an experiment: from chunks, on disk or in memory, to its result."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

from slipctl.experiment import durable, finish
from slipctl.experiment.chunk import Output, Setup, simulate_chunk
from slipctl.experiment.chunkfiles import resume_command, storage_error
from slipctl.experiment.errors import StorageError
from slipctl.experiment.folder import MANIFEST, METRICS, SIGNALS
from slipctl.experiment.plan import canonical_json
from slipctl.experiment.record import record_worlds, worlds_to_record
from slipctl.experiment.result import Result
from slipctl.experiment.rows import joined, with_recordings
from slipctl.experiment.store import Store

if TYPE_CHECKING:
    import pyarrow as pa

REPLAYED = "replayed.parquet"
"""Every row of the worlds to record, where the signals do not hold them; removed afterwards."""


def conclude(setup: Setup, manifest: dict[str, Any], store: Store, began: float) -> Result:
    """Put the results of all chunks beside them, and turn the unfinished folder into the run folder.

    Parameters
    ----------
    setup : Setup
    manifest : dict
        As of `slipctl.experiment.finish.manifest`.
    store : Store
        Holds every chunk.
    began : float
        `time.monotonic` of the beginning.
    """
    plan, folder = setup.plan, store.folder
    metrics = joined(list(_metrics(setup, store)))
    if plan.signals != "none":
        store.put(SIGNALS, lambda file: finish.write_signals(file, plan, _signals(setup, store)))
    chosen, note = worlds_to_record(plan.record, metrics)
    # a first time without recordings, so that the numbers are there whatever becomes of these
    store.put(METRICS, lambda file: finish.write_metrics(file, with_recordings(metrics, {})))
    try:
        recordings = _record(setup, store, chosen, metrics, manifest)
    except StorageError:
        raise  # room can be made, and then they are written by whoever goes on
    except Exception as error:
        if isinstance(error, OSError) and error.errno in durable.FULL:
            raise storage_error(folder, error) from error
        # they are a view of the results, which are whole without: what was lacking is said, not lost
        recordings = {}
        note = f"no recordings: writing them failed ({type(error).__name__}: {error})"
        print(note, file=sys.stderr)
        _remove_recordings(store)
    failed = finish.failures(metrics, plan.grid.keys)
    metrics = with_recordings(metrics, recordings)
    if recordings:
        store.put(METRICS, lambda file: finish.write_metrics(file, metrics))
    told = manifest | {
        "runs": metrics.num_rows,
        "interrupted": False,
        "recordings": note,
        "signals": plan.signals_note,
        "statuses": dict(finish.statuses(metrics)),
        "failures": failed,
        "finished": datetime.now(UTC).isoformat(timespec="seconds"),
        "wall_time": round(time.monotonic() - began, 3),
    }
    store.put(MANIFEST, lambda file: file.write(canonical_json(told).encode()))
    target = store.publish(folder.parent, plan.scenario.name)
    return Result(target, metrics, told, plan.grid.keys, note, plan.signals_note, tuple(failed))


def in_memory(setup: Setup, manifest: dict[str, Any], outputs: Sequence[Output], interrupted: bool) -> Result:
    """Return the result of chunks that are in memory."""
    import pyarrow as pa

    plan = setup.plan
    metrics = joined([output.metrics for output in outputs])
    tables = [table for output in outputs for table in output.signals]
    failed = finish.failures(metrics, plan.grid.keys)
    return Result(
        folder=None,
        metrics=with_recordings(metrics, {}),
        manifest=manifest,
        varied=plan.grid.keys,
        recording_note="no recordings: nothing was written to disk",
        signals_note=plan.signals_note,
        failures=tuple(failed),
        interrupted=interrupted,
        in_memory=pa.concat_tables(tables) if tables else None,
    )


def _metrics(setup: Setup, store: Store) -> Iterator[pa.Table]:
    for chunk in setup.plan.chunks():
        table = store.metrics(chunk)
        if table is None:
            raise StorageError(
                f"chunk {chunk.index} of {store.folder} cannot be read any more; "
                f"go on: {resume_command(store.folder)}"
            )
        yield table


def _signals(setup: Setup, store: Store) -> Iterator[pa.Table]:
    for chunk in setup.plan.chunks():
        yield from store.signals(chunk)


def _remove_recordings(store: Store) -> None:
    for left in store.folder.glob("*.rrd"):
        left.unlink(missing_ok=True)


def _record(
    setup: Setup, store: Store, chosen: Sequence[int], metrics: pa.Table, manifest: dict[str, Any]
) -> dict[int, str]:
    _remove_recordings(store)  # of an end that was itself interrupted
    if not chosen:
        return {}
    source = store.folder / SIGNALS
    if setup.plan.signals != "all":
        source = store.folder / REPLAYED
        store.put(REPLAYED, lambda file: _replay(file, setup, chosen))
    try:
        return record_worlds(store.folder, source, chosen, metrics, setup, manifest)
    finally:
        (store.folder / REPLAYED).unlink(missing_ok=True)


def _replay(file: Any, setup: Setup, chosen: Sequence[int]) -> None:
    """Simulate some worlds again, which gives the same numbers, and write every row of them."""
    # few at a time: every row of a chunk is in memory
    plan = replace(setup.plan, worlds=tuple(chosen), signals="all", chunk_worlds=8)
    again = replace(setup, plan=plan)

    def tables() -> Iterator[pa.Table]:
        for chunk in plan.chunks():
            yield from simulate_chunk(again, chunk, silent=True).signals

    finish.write_signals(file, plan, tables())
