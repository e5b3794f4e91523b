"""Worlds, plants and laws that several tests build, and a recorder for the loop."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

import numpy as np

from slipctl.control.drive import DriveLimits
from slipctl.control.nominal_kinematic import NominalKinematic
from slipctl.control.robust_kinematic import RobustKinematic
from slipctl.plants.ode import KinematicOde
from slipctl.simulate import Controller, Ending, Plant, Row, simulate
from slipctl.theory.reference import Placement, Plan, PointToPoint
from slipctl.theory.robot import MAGELLAN_PRO
from slipctl.theory.robust import UNCERTAINTIES, UncertaintyBound, chain_gains, lyapunov_matrix
from slipctl.theory.slip import ProportionalSlip, SlipLaw
from slipctl.tick import Array, Motion, Reference, Start

PAPER_POLE = -0.5
PAPER_SLIP = 0.4
PAPER_LAYER = 0.02


def full(worlds: int, value: float) -> Array:
    return np.full(worlds, float(value))


def at_origin(worlds: int) -> Placement:
    return Placement(np.zeros(worlds), np.zeros(worlds), np.zeros(worlds))


def table_one(worlds: int = 1) -> PointToPoint:
    """Return the plan of Table I, cubic in both flat outputs."""
    start = np.tile([0.0, 0.0, math.pi / 2.0, 0.15], (worlds, 1))
    goal = np.tile([1.2, 1.5, math.pi / 2.0, 0.15], (worlds, 1))
    return PointToPoint(start, goal, full(worlds, 20.0), at_origin(worlds))


def wide_drive(worlds: int) -> DriveLimits:
    """Return limits that the paper's path never meets."""
    return DriveLimits(MAGELLAN_PRO, full(worlds, 50.0), full(worlds, 500.0), full(worlds, 1e-3))


def nominal_law(pole: Array, drive: DriveLimits | None = None) -> NominalKinematic:
    return NominalKinematic(drive or wide_drive(len(pole)), chain_gains(pole, 2))


def robust_law(
    pole: Array,
    slip_bound: Array,
    boundary_layer: Array,
    bound: UncertaintyBound = UNCERTAINTIES["paper"].bound,
    drive: DriveLimits | None = None,
) -> RobustKinematic:
    gains = chain_gains(pole, 2)
    weights = np.stack([lyapunov_matrix(row)[:, 1] for row in gains])
    return RobustKinematic(drive or wide_drive(len(pole)), gains, weights, slip_bound, boundary_layer, bound)


def ode_plant(slip_law: SlipLaw, worlds: int, arena: float = 50.0) -> KinematicOde:
    return KinematicOde(MAGELLAN_PRO, slip_law, full(worlds, arena))


def paper_slip(worlds: int = 1, fraction: float = PAPER_SLIP) -> ProportionalSlip:
    return ProportionalSlip(full(worlds, fraction), full(worlds, fraction), full(worlds, fraction))


def rows_of(plan: Plan, tick: float, duration: float) -> Reference:
    """Return a plan's rows, (T + 1, N, 2), as the loop wants them."""
    at = plan.at(np.arange(round(duration / tick) + 1.0) * tick)
    return Reference(
        position=np.swapaxes(at.position, 0, 1).copy(),
        velocity=np.swapaxes(at.velocity, 0, 1).copy(),
        acceleration=np.swapaxes(at.acceleration, 0, 1).copy(),
        jerk=np.swapaxes(at.jerk, 0, 1).copy(),
    )


def planned_start(references: Reference) -> Start:
    """Return the start that the first row of a plan asks for."""
    v, a = references.velocity[0], references.acceleration[0]
    squared = v[:, 0] ** 2 + v[:, 1] ** 2
    turn = (v[:, 0] * a[:, 1] - v[:, 1] * a[:, 0]) / squared
    push = (v[:, 0] * a[:, 0] + v[:, 1] * a[:, 1]) / np.sqrt(squared)
    return Start(references.position[0], np.arctan2(v[:, 1], v[:, 0]), np.sqrt(squared), turn, push)


def start_of(position: Array, heading: Array, forward_speed: Array, yaw_rate: Array) -> Start:
    """Return a start that pushes at nothing yet."""
    return Start(position, heading, forward_speed, yaw_rate, np.zeros_like(forward_speed))


@dataclass(frozen=True)
class Track:
    """Everything that a simulation wrote."""

    rows: list[Row]
    ending: Ending

    def stack(self, *path: str) -> Array:
        """Return one signal of all rows, (T + 1, N, …), by its attribute path."""
        return np.stack([_follow(row, path) for row in self.rows])

    @property
    def position_error(self) -> Array:
        """Distance to the reference at the same time, (T + 1, N) [m]."""
        gap = self.stack("motion", "position") - self.stack("reference", "position")
        return np.sqrt(gap[..., 0] ** 2 + gap[..., 1] ** 2)


def _follow(value: Any, path: Iterable[str]) -> Any:
    for name in path:
        value = getattr(value, name)
    return value


def track(
    plant: Plant, controller: Controller, references: Reference, tick: float, start: Start | None = None
) -> Track:
    """Run the loop and keep every row."""
    rows: list[Row] = []
    ending = simulate(
        plant,
        controller,
        references,
        start or planned_start(references),
        tick,
        lambda _, row: rows.append(row),
    )
    return Track(rows, ending)


@dataclass(frozen=True)
class Errors:
    """Maximum, RMS and final position error of one world [m]."""

    maximum: float
    rms: float
    final: float

    @classmethod
    def of(cls, position_error: Array) -> Errors:
        return cls(
            float(position_error.max()), float(np.sqrt(np.mean(position_error**2))), float(position_error[-1])
        )


def leaves(value: Any, path: str = "") -> dict[str, Any]:
    """Return every array and number inside nested dataclasses and tuples, by its path."""
    if isinstance(value, Motion | Reference) or is_dataclass(value):
        found = {}
        for field in fields(value):
            found |= leaves(getattr(value, field.name), f"{path}.{field.name}")
        return found
    if isinstance(value, tuple):
        found = {}
        for index, item in enumerate(value):
            found |= leaves(item, f"{path}[{index}]")
        return found
    return {} if value is None else {path: value}
