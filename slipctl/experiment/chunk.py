"""One chunk of an experiment, simulated: the same function here, in a worker process and on a cluster."""

from __future__ import annotations

import os
import traceback
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from slipctl.experiment import assemble
from slipctl.experiment.batch import Run, batches, failed_run, run_batch
from slipctl.experiment.errors import WorkerError
from slipctl.experiment.own import OwnLaws
from slipctl.experiment.plan import Chunk, Plan
from slipctl.experiment.rows import joined, run_table

if TYPE_CHECKING:
    import pyarrow as pa

Progress = Callable[[int], None]

FRAMES = 4
"""Calls that are kept of what a failed run raised."""

ENDED = "ended "
"""So begins what is said of a run whose world ended its process; what a run raised begins with a class."""

MACHINE = (MemoryError, OSError)
"""What is said of the machine, not of the worlds: they must not be called failed for good."""


@dataclass(frozen=True)
class Setup:
    """What every chunk of an experiment needs, made once per process.

    Attributes
    ----------
    plan : Plan
    robot : RobotModel
    laws : mapping
        Laws of one's own by label; they run in the process that was given them.
    """

    plan: Plan
    robot: assemble.RobotModel
    laws: OwnLaws = field(default_factory=dict)


@dataclass(frozen=True)
class Output:
    """A finished chunk.

    Attributes
    ----------
    chunk : Chunk
    metrics : pyarrow.Table
        One row per run, as of `slipctl.experiment.rows.run_table`.
    signals : tuple of pyarrow.Table
        Those of the runs that have any, in the order of `metrics`.
    """

    chunk: Chunk
    metrics: pa.Table
    signals: tuple[pa.Table, ...]


def simulate_chunk(
    setup: Setup,
    chunk: Chunk,
    threads: int | None = None,
    progress: Progress | None = None,
    *,
    silent: bool = False,
) -> Output:
    """Simulate the worlds of a chunk under every controller.

    Parameters
    ----------
    setup : Setup
    chunk : Chunk
    threads : int, optional
        For MuJoCo; by default chosen from the size of a batch. Results do not depend on it.
    progress : callable, optional
        Told the number of world-ticks done.
    silent : bool
        Whether the traceback of a run that keeps its rows is not shown, as it was when it was first run.

    Raises
    ------
    WorkerError
        Where the machine lacks memory, or a file cannot be read.
    Exception
        What a run raised, unless the plan says to keep going.
    """
    grid, tell = setup.plan.grid, progress or (lambda done: None)
    runs, done = [], 0
    for indices in batches(grid, chunk.worlds):

        def within(ticks: int, before: int = done) -> None:
            tell(before + ticks)

        for finished in _runs(setup, indices, range(len(setup.plan.entrants)), threads, within, silent):
            runs += finished
        done += assemble.tick_count(grid[indices[0]].scenario) * len(indices) * len(setup.plan.entrants)
    runs.sort(key=lambda run: run.index)
    return output(setup.plan, chunk, runs)


def merged(chunk: Chunk, parts: Sequence[Output]) -> Output:
    """Put together what was simulated of a chunk in pieces, in any order."""
    parts = sorted(parts, key=lambda part: part.chunk.worlds[0])
    signals = tuple(table for part in parts for table in part.signals)
    return Output(chunk, joined([part.metrics for part in parts]), signals)


def lost(plan: Plan, chunk: Chunk, processes: str) -> Output:
    """Return what is said of a chunk that ended the `processes` that tried it: every run of it failed."""
    reason = f"{ENDED}{processes}"
    runs = [failure for world in chunk.worlds for failure in _failures(plan, [world], reason)]
    return output(plan, chunk, runs)


def ended_its_process(failure: str | None) -> bool:
    """Whether a run failed because its world ended the processes that simulated it, and raised nothing."""
    return failure is not None and failure.startswith(ENDED)


def output(plan: Plan, chunk: Chunk, runs: Sequence[Run]) -> Output:
    """Put the runs of a chunk, in order, into tables."""
    signals = tuple(run.signals for run in runs if run.signals is not None)
    return Output(chunk, run_table(runs, plan.grid), signals)


def _runs(
    setup: Setup,
    indices: Sequence[int],
    positions: Sequence[int],
    threads: int | None,
    tell: Progress,
    silent: bool,
) -> Iterator[list[Run]]:
    """Yield the runs of a batch; where the simulation raises, find the runs at fault and do the others."""
    plan, left = setup.plan, list(positions)

    def raised(error: Exception) -> str:
        if isinstance(error, MACHINE):
            raise error
        if not silent:
            traceback.print_exception(error)
        return _reason(error)

    try:
        for runs in run_batch(
            plan.grid,
            indices,
            setup.robot,
            threads or default_threads(len(indices)),
            tell,
            setup.laws,
            signals=plan.signals,
            positions=positions,
            raised=raised if plan.keep_failed_rows and len(indices) == 1 else None,
        ):
            yield runs
            left.pop(0)
        return
    except MACHINE as error:
        first, last = indices[0], indices[-1]
        raise WorkerError(
            f"worlds {first} to {last} could not be simulated on this machine: {_reason(error)}; "
            "this is said of the machine, not of the worlds: free memory or take fewer workers, "
            "or put right what is named"
        ) from error
    except Exception as error:
        if not (plan.keep_going or (plan.keep_failed_rows and len(indices) > 1)):
            raise
        reason = _reason(error)
    half = len(indices) // 2
    if half:
        for part in (indices[:half], indices[half:]):
            yield from _runs(setup, part, left, threads, tell, silent)
    elif len(left) > 1:
        for position in left:
            yield from _runs(setup, indices, [position], threads, tell, silent)
    else:
        yield _failures(plan, indices, reason, left)


def _failures(
    plan: Plan, worlds: Sequence[int], reason: str, positions: Sequence[int] | None = None
) -> list[Run]:
    count = len(plan.entrants)
    return [
        failed_run(world * count + position, world, plan.entrants[position], reason)
        for world in worlds
        for position in (range(count) if positions is None else positions)
    ]


def _reason(error: Exception) -> str:
    """Say on one line what was raised and where, with the calls that led there, the last one first."""
    said = " ".join("".join(traceback.format_exception_only(error)).split())
    frames = traceback.extract_tb(error.__traceback__)[: -FRAMES - 1 : -1]
    if not frames:
        return said
    return f"{said} ({' < '.join(f'{os.path.basename(frame.filename)}:{frame.lineno}' for frame in frames)})"


def default_threads(worlds: int) -> int:
    """Return how many threads pay: handing a tick over costs as much as a few worlds' physics."""
    return max(1, min(os.cpu_count() or 1, worlds // 4))
