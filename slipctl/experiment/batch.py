"""One batch: all controllers of some worlds, simulated and measured."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from slipctl.experiment import assemble
from slipctl.guarantee import verdicts, with_guarantee
from slipctl.metrics import measure_worlds
from slipctl.recording import Recorder, signal_tables, with_errors
from slipctl.simulate import simulate
from slipctl.tick import Status

if TYPE_CHECKING:
    import pyarrow as pa

STATUS_NAMES = {
    Status.RUNNING: "completed",
    Status.DIVERGED: "diverged",
    Status.TIPPED: "tipped",
    Status.LEFT_THE_ARENA: "left_the_arena",
}

ELEMENTS_AT_ONCE = 16384
"""Rows times worlds that are judged and measured at once."""


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
    end_time : float
        Time of the last row that counts [s].
    metrics : dict
    guarantee : dict
        As of `slipctl.guarantee.verdict`.
    signals : pyarrow.Table
    """

    index: int
    world: int
    label: str
    kind: str
    status: str
    end_time: float
    metrics: dict[str, float | None]
    guarantee: dict[str, float | str | None]
    signals: pa.Table


def batches(worlds: Sequence[assemble.World], largest: int) -> Iterator[list[int]]:
    """Yield indices of worlds that share a batch: consecutive, alike, at most `largest` of them."""
    batch: list[int] = []
    key: tuple = ()
    for index, world in enumerate(worlds):
        if batch and (assemble.batch_key(world) != key or len(batch) == largest):
            yield batch
            batch = []
        key = assemble.batch_key(world)
        batch.append(index)
    if batch:
        yield batch


def run_batch(
    worlds: Sequence[assemble.World],
    indices: Sequence[int],
    robot: assemble.RobotModel,
    threads: int,
    progress: Callable[[int], None],
) -> Iterator[list[Run]]:
    """Simulate the worlds `indices` of `worlds`; yield the runs of one controller after the other.

    `progress` is told the number of world-ticks done in this batch.
    """
    members = [worlds[index] for index in indices]
    first = members[0].scenario
    tick, controllers = first.tick, first.controller
    planned = assemble.references(members)
    start = assemble.start(members, planned)
    plant = assemble.plant(members, robot, threads)
    rows = len(planned.position)
    for position, config in enumerate(controllers):
        law = assemble.law(members, position, robot)
        known = assemble.believed(members, position, robot.inertia).geometry
        sensor = (
            None
            if assemble.sees_the_truth(worlds)
            else assemble.sensor(members, known, rows, assemble.radius_ratio(known, robot.geometry))
        )
        recorder = Recorder(rows, len(members))
        done_before = position * (rows - 1) * len(members)
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
        recorded, statuses = recorder.columns(), ending.status.tolist()
        last_rows = ending.last_row.tolist()
        runs: list[Run] = []
        for block in _blocks(len(members), rows):
            theorem = None if law.hypotheses is None else law.hypotheses.of(block)
            columns = {name: values[block] for name, values in recorded.items()}
            columns = with_guarantee(with_errors(columns), theorem, tick)
            numbers = [index * len(controllers) + position for index in indices[block]]
            runs += [
                Run(
                    index=number,
                    world=index,
                    label=config.label,
                    kind=config.kind,
                    status=STATUS_NAMES[Status(status)],
                    end_time=last * tick,
                    metrics=metrics,
                    guarantee=guarantee,
                    signals=signals,
                )
                for number, index, status, last, metrics, guarantee, signals in zip(
                    numbers,
                    indices[block],
                    statuses[block],
                    last_rows[block],
                    measure_worlds(columns, last_rows[block]),
                    verdicts(columns, theorem, last_rows[block], tick),
                    signal_tables(numbers, columns, last_rows[block], tick),
                    strict=True,
                )
            ]
        progress(done_before + (rows - 1) * len(members))
        yield runs


def _blocks(worlds: int, rows: int) -> Iterator[slice]:
    """Yield slices of worlds whose columns fit in a processor's cache, so that sums are made there."""
    step = max(1, ELEMENTS_AT_ONCE // rows)
    for first in range(0, worlds, step):
        yield slice(first, min(first + step, worlds))
