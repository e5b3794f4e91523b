"""Laws of one's own beside the listed controllers: objects of the public protocol, written in Python."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from slipctl.control.drive import DriveLimits
from slipctl.control.torque import TorqueDrive
from slipctl.experiment import assemble
from slipctl.experiment.checked import CheckedLaw, OwnLawError
from slipctl.guarantee import Hypotheses
from slipctl.scenario.controllers import LABEL_PATTERN
from slipctl.simulate import Controller
from slipctl.theory.dynamic import Inertia
from slipctl.theory.robot import WheelGeometry
from slipctl.tick import Array

KIND = "own"
"""The kind of a law of one's own, where a listed controller has that of the file format."""


@dataclass(frozen=True)
class KnownRobot:
    """What a law of one's own is told of the robot and of the worlds that it is made for.

    Attributes
    ----------
    worlds : int
        N, the length of the leading axis of everything that the law gets and gives.
    tick : float
        Control period [s].
    drive : str
        ``wheel_speed``: a law gives `SpeedCommand`; ``wheel_torque``: it gives `TorqueCommand`.
    inertia : Inertia
        Mass [kg], inertias [kg·m²], joint friction and lengths of the robot, as read off its model.
    speed_limit, yaw_rate_limit, torque_limit : (N,) arrays
        [m/s], [rad/s], [N·m] per wheel.
    """

    worlds: int
    tick: float
    drive: str
    inertia: Inertia
    speed_limit: Array
    yaw_rate_limit: Array
    torque_limit: Array

    @property
    def geometry(self) -> WheelGeometry:
        """Wheel radius and half track [m]."""
        return self.inertia.geometry

    def speed_drive(self, speed_floor: float = 0.05) -> DriveLimits:
        """Return what turns a forward acceleration and a yaw rate into limited wheel rates.

        Parameters
        ----------
        speed_floor : float
            Least commanded speed [m/s].
        """
        floor = np.full(self.worlds, float(speed_floor))
        return DriveLimits(self.geometry, self.speed_limit, self.yaw_rate_limit, floor)

    def torque_drive(self, speed_floor: float = 0.05) -> TorqueDrive:
        """Return what turns a jerk and a yaw acceleration into limited wheel torques.

        Parameters
        ----------
        speed_floor : float
            Least speed in the law's denominator [m/s].
        """
        return TorqueDrive(self.inertia, self.torque_limit, np.full(self.worlds, float(speed_floor)))


OwnLaw = Controller | Callable[[KnownRobot], Controller]
"""A law that fits any number of worlds, or what makes one for the robot that it is told of (a class
will do). One with an attribute `hypotheses` (a `slipctl.guarantee.Hypotheses`) is judged by its theorem."""

OwnLaws = Mapping[str, OwnLaw]
"""By label."""


@dataclass(frozen=True)
class Entrant:
    """One controller of a batch, listed or own.

    Attributes
    ----------
    label, kind : str
    law : Law
    known : WheelGeometry
        What it believes of the robot's lengths.
    """

    label: str
    kind: str
    law: assemble.Law
    known: WheelGeometry


def check_labels(laws: OwnLaws, listed: Sequence[str]) -> None:
    """Refuse labels that no controller may have, or that a listed one has already.

    Raises
    ------
    OwnLawError
        Which label, and what is allowed.
    """
    for label in laws:
        if not isinstance(label, str) or re.fullmatch(LABEL_PATTERN, label) is None:
            raise OwnLawError(
                f"laws: found the label {label!r}, allowed are lower-case letters a-z, digits, _ and -"
            )
        if label in listed:
            raise OwnLawError(
                f"laws: the scenario lists a controller {label!r} itself; give the own law another label "
                f"than {', '.join(listed)}"
            )


def described(laws: OwnLaws) -> dict[str, str]:
    """Say what each own law is: module and name of its class or function, by label."""
    return {label: _name(law) for label, law in laws.items()}


def _name(law: OwnLaw) -> str:
    named: Any = law if hasattr(law, "__qualname__") else type(law)
    return f"{named.__module__}.{named.__qualname__}"


def lineup(
    members: Sequence[assemble.World],
    robot: assemble.RobotModel,
    laws: OwnLaws,
    positions: Sequence[int] | None = None,
) -> Iterator[Entrant]:
    """Yield the controllers of a batch: those listed in the scenario in their order, then the own ones.

    Parameters
    ----------
    members : sequence of World
        The worlds of the batch.
    robot : RobotModel
    laws : mapping
        The own laws by label.
    positions : sequence of int, optional
        Places of the controllers to make, ascending; all of them where it is None.

    Raises
    ------
    OwnLawError
        Where an own law cannot be made or is none.
    """
    listed = members[0].scenario.controller
    wanted = range(len(listed) + len(laws)) if positions is None else positions
    for position, config in enumerate(listed):
        if position not in wanted:
            continue
        law = assemble.law(members, position, robot)
        known = assemble.believed(members, position, robot.inertia).geometry
        yield Entrant(config.label, config.kind, law, known)
    for position, (label, law) in enumerate(laws.items(), start=len(listed)):
        if position not in wanted:
            continue
        made = _made(label, law, _known(members, robot))
        hypotheses = _hypotheses(label, made, len(members))
        checked = CheckedLaw(label, made, members[0].scenario.robot.drive, len(members))
        yield Entrant(label, KIND, assemble.Law(checked, hypotheses), robot.geometry)


def _known(members: Sequence[assemble.World], robot: assemble.RobotModel) -> KnownRobot:
    first = members[0].scenario
    return KnownRobot(
        worlds=len(members),
        tick=first.tick,
        drive=first.robot.drive,
        inertia=assemble.known_inertia(members, robot.inertia),
        speed_limit=assemble.gather(members, lambda scenario: scenario.robot.speed_limit),
        yaw_rate_limit=assemble.gather(members, lambda scenario: scenario.robot.yaw_rate_limit),
        torque_limit=assemble.gather(members, lambda scenario: scenario.robot.torque_limit),
    )


def _made(label: str, law: OwnLaw, known: KnownRobot) -> Controller:
    made: Any = law
    if isinstance(law, type) or not hasattr(law, "update"):
        if not callable(law):
            raise OwnLawError(
                f"law {label!r} is a {type(law).__name__}; needed is an object with start and update, "
                "or something callable that makes one from a KnownRobot"
            )
        try:
            made = law(known)
        except Exception as error:
            raise OwnLawError(
                f"law {label!r} could not be made for this robot: {type(error).__name__}: {error}"
            ) from error
    for method in ("start", "update"):
        if isinstance(made, type) or not callable(getattr(made, method, None)):
            raise OwnLawError(f"law {label!r} is a {type(made).__name__} without a method {method}")
    return made


def _hypotheses(label: str, law: Controller, worlds: int) -> Hypotheses | None:
    """Return the hypotheses that a law offers, for every world of the batch."""
    offered = getattr(law, "hypotheses", None)
    if offered is None:
        return None
    if not isinstance(offered, Hypotheses):
        raise OwnLawError(
            f"law {label!r}: its hypotheses are a {type(offered).__name__}, "
            "needed is a slipctl.guarantee.Hypotheses"
        )
    arrays = {
        field.name: value
        for field in fields(offered)
        if isinstance(value := getattr(offered, field.name), np.ndarray)
    }
    try:
        return replace(
            offered,
            **{name: np.broadcast_to(value, (worlds, *value.shape[1:])) for name, value in arrays.items()},
        )
    except ValueError as error:
        raise OwnLawError(f"law {label!r}: its hypotheses do not fit {worlds} worlds: {error}") from error
