"""Time-scale reparametrisation: rest to rest along a path that never stops in its own time τ.

The flat map of the kinematic model is singular at v = 0. A path F_d(τ) with |dF_d/dτ| > 0 is regular, and a
monotone τ(t) whose rate τ̇ is 0 at both ends makes the robot start and stop at rest: v = τ̇ṽ, w = τ̇u₂, and in τ
the model is again (29), with ṽ, u₁ = dṽ/dτ and u₂ (derived; not in the paper). Slip proportional to v is in τ
the same fraction of ṽ, so a law keeps its gains, its ρ and its theorem; all of them are per path time.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from slipctl.pairs import pair
from slipctl.theory.reference import Plan
from slipctl.tick import Array, PathTime, Reference

LEAST_RATE = 0.01
"""Below this τ̇ a velocity says nothing about dF/dτ = Ḟ/τ̇ (assumed)."""


def smooth_step(times: Array, duration: Array, total: Array) -> tuple[Array, Array, Array, Array]:
    """Return a monotone τ(t) and its derivatives: total · (10x³ − 15x⁴ + 6x⁵) with x = t/duration.

    Parameters
    ----------
    times : (N, T) array
        t [s]; before 0 and after `duration` τ rests.
    duration, total : (N, 1) arrays
        Real and path time from end to end [s].

    Returns
    -------
    tuple of (N, T) arrays
        τ [s], τ̇ [1], τ̈ [1/s] and τ⃛ [1/s²]; τ̇ and τ̈ are 0 at both ends, τ̇ is at most 15/8 · total/duration.
    """
    x = np.minimum(np.maximum(times / duration, 0.0), 1.0)
    left = 1.0 - x
    moves = (times >= 0.0) & (times <= duration)
    return (
        total * (x * x * x * (10.0 - 15.0 * x + 6.0 * x * x)),
        total / duration * (30.0 * x * x * left * left),
        total / duration**2 * (60.0 * x * left * (left - x)),
        np.where(moves, total / duration**3 * (60.0 - 360.0 * x * left), 0.0),
    )


@dataclass(frozen=True)
class TimeScaled:
    """A path run from rest to rest.

    Attributes
    ----------
    path : Plan
        In its own time; answers at times (N, T).
    total : (N,) array
        How much of its own time is run [s].
    duration : (N,) array
        Real time from rest to rest [s].
    tick : float
        How far `PathTime` looks ahead [s].
    """

    path: Plan
    total: Array
    duration: Array
    tick: float

    def at(self, times: Array) -> Reference:
        """Return the plan at real `times` (T,) [s]: arrays (N, T, 2) by t, and `path_time` by τ."""
        total, duration = self.total[:, None], self.duration[:, None]
        clock = np.broadcast_to(times, (len(self.duration), times.shape[-1]))
        elapsed, rate, second, third = smooth_step(clock, duration, total)
        elapsed_after, rate_after, _, _ = smooth_step(clock + self.tick, duration, total)
        path = self.path.at(elapsed)
        d1, d2, d3 = rate[..., None], second[..., None], third[..., None]
        return Reference(
            position=path.position,
            velocity=path.velocity * d1,
            acceleration=path.acceleration * (d1 * d1) + path.velocity * d2,
            jerk=path.jerk * (d1 * d1 * d1) + path.acceleration * (3.0 * d1 * d2) + path.velocity * d3,
            path_time=PathTime(elapsed, elapsed_after, rate, rate_after, path.velocity, path.acceleration),
        )


@dataclass(frozen=True)
class PathRatio:
    """dF/dτ in units of ṽ as measured at one instant: 1 + σ, in the robot's frame.

    Attributes
    ----------
    velocity, heading_vector : (N, 2) arrays
        dF/dτ [m/s] and the heading vector at that instant.
    path_speed : (N,) array
        ṽ then, positive [m/s].
    """

    velocity: Array
    heading_vector: Array
    path_speed: Array

    @classmethod
    def of(cls, value: Array) -> PathRatio:
        """Return the ratio of a value (N, 2)."""
        ones = np.ones(len(value))
        return cls(value, pair(ones, np.zeros(len(value))), ones)

    @cached_property
    def value(self) -> Array:
        """Along the heading and to its left, (N, 2) [1]; asked for only where a path begins and ends."""
        cosine, sine = self.heading_vector[:, 0], self.heading_vector[:, 1]
        x, y = self.velocity[:, 0], self.velocity[:, 1]
        return pair(cosine * x + sine * y, cosine * y - sine * x) / self.path_speed[:, None]


def path_velocity(
    velocity: Array, heading_vector: Array, rate: Array, path_speed: Array, ratio: PathRatio
) -> tuple[Array, PathRatio]:
    """Return dF/dτ = Ḟ/τ̇, also where τ̇ vanishes.

    With slip, dF/dτ = ṽ (1 + σ) E has a limit for τ̇ → 0, but Ḟ/τ̇ is 0/0 there, and a moment t from there a
    servo that lags by δ makes it wrong by 2δ/t. So below `LEAST_RATE` the ratio 1 + σ is held as it was
    measured last, in the robot's frame; before the first measurement it is 1, rolling without slip. That is
    only 6e-5 of the path time at each end of a `smooth_step` of equal durations.

    Parameters
    ----------
    velocity, heading_vector : (N, 2) arrays
        Ḟ [m/s] and the heading vector.
    rate, path_speed : (N,) arrays
        τ̇ [1] and the commanded ṽ [m/s].
    ratio : PathRatio
        The ratio held.

    Returns
    -------
    path_velocity : (N, 2) array
        dF/dτ [m/s].
    ratio : PathRatio
        The ratio to hold from here on.
    """
    tells = rate >= LEAST_RATE
    known = tells & (path_speed > 0.0)
    if np.count_nonzero(known) == known.size:
        measured = velocity / rate[:, None]
        return measured, PathRatio(measured, heading_vector, path_speed)
    measured = velocity / np.where(tells, rate, 1.0)[:, None]
    share = PathRatio(measured, heading_vector, np.where(known, path_speed, 1.0))
    value = np.where(known[:, None], share.value, ratio.value)
    cosine, sine = heading_vector[:, 0], heading_vector[:, 1]
    along, left = value[:, 0] * path_speed, value[:, 1] * path_speed
    held = pair(cosine * along - sine * left, sine * along + cosine * left)
    return np.where(tells[:, None], measured, held), PathRatio.of(value)
