"""What a simulation leaves behind: columns (worlds, rows), then Arrow tables.

A column's name is its only name: in `signals.parquet`, in Python and as a Rerun entity path.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from slipctl.guarantee import UNITS as GUARANTEE_UNITS
from slipctl.simulate import Ending, Row, Sensed
from slipctl.theory.flatness import flat_to_state
from slipctl.theory.slip import slip_ratio
from slipctl.tick import BodyPose, PathTime, SpeedCommand, TorqueCommand, WheelContact

if TYPE_CHECKING:
    import pyarrow as pa

Columns = dict[str, NDArray]

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
    read : callable
        From a row to an array (N,) or (N, components), or to None where the run has no such quantity.
    """

    name: str
    unit: str
    parts: tuple[str, ...]
    read: Callable[[Row], NDArray | None]


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
    Signal("slip.longitudinal", "m/s", SCALAR, lambda row: row.slip.longitudinal),
    Signal("slip.lateral", "m/s", SCALAR, lambda row: row.slip.lateral),
    Signal("slip.yaw", "rad/s", SCALAR, lambda row: row.slip.yaw),
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


@dataclass
class Recorder:
    """Collects rows in memory; a simulation's `write`.

    Attributes
    ----------
    rows, worlds : int
        Rows including both ends, and worlds.
    """

    rows: int
    worlds: int
    _slots: list[tuple[Callable[[Row], NDArray | None], NDArray]] = field(default_factory=list)
    _names: list[Signal] = field(default_factory=list)

    def write(self, k: int, row: Row) -> None:
        """Keep row `k`."""
        if k == 0:
            self._open(row)
        for read, slot in self._slots:
            slot[k] = read(row)

    def _open(self, row: Row) -> None:
        for signal in SIGNALS:
            value = signal.read(row)
            if value is not None:
                self._names.append(signal)
                # zeros and not NaN: rows after a world's end are never read
                self._slots.append((signal.read, np.zeros((self.rows, *value.shape), dtype=value.dtype)))

    def columns(self) -> Columns:
        """Return the recorded signals as contiguous (worlds, rows) arrays, by column name."""
        columns: Columns = {}
        for signal, (_, slot) in zip(self._names, self._slots, strict=True):
            parts = slot[:, :, None] if signal.parts == SCALAR else slot
            for index, part in enumerate(signal.parts):
                columns[signal.name + part] = np.ascontiguousarray(parts[:, :, index].T)
        return columns


def with_errors(columns: Columns) -> Columns:
    """Add what follows from the recorded columns: reference state, heading, slip ratio and errors.

    Parameters
    ----------
    columns : dict of (N, T) arrays

    Returns
    -------
    dict of (N, T) arrays
        Heading vectors replaced by `motion.heading` and `sensed.heading`; the position error is the distance
        to the reference at the same time, cross-track its component along the reference's left normal,
        heading error wrapped to (−π, π].
    """
    columns = dict(columns)
    # a path that rests has a heading in its own time only
    stem = "reference.path_" if "reference.path_time" in columns else "reference."
    velocity, acceleration = _pair(columns, stem + "velocity"), _pair(columns, stem + "acceleration")
    speed, heading, _, yaw_rate = flat_to_state(velocity, acceleration)
    rate = columns.get("reference.path_rate", 1.0)
    columns["reference.heading"] = heading
    columns["reference.forward_speed"] = speed * rate
    columns["reference.yaw_rate"] = yaw_rate * rate
    for seen in ("motion", "sensed") if "sensed.fix" in columns else ("motion",):
        cosine, sine = columns.pop(f"{seen}.heading_vector.x"), columns.pop(f"{seen}.heading_vector.y")
        columns[f"{seen}.heading"] = np.arctan2(sine, cosine)
    columns["slip.ratio"] = slip_ratio(
        columns["slip.longitudinal"], columns["slip.lateral"], columns["motion.forward_speed"]
    )
    x = columns["motion.position.x"] - columns["reference.position.x"]
    y = columns["motion.position.y"] - columns["reference.position.y"]
    columns["error.position"] = np.sqrt(x * x + y * y)
    with np.errstate(invalid="ignore", divide="ignore"):
        columns["error.cross_track"] = (y * velocity[..., 0] - x * velocity[..., 1]) / speed
    turn = columns["motion.heading"] - heading
    columns["error.heading"] = np.arctan2(np.sin(turn), np.cos(turn))
    return columns


def _pair(columns: Columns, stem: str) -> NDArray:
    return np.stack([columns[f"{stem}.x"], columns[f"{stem}.y"]], axis=-1)


def signal_table(run: int, world: int, columns: Columns, ending: Ending, tick: float) -> pa.Table:
    """Return the rows of one world of a simulation as a table with units in the field metadata.

    Parameters
    ----------
    run : int
        Index of the run, written in the column `run`.
    world : int
        Row of the arrays in `columns`.
    columns : dict of (N, T) arrays
    ending : Ending
        Rows after the world's end are left out.
    tick : float
        [s].

    Returns
    -------
    pyarrow.Table
        The same schema for every law on a plant: what a law does not have is null. Bodies and contacts are
        left out where the plant has none.
    """
    import pyarrow as pa

    rows = int(ending.last_row[world]) + 1
    arrays = [pa.array(np.full(rows, run, dtype=np.int32)), pa.array(np.arange(rows) * tick)]
    fields = [pa.field("run", pa.int32(), metadata={"unit": "1"})]
    fields.append(pa.field("time", pa.float64(), metadata={"unit": "s"}))
    for name, unit in UNITS.items():
        if "decision.acceleration" in columns and name.startswith(FLAT_INPUTS):
            unit = "m/s³"
        kind = pa.bool_() if unit == "bool" else pa.float64()
        if name in columns:
            # the uncertainty of a tick needs the next row, which the last row does not have
            mask = np.arange(rows) == rows - 1 if name.startswith("guarantee.") else None
            array = pa.array(columns[name][world, :rows], type=kind, mask=mask)
        elif name in LAW_COLUMNS or (name in PATH_COLUMNS and "reference.path_time" in columns):
            array = pa.nulls(rows, kind)
        else:
            continue
        arrays.append(array)
        fields.append(pa.field(name, kind, metadata={"unit": unit}))
    return pa.Table.from_arrays(arrays, schema=pa.schema(fields))
