"""From the inputs of the flat model to limited wheel commands, common to the kinematic laws."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from slipctl.theory.robot import WheelGeometry
from slipctl.tick import Array, SpeedCommand, Start


@dataclass(frozen=True)
class SpeedMemory:
    """The prolonged state of the law.

    Attributes
    ----------
    forward_speed : (N,) array
        The commanded speed v_k [m/s].
    """

    forward_speed: Array


@dataclass(frozen=True)
class DriveLimits:
    """What the law knows about the robot's drive.

    Attributes
    ----------
    geometry : WheelGeometry
    speed_limit, yaw_rate_limit : (N,) arrays
        [m/s], [rad/s]. The rim of a wheel may move at `speed_limit`, too.
    speed_floor : (N,) array
        Least commanded speed [m/s] (0.05 in Section VI of the paper): keeps the law off its singularity.
    """

    geometry: WheelGeometry
    speed_limit: Array
    yaw_rate_limit: Array
    speed_floor: Array

    def start(self, start: Start) -> SpeedMemory:
        """Return what a law remembers before the first tick: the planned speed, never below the floor."""
        return SpeedMemory(np.maximum(start.forward_speed, self.speed_floor))

    def command(
        self, commanded_speed: Array, forward_acceleration: Array, yaw_rate: Array, tick: float | Array
    ) -> tuple[SpeedCommand, Array, NDArray[np.bool_]]:
        """Turn (ū₁, ū₂) into a command within the limits.

        Parameters
        ----------
        commanded_speed, forward_acceleration, yaw_rate : (N,) arrays
            v_k [m/s], ū₁ [m/s²], ū₂ [rad/s].
        tick : float or (N,) array
            [s].

        Returns
        -------
        command : SpeedCommand
        memory : (N,) array
            The speed that the law remembers: what was commanded, so that it cannot wind up past a limit, and
            never below the floor [m/s].
        saturated : (N,) bool array
            Whether any limit changed the command.
        """
        wanted = commanded_speed + forward_acceleration * tick
        command, saturated = self.reach(
            wanted, commanded_speed, self.speed_floor, forward_acceleration, yaw_rate, tick
        )
        speed = command.forward_speed
        # where it is what was wanted, it is not below the floor
        return command, speed if speed is wanted else np.maximum(speed, self.speed_floor), saturated

    def reach(
        self,
        wanted: Array,
        commanded_speed: Array,
        least: Array | float | None,
        forward_acceleration: Array,
        yaw_rate: Array,
        tick: float | Array,
    ) -> tuple[SpeedCommand, NDArray[np.bool_]]:
        """Return the command that reaches a wanted speed (N,) [m/s] within the limits, and whether one acted.

        `least` takes the place of the floor [m/s], and is None where there is none; the other parameters are
        those of `command`.
        """
        saturated = ~self._allowed(wanted, least, yaw_rate)
        if np.count_nonzero(saturated):
            speed = np.minimum(wanted if least is None else np.maximum(wanted, least), self.speed_limit)
            turn = np.minimum(np.maximum(yaw_rate, -self.yaw_rate_limit), self.yaw_rate_limit)
            rim = np.abs(speed) + self.geometry.half_track * np.abs(turn)
            beyond = rim > self.speed_limit
            if np.count_nonzero(beyond):
                scale = np.divide(self.speed_limit, rim, out=np.ones(rim.shape), where=beyond)
                speed, turn = speed * scale, turn * scale
            reached = (speed - commanded_speed) / tick
            forward_acceleration = np.where(saturated, reached, forward_acceleration)
            wanted, yaw_rate = speed, turn
        wheel_rate = self.geometry.wheel_rates(wanted, yaw_rate)
        return SpeedCommand(forward_acceleration, wanted, yaw_rate, wheel_rate), saturated

    def _allowed(self, wanted: Array, least: Array | float | None, yaw_rate: Array) -> NDArray[np.bool_]:
        """Return in which worlds no limit acts; false as well where one meets what is not a number.

        The axle is never faster than the rim, so the rim's speed is the only one to look at. A drive without
        limits looks at no yaw rate.
        """
        if self._endless:
            return wanted >= (-np.inf if least is None else least)
        turn = np.abs(yaw_rate)
        rim = np.abs(wanted) + self.geometry.half_track * turn
        allowed = (turn <= self.yaw_rate_limit) & (rim <= self.speed_limit)
        return allowed if least is None else allowed & (wanted >= least)

    @cached_property
    def _endless(self) -> bool:
        return bool(np.isinf(self.speed_limit).all() and np.isinf(self.yaw_rate_limit).all())

    def unlimited(self) -> DriveLimits:
        """Return a drive that keeps the floor only."""
        endless = np.full_like(self.speed_limit, np.inf)
        return DriveLimits(self.geometry, endless, endless, self.speed_floor)
