"""Dead reckoning from wheel angles."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from slipctl.theory.robot import WheelGeometry
from slipctl.tick import Array


@dataclass(frozen=True)
class OdometryPose:
    """A pose reckoned from the wheels alone, never corrected.

    Attributes
    ----------
    position : (N, 2) array
        [m].
    heading : (N,) array
        Not wrapped [rad].
    wheel_angle : (N, 2) array
        What the encoders read at this pose, left, right [rad].
    """

    position: Array
    heading: Array
    wheel_angle: Array


def advance(pose: OdometryPose, wheel_angle: Array, geometry: WheelGeometry) -> OdometryPose:
    """Return the pose after the wheels turned on, as if they rolled along an arc.

    With δs = r(δφ_l + δφ_r)/2 and δθ = r(δφ_r − δφ_l)/(2b) the robot moves by the chord
    δs · sin(δθ/2)/(δθ/2) in the direction of the heading halfway, θ + δθ/2: exact for constant wheel rates,
    and off by no more than third order in the tick for others.

    Parameters
    ----------
    pose : OdometryPose
    wheel_angle : (N, 2) array
        What the encoders read now [rad].
    geometry : WheelGeometry
    """
    length, turn = geometry.body_rates(wheel_angle - pose.wheel_angle)
    halfway = pose.heading + turn / 2.0
    chord = length * np.array([_sinc(angle / 2.0) for angle in turn.tolist()])
    return OdometryPose(pose.position + chord[:, None] * direction(halfway), pose.heading + turn, wheel_angle)


def direction(heading: Array) -> Array:
    """Return cosine and sine of angles (N,) as (N, 2).

    Angle by angle: how an array function rounds may depend on the length of the array.
    """
    return np.array([(math.cos(angle), math.sin(angle)) for angle in heading.tolist()])


def _sinc(angle: float) -> float:
    return math.sin(angle) / angle if abs(angle) > 1e-4 else 1.0 - angle * angle / 6.0
