"""The same drives in both engines, and what came of them."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np

from slipctl.plants.ground import Ground
from slipctl.plants.mujoco import MujocoPlant
from slipctl.theory.robot import MAGELLAN_PRO
from slipctl.theory.slip import measure_slip
from slipctl.tick import Array, Motion, SpeedCommand
from tests.builders import start_of
from tests.engine.bullet import Bullet
from tests.engine.drives import TICK, Drive
from tests.engine.robot import Robot
from tests.plants.driving import pushed

TIMESTEP = 0.001
"""Physics step of both engines [s]."""


@dataclass(frozen=True)
class Track:
    """What an engine did with a drive, after every tick; the axis is time.

    Attributes
    ----------
    longitudinal, lateral, yaw : (T,) arrays
        v_t, v_s (right positive) [m/s], w_s [rad/s].
    position, velocity : (T, 2) arrays
        World [m], [m/s].
    heading : (T,) array
        Unwrapped [rad].
    """

    longitudinal: Array
    lateral: Array
    yaw: Array
    position: Array
    velocity: Array
    heading: Array

    @classmethod
    def of(cls, motions: list[Motion]) -> Track:
        """Return the track of a list of motions of one world."""
        slips = [measure_slip(motion) for motion in motions]
        vectors = np.array([motion.heading_vector[0] for motion in motions])
        return cls(
            longitudinal=np.array([slip.longitudinal[0] for slip in slips]),
            lateral=np.array([slip.lateral[0] for slip in slips]),
            yaw=np.array([slip.yaw[0] for slip in slips]),
            position=np.array([motion.position[0] for motion in motions]),
            velocity=np.array([motion.velocity[0] for motion in motions]),
            heading=np.unwrap(np.arctan2(vectors[:, 1], vectors[:, 0])),
        )

    @property
    def length(self) -> float:
        """Return how far the axle midpoint went [m]."""
        return float(np.hypot(*np.diff(self.position, axis=0).T).sum())

    def acceleration(self, first: float, last: float) -> Array:
        """Return the mean acceleration (2,) between two instants [m/s²]."""
        begin, end = round(first / TICK) - 1, round(last / TICK) - 1
        return np.asarray(self.velocity[end] - self.velocity[begin]) / ((end - begin) * TICK)

    def after(self, time: float) -> Track:
        """Return the track without its beginning [s]."""
        first = round(time / TICK)
        return Track(*(getattr(self, field.name)[first:] for field in fields(self)))

    def steepest(self, window: float = 0.1) -> float:
        """Return the largest mean acceleration over a window [m/s²]."""
        span = round(window / TICK)
        change = self.velocity[span:] - self.velocity[:-span]
        return float(np.hypot(change[:, 0], change[:, 1]).max() / window)


@dataclass(frozen=True)
class Statistics:
    """Root mean square, median and largest of a slip's magnitude."""

    rms: float
    median: float
    largest: float

    @classmethod
    def of(cls, slip: Array) -> Statistics:
        """Return those of one slip signal (T,)."""
        size = np.abs(slip)
        return cls(float(np.sqrt((size * size).mean())), float(np.median(size)), float(size.max()))

    def each(self) -> list[float]:
        """Return the three."""
        return [getattr(self, field.name) for field in fields(self)]


def world_velocity(drive: Drive) -> Array:
    """Return the velocity (2,) at the start, along the world's axes [m/s]."""
    (along, left), c, s = drive.velocity, math.cos(drive.heading), math.sin(drive.heading)
    return np.array([c * along - s * left, s * along + c * left])


def in_mujoco(drive: Drive, timestep: float = TIMESTEP) -> Track:
    """Return what slipctl's own plant does."""
    plant = MujocoPlant.build(ground=Ground.flat(drive.friction), timestep=timestep)
    speed = drive.velocity[0] if drive.rolling else 0.0
    begin = start_of(
        np.zeros((1, 2)), np.array([drive.heading]), np.array([speed]), np.array([drive.yaw_rate])
    )
    state = pushed(plant, plant.start(begin), world_velocity(drive)[None])
    motions, still = [], np.zeros(1)
    for wheel_rate in drive.wheel_rate:
        state = plant.step(state, SpeedCommand(still, still, still, wheel_rate[None]), TICK)
        motions.append(plant.observe(state))
    assert state.status[0] == 0
    return Track.of(motions)


def in_bullet(robot: Robot, drive: Drive, timestep: float = TIMESTEP, cone: bool = True) -> Track:
    """Return what PyBullet does."""
    speed = drive.velocity[0] if drive.rolling else 0.0
    wheels = MAGELLAN_PRO.wheel_rates(np.array(speed), np.array(drive.yaw_rate))
    motions = []
    with Bullet(robot, drive.friction, timestep, cone) as world:
        world.start(drive.heading, world_velocity(drive), drive.yaw_rate, wheels)
        for wheel_rate in drive.wheel_rate:
            world.step(wheel_rate, round(TICK / timestep))
            motions.append(world.observe())
    return Track.of(motions)
