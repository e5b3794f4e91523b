"""One batch: all controllers of some worlds, simulated and measured."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from slipctl.experiment import assemble
from slipctl.experiment.own import OwnLaws, lineup
from slipctl.experiment.plan import sampled_rows
from slipctl.guarantee import METRIC_UNITS, verdicts, with_guarantee
from slipctl.metrics import UNITS, measure_worlds
from slipctl.recording import Columns, Recorder, signal_tables, with_errors, with_plan
from slipctl.simulate import Ending, simulate
from slipctl.tick import Status

if TYPE_CHECKING:
    import pyarrow as pa

STATUS_NAMES = {
    Status.RUNNING: "completed",
    Status.DIVERGED: "diverged",
    Status.TIPPED: "tipped",
    Status.LEFT_THE_ARENA: "left_the_arena",
}

ELEMENTS_AT_ONCE = 32768
"""Rows times worlds that are judged and measured at once: enough that calls do not count."""


@dataclass(frozen=True)
class Run:
    """One world under one controller, finished.

    Attributes
    ----------
    index : int
        world · number of controllers + controller.
    world : int
        Index of the world in grid order.
    label, kind : str
        Of the controller.
    status : str
    end_time : float or None
        Time of the last row that counts [s]; None where there is none, as the simulation raised.
    metrics : dict
    guarantee : dict
        As of `slipctl.guarantee.verdict`.
    signals : pyarrow.Table or None
        None where none are kept.
    failure : str or None
        What the simulation raised.
    """

    index: int
    world: int
    label: str
    kind: str
    status: str
    end_time: float | None
    metrics: dict[str, float | None]
    guarantee: dict[str, float | str | None]
    signals: pa.Table | None = None
    failure: str | None = None


FAILED = "failed"
"""Status of a run whose simulation raised, or ended its process."""


def failed_run(index: int, world: int, entrant: tuple[str, str], failure: str) -> Run:
    """Return what is said of a run that could not be simulated.

    Parameters
    ----------
    index, world : int
        As of `Run`.
    entrant : (str, str)
        Label and kind of the controller.
    failure : str
        What happened, one line.
    """
    guarantee = dict.fromkeys(("first_violation", *METRIC_UNITS))
    return Run(index, world, *entrant, FAILED, None, dict.fromkeys(UNITS), guarantee, None, failure)


def _without_judgement(run: Run, failure: str) -> Run:
    """Return a run that raised with the rows before: numbers of part of a run would look like its own."""
    bare = failed_run(run.index, run.world, (run.label, run.kind), failure)
    return replace(bare, end_time=run.end_time, signals=run.signals)


def batches(worlds: Sequence[assemble.World], indices: Sequence[int]) -> list[list[int]]:
    """Return which of the worlds `indices` share a batch: those that are alike, in order."""
    alike: dict[tuple, list[int]] = {}
    for index in indices:
        alike.setdefault(assemble.batch_key(worlds[index]), []).append(index)
    return list(alike.values())


def run_batch(
    worlds: Sequence[assemble.World],
    indices: Sequence[int],
    robot: assemble.RobotModel,
    threads: int,
    progress: Callable[[int], None],
    laws: OwnLaws | None = None,
    *,
    signals: str = "all",
    positions: Sequence[int] | None = None,
    raised: Callable[[Exception], str] | None = None,
) -> Iterator[list[Run]]:
    """Simulate the worlds `indices` of `worlds`; yield the runs of one controller after the other.

    Parameters
    ----------
    worlds : sequence of World
        All worlds of the scenario.
    indices : sequence of int
        Those of the batch: alike, see `batches`.
    robot : RobotModel
    threads : int
        For MuJoCo.
    progress : callable
        Told the number of world-ticks done in this batch.
    laws : mapping, optional
        Own laws, which come after the listed controllers.
    signals : str
        ``all``, ``sampled`` or ``none``: which rows the runs keep.
    positions : sequence of int, optional
        Places of the controllers to run; all of them where it is None.
    raised : callable, optional
        Told what a simulation raised after its first row, and says it in one line: the runs are then failed
        ones that end with the last row there is. What is raised ends the batch where it is None.

    Yields
    ------
    list of Run
        One per world, in the order of `indices`.
    """
    members = [worlds[index] for index in indices]
    first = members[0].scenario
    laws = laws or {}
    tick, runs_of_world = first.tick, len(first.controller) + len(laws)
    planned = assemble.references(members)
    start = assemble.start(members, planned)
    plant = assemble.plant(members, robot, threads)
    rows = len(planned.position)
    chosen = range(runs_of_world) if positions is None else positions
    for place, (position, entrant) in enumerate(
        zip(chosen, lineup(members, robot, laws, chosen), strict=True)
    ):
        law, known = entrant.law, entrant.known
        sensor = (
            None
            if assemble.sees_the_truth(worlds)
            else assemble.sensor(members, known, rows, assemble.radius_ratio(known, robot.geometry))
        )
        recorder = Recorder(rows, len(members), planned)
        done_before = place * (rows - 1) * len(members)
        failure = None
        try:
            ending = simulate(
                plant,
                law.controller,
                planned,
                start,
                tick,
                recorder.write,
                lambda k, before=done_before: progress(before + k * len(members)),
                sensor,
            )
        except Exception as error:
            if raised is None or not recorder.written:
                raise
            failure = raised(error)
            every = np.full(len(members), recorder.written - 1)
            ending = Ending(np.zeros_like(every, dtype=np.int8), every)
        statuses, last_rows = ending.status.tolist(), ending.last_row.tolist()
        runs: list[Run] = []
        for block, columns in _blocks(with_plan(recorder.columns()), len(members), rows):
            theorem = None if law.hypotheses is None else law.hypotheses.of(block)
            columns = with_guarantee(with_errors(columns), theorem, tick)
            numbers = [index * runs_of_world + position for index in indices[block]]
            runs += [
                Run(
                    index=number,
                    world=index,
                    label=entrant.label,
                    kind=entrant.kind,
                    status=STATUS_NAMES[Status(status)],
                    end_time=last * tick,
                    metrics=metrics,
                    guarantee=guarantee,
                    signals=kept,
                )
                for number, index, status, last, metrics, guarantee, kept in zip(
                    numbers,
                    indices[block],
                    statuses[block],
                    last_rows[block],
                    measure_worlds(columns, last_rows[block]),
                    verdicts(columns, theorem, last_rows[block], tick),
                    _kept(signals, numbers, columns, last_rows[block], tick),
                    strict=True,
                )
            ]
        if failure is not None:
            runs = [_without_judgement(run, failure) for run in runs]
        progress(done_before + (rows - 1) * len(members))
        yield runs


def _blocks(columns: Columns, worlds: int, rows: int) -> Iterator[tuple[slice, Columns]]:
    """Yield slices of worlds and their columns.

    Columns that all worlds share, as those of a plan, take room for one block only, which all blocks share.
    """
    step = max(1, ELEMENTS_AT_ONCE // rows)
    shared = {
        name: np.ascontiguousarray(values[:step])
        for name, values in columns.items()
        if values.strides[0] == 0
    }
    for first in range(0, worlds, step):
        block = slice(first, min(first + step, worlds))
        alike = {name: values[: block.stop - first] for name, values in shared.items()}
        yield block, {name: alike.get(name, values[block]) for name, values in columns.items()}


def _kept(
    signals: str, runs: Sequence[int], columns: Columns, last_rows: Sequence[int], tick: float
) -> Sequence[pa.Table | None]:
    if signals == "none":
        return [None] * len(runs)
    if signals == "all":
        return signal_tables(runs, columns, last_rows, tick)
    ticks = columns["error.position"].shape[1] - 1
    even = sampled_rows(ticks, ticks)
    thin = {name: values[:, even] for name, values in columns.items()}
    tables = signal_tables(runs, thin, [len(even) - 1] * len(runs), tick, even)
    for place, last in enumerate(last_rows):
        if last != ticks:  # it ended early, and so with a row of its own
            own = {name: values[place : place + 1] for name, values in columns.items()}
            (table,) = signal_tables([runs[place]], own, [last], tick)
            tables[place] = table.take(sampled_rows(ticks, last))
    return tables
