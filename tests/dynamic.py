"""Dynamic plants, laws and plans that several tests build."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from slipctl.control.nominal_dynamic import NominalDynamic
from slipctl.control.robust_dynamic import RobustDynamic
from slipctl.control.torque import TorqueDrive
from slipctl.plants.dynamic_ode import DynamicOde
from slipctl.theory.dynamic import Inertia
from slipctl.theory.reference import PointToPoint
from slipctl.theory.robot import MAGELLAN_PRO
from slipctl.theory.robust import chain_gains, lyapunov_matrix
from slipctl.theory.robust_dynamic import (
    DynamicBound,
    GeneralDynamicBound,
    PaperDynamicBound,
    ProportionalDynamicBound,
)
from slipctl.theory.slip import SlipLaw
from slipctl.tick import Array
from tests.builders import at_origin, full

PAPER_BODY = Inertia(MAGELLAN_PRO, mass=18.2, yaw_inertia=0.39375)
"""Table II."""

DYNAMIC_SLIP = 0.3
DYNAMIC_LAYER = 0.005

BOUNDS: dict[str, Callable[[Array], DynamicBound]] = {
    "paper": PaperDynamicBound,
    "proportional": ProportionalDynamicBound,
    "general": lambda slip_bound: GeneralDynamicBound(
        slip_bound,
        yaw_slip_bound=0.3 * slip_bound,
        lateral_slip_bound=0.3 * slip_bound,
        lateral_slip_rate_bound=0.1 * slip_bound,
        lateral_slip_acceleration_bound=0.1 * slip_bound,
        coupling_bound=0.5 * slip_bound,
    ),
}
"""By the scenario's names, from α (N,) to ρ as a function; the numbers of the general form are made up."""


def quintic_table_one(worlds: int = 1) -> PointToPoint:
    """Return the plan of Section V-B: Table I with w = 0 and μ₁ = 0 at both ends."""
    start = np.tile([0.0, 0.0, math.pi / 2.0, 0.15, 0.0, 0.0], (worlds, 1))
    goal = np.tile([1.2, 1.5, math.pi / 2.0, 0.15, 0.0, 0.0], (worlds, 1))
    return PointToPoint(start, goal, full(worlds, 20.0), at_origin(worlds))


def wide_torque(worlds: int, body: Inertia = PAPER_BODY) -> TorqueDrive:
    """Return motors whose limits the paper's path never meets."""
    return TorqueDrive(body, full(worlds, 1e6), full(worlds, 1e-3))


def nominal_dynamic(pole: Array, drive: TorqueDrive | None = None) -> NominalDynamic:
    return NominalDynamic(drive or wide_torque(len(pole)), chain_gains(pole, 3))


def robust_dynamic(
    pole: Array, boundary_layer: Array, bound: DynamicBound, drive: TorqueDrive | None = None
) -> RobustDynamic:
    gains = chain_gains(pole, 3)
    weights = np.stack([lyapunov_matrix(row)[:, 2] for row in gains])
    return RobustDynamic(drive or wide_torque(len(pole)), gains, weights, boundary_layer, bound)


def dynamic_plant(
    slip_law: SlipLaw, worlds: int, arena: float = 50.0, body: Inertia = PAPER_BODY
) -> DynamicOde:
    return DynamicOde(body, slip_law, full(worlds, arena))
