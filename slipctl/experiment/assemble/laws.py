"""The controllers of a batch, and what their theorems assume."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from slipctl import scenario as files
from slipctl.control.drive import DriveLimits
from slipctl.control.nominal_dynamic import NominalDynamic
from slipctl.control.nominal_kinematic import NominalKinematic
from slipctl.control.robust_dynamic import RobustDynamic
from slipctl.control.robust_kinematic import RobustKinematic
from slipctl.control.time_scaled import KinematicLaw, TimeScaledLaw
from slipctl.control.torque import TorqueDrive
from slipctl.experiment.assemble.beliefs import believed, misled
from slipctl.experiment.assemble.robot import RobotModel, paper_inertia
from slipctl.experiment.assemble.stack import World, gather
from slipctl.guarantee import Hypotheses
from slipctl.simulate import Controller
from slipctl.theory.dynamic import Inertia
from slipctl.theory.robust import UNCERTAINTIES, chain_gains, lyapunov_matrix
from slipctl.theory.robust_dynamic import GeneralDynamicBound, PaperDynamicBound, ProportionalDynamicBound
from slipctl.tick import Array


@dataclass(frozen=True)
class Law:
    """A controller for one batch and what its theorem assumes.

    Attributes
    ----------
    controller : Controller
    hypotheses : Hypotheses or None
        None for a law without a theorem.
    """

    controller: Controller
    hypotheses: Hypotheses | None


def law(worlds: Sequence[World], index: int, robot: RobotModel) -> Law:
    """Return the `index`-th listed controller for a batch, for the robot that it believes in."""
    kind = worlds[0].scenario.controller[index].kind
    build = _dynamic if kind in ("nominal_dynamic", "robust_dynamic") else _kinematic
    known = believed(worlds, index, robot.inertia)
    made = build(worlds, index, known)
    return Law(misled(made.controller, known.geometry, robot.geometry), made.hypotheses)


def _each(worlds: Sequence[World], index: int, name: str) -> Array:
    return gather(worlds, lambda scenario: getattr(scenario.controller[index], name))


def _kinematic(worlds: Sequence[World], index: int, known: Inertia) -> Law:
    def each(name: str) -> Array:
        return _each(worlds, index, name)

    drive = DriveLimits(
        geometry=known.geometry,
        speed_limit=gather(worlds, lambda scenario: scenario.robot.speed_limit),
        yaw_rate_limit=gather(worlds, lambda scenario: scenario.robot.yaw_rate_limit),
        speed_floor=each("speed_floor"),
    )
    first = worlds[0].scenario.controller[index]
    scaled = getattr(first, "time_scaled", None)
    inner = drive.unlimited() if scaled else drive
    gains = chain_gains(each("pole"), 2)

    def timed(law: KinematicLaw) -> Controller:
        return TimeScaledLaw(law, drive) if scaled else law

    if not isinstance(first, files.RobustKinematic):
        return Law(timed(NominalKinematic(inner, gains)), None)
    slip_bound = each("slip_bound")
    controller = RobustKinematic(
        drive=inner,
        gains=gains,
        weights=np.ascontiguousarray(_lyapunov(gains)[:, :, 1]),
        slip_bound=slip_bound,
        boundary_layer=each("boundary_layer"),
        bound=UNCERTAINTIES[first.uncertainty].bound,
    )
    hypotheses = Hypotheses(
        slip_bound,
        drive.speed_floor,
        first.uncertainty,
        boundary_layer=each("boundary_layer"),
        gains=gains,
        weights=_lyapunov(gains),
    )
    return Law(timed(controller), hypotheses)


def _lyapunov(gains: Array) -> Array:
    """Return the Lyapunov matrix of every row of gains; most worlds have the same, which is solved once."""
    solved = {key: lyapunov_matrix(np.array(key)) for key in {tuple(row) for row in gains.tolist()}}
    return np.stack([solved[tuple(row)] for row in gains.tolist()])


def _dynamic(worlds: Sequence[World], index: int, known: Inertia) -> Law:
    def each(name: str) -> Array:
        return _each(worlds, index, name)

    first = worlds[0].scenario.controller[index]
    drive = TorqueDrive(
        inertia=known_inertia(worlds, known),
        torque_limit=gather(worlds, lambda scenario: scenario.robot.torque_limit),
        speed_floor=each("speed_floor"),
    )
    gains = chain_gains(each("pole"), 3)
    if not isinstance(first, files.RobustDynamic):
        return Law(NominalDynamic(drive, gains), None)
    slip_bound = each("slip_bound")
    if first.uncertainty == "general":
        bound = GeneralDynamicBound(slip_bound, *(each(name) for name in GENERAL_KEYS))
    else:
        bound = {"paper": PaperDynamicBound, "proportional": ProportionalDynamicBound}[first.uncertainty](
            slip_bound
        )
    controller = RobustDynamic(
        drive=drive,
        gains=gains,
        weights=np.ascontiguousarray(_lyapunov(gains)[:, :, 2]),
        boundary_layer=each("boundary_layer"),
        bound=bound,
    )
    general = first.uncertainty == "general"
    hypotheses = Hypotheses(
        slip_bound,
        drive.speed_floor,
        first.uncertainty,
        boundary_layer=each("boundary_layer"),
        gains=gains,
        weights=_lyapunov(gains),
        yaw_slip_bound=each("yaw_slip_bound") if general else None,
        lateral_slip_bound=each("lateral_slip_bound") if general else None,
    )
    return Law(controller, hypotheses)


GENERAL_KEYS = (
    "yaw_slip_bound",
    "lateral_slip_bound",
    "lateral_slip_rate_bound",
    "lateral_slip_acceleration_bound",
    "coupling_bound",
)
"""In the order of `GeneralDynamicBound`."""


def known_inertia(worlds: Sequence[World], known: Inertia) -> Inertia:
    """Return what laws know of the wheels beside what they believe: as on MuJoCo, or as in the paper."""
    return _wheels_known(worlds, known) if compensates(worlds) else paper_inertia(known)


def _wheels_known(worlds: Sequence[World], known: Inertia) -> Inertia:
    """Return what the law compensates: the model's wheel inertia and joint friction, or the file's."""
    robot = worlds[0].scenario.robot

    def told(name: str) -> Array:
        return gather(worlds, lambda scenario: getattr(scenario.robot, name))

    return replace(
        known,
        wheel_inertia=known.wheel_inertia if robot.wheel_inertia is None else told("wheel_inertia"),
        joint_friction=known.joint_friction if robot.joint_friction is None else told("joint_friction"),
    )


def compensates(worlds: Sequence[World]) -> bool:
    """Return whether the law knows of wheel inertia and joint friction: on MuJoCo, unless told not to.

    The dynamic ODE is the paper's model, which neglects both.
    """
    scenario = worlds[0].scenario
    return scenario.plant.kind == "mujoco" and scenario.robot.compensate_wheels
