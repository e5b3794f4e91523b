"""The rules that span several keys.

They read the raw tables, not the models, so that they also speak up where other keys are wrong: a file's
problems come all at once. A rule whose keys are themselves missing or wrong keeps silent. Those of the laws,
the reference and the sensors have modules of their own.
"""

from collections.abc import Iterator, Mapping
from typing import Any

from slipctl.scenario.applies import ignored_problems
from slipctl.scenario.base import lookup
from slipctl.scenario.expect_checks import expect_problems
from slipctl.scenario.floor_checks import floor_problems
from slipctl.scenario.law_checks import law_problems
from slipctl.scenario.own_robot import model_problems
from slipctl.scenario.path_checks import reference_problems, slip_problems
from slipctl.scenario.problems import Problem
from slipctl.scenario.sensing_checks import sensing_problems
from slipctl.scenario.values import has, misses_multiple, natural_duration, value_at

TICK_LIMIT = 10_000_000
"""Largest number of control ticks of one run (their signals would no longer fit into memory)."""


def rule_problems(raw: Mapping[str, Any]) -> list[Problem]:
    """Everything wrong between the keys of a file."""
    rules = (
        model_problems,
        ignored_problems,
        _ground,
        floor_problems,
        _times,
        slip_problems,
        reference_problems,
        sensing_problems,
        law_problems,
        expect_problems,
    )
    return [problem for rule in rules for problem in rule(raw)]


def _ground(raw: Mapping[str, Any]) -> Iterator[Problem]:
    sides = [key for key in ("friction_left", "friction_right") if has(raw, "ground", key)]
    if sides and has(raw, "ground", "friction"):
        yield Problem(
            "ground.friction",
            f"it together with {' and '.join(sides)}",
            "friction, or friction_left and friction_right",
        )
    if len(sides) == 1:
        other = "friction_right" if sides == ["friction_left"] else "friction_left"
        yield Problem(f"ground.{other}", f"nothing, though {sides[0]} is given", "both, or friction alone")
    if has(raw, "ground", "film") and has(raw, "ground", "creep_stiffness"):
        yield Problem("ground.film", "it together with creep_stiffness", "one of film and creep_stiffness")


def _times(raw: Mapping[str, Any]) -> Iterator[Problem]:
    tick = value_at(raw, "tick")
    if tick is None or tick <= 0:
        return
    timestep = value_at(raw, "plant", "timestep")
    if lookup(raw, "plant", "kind") == "mujoco" and timestep is not None and timestep > 0:
        steps = tick / timestep
        if round(steps) < 1 or misses_multiple(tick, timestep):
            lower = max(1, int(steps))
            yield Problem(
                "tick",
                f"{tick:g} s, {steps:.6g} times the timestep",
                f"a multiple of plant.timestep ({timestep:g} s), such as "
                f"{lower * timestep:.9g} or {(lower + 1) * timestep:.9g} s",
            )
    given = "duration" in raw
    duration = value_at(raw, "duration") if given else natural_duration(raw)
    if duration is None or duration <= 0:
        return
    whose = "duration" if given else "the reference's duration"
    if tick > duration:
        yield Problem("tick", f"{tick:g} s", f"at most {whose}, {duration:.6g} s")
    elif duration / tick > TICK_LIMIT:
        allowed = f"at most {TICK_LIMIT:,} ticks a run: a longer tick or a shorter duration"
        yield Problem(
            "tick", f"{tick:g} s, {duration / tick:.4g} ticks in {whose}, {duration:.6g} s", allowed
        )
