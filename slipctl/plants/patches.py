"""Patches of the floor and changes of it with time: what is under a wheel, decided at its contact point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from slipctl.tick import Array

Flags = NDArray[np.bool_]

JUST_NOW = 1e-9
"""A change counts from this much before its time on [s]: sums of ticks are not exact."""


@dataclass(frozen=True)
class Patch:
    """A part of the floor with a friction of its own, one per world.

    Attributes
    ----------
    kind : str
        ``rectangle``, ``disc`` or ``stripes``.
    place : (N, 2) array
        World x, y of the middle, of stripes that of the first stripe [m].
    direction : (N, 2) array
        Cosine and sine of the heading: along a rectangle's length; the way in which stripes follow.
    size : (N, 2) array
        Length and width; radius (twice); period and width [m].
    count : (N,) array
        Number of stripes, infinite for stripes all over the floor.
    friction : (N,) array
        [1].
    film : (N,) array
        Viscous film [N·s/m]; NaN for a dry patch.
    """

    kind: Literal["rectangle", "disc", "stripes"]
    place: Array
    direction: Array
    size: Array
    count: Array
    friction: Array
    film: Array

    def covers(self, points: Array) -> Flags:
        """Return whether points (N, 2 wheels, 2) [m] lie on the patch, (N, 2)."""
        x = points[..., 0] - self.place[:, 0, None]
        y = points[..., 1] - self.place[:, 1, None]
        if self.kind == "disc":
            radius = self.size[:, 0, None]
            return x * x + y * y <= radius * radius
        cosine, sine = self.direction[:, 0, None], self.direction[:, 1, None]
        along, across = cosine * x + sine * y, cosine * y - sine * x
        first, second = self.size[:, 0, None], self.size[:, 1, None]
        if self.kind == "rectangle":
            return (np.abs(along) <= 0.5 * first) & (np.abs(across) <= 0.5 * second)
        order = np.floor(along / first + 0.5)
        counted = np.isinf(self.count[:, None]) | ((order >= 0.0) & (order < self.count[:, None]))
        return counted & (np.abs(along - order * first) <= 0.5 * second)


@dataclass(frozen=True)
class Change:
    """From a time on the floor beside the patches is another one, the same under both wheels.

    Attributes
    ----------
    time : (N,) array
        [s].
    friction : (N,) array
        [1]; NaN leaves it as it was.
    film : (N,) array
        [N·s/m]; NaN leaves it as it was.
    dry : bool
        Whether the film goes.
    """

    time: Array
    friction: Array
    film: Array
    dry: bool = False


def changed(changes: Sequence[Change], time: float, friction: Array, film: Array) -> tuple[Array, Array]:
    """Return friction and film, (N, 2) each, as they are at a time [s]."""
    for change in changes:
        now = (change.time <= time + JUST_NOW)[:, None]
        friction = np.where(now & ~np.isnan(change.friction)[:, None], change.friction[:, None], friction)
        film = np.where(now & ~np.isnan(change.film)[:, None], change.film[:, None], film)
        if change.dry:
            film = np.where(now, np.nan, film)
    return friction, film


def patched(patches: Sequence[Patch], points: Array, friction: Array, film: Array) -> tuple[Array, Array]:
    """Return friction and film, (N, 2) each, under contact points (N, 2, 2); later patches lie on top."""
    for patch in patches:
        inside = patch.covers(points)
        friction = np.where(inside, patch.friction[:, None], friction)
        film = np.where(inside, patch.film[:, None], film)
    return friction, film


def contact_points(position: Array, heading_vector: Array, half_track: float) -> Array:
    """Return where the wheels touch the floor, (N, 2 wheels, 2) [m].

    Parameters
    ----------
    position : (N, 2) array
        Axle midpoint [m].
    heading_vector : (N, 2) array
        Cosine and sine of the heading.
    half_track : float
        [m].
    """
    left = half_track * np.stack([-heading_vector[:, 1], heading_vector[:, 0]], axis=-1)
    return np.stack([position + left, position - left], axis=1)
