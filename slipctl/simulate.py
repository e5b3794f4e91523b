"""The two protocols and the one loop.

The loop states what it needs of a plant and of a controller; implementations know neither each other nor it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from slipctl.theory.slip import measure_slip
from slipctl.tick import (
    BodyPose,
    Decision,
    Motion,
    Reference,
    Slip,
    Start,
    Status,
    WheelContact,
)


class Plant(Protocol):
    """A robot on its ground. State goes in and comes out; a step never changes an old state."""

    def start(self, start: Start) -> Any:
        """Return the state at t = 0."""
        ...

    def observe(self, state: Any) -> Motion:
        """Return the motion at the state's instant."""
        ...

    def details(self, state: Any) -> tuple[BodyPose, WheelContact] | None:
        """Return poses and contacts, or None where the plant has none."""
        ...

    def step(self, state: Any, command: Any, tick: float) -> Any:
        """Return the state one tick [s] later; its `status` is an (N,) array of `Status`.

        The command is the one of the plant's drive, a `SpeedCommand` or a `TorqueCommand`.
        """
        ...


class Controller(Protocol):
    """A tracking law. What it remembers is returned, never stored."""

    def start(self, start: Start) -> Any:
        """Return the memory at the start."""
        ...

    def update(self, memory: Any, reference: Reference, motion: Motion, tick: float) -> Decision[Any]:
        """Decide the command of one tick [s]."""
        ...


class Sensor(Protocol):
    """What a controller gets to see. Memory goes in and comes out; its `fix` is an (N,) bool array."""

    def start(self, motion: Motion) -> Any:
        """Return the memory before the first row, from the motion at t = 0."""
        ...

    def measure(self, memory: Any, k: int, motion: Motion) -> tuple[Any, Motion]:
        """Return the memory after row `k` and the motion as it is seen there."""
        ...


@dataclass(frozen=True)
class Sensed:
    """What a sensor made of the motion.

    Attributes
    ----------
    motion : Motion
        As the controller saw it.
    fix : (N,) bool array
        Whether a camera fix arrived.
    """

    motion: Motion
    fix: NDArray[np.bool_]


@dataclass(frozen=True)
class Row:
    """Everything true at t_k, what the controller saw of it, and the decision that acts from t_k on.

    Slip and details feed nothing back, so they are worked out when they are asked for: a state never changes.

    Attributes
    ----------
    reference : Reference
    motion : Motion
    decision : Decision
    plant : Plant
    state : object
        Of the plant.
    sensed : Sensed or None
        None where the controller saw the true motion itself.
    """

    reference: Reference
    motion: Motion
    decision: Decision[Any]
    plant: Plant
    state: Any
    sensed: Sensed | None = None

    @cached_property
    def slip(self) -> Slip:
        """What the true motion slips."""
        return measure_slip(self.motion)

    @cached_property
    def details(self) -> tuple[BodyPose, WheelContact] | None:
        """Poses and contacts, or None where the plant has none."""
        return self.plant.details(self.state)


@dataclass(frozen=True)
class Ending:
    """How the worlds of a simulation ended.

    Attributes
    ----------
    status : (N,) int8 array
        Values of `Status`; `RUNNING` means that the world completed.
    last_row : (N,) int array
        The last row that counts.
    """

    status: NDArray[np.int8]
    last_row: NDArray[np.int64]


def simulate(
    plant: Plant,
    controller: Controller,
    references: Reference,
    start: Start,
    tick: float,
    write: Callable[[int, Row], None],
    progress: Callable[[int], None] | None = None,
    sensor: Sensor | None = None,
) -> Ending:
    """Run the closed loop of all worlds over all ticks.

    Parameters
    ----------
    plant, controller : Plant, Controller
        For the same N worlds.
    references : Reference
        Arrays (T + 1, N, 2): one row per tick, both ends included.
    start : Start
    tick : float
        Control period [s].
    write : callable
        Called with k and row k for k = 0 … T.
    progress : callable, optional
        Called with k from time to time.
    sensor : Sensor, optional
        What the controller sees; the true motion where there is none.

    Returns
    -------
    Ending
        A world's last row is the last one at which it still ran.
    """
    rows = len(references.position)
    state = plant.start(start)
    memory = controller.start(start)
    senses: Any = None
    last_row = np.full(len(start.heading), rows - 1)
    running = np.ones(len(start.heading), dtype=bool)
    for k in range(rows):
        reference = references.row(k)
        motion = plant.observe(state)
        seen, sensed = motion, None
        if sensor is not None:
            senses, seen = sensor.measure(sensor.start(motion) if k == 0 else senses, k, motion)
            sensed = Sensed(seen, senses.fix)
        decision = controller.update(memory, reference, seen, tick)
        write(k, Row(reference, motion, decision, plant, state, sensed))
        if k == rows - 1:
            break
        memory = decision.memory
        state = plant.step(state, decision.command, tick)
        ended = running & (state.status != int(Status.RUNNING))
        if np.count_nonzero(ended):  # many times faster than any
            last_row[ended] = k
            running &= ~ended
            if not running.any():
                break
        if progress is not None and k % 64 == 0:
            progress(k)
    return Ending(state.status, last_row)
