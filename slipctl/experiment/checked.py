"""A law of one's own, watched: what it gives must fit, and what goes wrong names the law and the tick."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from slipctl.simulate import Controller
from slipctl.tick import Decision, DecisionTrace, Motion, Reference, SpeedCommand, Start, TorqueCommand

Shared = TypeVar("Shared", Motion, SpeedCommand, TorqueCommand)
"""What passes between a law and the rest."""

COMMANDS: dict[str, type[SpeedCommand] | type[TorqueCommand]] = {
    "wheel_speed": SpeedCommand,
    "wheel_torque": TorqueCommand,
}
"""What a robot's drive is told."""

PAIRS = ("wheel_rate", "wheel_torque_start", "wheel_torque_end")
"""Fields of a command with one number per wheel."""

PAIRS_OF_TRACE = ("nominal_input", "robust_input", "weighted_error", "path_velocity")
"""Fields of a trace with an x and a y."""

REQUIRED_OF_TRACE = ("nominal_input", "robust_input", "saturated")

LARGEST = 1e6
"""In SI units: a robot beyond is lost, and its law may give what is not a number."""


class OwnLawError(Exception):
    """A law of one's own cannot be used; the message is one line that names the law, and the tick if any."""


@dataclass(frozen=True)
class Watched:
    """What is remembered of a law: its own memory, which tick comes next, and which worlds are lost.

    Attributes
    ----------
    memory : object
    k : int
        Index of the next tick.
    lost : (N,) bool array
        Worlds in which the law was shown a motion that is not finite or absurdly large.
    """

    memory: Any
    k: int
    lost: NDArray[np.bool_]


@dataclass(frozen=True)
class CheckedLaw:
    """A law whose every decision is checked before it reaches the robot.

    It may write into the arrays that it is shown, and again into those that it gave: they are copies.

    Attributes
    ----------
    label : str
    law : Controller
    drive : str
        ``wheel_speed`` or ``wheel_torque``.
    worlds : int
        N.

    Raises
    ------
    OwnLawError
        From `start` and `update`: the law raised, or gave something of another type or shape, or a command
        that is not finite although the robot's motion is.
    """

    label: str
    law: Controller
    drive: str
    worlds: int

    def start(self, start: Start) -> Watched:
        """Return the memory at the start."""
        try:
            memory = self.law.start(start)
        except Exception as error:
            raise OwnLawError(
                f"law {self.label!r} failed at its start: {type(error).__name__}: {error}"
            ) from error
        return Watched(memory, 0, np.zeros(self.worlds, dtype=bool))

    def update(self, memory: Watched, reference: Reference, motion: Motion, tick: float) -> Decision[Any]:
        """Decide the command of one tick."""
        where = f"law {self.label!r} at tick {memory.k} ({memory.k * tick:g} s)"
        try:
            decision = self.law.update(memory.memory, reference.each(np.array), _copied(motion), tick)
        except Exception as error:
            raise OwnLawError(f"{where} failed: {type(error).__name__}: {error}") from error
        lost = memory.lost | _lost(motion)
        wrong = next(self._wrong(decision, lost), None)
        if wrong is not None:
            raise OwnLawError(f"{where} gave {wrong}")
        command = _copied(decision.command)
        return Decision(command, Watched(decision.memory, memory.k + 1, lost), decision.trace)

    def _wrong(self, decision: Any, lost: NDArray[np.bool_]) -> Iterator[str]:
        if not isinstance(decision, Decision):
            yield f"a {type(decision).__name__}, needed is a slipctl.tick.Decision"
            return
        command, trace, needed = decision.command, decision.trace, COMMANDS[self.drive]
        if not isinstance(command, needed):
            yield f"a {type(command).__name__}, a robot driven by {self.drive} needs a {needed.__name__}"
            return
        if not isinstance(trace, DecisionTrace):
            yield f"a {type(trace).__name__} as its trace, needed is a DecisionTrace"
            return
        for field in fields(command):
            value, name = getattr(command, field.name), f"command.{field.name}"
            shape = (self.worlds, 2) if field.name in PAIRS else (self.worlds,)
            yield from _misshapen(name, value, shape)
            broken = ~np.isfinite(value) & ~(lost[:, None] if len(shape) == 2 else lost)
            if broken.any():
                world = int(np.argwhere(broken)[0][0])
                yield (
                    f"a {name} that is not finite (world {world} of its batch), though the motion it saw is: "
                    f"{np.asarray(value)[world]}"
                )
        for field in fields(trace):
            value = getattr(trace, field.name)
            if value is None and field.name not in REQUIRED_OF_TRACE:
                continue
            shape = (self.worlds, 2) if field.name in PAIRS_OF_TRACE else (self.worlds,)
            yield from _misshapen(f"trace.{field.name}", value, shape, bool if shape[1:] == () else float)


def _misshapen(name: str, value: Any, shape: tuple[int, ...], kind: type = float) -> Iterator[str]:
    if not isinstance(value, np.ndarray):
        yield f"{name} as a {type(value).__name__}, needed is an array of shape {shape}: one row per world"
    elif value.shape != shape:
        yield f"{name} of shape {value.shape}, needed is {shape}: one row per world"
    elif value.dtype.kind not in ("biuf" if kind is bool else "iuf"):
        yield f"{name} of type {value.dtype}, needed are numbers"


def _copied(given: Shared) -> Shared:
    """Return the same with arrays of its own."""
    arrays: dict[str, Any] = {field.name: getattr(given, field.name) for field in fields(given)}
    arrays |= {name: np.array(array) for name, array in arrays.items() if array is not None}
    return type(given)(**arrays)


def _lost(motion: Motion) -> NDArray[np.bool_]:
    """Return the worlds whose motion is not finite or absurdly large."""
    sizes = np.abs(motion.position).max(axis=1), np.abs(motion.velocity).max(axis=1)
    # a comparison with NaN is false
    kept = (sizes[0] < LARGEST) & (sizes[1] < LARGEST) & (np.abs(motion.heading_rate) < LARGEST)
    return ~(kept & (np.abs(motion.wheel_rate).max(axis=1) < LARGEST))
