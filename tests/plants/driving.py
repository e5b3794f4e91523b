"""Robots to drive in the tests of the MuJoCo plant, and what was seen of them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from slipctl.plants.ground import Ground
from slipctl.plants.mujoco import MujocoPlant
from slipctl.plants.rows import MujocoState
from slipctl.theory.robot import MAGELLAN_PRO
from slipctl.theory.slip import measure_slip
from slipctl.tick import Array, Motion, Slip, SpeedCommand, Start, WheelContact
from tests.builders import start_of

MASS = 18.2
WEIGHT = MASS * 9.81


def full(worlds: int, value: float) -> Array:
    return np.full(worlds, float(value))


def ground(
    worlds: int = 1,
    friction: float = 0.8,
    film: float = math.nan,
    creep_stiffness: float = math.nan,
    slope_deg: float = 0.0,
    downhill_deg: float = 0.0,
) -> Ground:
    return Ground(
        friction=np.full((worlds, 2), float(friction)),
        film=full(worlds, film),
        creep_stiffness=full(worlds, creep_stiffness),
        slope=full(worlds, math.radians(slope_deg)),
        downhill=full(worlds, math.radians(downhill_deg)),
    )


def command(forward_speed: Array, yaw_rate: Array) -> SpeedCommand:
    return SpeedCommand(
        forward_acceleration=np.zeros_like(forward_speed),
        forward_speed=forward_speed,
        yaw_rate=yaw_rate,
        wheel_rate=MAGELLAN_PRO.wheel_rates(forward_speed, yaw_rate),
    )


def start(worlds: int = 1, heading: float = 0.0, forward_speed: float = 0.0, yaw_rate: float = 0.0) -> Start:
    return start_of(
        np.zeros((worlds, 2)), full(worlds, heading), full(worlds, forward_speed), full(worlds, yaw_rate)
    )


@dataclass(frozen=True)
class Seen:
    """What was seen after every tick, the newest last."""

    motion: list[Motion]
    contact: list[WheelContact]

    @property
    def slip(self) -> list[Slip]:
        return [measure_slip(motion) for motion in self.motion]


def drive(
    plant: MujocoPlant,
    state: MujocoState,
    forward_speed: float | Callable[[float], float],
    yaw_rate: float,
    duration: float,
    tick: float = 0.01,
) -> tuple[MujocoState, Seen]:
    """Drive every world alike, at a speed or at speeds of the time, and look on."""
    worlds = len(state.status)
    seen = Seen([], [])
    for k in range(round(duration / tick)):
        speed = forward_speed(k * tick) if callable(forward_speed) else forward_speed
        state = plant.step(state, command(full(worlds, speed), full(worlds, yaw_rate)), tick)
        seen.motion.append(plant.observe(state))
        seen.contact.append(plant.details(state)[1])
    return state, seen


def pushed(plant: MujocoPlant, state: MujocoState, velocity: Array) -> MujocoState:
    """Return the state with another velocity of the base, (N, 2) [m/s]."""
    rows = state.rows.copy()
    rows[:, plant._columns.velocity] = velocity
    return replace(state, rows=rows)
