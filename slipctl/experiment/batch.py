"""One batch: all controllers of some worlds, simulated and measured."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from slipctl.experiment import assemble
from slipctl.experiment.own import OwnLaws, lineup
from slipctl.guarantee import verdict, with_guarantee
from slipctl.metrics import measure
from slipctl.recording import Recorder, signal_table, with_errors
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
    laws: OwnLaws | None = None,
) -> Iterator[list[Run]]:
    """Simulate the worlds `indices` of `worlds`; yield the runs of one controller after the other.

    `progress` is told the number of world-ticks done in this batch. The own `laws` come after the listed
    controllers.
    """
    members = [worlds[index] for index in indices]
    first = members[0].scenario
    laws = laws or {}
    tick, runs_of_world = first.tick, len(first.controller) + len(laws)
    planned = assemble.references(members)
    start = assemble.start(members, planned)
    plant = assemble.plant(members, robot, threads)
    rows = len(planned.position)
    for position, entrant in enumerate(lineup(members, robot, laws)):
        law, known = entrant.law, entrant.known
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
        columns = with_guarantee(with_errors(recorder.columns()), law.hypotheses, tick)
        runs = []
        for row, index in enumerate(indices):
            run = index * runs_of_world + position
            last = int(ending.last_row[row])
            runs.append(
                Run(
                    index=run,
                    world=index,
                    label=entrant.label,
                    kind=entrant.kind,
                    status=STATUS_NAMES[Status(int(ending.status[row]))],
                    end_time=last * tick,
                    metrics=measure(columns, row, last),
                    guarantee=verdict(columns, law.hypotheses, row, last, tick),
                    signals=signal_table(run, row, columns, ending, tick),
                )
            )
        progress(done_before + (rows - 1) * len(members))
        yield runs
