"""How long every law takes to decide for one robot."""

from __future__ import annotations

import statistics
import time
from typing import Any

from slipctl import scenario as files
from slipctl.experiment import assemble

SCENARIOS = ("paper-kinematic", "paper-dynamic", "rest-to-rest")
"""Shipped ones, which between them have every law."""

WARM_UP = 20


def decision_times(ticks: int = 400) -> dict[str, float]:
    """Return the median wall time of one decision for one world, by the label of the law [µs].

    The law is in its loop: what it sees changes from tick to tick, and other code runs between decisions.

    Parameters
    ----------
    ticks : int
        Decisions of every law.
    """
    times: dict[str, float] = {}
    for name in SCENARIOS:
        scenario = files.load(name)
        worlds = list(files.worlds(scenario))[:1]
        robot = assemble.read_robot(scenario)
        planned = assemble.references(worlds)
        start = assemble.start(worlds, planned)
        plant: Any = assemble.plant(worlds, robot, 1)
        for index, config in enumerate(scenario.controller):
            law = assemble.law(worlds, index, robot).controller
            state, memory, taken = plant.start(start), law.start(start), []
            for k in range(min(ticks + WARM_UP, len(planned.position) - 1)):
                reference, motion = planned.row(k), plant.observe(state)
                began = time.perf_counter()
                decision = law.update(memory, reference, motion, scenario.tick)
                taken.append(time.perf_counter() - began)
                memory, state = decision.memory, plant.step(state, decision.command, scenario.tick)
            times[config.label] = statistics.median(taken[WARM_UP:]) * 1e6
    return times
