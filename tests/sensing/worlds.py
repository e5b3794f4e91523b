"""Sensors and motions that the tests of the sensing share."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from slipctl.plants.ode import KinematicOde
from slipctl.sensing.sensor import MotionSensor, SensorMemory
from slipctl.sensing.settings import CameraSettings, Delays, Noise, Sensing
from slipctl.theory.robot import MAGELLAN_PRO
from slipctl.theory.slip import NoSlip, SlipLaw
from slipctl.tick import Array, Motion, SpeedCommand
from tests.builders import full, start_of

TICK = 0.05


def camera(
    worlds: int,
    rate: float = 3.0,
    position_noise: float = 0.0,
    heading_noise: float = 0.0,
    delay: float = 0.0,
    gain: float = 1.0,
) -> CameraSettings:
    return CameraSettings(
        *(full(worlds, value) for value in (rate, position_noise, heading_noise, delay, gain))
    )


def noise(worlds: int, **deviations: float) -> Noise:
    return replace(
        Sensing.truth(worlds).noise, **{name: full(worlds, value) for name, value in deviations.items()}
    )


def delays(worlds: int, **seconds: float) -> Delays:
    return replace(
        Sensing.truth(worlds).delays, **{name: full(worlds, value) for name, value in seconds.items()}
    )


def sensor_of(worlds: int, rows: int, seeds: list[int] | None = None, **changes: Any) -> MotionSensor:
    """Return a sensor of perfect senses but for the changes."""
    sensing = replace(Sensing.truth(worlds), **changes)
    return MotionSensor.build(sensing, MAGELLAN_PRO, seeds or list(range(worlds)), rows, TICK)


def everything(worlds: int, seeds: list[int], rows: int) -> MotionSensor:
    """Return a sensor with every imperfection at once."""
    return sensor_of(
        worlds,
        rows,
        seeds,
        pose="odometry_camera",
        velocity="differentiated",
        acceleration="imu",
        camera=camera(worlds, position_noise=0.003, heading_noise=0.01, delay=0.1, gain=0.7),
        noise=noise(
            worlds, position=0.001, heading=0.002, velocity=0.003, acceleration=0.004, yaw_rate=0.005
        ),
        delays=delays(worlds, pose=0.05, velocity=0.1, acceleration=0.15),
    )


def drive(
    speeds: Array,
    turns: Array,
    slip_law: SlipLaw | None = None,
    heading: float = 0.3,
    position: tuple[float, float] = (1.0, -2.0),
) -> list[Motion]:
    """Drive one robot at constant v (T,) and w (T,) in every tick; return its T + 1 motions.

    Wheels that jump to a new speed at the beginning of a tick keep it constant within the tick, so that the
    arcs of the odometry are exact.
    """
    plant = KinematicOde(MAGELLAN_PRO, slip_law or NoSlip(1), full(1, 1e6))
    state = plant.start(
        start_of(np.array([position]), full(1, heading), np.array(speeds[:1]), np.array(turns[:1]))
    )
    motions = [plant.observe(state)]
    for speed, turn in zip(speeds, turns, strict=True):
        v, w = full(1, speed), full(1, turn)
        # what follows from the new speed as well
        state = plant.with_own_slip(replace(state, forward_speed=v, yaw_rate=w))
        command = SpeedCommand(full(1, 0.0), v, w, MAGELLAN_PRO.wheel_rates(v, w))
        state = plant.step(state, command, TICK)
        motions.append(plant.observe(state))
    return motions


def sense(sensor: MotionSensor, motions: list[Motion]) -> tuple[list[SensorMemory], list[Motion]]:
    """Return all memories and all that is seen of the motions."""
    memories, seen = [], []
    memory = sensor.start(motions[0])
    for k, motion in enumerate(motions):
        memory, sight = sensor.measure(memory, k, motion)
        memories.append(memory)
        seen.append(sight)
    return memories, seen


def positions(motions: list[Motion]) -> Array:
    """Return the positions of the first world, (T + 1, 2) [m]."""
    return np.array([motion.position[0] for motion in motions])


def headings(motions: list[Motion]) -> Array:
    """Return the headings of the first world, (T + 1,) [rad], unwrapped."""
    return np.unwrap([math.atan2(*motion.heading_vector[0, ::-1]) for motion in motions])


def still(worlds: int, **changes: Any) -> Motion:
    """Return robots that stand at the origin."""
    zero, none = np.zeros((worlds, 2)), np.zeros(worlds)
    ahead = np.tile([1.0, 0.0], (worlds, 1))
    return replace(Motion(zero, zero, ahead, none, zero, zero, none, none, zero), **changes)
