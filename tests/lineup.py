"""Every plant and every law, for any choice of five unlike worlds, and the loop between them by hand."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from slipctl.control.drive import DriveLimits
from slipctl.control.torque import TorqueDrive
from slipctl.plants.dynamic_ode import DynamicOde
from slipctl.plants.ground import Ground
from slipctl.plants.mujoco import MujocoPlant
from slipctl.plants.ode import KinematicOde
from slipctl.simulate import Controller, Plant
from slipctl.theory.reference import FigureEight, Placement
from slipctl.theory.robot import MAGELLAN_PRO
from slipctl.theory.robust import UNCERTAINTIES
from slipctl.theory.slip import NoSlip, ProportionalSlip, SinusoidalSlip
from slipctl.tick import Reference, Start
from tests.builders import full, leaves, nominal_law, planned_start, robust_law, rows_of
from tests.dynamic import BOUNDS, PAPER_BODY, nominal_dynamic, robust_dynamic

TICK = 0.01
TICKS = 60
WORLDS = (0, 1, 2, 3, 4)
Rows = Sequence[int]


def pick(rows: Rows, *values: float) -> Any:
    """Return the parameter of the worlds asked for."""
    return np.array(values)[list(rows)]


def fractions(rows: Rows) -> tuple[Any, Any, Any]:
    return (
        pick(rows, 0.1, 0.4, -0.3, 0.0, 0.2),
        pick(rows, -0.2, 0.4, 0.1, 0.3, 0.0),
        pick(rows, 0.5, 0.4, -0.7, 0.0, 1.0),
    )


def ode(slip_law: Callable[[Rows], Any]) -> Callable[[Rows], Plant]:
    return lambda rows: KinematicOde(MAGELLAN_PRO, slip_law(rows), pick(rows, 50.0, 40.0, 0.35, 30.0, 20.0))


def ground(rows: Rows, film: bool = False, creep: bool = False) -> Ground:
    nothing = pick(rows, *[np.nan] * 5)
    return Ground(
        friction=np.stack(
            [pick(rows, 0.8, 0.05, 0.3, 0.15, 0.5), pick(rows, 0.8, 0.1, 0.3, 0.6, 0.2)], axis=-1
        ),
        film=pick(rows, 100.0, 200.0, 50.0, 400.0, 30.0) if film else nothing,
        creep_stiffness=pick(rows, 100.0, 300.0, 50.0, 800.0, 200.0) if creep else nothing,
        slope=pick(rows, 0.0, 0.05, 0.0, 0.1, 0.02),
        downhill=pick(rows, 0.0, 1.0, 0.0, -2.0, 3.0),
    )


def on_mujoco(**kind: bool) -> Callable[[Rows], Plant]:
    return lambda rows: MujocoPlant.build(ground=ground(rows, **kind))


def on_belts(rows: Rows) -> Plant:
    return MujocoPlant.build(ground=ground(rows), slip_law=ProportionalSlip(*fractions(rows)), threads=2)


def dynamic(slip_law: Callable[[Rows], Any]) -> Callable[[Rows], Plant]:
    return lambda rows: DynamicOde(PAPER_BODY, slip_law(rows), pick(rows, 50.0, 40.0, 0.35, 30.0, 20.0))


def with_motors(rows: Rows) -> Plant:
    return MujocoPlant.build(ground=ground(rows), speed_drive=False, torque_limit=1.0, wheel_rate_limit=14.0)


def no_slip(rows: Rows) -> NoSlip:
    return NoSlip(len(rows))


def swinging(rows: Rows) -> SinusoidalSlip:
    return SinusoidalSlip(*fractions(rows), period=pick(rows, 1.0, 2.0, 3.0, 0.4, 0.7))


PLANTS: dict[str, Callable[[Rows], Plant]] = {
    "ode": ode(no_slip),
    "ode_proportional": ode(lambda rows: ProportionalSlip(*fractions(rows))),
    "ode_sinusoidal": ode(swinging),
    "mujoco": on_mujoco(),
    "mujoco_film": on_mujoco(film=True),
    "mujoco_creep": on_mujoco(creep=True),
    "mujoco_belts": on_belts,
}

TORQUE_PLANTS: dict[str, Callable[[Rows], Plant]] = {
    "dynamic_ode": dynamic(no_slip),
    "dynamic_ode_proportional": dynamic(lambda rows: ProportionalSlip(*fractions(rows))),
    "dynamic_ode_sinusoidal": dynamic(swinging),
    "mujoco_torque": with_motors,
}


def drive(rows: Rows) -> DriveLimits:
    """Return limits that some worlds meet and others do not."""
    worlds = len(rows)
    return DriveLimits(
        MAGELLAN_PRO,
        pick(rows, 2.5, 2.0, 0.8, 2.5, 1.5),
        pick(rows, 6.0, 1.0, 6.0, 3.0, 2.0),
        full(worlds, 0.05),
    )


def poles(rows: Rows) -> Any:
    return pick(rows, -0.5, -1.0, -2.0, -1.5, -3.0)


def robust(name: str, layers: Sequence[float] = (0.02, 0.05, 0.1, 0.03, 0.2)) -> Callable[[Rows], Controller]:
    def build(rows: Rows) -> Controller:
        bound = UNCERTAINTIES[name].bound
        return robust_law(
            poles(rows), pick(rows, 0.4, 0.2, 0.3, 0.1, 0.45), pick(rows, *layers), bound, drive(rows)
        )

    return build


LAWS: dict[str, Callable[[Rows], Controller]] = {
    "nominal_kinematic": lambda rows: nominal_law(poles(rows), drive(rows)),
    **{f"robust_{name}": robust(name) for name in UNCERTAINTIES},
    "robust_discontinuous": robust("independent", [0.0] * 5),
}


def motors(rows: Rows) -> TorqueDrive:
    """Return limits that some worlds meet and others do not."""
    return TorqueDrive(PAPER_BODY, pick(rows, 4.0, 0.3, 4.0, 1.0, 0.1), full(len(rows), 0.05))


def robust_torque(name: str) -> Callable[[Rows], Controller]:
    def build(rows: Rows) -> Controller:
        bound = BOUNDS[name](pick(rows, 0.3, 0.2, 0.3, 0.1, 0.45))
        return robust_dynamic(poles(rows), pick(rows, 0.02, 0.05, 0.1, 0.03, 0.2), bound, motors(rows))

    return build


TORQUE_LAWS: dict[str, Callable[[Rows], Controller]] = {
    "nominal_dynamic": lambda rows: nominal_dynamic(poles(rows), motors(rows)),
    **{f"robust_dynamic_{name}": robust_torque(name) for name in BOUNDS},
}

EVERY_PLANT, EVERY_LAW = PLANTS | TORQUE_PLANTS, LAWS | TORQUE_LAWS


def nominal_for(plant: str) -> str:
    return "nominal_dynamic" if plant in TORQUE_PLANTS else "nominal_kinematic"


def robust_for(plant: str) -> str:
    return "robust_dynamic_proportional" if plant in TORQUE_PLANTS else "robust_independent"


def references(rows: Rows) -> Reference:
    placement = Placement(
        pick(rows, 0.0, 1.0, 0.0, -1.0, 0.5),
        pick(rows, 0.0, 2.0, 0.0, 0.3, -0.5),
        pick(rows, 0.0, 2.0, 0.7, -3.0, 1.0),
    )
    plan = FigureEight(pick(rows, 2.0, 3.0, 2.0, 4.0, 1.5), pick(rows, 1.0, 0.6, 1.0, 0.8, 0.5), placement)
    return rows_of(plan, TICK, TICKS * TICK)


def beginning(rows: Rows) -> Start:
    """Return starts beside the plans, one of them at rest."""
    plan = planned_start(references(rows))
    offset = np.stack(
        [pick(rows, 0.0, 0.02, 0.0, -0.03, 0.01), pick(rows, 0.01, 0.0, 0.0, 0.02, 0.0)], axis=-1
    )
    return Start(
        plan.position + offset,
        plan.heading + pick(rows, 0.0, 0.1, 0.0, 0.0, -0.2),
        plan.forward_speed * pick(rows, 1.0, 1.0, 1.0, 0.0, 1.0),
        plan.yaw_rate * pick(rows, 1.0, 1.0, 1.0, 0.0, 1.0),
        plan.forward_acceleration * pick(rows, 1.0, 1.0, 1.0, 0.0, 1.0),
    )


class Loop:
    """The closed loop by hand, able to stop and go on anywhere."""

    def __init__(self, plant: str, law: str, rows: Rows = WORLDS):
        self.plant, self.law = EVERY_PLANT[plant](rows), EVERY_LAW[law](rows)
        self.references, self.rows = references(rows), rows

    def begin(self) -> tuple[Any, Any]:
        start = beginning(self.rows)
        return self.plant.start(start), self.law.start(start)

    def go(self, state: Any, memory: Any, first: int, last: int) -> tuple[Any, Any, list[dict[str, Any]]]:
        """Run ticks `first` to `last` and return what is left, and everything seen on the way."""
        seen = []
        for k in range(first, last):
            reference = self.references.row(k)
            motion = self.plant.observe(state)
            decision = self.law.update(memory, reference, motion, TICK)
            everything = (motion, decision.command, decision.trace, state.status, self.plant.details(state))
            seen.append(
                {name: np.copy(leaf) for name, leaf in leaves(everything).items() if leaf is not None}
            )
            memory = decision.memory
            state = self.plant.step(state, decision.command, TICK)
        return state, memory, seen
