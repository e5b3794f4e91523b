"""Desired trajectories, planned in the space of the flat output.

Every plan has parameters (N,) and answers `at(times)` with arrays (N, T, 2): position [m], velocity [m/s],
acceleration [m/s²] and jerk [m/s³]. A plan is laid out in its own frame and then placed by a `Placement`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from slipctl.tick import Array, Reference


class Plan(Protocol):
    """A desired trajectory."""

    def at(self, times: Array) -> Reference:
        """Return the plan at `times` (T,) [s], arrays (N, T, 2)."""
        ...


@dataclass(frozen=True)
class Placement:
    """Where a plan's own frame stands in the world.

    Attributes
    ----------
    x, y : (N,) arrays
        [m].
    heading : (N,) array
        [rad].
    """

    x: Array
    y: Array
    heading: Array

    def place(self, position: Array, velocity: Array, acceleration: Array, jerk: Array) -> Reference:
        """Return a reference of world vectors (N, T, 2) from vectors in the plan's frame."""
        cosine, sine = np.cos(self.heading)[:, None], np.sin(self.heading)[:, None]

        def turned(vector: Array) -> Array:
            x, y = vector[..., 0], vector[..., 1]
            return np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=-1)

        origin = np.stack([self.x, self.y], axis=-1)[:, None, :]
        return Reference(origin + turned(position), turned(velocity), turned(acceleration), turned(jerk))


def _polynomial(coefficients: Array, times: Array, derivatives: int) -> list[Array]:
    """Evaluate polynomials (N, 2, K), constant first, and their derivatives at (N, T): (N, T, 2) each."""
    t = times[:, :, None]
    values = []
    for _ in range(derivatives + 1):
        value = np.zeros((*times.shape, 2))
        for power in reversed(range(coefficients.shape[-1])):
            value = value * t + coefficients[:, None, :, power]
        values.append(value)
        coefficients = coefficients[..., 1:] * np.arange(1.0, coefficients.shape[-1])
    return values


@dataclass(frozen=True)
class PointToPoint:
    """Polynomial flat outputs between two poses with speeds, Section V with Table I.

    Cubic, or quintic where the ends also have a yaw rate and an acceleration (Section V-B). After `duration`
    the plan goes on at its final velocity.

    Attributes
    ----------
    start, goal : (N, 4) or (N, 6) arrays
        x, y [m], heading [rad], speed [m/s] and, for a quintic, yaw rate [rad/s] and forward acceleration
        [m/s²] at the ends.
    duration : (N,) array
        [s].
    placement : Placement
    """

    start: Array
    goal: Array
    duration: Array
    placement: Placement

    def at(self, times: Array) -> Reference:
        """Return the plan at `times` (T,) [s], or at other times (N, T) in every world: arrays (N, T, 2)."""
        total = self.duration[:, None]
        clock = np.broadcast_to(times, (len(self.duration), times.shape[-1]))
        inside = np.minimum(clock, total)
        position, velocity, acceleration, jerk = _polynomial(self._coefficients(), inside, 3)
        beyond = (clock > total)[:, :, None]
        position = np.where(beyond, position + velocity * (clock - inside)[:, :, None], position)
        acceleration, jerk = np.where(beyond, 0.0, acceleration), np.where(beyond, 0.0, jerk)
        return self.placement.place(position, velocity, acceleration, jerk)

    def _coefficients(self) -> Array:
        """Return (N, 2, 4) or (N, 2, 6) coefficients, constant first."""
        (p0, v0, a0), (p1, v1, a1) = _ends(self.start), _ends(self.goal)
        total = self.duration[:, None]
        gap, turn = p1 - p0 - v0 * total, v1 - v0
        if self.start.shape[-1] == 4:
            quadratic = 3.0 * gap / total**2 - turn / total
            cubic = -2.0 * gap / total**3 + turn / total**2
            return np.stack([p0, v0, quadratic, cubic], axis=-1)
        gap, turn, bend = gap - a0 * total**2 / 2.0, turn - a0 * total, a1 - a0
        cubic = (10.0 * gap - 4.0 * turn * total + bend * total**2 / 2.0) / total**3
        quartic = (-15.0 * gap + 7.0 * turn * total - bend * total**2) / total**4
        fifth = (6.0 * gap - 3.0 * turn * total + bend * total**2 / 2.0) / total**5
        return np.stack([p0, v0, a0 / 2.0, cubic, quartic, fifth], axis=-1)


def _ends(pose: Array) -> tuple[Array, Array, Array]:
    """Return position, velocity and acceleration (N, 2) of an end; a cubic's acceleration is not used."""
    cosine, sine, speed = np.cos(pose[:, 2]), np.sin(pose[:, 2]), pose[:, 3]
    forward, across = (pose[:, 5], speed * pose[:, 4]) if pose.shape[-1] == 6 else (0.0 * speed, 0.0 * speed)
    velocity = np.stack([speed * cosine, speed * sine], axis=-1)
    acceleration = np.stack([forward * cosine - across * sine, forward * sine + across * cosine], axis=-1)
    return pose[:, :2], velocity, acceleration


@dataclass(frozen=True)
class Line:
    """A straight line at constant speed.

    Attributes
    ----------
    speed : (N,) array
        [m/s].
    placement : Placement
        The start.
    """

    speed: Array
    placement: Placement

    def at(self, times: Array) -> Reference:
        """Return the plan at `times` (T,) [s], arrays (N, T, 2)."""
        along = self.speed[:, None] * times[None, :]
        zero = np.zeros_like(along)
        speed = np.broadcast_to(self.speed[:, None], along.shape)
        still = np.stack([zero, zero], axis=-1)
        return self.placement.place(
            np.stack([along, zero], axis=-1), np.stack([speed, zero], axis=-1), still, still
        )


@dataclass(frozen=True)
class Circle:
    """A circle at constant speed, entered along the plan's x axis; it goes on periodically.

    Attributes
    ----------
    speed : (N,) array
        [m/s].
    radius : (N,) array
        [m]; positive turns left, negative right.
    placement : Placement
        The start.
    """

    speed: Array
    radius: Array
    placement: Placement

    def at(self, times: Array) -> Reference:
        """Return the plan at `times` (T,) [s], arrays (N, T, 2)."""
        radius = self.radius[:, None]
        rate = self.speed[:, None] / radius
        angle = rate * times[None, :]
        cosine, sine = np.cos(angle), np.sin(angle)
        position = np.stack([radius * sine, radius * (1.0 - cosine)], axis=-1)
        velocity = (radius * rate)[..., None] * np.stack([cosine, sine], axis=-1)
        acceleration = (radius * rate * rate)[..., None] * np.stack([-sine, cosine], axis=-1)
        jerk = (radius * rate * rate * rate)[..., None] * np.stack([-cosine, -sine], axis=-1)
        return self.placement.place(position, velocity, acceleration, jerk)


@dataclass(frozen=True)
class FigureEight:
    """x = (length/2) sin φ, y = (length/4) sin 2φ with constant φ̇, periodic.

    Attributes
    ----------
    length : (N,) array
        End to end [m].
    speed : (N,) array
        At the crossing [m/s].
    placement : Placement
        The crossing; the robot leaves it into the first quadrant of the plan's frame, at 45°.
    """

    length: Array
    speed: Array
    placement: Placement

    def at(self, times: Array) -> Reference:
        """Return the plan at `times` (T,) [s], arrays (N, T, 2)."""
        half = (self.length / 2.0)[:, None]
        rate = figure_eight_rate(self.length, self.speed)[:, None]
        phase = rate * times[None, :]
        s1, c1, s2, c2 = np.sin(phase), np.cos(phase), np.sin(2.0 * phase), np.cos(2.0 * phase)
        position = np.stack([half * s1, half / 2.0 * s2], axis=-1)
        velocity = np.stack([half * rate * c1, half * rate * c2], axis=-1)
        squared = half * rate * rate
        acceleration = np.stack([-squared * s1, -2.0 * squared * s2], axis=-1)
        jerk = np.stack([-squared * rate * c1, -4.0 * squared * rate * c2], axis=-1)
        return self.placement.place(position, velocity, acceleration, jerk)


def figure_eight_rate(length: Array, speed: Array) -> Array:
    """Return φ̇ [rad/s] of a figure-eight (N,): its speed at φ = 0 is φ̇ (length/2) √2."""
    return speed / (length / 2.0 * math.sqrt(2.0))
