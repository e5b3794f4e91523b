"""The slip kinematics of the paper, measured and prescribed.

Symbols as in the paper; v_s is positive to the **right** of the robot.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from slipctl.tick import Array, Motion, Slip


@dataclass(frozen=True)
class Affine:
    """Slip as offset + fraction · v at one instant.

    Attributes
    ----------
    fraction : Slip
        v_t/v, v_s/v [1] and w_s/v [rad/m], (N,) each.
    offset : Slip
        [m/s], [m/s], [rad/s], (N,) each.
    """

    fraction: Slip
    offset: Slip

    @classmethod
    def together(cls, instants: Sequence[Affine]) -> Affine:
        """Return K instants as one whose arrays are (K, N); made once for one that is there K times."""
        first, *others = instants
        count = len(instants)
        if any(one is not first for one in others):
            return cls(
                _stacked([one.fraction for one in instants]), _stacked([one.offset for one in instants])
            )
        if count not in first._repeated:
            same = cls(_stacked([first.fraction] * count), _stacked([first.offset] * count))
            first._repeated[count] = same
        return first._repeated[count]

    @cached_property
    def _repeated(self) -> dict[int, Affine]:
        return {}

    def at(self, forward_speed: Array) -> Slip:
        """Return the slip for wheel speeds (N,) [m/s], or (K, N) at K instants."""
        fraction, offset = self.fraction, self.offset
        longitudinal = fraction.longitudinal * forward_speed
        longitudinal += offset.longitudinal  # where it lies: numpy takes half as long
        lateral = fraction.lateral * forward_speed
        lateral += offset.lateral
        yaw = fraction.yaw * forward_speed
        yaw += offset.yaw
        return Slip(longitudinal, lateral, yaw)


def _stacked(slips: Sequence[Slip]) -> Slip:
    return Slip(
        np.array([slip.longitudinal for slip in slips]),
        np.array([slip.lateral for slip in slips]),
        np.array([slip.yaw for slip in slips]),
    )


class SlipLaw(Protocol):
    """A prescribed slip, affine in the signed wheel-derived speed."""

    def affine(self, time: float) -> Affine:
        """Return fraction and offset at `time` [s]."""
        ...

    def affine_rate(self, time: float) -> Affine:
        """Return the time derivatives of fraction and offset [1/s]."""
        ...


@dataclass(frozen=True)
class NoSlip:
    """Rolling without slip.

    Attributes
    ----------
    worlds : int
        N.
    """

    worlds: int

    def affine(self, time: float) -> Affine:
        """Return zeros."""
        return self._affine

    @cached_property
    def _affine(self) -> Affine:
        zero = np.zeros(self.worlds)
        return Affine(Slip(zero, zero, zero), Slip(zero, zero, zero))

    def affine_rate(self, time: float) -> Affine:
        """Return zeros."""
        return self.affine(time)


@dataclass(frozen=True)
class ProportionalSlip:
    """Slip proportional to the wheel speed, (83), (84), (86)–(88).

    Attributes
    ----------
    longitudinal, lateral : (N,) arrays
        v_t/v and v_s/v [1].
    yaw : (N,) array
        w_s/v [rad/m].
    """

    longitudinal: Array
    lateral: Array
    yaw: Array

    def affine(self, time: float) -> Affine:
        """Return the constant fractions; `time` plays no part."""
        return self._affine

    @cached_property
    def _affine(self) -> Affine:
        return Affine(Slip(self.longitudinal, self.lateral, self.yaw), _none(self.longitudinal))

    def affine_rate(self, time: float) -> Affine:
        """Return zeros: the fractions are constant."""
        return Affine(_none(self.longitudinal), _none(self.longitudinal))


@dataclass(frozen=True)
class SinusoidalSlip:
    """Proportional slip whose fractions swing as sin(2πt/period) (assumed; not in the paper).

    Attributes
    ----------
    longitudinal, lateral, yaw : (N,) arrays
        Amplitudes, as in `ProportionalSlip`.
    period : (N,) array
        [s].
    """

    longitudinal: Array
    lateral: Array
    yaw: Array
    period: Array

    def affine(self, time: float) -> Affine:
        """Return the fractions at `time` [s]."""
        return self._scaled(np.sin(2.0 * math.pi * time / self.period))

    def affine_rate(self, time: float) -> Affine:
        """Return how fast the fractions change at `time` [s]."""
        rate = 2.0 * math.pi / self.period
        return self._scaled(rate * np.cos(rate * time))

    def _scaled(self, factor: Array) -> Affine:
        fraction = Slip(self.longitudinal * factor, self.lateral * factor, self.yaw * factor)
        return Affine(fraction, _none(factor))


@dataclass(frozen=True)
class SeriesSlip:
    """Slip velocities given over time, whatever the wheels do; linear between samples, held at the ends.

    Attributes
    ----------
    times : (K,) array
        Ascending [s].
    longitudinal, lateral, yaw : (N, K) arrays
        [m/s], [m/s], [rad/s].
    """

    times: Array
    longitudinal: Array
    lateral: Array
    yaw: Array

    def affine(self, time: float) -> Affine:
        """Return the slip at `time` [s] as an offset."""
        index, share = self._place(time)

        def between(series: Array) -> Array:
            return series[:, index] + share * (series[:, index + 1] - series[:, index])

        offset = Slip(between(self.longitudinal), between(self.lateral), between(self.yaw))
        return Affine(_none(offset.yaw), offset)

    def affine_rate(self, time: float) -> Affine:
        """Return the slope of the series at `time` [s], the right-hand one at a sample; 0 beyond the ends."""
        index, _ = self._place(time)
        inside = self.times[0] <= time < self.times[-1]
        step = (self.times[index + 1] - self.times[index]) if inside else math.inf

        def slope(series: Array) -> Array:
            return (series[:, index + 1] - series[:, index]) / step

        offset = Slip(slope(self.longitudinal), slope(self.lateral), slope(self.yaw))
        return Affine(_none(offset.yaw), offset)

    def _place(self, time: float) -> tuple[int, float]:
        index = int(np.clip(np.searchsorted(self.times, time, side="right") - 1, 0, len(self.times) - 2))
        left, right = float(self.times[index]), float(self.times[index + 1])
        return index, min(max((time - left) / (right - left), 0.0), 1.0)


def _none(like: Array) -> Slip:
    zero = np.zeros(like.shape)
    return Slip(zero, zero, zero)


def slipping_velocity(forward_speed: Array, slip: Slip, cosine: Array, sine: Array) -> tuple[Array, Array]:
    """Return the world velocity of the axle midpoint, first two rows of (28) and (29).

    Parameters
    ----------
    forward_speed, cosine, sine : (N,) arrays
        v [m/s] and the heading vector; (K, N) for K instants.
    slip : Slip

    Returns
    -------
    tuple of arrays
        ẋ and ẏ [m/s], of the same shape.
    """
    along = forward_speed + slip.longitudinal
    x = along * cosine
    x += slip.lateral * sine
    y = along * sine
    y -= slip.lateral * cosine
    return x, y


def measure_slip(motion: Motion) -> Slip:
    """Return the slip that explains a motion, the inverse of (28).

    Parameters
    ----------
    motion : Motion
        All of one instant: a velocity and a heading that are one physics step apart bias the lateral slip
        by v·w·step.

    Returns
    -------
    Slip
        v_t = t·Ḟ − v, v_s = −n·Ḟ, w_s = Ω − w, (N,) each.
    """
    return explained_slip(
        (motion.heading_vector[:, 0], motion.heading_vector[:, 1]),
        (motion.velocity[:, 0], motion.velocity[:, 1]),
        motion.heading_rate,
        motion.forward_speed,
        motion.yaw_rate,
    )


def explained_slip(
    heading_vector: tuple[Array, Array],
    velocity: tuple[Array, Array],
    heading_rate: Array,
    forward_speed: Array,
    yaw_rate: Array,
) -> Slip:
    """Return `measure_slip` of arrays of any one shape, x and y apart; see there."""
    c, s = heading_vector
    vx, vy = velocity
    longitudinal = c * vx
    longitudinal += s * vy
    longitudinal -= forward_speed
    lateral = s * vx
    lateral -= c * vy
    return Slip(longitudinal, lateral, yaw=heading_rate - yaw_rate)


def slip_ratio(longitudinal: Array, lateral: Array, forward_speed: Array, least_speed: float = 0.05) -> Array:
    """Return √(v_t² + v_s²)/max(|v|, least_speed), elementwise.

    Parameters
    ----------
    longitudinal, lateral, forward_speed : arrays of one shape
        [m/s].
    least_speed : float
        Keeps the ratio finite at standstill [m/s]; 0.05 is the paper's speed floor (Section VI).
    """
    squares = longitudinal * longitudinal
    squares += lateral * lateral
    length = np.sqrt(squares)
    length /= np.maximum(np.abs(forward_speed), least_speed)
    return length
