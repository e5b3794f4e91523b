"""What was seen of a robot on the bench."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slipctl.tick import Array


@dataclass(frozen=True)
class Trace:
    """What was seen at the beginning of every step, and the forces over it; S steps.

    Attributes
    ----------
    time : (S,) array
        [s].
    position, velocity : (S, 3) arrays
        Of the body origin, world [m], [m/s].
    momentum : (S, 3) array
        Velocity of the robot's centre of mass, world [m/s].
    heading, yaw_rate : (S,) arrays
        [rad], [rad/s].
    pitch : (S,) array
        Nose down [rad].
    wheel_rate : (S, 2) array
        [rad/s].
    force : (S, 2, 3) array
        Of the floor on each wheel over the step that begins here, world [N].
    caster : (S, C) array
        Normal force on every other geom that touches the floor at rest [N].
    rubbing : (S,) array
        Power of the wheels' friction [W]; zero where it was not asked for.
    energy : (S,) array
        Kinetic and potential [J].
    """

    time: Array
    position: Array
    velocity: Array
    momentum: Array
    heading: Array
    yaw_rate: Array
    pitch: Array
    wheel_rate: Array
    force: Array
    caster: Array
    rubbing: Array
    energy: Array

    @property
    def load(self) -> Array:
        """Normal force on each wheel (S, 2) [N]."""
        return self.force[:, :, 2]

    def along(self, vectors: Array) -> tuple[Array, Array]:
        """Return the parts of world vectors (S, 3) along body forward and body left."""
        c, s = np.cos(self.heading), np.sin(self.heading)
        return c * vectors[:, 0] + s * vectors[:, 1], c * vectors[:, 1] - s * vectors[:, 0]

    def since(self, time: float) -> slice:
        """Return the steps from a time on."""
        return slice(int(np.searchsorted(self.time, time - 1e-9)), None)
