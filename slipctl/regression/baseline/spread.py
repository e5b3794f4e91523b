"""The runs beside a scenario that show how far its numbers move when nothing that matters has changed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from slipctl.metrics import UNITS
from slipctl.regression.baseline.file import CannotJudge, RunBaseline, run_key
from slipctl.regression.baseline.gated import GATED, NUDGE, is_repeated
from slipctl.regression.baseline.tolerance import Seen, number
from slipctl.scenario import Axis, Scenario

NUDGES = {
    "start.x_offset": (NUDGE, 2),
    "start.y_offset": (NUDGE, 3),
    "start.heading_offset_deg": (math.degrees(NUDGE), 1),
}
"""Keys that are moved, by how much, and on how many threads. Each of these runs also holds every world as it
is, so that three runs show what nudges do and what threads do."""

TIMESTEP = "plant.timestep"

Kind = Literal["nudged", "threads", "halved"]


@dataclass(frozen=True)
class Beside:
    """A scenario that has every world of another one in it, with one key moved.

    Attributes
    ----------
    scenario
        To be run.
    key
        The moved key.
    origins
        Its values, and of each the value of the other scenario that it stands for and what was done to it.
    swept
        Whether the other scenario sweeps the key, too.
    threads
        On how many threads to run it; None leaves the choice.
    """

    scenario: Scenario
    key: str
    origins: Mapping[float, tuple[float, Kind]]
    swept: bool
    threads: int | None

    def origin(self, run: Mapping[str, Any]) -> tuple[tuple[str, str, int], Kind]:
        """Say which run of the other scenario a run of this one stands beside, and how."""
        varied = dict(run["varied"])
        value, kind = self.origins[varied[self.key]]
        if self.swept:
            varied[self.key] = value
        else:
            del varied[self.key]
        return run_key(run["controller"], varied, run["seed"]), kind


@dataclass(frozen=True)
class Neighbour:
    """A run beside another one.

    Attributes
    ----------
    kind
        What was moved.
    status, metrics
        What it gave.
    """

    kind: Kind
    status: str
    metrics: Mapping[str, float | None]


def scenarios_beside(scenario: Scenario, threads: int | None = None) -> Iterator[Beside]:
    """Yield what has to be run: moved starts on one to three threads, and half the timestep.

    Parameters
    ----------
    scenario : Scenario
    threads : int, optional
        For the run with half the timestep.
    """
    start = scenario.start
    now = {
        "start.x_offset": start.x_offset,
        "start.y_offset": start.y_offset,
        "start.heading_offset_deg": start.heading_offset_deg,
    }
    for key, (step, cores) in NUDGES.items():
        values: dict[float, tuple[float, Kind]] = {}
        for value in _values(scenario, key, now[key]):
            values[value] = (value, "threads")
            for moved in (value + step, value - step):
                values.setdefault(_within_a_turn(key, moved), (value, "nudged"))
        yield _beside(scenario, key, values, cores)
    if scenario.plant.timestep is not None:
        steps = _values(scenario, TIMESTEP, scenario.plant.timestep)
        yield _beside(scenario, TIMESTEP, {step / 2.0: (step, "halved") for step in steps}, threads)


def neighbours(
    scenario: Scenario, run: Callable[[Scenario, int | None], Mapping[str, Any]], threads: int | None = None
) -> dict[tuple[str, str, int], list[Neighbour]]:
    """Run everything beside a scenario.

    Parameters
    ----------
    scenario : Scenario
    run : callable
        From a scenario and a number of threads to the JSON output of its run.
    threads : int, optional
        As of `scenarios_beside`.

    Returns
    -------
    dict
        From each run of the scenario, by `run_key`, to the runs beside it.
    """
    found: dict[tuple[str, str, int], list[Neighbour]] = {}
    for beside in scenarios_beside(scenario, threads):
        for entry in run(beside.scenario, beside.threads)["runs"]:
            key, kind = beside.origin(entry)
            found.setdefault(key, []).append(Neighbour(kind, entry["status"], entry["metrics"]))
    return found


def measure(
    payload: Mapping[str, Any],
    ticks: Sequence[int],
    beside: Mapping[tuple[str, str, int], Sequence[Neighbour]],
) -> list[RunBaseline]:
    """Turn a result into what a baseline holds of its runs.

    Parameters
    ----------
    payload
        The JSON output of a run.
    ticks
        Length of each of its runs.
    beside
        The runs beside each, as of `neighbours`.

    Raises
    ------
    CannotJudge
        A run from the very same start gave something else: such a law cannot be gated.
    """
    runs = []
    for run, length in zip(payload["runs"], ticks, strict=True):
        others = beside[run_key(run["controller"], run["varied"], run["seed"])]
        _see_repeated(payload["scenario"], run, others, length)
        statuses = {other.status for other in others} - {run["status"]}
        runs.append(
            RunBaseline(
                controller=run["controller"],
                varied=dict(run["varied"]),
                seed=run["seed"],
                status=run["status"],
                ticks=length,
                statuses_seen=sorted(statuses),
                metrics={
                    metric: number(
                        metric, run["metrics"][metric], _seen(metric, others, not statuses), length
                    )
                    for metric in GATED
                },
            )
        )
    return runs


def _see_repeated(scenario: str, run: Mapping[str, Any], others: Sequence[Neighbour], ticks: int) -> None:
    """See that every run from a start that was not moved gave what the run itself gave."""
    for other in others:
        if other.kind != "threads":
            continue
        pairs = {"status": (run["status"], other.status)} if other.status != run["status"] else {}
        pairs |= {
            metric: (run["metrics"][metric], other.metrics[metric])
            for metric in GATED
            if not is_repeated(metric, run["metrics"][metric], other.metrics[metric], ticks)
        }
        if not pairs:
            continue
        metric, (first, again) = next(iter(pairs.items()))
        unit = f" [{UNITS[metric]}]" if metric in UNITS else ""
        raise CannotJudge(
            f"{scenario}: {run['controller']} is not repeatable, so that nothing can be recorded: from the "
            f"very same start its {metric}{unit} is {first}, then {again}; "
            "what is random in a law must be seeded, world by world"
        )


def _seen(metric: str, others: Sequence[Neighbour], same_status: bool) -> Seen:
    by_kind: dict[Kind, list[float | None]] = {"nudged": [], "threads": [], "halved": []}
    for other in others:
        by_kind[other.kind].append(other.metrics[metric])
    return Seen(by_kind["nudged"], by_kind["threads"], by_kind["halved"], same_status)


def _beside(
    scenario: Scenario, key: str, origins: Mapping[float, tuple[float, Kind]], threads: int | None
) -> Beside:
    """Put the values of a key into a scenario's sweep: in place of its axis, or as the fastest one."""
    axis = Axis(key, tuple(origins))
    swept = any(other.key == key for other in scenario.sweep)
    sweep = tuple(axis if other.key == key else other for other in scenario.sweep)
    moved = scenario.model_copy(update={"sweep": sweep if swept else (*sweep, axis)})
    return Beside(moved, key, origins, swept, threads)


def _values(scenario: Scenario, key: str, value: float) -> list[float]:
    return next((list(axis) for axis in scenario.sweep if axis.key == key), [value])


def _within_a_turn(key: str, value: float) -> float:
    """Turn a heading back that the file format would refuse for being over a whole turn."""
    if key.endswith("heading_offset_deg") and abs(value) > 360.0:
        return value - math.copysign(360.0, value)
    return value
