"""What is measured, how, and how badly; one value per world wherever a number is meant."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from slipctl.tick import Array

PoseSource = Literal["true", "odometry_camera"]
VelocitySource = Literal["true", "odometry", "differentiated"]
AccelerationSource = Literal["true", "imu", "model"]


@dataclass(frozen=True)
class CameraSettings:
    """The overhead camera of Section VI and how much it is believed.

    Attributes
    ----------
    rate : (N,) array
        Frames per second [Hz]; 0 for a camera that never looks.
    position_noise, heading_noise : (N,) arrays
        Standard deviations of a fix, of x and of y alike [m], [rad].
    delay : (N,) array
        From the exposure to the arrival of the fix [s].
    gain : (N,) array
        Share of the difference that a fix corrects, 0 to 1.
    """

    rate: Array
    position_noise: Array
    heading_noise: Array
    delay: Array
    gain: Array


@dataclass(frozen=True)
class Noise:
    """Standard deviations of the white noise on what the controller gets, each an (N,) array.

    Attributes
    ----------
    position, velocity, acceleration : (N,) arrays
        Of x and of y alike [m], [m/s], [m/s²].
    heading, yaw_rate : (N,) arrays
        [rad]; the gyro's [rad/s].
    """

    position: Array
    heading: Array
    velocity: Array
    acceleration: Array
    yaw_rate: Array


@dataclass(frozen=True)
class Delays:
    """How late the controller gets a signal, each an (N,) array [s], rounded to ticks.

    Attributes
    ----------
    pose, velocity, acceleration : (N,) arrays
    """

    pose: Array
    velocity: Array
    acceleration: Array


@dataclass(frozen=True)
class Sensing:
    """Everything that tells one sensor from another.

    Attributes
    ----------
    pose, velocity, acceleration : str
        Where the signal comes from.
    camera : CameraSettings
        Used with ``odometry_camera`` only.
    noise : Noise
    delays : Delays
    gravity : (N, 2) array
        Part of gravity along the ground, world x, y [m/s²]; what an accelerometer adds on a slope.
    """

    pose: PoseSource
    velocity: VelocitySource
    acceleration: AccelerationSource
    camera: CameraSettings
    noise: Noise
    delays: Delays
    gravity: Array

    @classmethod
    def truth(cls, worlds: int) -> Sensing:
        """Return the settings of perfect senses for N worlds: a base to replace fields of."""
        zero = np.zeros(worlds)
        return cls(
            pose="true",
            velocity="true",
            acceleration="true",
            camera=CameraSettings(zero, zero, zero, zero, np.ones(worlds)),
            noise=Noise(zero, zero, zero, zero, zero),
            delays=Delays(zero, zero, zero),
            gravity=np.zeros((worlds, 2)),
        )
