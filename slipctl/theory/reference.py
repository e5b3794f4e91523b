"""Desired trajectories, planned in the space of the flat output.

Every plan has parameters (N,) and answers `at(times)` with arrays (N, T, 2): position [m], velocity [m/s] and
acceleration [m/s²]. A plan is laid out in its own frame and then placed by a `Placement`.
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

    def place(self, position: Array, velocity: Array, acceleration: Array) -> Reference:
        """Return a reference of world vectors (N, T, 2) from vectors in the plan's frame."""
        cosine, sine = np.cos(self.heading)[:, None], np.sin(self.heading)[:, None]

        def turned(vector: Array) -> Array:
            x, y = vector[..., 0], vector[..., 1]
            return np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=-1)

        origin = np.stack([self.x, self.y], axis=-1)[:, None, :]
        return Reference(origin + turned(position), turned(velocity), turned(acceleration))


def _polynomial(coefficients: Array, times: Array) -> tuple[Array, Array, Array]:
    """Evaluate polynomials (N, 2, 4), constant first, and two derivatives at (N, T): (N, T, 2) each."""
    c = coefficients[:, None, :, :]
    t = times[:, :, None]
    value = c[..., 0] + t * (c[..., 1] + t * (c[..., 2] + t * c[..., 3]))
    first = c[..., 1] + t * (2.0 * c[..., 2] + t * (3.0 * c[..., 3]))
    second = 2.0 * c[..., 2] + t * (6.0 * c[..., 3])
    return value, first, second


@dataclass(frozen=True)
class PointToPoint:
    """Cubic flat outputs between two poses with speeds, Section V with Table I.

    After `duration` the plan goes on at its final velocity.

    Attributes
    ----------
    start, goal : (N, 4) arrays
        x, y [m], heading [rad], speed [m/s] at the ends.
    duration : (N,) array
        [s].
    placement : Placement
    """

    start: Array
    goal: Array
    duration: Array
    placement: Placement

    def at(self, times: Array) -> Reference:
        """Return the plan at `times` (T,) [s], arrays (N, T, 2)."""
        total = self.duration[:, None]
        clock = np.broadcast_to(times[None, :], (len(self.duration), len(times)))
        inside = np.minimum(clock, total)
        position, velocity, acceleration = _polynomial(self._coefficients(), inside)
        beyond = (clock > total)[:, :, None]
        position = np.where(beyond, position + velocity * (clock - inside)[:, :, None], position)
        return self.placement.place(position, velocity, np.where(beyond, 0.0, acceleration))

    def _coefficients(self) -> Array:
        def ends(pose: Array) -> tuple[Array, Array]:
            heading, speed = pose[:, 2], pose[:, 3]
            return pose[:, :2], np.stack([speed * np.cos(heading), speed * np.sin(heading)], axis=-1)

        (p0, v0), (p1, v1) = ends(self.start), ends(self.goal)
        total = self.duration[:, None]
        gap = p1 - p0 - v0 * total
        turn = v1 - v0
        quadratic = 3.0 * gap / total**2 - turn / total
        cubic = -2.0 * gap / total**3 + turn / total**2
        return np.stack([p0, v0, quadratic, cubic], axis=-1)


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
        return self.placement.place(
            np.stack([along, zero], axis=-1),
            np.stack([speed, zero], axis=-1),
            np.stack([zero, zero], axis=-1),
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
        return self.placement.place(position, velocity, acceleration)


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
        return self.placement.place(position, velocity, acceleration)


def figure_eight_rate(length: Array, speed: Array) -> Array:
    """Return φ̇ [rad/s] of a figure-eight (N,): its speed at φ = 0 is φ̇ (length/2) √2."""
    return speed / (length / 2.0 * math.sqrt(2.0))
