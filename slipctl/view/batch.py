"""Many recordings: in this process while they are few, in recycled worker processes beyond."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Generator, Sequence
from contextlib import ExitStack, closing
from itertools import repeat
from math import inf
from pathlib import Path
from typing import IO, Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from slipctl.shape import Shape
from slipctl.view.content import RecordingError, RunInfo, Theorem, WorldRecording, part_of
from slipctl.view.tracks import rows_of

IN_PROCESS = 24
"""Worlds that the caller's process writes: every recording keeps four threads and some 6 MB until it ends."""

PER_WORKER = 64
"""Worlds per worker process, which can end half of the threads."""

Progress = Callable[[int, int], None]


def write_all(
    folder: Path,
    signals: pa.Table | Path,
    worlds: Sequence[WorldRecording],
    shapes: Sequence[Shape] | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
) -> list[Path]:
    """Write one recording per world into a folder.

    Parameters
    ----------
    folder : Path
        Where ``world.file`` is written.
    signals : pyarrow.Table or Path
        The signals of all runs, or the Parquet file that holds them (then only the row groups of one world
        are in memory at a time; each is read once where the worlds come in the order of their runs).
    worlds : sequence of WorldRecording
        What to write.
    shapes : sequence of Shape or None
        The robot's shapes; None = a plain disc robot.
    threads : int or None
        Worker processes at a time, used beyond 24 worlds; None = the machine's cores, at most 4.
    progress : callable or None
        Called with recordings done and recordings in all.

    Returns
    -------
    list of Path
        In the order of `worlds`.

    Raises
    ------
    RecordingError
        A recording could not be written; those written before remain.
    """
    tell = progress or (lambda done, total: None)
    if len(worlds) <= IN_PROCESS:
        return _write_here(folder, signals, worlds, shapes, tell)
    workers = threads or min(os.cpu_count() or 1, 4)
    on_disk = isinstance(signals, Path)
    # a killed process leaves these: not among results, but where there is room if they hold the signals
    with tempfile.TemporaryDirectory(prefix=".view-", dir=None if on_disk else folder) as scratch:
        source = signals if on_disk else Path(scratch) / "signals.parquet"
        if not on_disk:
            rows = max(1, len(signals) // sum(len(world.runs) for world in worlds))
            pq.write_table(signals, source, row_group_size=rows)
        jobs = []
        count = min(PER_WORKER, -(-len(worlds) // workers))
        for start in range(0, len(worlds), count):
            some, job = worlds[start : start + count], Path(scratch) / f"job-{start}.json"
            job.write_text(_encode(folder, source, some, shapes), encoding="utf-8")
            jobs.append((job, len(some)))
        try:
            _work(jobs, workers, tell, len(worlds))
        except BaseException:
            for world in worlds:  # a worker that was stopped had no time to
                part_of(folder / world.file).unlink(missing_ok=True)
            raise
    return [folder / world.file for world in worlds]


def run_job(job: Path) -> None:
    """Write the recordings of a job file; what a worker process does."""
    content = json.loads(job.read_text(encoding="utf-8"))
    shapes = content["shapes"]
    worlds = [
        WorldRecording(world["file"], tuple(_run(run) for run in world["runs"]), world["info"])
        for world in content["worlds"]
    ]
    _write_here(
        Path(content["folder"]),
        Path(content["signals"]),
        worlds,
        None if shapes is None else [_shape(shape) for shape in shapes],
        _end_some_threads,
    )


def _end_some_threads(done: int, total: int) -> None:
    from slipctl.view.recording import end_threads

    if done % 16 == 0:
        end_threads()


def _run(content: dict[str, Any]) -> RunInfo:
    if content["theorem"] is not None:
        content["theorem"] = Theorem(**content["theorem"])
    return RunInfo(**content)


def _write_here(
    folder: Path,
    signals: pa.Table | Path,
    worlds: Sequence[WorldRecording],
    shapes: Sequence[Shape] | None,
    tell: Progress,
) -> list[Path]:
    from slipctl.view.recording import write

    written = []
    # closed whatever happens: systems there are that remove no file that is open
    with closing(_rows(signals, worlds)) as tables:
        for world, rows in zip(worlds, tables, strict=True):
            written.append(write(folder / world.file, rows, world.runs, world.info, shapes))
            tell(len(written), len(worlds))
    return written


def _rows(signals: pa.Table | Path, worlds: Sequence[WorldRecording]) -> Generator[pa.Table]:
    """Yield the rows of each world; a row group that holds several worlds in a row is read once for them."""
    if not isinstance(signals, Path):
        yield from repeat(signals, len(worlds))
        return
    with pq.ParquetFile(signals) as file:
        spans = _spans(file.metadata)
        held: dict[int, pa.Table] = {}
        for world in worlds:
            runs = [run.run for run in world.runs]
            needed = [k for k, (first, last) in enumerate(spans) if any(first <= run <= last for run in runs)]
            held = {k: held[k] if k in held else file.read_row_group(k) for k in needed}
            parts = [rows_of(part, np.isin(part["run"].to_numpy(), runs)) for part in held.values()]
            yield pa.concat_tables(parts) if parts else file.schema_arrow.empty_table()


def _spans(metadata: pq.FileMetaData) -> list[tuple[float, float]]:
    """Return first and last run of each row group; everything where the file does not say."""
    column = next(k for k in range(metadata.num_columns) if metadata.schema.column(k).path == "run")
    told = [metadata.row_group(k).column(column).statistics for k in range(metadata.num_row_groups)]
    return [(one.min, one.max) if one is not None and one.has_min_max else (-inf, inf) for one in told]


def _work(jobs: Sequence[tuple[Path, int]], workers: int, tell: Progress, total: int) -> None:
    """Keep `workers` processes busy; whatever happens, none is left behind."""
    # a worker finds what this process found, and not what lies where the user happens to be
    paths = os.pathsep.join(map(os.path.abspath, sys.path))
    environment = {**os.environ, "PYTHONPATH": paths, "PYTHONSAFEPATH": "1"}
    waiting, done = list(jobs), 0
    with ExitStack() as stack:
        active: list[tuple[subprocess.Popen[bytes], IO[bytes], int]] = []
        while waiting or active:
            while waiting and len(active) < workers:
                job, count = waiting.pop(0)
                command = [sys.executable, "-m", "slipctl.view", str(job)]
                # a file, not a pipe: nobody reads before the worker ends, and a full pipe would hold it up
                said = stack.enter_context(tempfile.TemporaryFile())
                process = subprocess.Popen(command, env=environment, stdin=subprocess.PIPE, stderr=said)
                stack.callback(_stop, process)
                active.append((process, said, count))
            finished = [worker for worker in active if worker[0].poll() is not None]
            for worker in finished:
                active.remove(worker)
                process, said, count = worker
                if process.returncode != 0:
                    said.seek(0)
                    lines = said.read().decode(errors="replace").strip().splitlines()
                    raise RecordingError(lines[-1] if lines else f"a worker ended with {process.returncode}")
                done += count
                tell(done, total)
            if not finished:
                time.sleep(0.02)


def _stop(process: subprocess.Popen[bytes]) -> None:
    if process.poll() is None:
        process.terminate()
        process.wait()
    if process.stdin is not None:
        process.stdin.close()


def _encode(
    folder: Path, signals: Path, worlds: Sequence[WorldRecording], shapes: Sequence[Shape] | None
) -> str:
    content = {
        "folder": str(folder.resolve()),
        "signals": str(signals.resolve()),
        "shapes": None if shapes is None else [vars(shape) for shape in shapes],
        "worlds": [
            {
                "file": world.file,
                "runs": [
                    {
                        **vars(run),
                        "metrics": dict(run.metrics),
                        "theorem": None if run.theorem is None else vars(run.theorem),
                        "guarantee": dict(run.guarantee),
                    }
                    for run in world.runs
                ],
                "info": dict(world.info),
            }
            for world in worlds
        ],
    }
    return json.dumps(content, default=_plain)


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, tuple | dict):
        return value
    return str(value)


def _shape(fields: dict[str, Any]) -> Shape:
    size, position, quaternion, rgba = (
        np.array(fields[name], dtype=np.float64) for name in ("size", "position", "quaternion", "rgba")
    )
    return Shape(fields["body"], fields["kind"], size, position, quaternion, rgba)
