"""The kinematic model with what was measured on a robot put into it, one cause after the other."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from slipctl.plants.ode import KinematicOde, OdeState
from slipctl.theory.slip import Affine, SlipLaw
from slipctl.tick import Array, BodyPose, Motion, Slip, SpeedCommand, Start, WheelContact


@dataclass(frozen=True)
class Differences:
    """What a robot did beyond what the kinematic model has, on one run of T ticks.

    Attributes
    ----------
    wheels_at, wheels_over : (T + 1, 2), (T, 2) arrays
        v [m/s] and w [rad/s] of the wheels beyond the model's: at the instants t_k, and on average over
        tick k.
    slip_at, slip_over : (T + 1, 3), (T, 3) arrays
        v_t, v_s [m/s] and w_s [rad/s] beyond the slip law, alike.
    """

    wheels_at: Array
    wheels_over: Array
    slip_at: Array
    slip_over: Array

    def without_slip(self) -> Differences:
        """Return the wheels alone."""
        return replace(self, slip_at=np.zeros_like(self.slip_at), slip_over=np.zeros_like(self.slip_over))

    def from_instants(self) -> Differences:
        """Return the same with the slip over a tick taken from the instants at its two ends."""
        return replace(self, slip_over=(self.slip_at[:-1] + self.slip_at[1:]) / 2.0)


@dataclass(frozen=True)
class _Shifted:
    """A slip law whose wheels turn faster than the model thinks, and with more slip."""

    law: SlipLaw
    wheels: Array
    slip: Array

    def affine(self, time: float) -> Affine:
        affine = self.law.affine(time)
        faster, turning = self.wheels
        more = self.slip
        fraction, offset = affine.fraction, affine.offset
        shifted = Slip(
            offset.longitudinal + fraction.longitudinal * faster + faster + more[0],
            offset.lateral + fraction.lateral * faster + more[1],
            offset.yaw + fraction.yaw * faster + turning + more[2],
        )
        return Affine(fraction, shifted)

    def affine_rate(self, time: float) -> Affine:
        # the differences stand still within a tick
        rate = self.law.affine_rate(time)
        faster = self.wheels[0]
        shifted = Slip(
            rate.offset.longitudinal + rate.fraction.longitudinal * faster,
            rate.offset.lateral + rate.fraction.lateral * faster,
            rate.offset.yaw + rate.fraction.yaw * faster,
        )
        return Affine(rate.fraction, shifted)


@dataclass(frozen=True)
class CorrectedOde:
    """The kinematic model (29), one world, with measured differences put in.

    Over tick k wheels and slip get their average differences; what the law sees at t_k has those of the
    instant. With all differences in, the model repeats the run they were measured on.

    Attributes
    ----------
    ode : KinematicOde
    differences : Differences
    tick : float
        [s].
    """

    ode: KinematicOde
    differences: Differences
    tick: float

    def start(self, start: Start) -> OdeState:
        """Return the planned state."""
        return self.ode.start(start)

    def observe(self, state: OdeState) -> Motion:
        """Return the motion at the state's instant, as the wheels' sensors would tell it."""
        k = self._row(state, len(self.differences.wheels_at))
        wheels = self.differences.wheels_at[k]
        plant = self._plant(wheels, self.differences.slip_at[k])
        motion = plant.observe(plant.with_own_slip(state))
        speed, turn = motion.forward_speed + wheels[0], motion.yaw_rate + wheels[1]
        return replace(
            motion,
            forward_speed=speed,
            yaw_rate=turn,
            wheel_rate=self.ode.geometry.wheel_rates(speed, turn),
        )

    def details(self, state: OdeState) -> tuple[BodyPose, WheelContact] | None:
        """Return None: a kinematic model has neither bodies nor contacts."""
        return None

    def step(self, state: OdeState, command: SpeedCommand, tick: float) -> OdeState:
        """Return the state one tick [s] later."""
        k = self._row(state, len(self.differences.wheels_over))
        plant = self._plant(self.differences.wheels_over[k], self.differences.slip_over[k])
        return plant.step(plant.with_own_slip(state), command, tick)

    def _row(self, state: OdeState, rows: int) -> int:
        return min(round(state.time / self.tick), rows - 1)

    def _plant(self, wheels: Array, slip: Array) -> KinematicOde:
        return replace(self.ode, slip_law=_Shifted(self.ode.slip_law, wheels, slip))


def measure_differences(columns: dict[str, Any], ode: KinematicOde, start: Start, tick: float) -> Differences:
    """Return what a robot did beyond the kinematic model under the same commands.

    Parameters
    ----------
    columns : dict of (T + 1,) arrays
        Of a run on MuJoCo.
    ode : KinematicOde
        With the slip law that the run is compared with.
    start : Start
    tick : float
        [s].
    """
    speed, turn = columns["decision.forward_speed"], columns["decision.yaw_rate"]
    speed_before = np.concatenate([start.forward_speed, speed[:-1]])
    turn_before = np.concatenate([start.yaw_rate, turn[:-1]])
    measured = np.stack([columns["motion.forward_speed"], columns["motion.yaw_rate"]], axis=-1)
    angle = np.stack([columns["wheel.angle.left"], columns["wheel.angle.right"]], axis=-1)
    average = np.stack(ode.geometry.body_rates(np.diff(angle, axis=0) / tick), axis=-1)
    modelled = np.stack([(speed_before + speed)[:-1] / 2.0, turn[:-1]], axis=-1)
    wheels_over = average - modelled

    times = np.arange(len(speed), dtype=np.float64) * tick
    slip = np.stack([columns["slip.longitudinal"], columns["slip.lateral"], columns["slip.yaw"]], axis=-1)
    slip_at = slip - _law(ode.slip_law, times, measured[:, 0])
    begin, end = speed_before[:-1] + wheels_over[:, 0], speed[:-1] + wheels_over[:, 0]
    expected = (
        _law(ode.slip_law, times[:-1], begin)
        + 4.0 * _law(ode.slip_law, times[:-1] + tick / 2.0, (begin + end) / 2.0)
        + _law(ode.slip_law, times[1:], end)
    ) / 6.0
    twist = mean_twist(columns, tick)
    slip_over = np.stack([twist[:, 0] - average[:, 0], -twist[:, 1], twist[:, 2] - average[:, 1]], axis=-1)
    return Differences(
        wheels_at=measured - np.stack([speed_before, turn_before], axis=-1),
        wheels_over=wheels_over,
        slip_at=slip_at,
        slip_over=slip_over - expected,
    )


def mean_twist(columns: dict[str, Any], tick: float) -> Array:
    """Return the constant body twist that leads from each pose to the next, (T, 3).

    Forward [m/s], to the left [m/s], turning [rad/s].
    """
    heading = columns["motion.heading"]
    turn = np.diff(heading)
    turn = np.arctan2(np.sin(turn), np.cos(turn))
    x, y = np.diff(columns["motion.position.x"]), np.diff(columns["motion.position.y"])
    middle = heading[:-1] + turn / 2.0
    # the chord of an arc is shorter than the arc by this
    chord = np.sinc(turn / 2.0 / np.pi)
    forward = (np.cos(middle) * x + np.sin(middle) * y) / chord
    left = (np.cos(middle) * y - np.sin(middle) * x) / chord
    return np.stack([forward, left, turn], axis=-1) / tick


def _law(law: SlipLaw, times: Array, speeds: Array) -> Array:
    """Return a law's slip (T, 3) at times (T,) for speeds (T,), of its one world."""
    rows = []
    for time, speed in zip(times.tolist(), speeds.tolist(), strict=True):
        slip = law.affine(time).at(np.array([speed]))
        rows.append([slip.longitudinal[0], slip.lateral[0], slip.yaw[0]])
    return np.array(rows).reshape(-1, 3)
