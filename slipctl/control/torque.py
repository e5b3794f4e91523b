"""From the inputs of the dynamic flat model to limited wheel torques, common to the dynamic laws."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipctl.theory.dynamic import Inertia
from slipctl.tick import Array, Start, TorqueCommand


@dataclass(frozen=True)
class PushMemory:
    """The prolonged state of a dynamic law.

    Attributes
    ----------
    acceleration : (N,) array
        μ₁, what the wheels push at per mass [m/s²].
    """

    acceleration: Array


@dataclass(frozen=True)
class TorqueDrive:
    """What the law knows about the robot's motors.

    Attributes
    ----------
    inertia : Inertia
        What the law believes resists the torques.
    torque_limit : (N,) array
        Of each wheel [N·m].
    speed_floor : (N,) array
        Least speed in the law's denominator [m/s]: keeps it off its singularity.
    """

    inertia: Inertia
    torque_limit: Array
    speed_floor: Array

    def start(self, start: Start) -> PushMemory:
        """Return what the motors push at before the first tick: the planned μ₁, and what a slope takes.

        Gravity pulls at the mass alone, and μ₁ counts per effective mass.
        """
        if start.uphill_acceleration is None:
            return PushMemory(start.forward_acceleration)
        share = self.inertia.mass / self.inertia.effective_mass
        return PushMemory(start.forward_acceleration + start.uphill_acceleration * share)

    def command(
        self, acceleration: Array, jerk: Array, yaw_acceleration: Array, wheel_rate: Array, tick: float
    ) -> tuple[TorqueCommand, PushMemory, NDArray[np.bool_]]:
        """Turn (μ̄₁, μ₂) into torques within the limit, (21)–(23).

        Parameters
        ----------
        acceleration, jerk, yaw_acceleration : (N,) arrays
            μ₁ at the tick's start [m/s²], μ̄₁ [m/s³] and μ₂ [rad/s²].
        wheel_rate : (N, 2) array
            Left, right [rad/s].
        tick : float
            [s].

        Returns
        -------
        command : TorqueCommand
        memory : PushMemory
            μ₁ at the tick's end, as far as the motors could follow.
        saturated : (N,) bool array
            Whether the limit changed the command.
        """
        wanted = acceleration + jerk * tick
        torques = self.inertia.torques(np.array((acceleration, wanted)), yaw_acceleration, wheel_rate)
        peak = np.maximum.reduce(np.abs(torques), axis=(0, 2))
        saturated = peak > self.torque_limit
        if np.count_nonzero(saturated):
            # both wheels together, so that the robot still turns the way it should
            scale = np.divide(self.torque_limit, peak, out=np.ones(peak.shape), where=saturated)
            torques = torques * scale[:, None]
            reached, turned = self.inertia.accelerations(torques[1], wheel_rate)
            wanted = np.where(saturated, reached, wanted)
            yaw_acceleration = np.where(saturated, turned, yaw_acceleration)
        command = TorqueCommand(wanted, yaw_acceleration, torques[0], torques[1])
        return command, PushMemory(wanted), saturated
