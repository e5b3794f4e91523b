"""Wheel kinematics of a differential drive: from body rates to wheel rates and back."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from slipctl.pairs import last_axis
from slipctl.tick import Array

GRAVITY = 9.81
"""Standard gravity as slipctl rounds it [m/s²]."""


@dataclass(frozen=True)
class WheelGeometry:
    """The two lengths that tie wheel rates to body rates.

    Attributes
    ----------
    wheel_radius : float or (N,) array
        r [m]; one per world for what controllers believe.
    half_track : float or (N,) array
        b, **half** the distance between the wheels [m].
    """

    wheel_radius: float | Array
    half_track: float | Array

    @cached_property
    def _lengths(self) -> tuple[Array, Array]:
        """Return r and b as arrays, which numpy would make of them anew in every operation."""
        return np.asarray(self.wheel_radius), np.asarray(self.half_track)

    def wheel_rates(self, forward_speed: Array, yaw_rate: Array) -> Array:
        """Return wheel rates (N, 2), left and right [rad/s], of v (N,) [m/s] and w (N,) [rad/s]."""
        wheel_radius, half_track = self._lengths
        sweep = half_track * yaw_rate
        rates = np.array((forward_speed - sweep, forward_speed + sweep))
        rates /= wheel_radius
        return last_axis(rates)

    def body_rates(self, wheel_rate: Array) -> tuple[Array, Array]:
        """Return v (N,) [m/s] and w (N,) [rad/s] of wheel rates (N, 2), left and right [rad/s]."""
        left, right = wheel_rate[..., 0], wheel_rate[..., 1]
        forward_speed = self.wheel_radius * (left + right) / 2.0
        yaw_rate = self.wheel_radius * (right - left) / (2.0 * self.half_track)
        return forward_speed, yaw_rate


MAGELLAN_PRO = WheelGeometry(wheel_radius=0.0825, half_track=0.1624)
"""iRobot Magellan Pro, Table II of the paper."""
