"""Three rungs between real contacts and the paper's equations, and what lies between them.

`emergent`: the scenario's own ground makes the slip. `prescribed`: MuJoCo on grip, whose moving floor gives
the slip that was measured there (or that the scenario prescribes). `analytic`: the kinematic model (29) with
the same slip. A gap between a rung and `analytic` is taken apart by putting its causes into the kinematic
model one after the other, each time in closed loop: first the wheels as they really turned under their load
(**servo**), then the slip as it really was at the ticks (**contact**), then what it was between the ticks
(**tick**). With all three the model repeats the rung; what still differs is printed as `rest` and should be
nothing.

A torque drive has no wheel servo, and its law answers to accelerations that change within a tick: its rungs
are compared with the dynamic model (31), and their gaps stay whole.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from slipctl import scenario as files
from slipctl.experiment import assemble
from slipctl.experiment.assemble.plants import slip_law
from slipctl.experiment.assemble.robot import paper_inertia
from slipctl.plants.dynamic_ode import DynamicOde
from slipctl.plants.ode import KinematicOde
from slipctl.scenario.problems import Problem
from slipctl.simulate import Plant
from slipctl.study.corrected import CorrectedOde, Differences, measure_differences
from slipctl.study.runs import StudyRun, closed_loop, edited
from slipctl.theory.slip import SeriesSlip, SlipLaw
from slipctl.tick import Start

PARTS = ("servo", "contact", "tick", "rest")
GRIP = 0.8
"""Friction of the floor under the prescribed rung, that of an ordinary dry floor (assumed)."""

Progress = Callable[[int, int, str], None]


@dataclass(frozen=True)
class Rung:
    """One law on one rung.

    Attributes
    ----------
    name : str
        ``emergent``, ``prescribed`` or ``analytic``.
    run : StudyRun
    gap : float or None
        RMS distance of its path from that of `analytic` [m]; None for `analytic` itself.
    parts : dict of float
        By name of `PARTS`: what each adds to the RMS position error, beginning at `analytic` [m]; empty for
        a torque drive.
    moved : dict of float
        By name of `PARTS`: RMS distance by which each moves the path [m].
    """

    name: str
    run: StudyRun
    gap: float | None
    parts: dict[str, float]
    moved: dict[str, float]


def study(scenario: files.Scenario, progress: Progress | None = None) -> dict[str, Any]:
    """Run the rungs of a scenario, at its tick and at half of it, and take their gaps apart.

    Parameters
    ----------
    scenario : Scenario
        True sensing, no sweep. With `[slip]` it has the two upper rungs only.
    progress : callable, optional

    Returns
    -------
    dict
        ``scenario``, ``tick`` and ``controllers``: per law its rungs with errors, gaps and parts, and the
        tick's part at half the tick. Finite numbers in SI units.

    Raises
    ------
    slipctl.scenario.ScenarioError
        Where the scenario has no rungs to compare.
    """
    _refuse(scenario)
    tell = progress or (lambda done, total, text: None)
    ticks = [scenario.tick]
    if _steps(scenario, scenario.tick / 2.0):
        ticks.append(scenario.tick / 2.0)
    total = len(ticks) * len(scenario.controller)
    rungs: dict[tuple[str, float], list[Rung]] = {}
    for tick in ticks:
        for config in scenario.controller:
            tell(len(rungs), total, f"{config.label} at {1e3 * tick:g} ms")
            rungs[config.label, tick] = _climb(edited(scenario, {"tick": tick}), config.label)
    return {
        "scenario": scenario.name,
        "tick": scenario.tick,
        "controllers": [
            {
                "controller": config.label,
                "rungs": [_plain(rung) for rung in rungs[config.label, ticks[0]]],
                "rungs_at_half_the_tick": [_plain(rung) for rung in rungs[config.label, ticks[1]]]
                if len(ticks) > 1
                else None,
            }
            for config in scenario.controller
        ],
    }


def _refuse(scenario: files.Scenario) -> None:
    problems = []
    if scenario.sweep:
        problems.append(Problem("sweep", "a grid", "no sweep: the rungs compare one world"))
    if scenario.plant.kind != "mujoco" and scenario.slip is None:
        problems.append(Problem("plant.kind", f'"{scenario.plant.kind}"', '"mujoco", or a [slip] table'))
    dumped = scenario.sensing.model_dump()
    if any(dumped[name] != "true" for name in ("pose", "velocity", "acceleration")):
        problems.append(Problem("sensing", "sensors", "true values: noise would hide the gaps"))
    if problems:
        raise files.ScenarioError(scenario.name, problems)


def _steps(scenario: files.Scenario, tick: float) -> bool:
    """Whether a tick is made of whole physics steps."""
    step = _timestep(scenario)
    return round(tick / step) >= 1 and abs(round(tick / step) * step - tick) < 1e-9 * tick


def _timestep(scenario: files.Scenario) -> float:
    return scenario.plant.timestep or min(0.001, scenario.tick)


def _climb(scenario: files.Scenario, label: str) -> list[Rung]:
    """Return the rungs of one law, the most real one first."""
    worlds = files.worlds(scenario)
    law = slip_law(worlds)
    below: list[tuple[str, StudyRun]] = []
    if law is None:
        emergent = closed_loop(scenario, only=label)[label]
        law = _series(emergent)
        below.append(("emergent", emergent))
        floor = _moving_floor(scenario, law)
        below.append(("prescribed", closed_loop(scenario, only=label, plant=floor)[label]))
    else:
        values = {"plant.kind": "mujoco", "plant.timestep": _timestep(scenario)}
        below.append(("prescribed", closed_loop(edited(scenario, values), only=label)[label]))
    robot = assemble.read_robot(scenario)
    arena = np.array([scenario.plant.arena])
    if scenario.robot.drive == "wheel_torque":
        model = DynamicOde(paper_inertia(robot.inertia), law, arena)
        rungs, analytic = _torque_rungs(scenario, label, model, below)
        return [*rungs, Rung("analytic", analytic, None, {}, {})]
    ode = KinematicOde(robot.geometry, law, arena)
    analytic = closed_loop(scenario, only=label, plant=ode)[label]
    start = assemble.start(worlds, assemble.references(worlds))

    def with_differences(differences: Differences) -> StudyRun:
        plant = CorrectedOde(ode, differences, scenario.tick)
        return closed_loop(scenario, only=label, plant=plant)[label]

    rungs = [
        _taken_apart(name, run, analytic, ode, start, scenario.tick, with_differences) for name, run in below
    ]
    return [*rungs, Rung("analytic", analytic, None, {}, {})]


def _torque_rungs(
    scenario: files.Scenario, label: str, model: DynamicOde, below: list[tuple[str, StudyRun]]
) -> tuple[list[Rung], StudyRun]:
    """Return the rungs of a torque drive, whose gaps stay whole, and the run of the model (31)."""
    # the model's wheels have neither inertia nor friction to make up for
    plain = scenario
    if scenario.plant.kind == "mujoco":
        plain = edited(scenario, {"robot.compensate_wheels": False})
    analytic = closed_loop(plain, only=label, plant=model)[label]
    rungs = []
    for name, run in below:
        rows = min(len(run["time"]), len(analytic["time"]))
        paths = [each.pair("motion.position")[:rows] for each in (run, analytic)]
        rungs.append(Rung(name, run, _rms(_distance(*paths)), {}, {}))
    return rungs, analytic


def _taken_apart(
    name: str,
    run: StudyRun,
    analytic: StudyRun,
    ode: KinematicOde,
    start: Start,
    tick: float,
    with_differences: Callable[[Differences], StudyRun],
) -> Rung:
    differences = measure_differences(run.columns, ode, start, tick)
    instants = differences.from_instants()
    stages = [
        analytic,
        with_differences(differences.without_slip()),
        with_differences(instants),
        with_differences(differences),
        run,
    ]
    rows = min(len(stage["time"]) for stage in stages)
    paths = [stage.pair("motion.position")[:rows] for stage in stages]
    errors = [_rms(stage["error.position"][:rows]) for stage in stages]
    steps = range(len(PARTS))
    return Rung(
        name=name,
        run=run,
        gap=_rms(_distance(paths[-1], paths[0])),
        parts={PARTS[i]: errors[i + 1] - errors[i] for i in steps},
        moved={PARTS[i]: _rms(_distance(paths[i + 1], paths[i])) for i in steps},
    )


def _moving_floor(scenario: files.Scenario, law: SlipLaw) -> Plant:
    """Return MuJoCo on flat grip, whose surface moves as `law` says."""
    from slipctl.plants.ground import Ground
    from slipctl.plants.mujoco import MujocoPlant

    return MujocoPlant.build(
        model=scenario.robot.model,
        ground=Ground.flat(GRIP),
        slip_law=law,
        timestep=_timestep(scenario),
        speed_drive=scenario.robot.drive == "wheel_speed",
        torque_limit=scenario.robot.torque_limit,
        arena=scenario.plant.arena,
    )


def _series(run: StudyRun) -> SeriesSlip:
    return SeriesSlip(
        times=run["time"],
        longitudinal=run["slip.longitudinal"][None, :],
        lateral=run["slip.lateral"][None, :],
        yaw=run["slip.yaw"][None, :],
    )


def _plain(rung: Rung) -> dict[str, Any]:
    run = rung.run
    return {
        "rung": rung.name,
        "status": run.status,
        "rms_position_error": run.metrics["rms_position_error"],
        "max_position_error": run.metrics["max_position_error"],
        "final_position_error": run.metrics["final_position_error"],
        "gap": rung.gap,
        "parts": rung.parts,
        "moved": rung.moved,
    }


def _distance(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    gap = one - other
    return np.sqrt(gap[:, 0] ** 2 + gap[:, 1] ** 2)


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values * values)))
