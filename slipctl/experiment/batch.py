"""One batch: all controllers of some worlds, simulated and measured."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from slipctl.experiment import assemble
from slipctl.experiment.own import OwnLaws, lineup
from slipctl.experiment.plan import sampled_rows
from slipctl.guarantee import METRIC_UNITS, verdict, with_guarantee
from slipctl.metrics import UNITS, measure
from slipctl.recording import Columns, Recorder, signal_table, with_errors
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
        Time of the last row that counts [s]; None where the simulation raised.
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
        recorder = Recorder(rows, len(members))
        done_before = place * (rows - 1) * len(members)
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
                    signals=_kept(signals, run, row, columns, ending, tick),
                )
            )
        progress(done_before + (rows - 1) * len(members))
        yield runs


def _kept(signals: str, run: int, row: int, columns: Columns, ending: Ending, tick: float) -> pa.Table | None:
    if signals == "none":
        return None
    table = signal_table(run, row, columns, ending, tick)
    if signals == "all":
        return table
    ticks = columns["error.position"].shape[1] - 1
    return table.take(sampled_rows(ticks, int(ending.last_row[row])))
