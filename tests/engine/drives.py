"""Wheel commands to replay in every engine: inside the grip, at its limit, and sliding."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from slipctl.theory.robot import GRAVITY, MAGELLAN_PRO
from slipctl.tick import Array

TICK = 0.01
"""[s]."""

ON_WHEELS = 0.8
"""Share of the weight on the wheels; the casters carry the rest without friction."""


@dataclass(frozen=True)
class Drive:
    """Open-loop wheel speeds on a floor, and how the robot starts, at the origin.

    Attributes
    ----------
    name : str
    friction : float
        The same under both wheels [1].
    wheel_rate : (T, 2) array
        Commands of every tick, left, right [rad/s].
    heading : float
        At the start [rad].
    velocity : (2,) array
        Of the body at the start, along the heading and to its left [m/s].
    yaw_rate : float
        Of the body at the start [rad/s].
    rolling : bool
        Whether the wheels start rolling with the body, or locked.
    """

    name: str
    friction: float
    wheel_rate: Array
    heading: float = 0.0
    velocity: tuple[float, float] = (0.0, 0.0)
    yaw_rate: float = 0.0
    rolling: bool = True

    @property
    def duration(self) -> float:
        """Return the length of the drive [s]."""
        return len(self.wheel_rate) * TICK


def grip_limit(friction: float) -> float:
    """Return the largest acceleration that the wheels can give the robot [m/s²]."""
    return friction * ON_WHEELS * GRAVITY


def _times(duration: float) -> Array:
    return np.arange(1.0, round(duration / TICK) + 1.0, dtype=np.float64) * TICK


def _commands(forward_speed: Array | float, yaw_rate: Array | float, duration: float) -> Array:
    shape = np.zeros(round(duration / TICK))
    return MAGELLAN_PRO.wheel_rates(forward_speed + shape, yaw_rate + shape)


def weave(name: str, friction: float, speed: float, share: float, duration: float = 10.0) -> Drive:
    """Return a drive of constant speed whose largest lateral acceleration is a share of the grip's."""
    peak = share * grip_limit(friction) / speed
    yaw_rate = peak * np.sin(2.0 * math.pi * _times(duration) / 5.0)
    return Drive(name, friction, _commands(speed, yaw_rate, duration), velocity=(speed, 0.0))


def locked(name: str, friction: float, direction_deg: float, heading_deg: float = 0.0) -> Drive:
    """Return a slide at 2 m/s with the wheels locked, in a direction from the heading, while it lasts."""
    angle = math.radians(direction_deg)
    duration = 0.75 * 2.0 / grip_limit(friction)
    velocity = (2.0 * math.cos(angle), 2.0 * math.sin(angle))
    still = _commands(0.0, 0.0, duration)
    return Drive(name, friction, still, math.radians(heading_deg), velocity, rolling=False)


def circle(name: str, friction: float, speed: float, share: float, duration: float = 4.0) -> Drive:
    """Return a circle whose lateral acceleration is a share of the grip's."""
    yaw_rate = share * grip_limit(friction) / speed
    commands = _commands(speed, yaw_rate, duration)
    return Drive(name, friction, commands, velocity=(speed, 0.0), yaw_rate=yaw_rate)


def tightening(name: str, friction: float, yaw_rate: float = 2.0, duration: float = 8.0) -> Drive:
    """Return a circle driven faster and faster, from 0.7 to 1.3 of the grip's lateral acceleration."""
    shares = np.linspace(0.7, 1.3, round(duration / TICK))
    speed = shares * grip_limit(friction) / yaw_rate
    commands = _commands(speed, yaw_rate, duration)
    return Drive(name, friction, commands, velocity=(float(speed[0]), 0.0), yaw_rate=yaw_rate)


def dash(name: str, friction: float, share: float, duration: float = 1.0) -> Drive:
    """Return an acceleration from rest at a share of what the grip allows."""
    return Drive(name, friction, _commands(share * grip_limit(friction) * _times(duration), 0.0, duration))


DRIVES = (
    weave("weave, a tenth of the grip", 0.8, 0.5, 0.1),
    weave("weave, up to 0.9 of the grip", 0.3, 1.0, 0.9),
    circle("circle, 0.97 of the grip", 0.3, 1.0, 0.97),
    weave("weave, up to 1.1 of the grip", 0.3, 1.0, 1.1),
    circle("circle, 1.5 of the grip", 0.3, 1.0, 1.5),
    dash("dash, 0.9 of the grip", 0.3, 0.9),
    dash("dash, 2 times the grip", 0.3, 2.0),
    locked("locked wheels, straight", 0.3, 0.0),
    locked("locked wheels, sideways", 0.3, 90.0),
    locked("locked wheels, at 45°, heading along x", 0.3, 45.0),
    locked("locked wheels, at 45°, heading 45° from x", 0.3, 45.0, 45.0),
)
"""What is compared, the gentlest first."""
