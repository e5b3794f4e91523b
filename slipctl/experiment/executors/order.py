"""What another process is told, and what it makes of it."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache

from slipctl import scenario as scenarios
from slipctl.experiment import assemble
from slipctl.experiment.chunk import Output, Setup
from slipctl.experiment.errors import WorkerError
from slipctl.experiment.machine import exact_versions
from slipctl.experiment.plan import Chunk, read_plan

Simulate = Callable[[Setup, Chunk, int | None], Output]
"""What a worker does with a chunk: `slipctl.experiment.chunk.simulate_chunk`."""


@dataclass(frozen=True)
class Order:
    """What another process needs to do chunks of an experiment: small, and of plain values.

    Attributes
    ----------
    plan : str
        JSON of `Plan.json`.
    scenario_id, model_id : str
        What it must be there, too.
    versions : tuple of (str, str)
        That it must have.
    threads : int
        For MuJoCo.
    """

    plan: str
    scenario_id: str
    model_id: str
    versions: tuple[tuple[str, str], ...]
    threads: int


def order(setup: Setup, threads: int | None) -> Order:
    """Write an order; by default every process has one thread, as there are many of them.

    Raises
    ------
    WorkerError
        Where there are laws of one's own: they exist in this process only.
    """
    if setup.laws:
        raise WorkerError(
            f"own laws ({', '.join(setup.laws)}) run in this process only: leave out workers and dask"
        )
    plan = setup.plan
    return Order(
        plan=json.dumps(plan.json(), allow_nan=False),
        scenario_id=scenarios.scenario_id(plan.scenario),
        model_id=setup.robot.model_id,
        versions=tuple(exact_versions().items()),
        threads=threads or 1,
    )


@lru_cache(maxsize=1)
def setup_of(order: Order) -> Setup:
    """Make what chunks need, once per process.

    Raises
    ------
    WorkerError
        Where this process would simulate something else.
    """
    wrong = version_problem(dict(order.versions), exact_versions())
    if wrong is not None:
        raise WorkerError(f"a worker cannot take part: {wrong}")
    plan = read_plan(json.loads(order.plan))
    robot = assemble.read_robot(plan.scenario)
    found = scenarios.scenario_id(plan.scenario), robot.model_id
    for name, its, ours in zip(
        ("scenario", "model"), found, (order.scenario_id, order.model_id), strict=True
    ):
        if its != ours:
            raise WorkerError(
                f"a worker cannot take part: its {name} is another ({its} there, {ours} here); "
                "files that the scenario names must be the same on every machine"
            )
    return Setup(plan, robot)


def version_problem(needed: Mapping[str, str], found: Mapping[str, str | None]) -> str | None:
    """Say which versions differ, or None where none does."""
    differ = [
        f"{name} is {found.get(name) or 'not there'}, needed is {version}"
        for name, version in needed.items()
        if found.get(name) != version
    ]
    return "; ".join(differ) or None
