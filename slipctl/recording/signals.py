"""Every quantity of the loop that is recorded, and its unit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from numpy.typing import NDArray

from slipctl.guarantee import UNITS as GUARANTEE_UNITS
from slipctl.simulate import Row, Sensed
from slipctl.tick import BodyPose, PathTime, SpeedCommand, TorqueCommand, WheelContact

Columns = dict[str, NDArray]
"""Arrays (worlds, rows) by column name."""

XY = (".x", ".y")
SIDES = (".left", ".right")
QUATERNION = (".w", ".x", ".y", ".z")
SCALAR = ("",)


@dataclass(frozen=True)
class Signal:
    """One quantity of the loop, recorded in every row.

    Attributes
    ----------
    name : str
        Column name without the component.
    unit : str
    parts : tuple of str
        Endings of the component columns.
    read : callable or None
        From a row to an array (N,) or (N, components), or to None where the run has no such quantity. None
        for what follows from other columns: whole columns of it take fewer calls than its rows.
    """

    name: str
    unit: str
    parts: tuple[str, ...]
    read: Callable[[Row], NDArray | None] | None


def _path(read: Callable[[PathTime], NDArray]) -> Callable[[Row], NDArray | None]:
    return lambda row: None if row.reference.path_time is None else read(row.reference.path_time)


def _pose(read: Callable[[BodyPose], NDArray]) -> Callable[[Row], NDArray | None]:
    return lambda row: None if row.details is None else read(row.details[0])


def _contact(read: Callable[[WheelContact], NDArray]) -> Callable[[Row], NDArray | None]:
    return lambda row: None if row.details is None else read(row.details[1])


def _speed(read: Callable[[SpeedCommand], NDArray]) -> Callable[[Row], NDArray | None]:
    def reading(row: Row) -> NDArray | None:
        command = row.decision.command
        return read(command) if isinstance(command, SpeedCommand) else None

    return reading


def _sensed(read: Callable[[Sensed], NDArray]) -> Callable[[Row], NDArray | None]:
    return lambda row: None if row.sensed is None else read(row.sensed)


def _torque(read: Callable[[TorqueCommand], NDArray]) -> Callable[[Row], NDArray | None]:
    def reading(row: Row) -> NDArray | None:
        command = row.decision.command
        return read(command) if isinstance(command, TorqueCommand) else None

    return reading


SIGNALS = (
    Signal("reference.position", "m", XY, lambda row: row.reference.position),
    Signal("reference.velocity", "m/s", XY, lambda row: row.reference.velocity),
    Signal("reference.acceleration", "m/s²", XY, lambda row: row.reference.acceleration),
    Signal("reference.jerk", "m/s³", XY, lambda row: row.reference.jerk),
    Signal("reference.path_time", "s", SCALAR, _path(lambda path: path.elapsed)),
    Signal("reference.path_rate", "1", SCALAR, _path(lambda path: path.rate)),
    Signal("reference.path_velocity", "m/s", XY, _path(lambda path: path.velocity)),
    Signal("reference.path_acceleration", "m/s²", XY, _path(lambda path: path.acceleration)),
    Signal("motion.position", "m", XY, lambda row: row.motion.position),
    Signal("motion.velocity", "m/s", XY, lambda row: row.motion.velocity),
    Signal("motion.heading_vector", "1", XY, lambda row: row.motion.heading_vector),
    Signal("motion.heading_rate", "rad/s", SCALAR, lambda row: row.motion.heading_rate),
    Signal("motion.acceleration", "m/s²", XY, lambda row: row.motion.acceleration),
    Signal("motion.forward_speed", "m/s", SCALAR, lambda row: row.motion.forward_speed),
    Signal("motion.yaw_rate", "rad/s", SCALAR, lambda row: row.motion.yaw_rate),
    Signal("sensed.position", "m", XY, _sensed(lambda sensed: sensed.motion.position)),
    Signal("sensed.velocity", "m/s", XY, _sensed(lambda sensed: sensed.motion.velocity)),
    Signal("sensed.heading_vector", "1", XY, _sensed(lambda sensed: sensed.motion.heading_vector)),
    Signal("sensed.fix", "bool", SCALAR, _sensed(lambda sensed: sensed.fix)),
    Signal("slip.longitudinal", "m/s", SCALAR, None),
    Signal("slip.lateral", "m/s", SCALAR, None),
    Signal("slip.yaw", "rad/s", SCALAR, None),
    Signal("decision.nominal_input", "m/s²", XY, lambda row: row.decision.trace.nominal_input),
    Signal("decision.robust_input", "m/s²", XY, lambda row: row.decision.trace.robust_input),
    Signal("decision.robust_gain", "m/s²", SCALAR, lambda row: row.decision.trace.robust_gain),
    Signal("decision.weighted_error", "1", XY, lambda row: row.decision.trace.weighted_error),
    Signal("decision.path_speed", "m/s", SCALAR, lambda row: row.decision.trace.path_speed),
    Signal("decision.path_velocity", "m/s", XY, lambda row: row.decision.trace.path_velocity),
    Signal("decision.forward_speed", "m/s", SCALAR, _speed(lambda command: command.forward_speed)),
    Signal("decision.yaw_rate", "rad/s", SCALAR, _speed(lambda command: command.yaw_rate)),
    Signal("decision.acceleration", "m/s²", SCALAR, _torque(lambda command: command.acceleration)),
    Signal("decision.yaw_acceleration", "rad/s²", SCALAR, _torque(lambda command: command.yaw_acceleration)),
    Signal("decision.saturated", "bool", SCALAR, lambda row: row.decision.trace.saturated),
    Signal("wheel.rate", "rad/s", SIDES, lambda row: row.motion.wheel_rate),
    Signal("wheel.angle", "rad", SIDES, lambda row: row.motion.wheel_angle),
    Signal("wheel.rate_command", "rad/s", SIDES, _speed(lambda command: command.wheel_rate)),
    Signal("wheel.torque_command", "N·m", SIDES, _torque(lambda command: command.wheel_torque_start)),
    Signal("wheel.torque", "N·m", SIDES, _contact(lambda contact: contact.torque)),
    Signal("wheel.normal_force", "N", SIDES, _contact(lambda contact: contact.normal_force)),
    Signal("wheel.longitudinal_force", "N", SIDES, _contact(lambda contact: contact.longitudinal_force)),
    Signal("wheel.lateral_force", "N", SIDES, _contact(lambda contact: contact.lateral_force)),
    Signal("wheel.sliding", "bool", SIDES, _contact(lambda contact: contact.sliding)),
    Signal("body.height", "m", SCALAR, _pose(lambda pose: pose.height)),
    Signal("body.quaternion", "1", QUATERNION, _pose(lambda pose: pose.quaternion)),
)

DERIVED_UNITS = {
    "reference.heading": "rad",
    "reference.forward_speed": "m/s",
    "reference.yaw_rate": "rad/s",
    "motion.heading": "rad",
    "sensed.heading": "rad",
    "slip.ratio": "1",
    "error.position": "m",
    "error.cross_track": "m",
    "error.heading": "rad",
} | GUARANTEE_UNITS
"""Columns computed from the recorded ones after the loop."""

UNITS = {
    signal.name + part: signal.unit
    for signal in SIGNALS
    for part in signal.parts
    if not signal.name.endswith(".heading_vector")  # told by the heading
} | DERIVED_UNITS
"""Every column of `signals.parquet` but `run` and `time`, and its unit."""

FLAT_INPUTS = (
    "decision.nominal_input",
    "decision.robust_input",
    "decision.robust_gain",
    "guarantee.uncertainty",
)
"""Columns that are inputs of the flat model: accelerations, or jerks for a dynamic law."""

LAW_COLUMNS = {
    "decision.robust_gain",
    "decision.weighted_error.x",
    "decision.weighted_error.y",
} | (set(GUARANTEE_UNITS) - {"guarantee.uncertainty"})
"""Columns that only some laws fill."""

PATH_COLUMNS = {"decision.path_speed", "decision.path_velocity.x", "decision.path_velocity.y"}
"""Columns that only laws in the path's own time fill."""
