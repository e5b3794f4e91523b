"""Pushes: forces that act on the robot's centre of mass for a while."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slipctl.tick import Array


@dataclass(frozen=True)
class Push:
    """A horizontal force of one size and world direction for a while, one per world.

    Attributes
    ----------
    force : (N,) array
        [N].
    direction : (N, 2) array
        Unit vector, world x, y.
    start, duration : (N,) arrays
        [s].
    """

    force: Array
    direction: Array
    start: Array
    duration: Array


def mean_force(pushes: Sequence[Push], time: float, timestep: float) -> Array:
    """Return the mean force (N, 2) of all pushes over a physics step that begins at a time [s].

    A push that begins or ends within the step acts with its share of it, so that its impulse is exact
    whatever the timestep.
    """
    total = np.zeros_like(pushes[0].direction)
    for push in pushes:
        begun = np.maximum(push.start, time)
        ended = np.minimum(push.start + push.duration, time + timestep)
        share = np.clip((ended - begun) / timestep, 0.0, 1.0)
        total = total + (push.force * share)[:, None] * push.direction
    return total


def lever(force: Array, quaternion: Array, arm: Array) -> Array:
    """Return the torque (N, 3) of a horizontal force (N, 2) at the end of an arm (3,) fixed in the body.

    Parameters
    ----------
    force : (N, 2) array
        World x, y [N].
    quaternion : (N, 4) array
        Orientation of the body, w, x, y, z.
    arm : (3,) array
        From the body's own centre of mass to where the force acts, body axes [m].
    """
    w, x, y, z = (quaternion[:, i] for i in range(4))
    a, b, c = arm.tolist()
    arm_x = a * (1.0 - 2.0 * (y * y + z * z)) + b * 2.0 * (x * y - w * z) + c * 2.0 * (x * z + w * y)
    arm_y = a * 2.0 * (x * y + w * z) + b * (1.0 - 2.0 * (x * x + z * z)) + c * 2.0 * (y * z - w * x)
    arm_z = a * 2.0 * (x * z - w * y) + b * 2.0 * (y * z + w * x) + c * (1.0 - 2.0 * (x * x + y * y))
    return np.stack(
        [-arm_z * force[:, 1], arm_z * force[:, 0], arm_x * force[:, 1] - arm_y * force[:, 0]], axis=-1
    )
