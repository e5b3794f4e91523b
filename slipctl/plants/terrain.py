"""Uneven floor: a sum of plane waves, and where a sphere touches it.

The floor is not cut into the facets of a height field, over whose seams a wheel would hop. Every sphere that
touches the floor gets a plane of its own, put tangent to the floor at the point nearest to the sphere before
every physics step: the calibrated contacts stay as they are, one point each.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from slipctl.tick import Array

WAVES = 7
"""Plane waves that bumps are made of."""

MOST_CURVED = 0.3
"""Largest curvature of the floor times the radius of a sphere on it; at 1 a hollow would touch it twice."""

NEAREST_ROUNDS = 4
"""Rounds of the search for the nearest point; each leaves at most `MOST_CURVED` of the error."""

_SINE = tuple((-1.0) ** k * (2.0 * math.pi) ** (2 * k + 1) / math.factorial(2 * k + 1) for k in range(9))


def sine(turns: Array) -> Array:
    """Return sin(2π·turns) to 1e-13, with additions and products only.

    The library's sine may round differently in batches of another size; these do not.
    """
    part = turns - np.round(turns)
    part = np.where(np.abs(part) > 0.25, np.copysign(0.5, part) - part, part)
    square = part * part
    total = np.full_like(part, _SINE[-1])
    for factor in _SINE[-2::-1]:
        total = total * square + factor
    return total * part


@dataclass(frozen=True)
class Terrain:
    """Height z = Σ a·sin(2π (k·(x, y) + φ)), one per world.

    Attributes
    ----------
    amplitude : (N, K) array
        a of the K waves [m].
    wave_vector : (N, K, 2) array
        k, of length one over the wavelength [1/m].
    phase : (N, K) array
        φ [turns].
    """

    amplitude: Array
    wave_vector: Array
    phase: Array

    @classmethod
    def waves(cls, amplitude: Array, wavelength: Array, heading: Array) -> Terrain:
        """Return straight waves that follow each other along a heading [rad], rising from the origin on."""
        along = [(math.cos(angle), math.sin(angle)) for angle in heading.tolist()]
        vector = (np.array(along) / wavelength[:, None])[:, None, :]
        return cls(amplitude[:, None], vector, np.zeros((len(amplitude), 1)))

    @classmethod
    def bumps(cls, amplitude: Array, wavelength: Array, seeds: list[int]) -> Terrain:
        """Return bumps without direction: waves all around with phases from the worlds' seeds.

        The amplitude is the largest possible height, at which all waves meet; root mean square it is
        amplitude/√(2·`WAVES`).
        """
        phases, vectors = [], []
        for length, seed in zip(wavelength.tolist(), seeds, strict=True):
            chance = np.random.default_rng(seed)
            turned = math.pi / WAVES * chance.random()
            angles = [turned + math.pi * k / WAVES for k in range(WAVES)]
            vectors.append([(math.cos(angle) / length, math.sin(angle) / length) for angle in angles])
            phases.append(chance.random(WAVES))
        each = np.broadcast_to(amplitude[:, None] / WAVES, (len(amplitude), WAVES))
        return cls(np.array(each), np.array(vectors), np.array(phases))

    @property
    def curvature(self) -> Array:
        """Upper bound of the curvature, (N,) [1/m]."""
        length = self.wave_vector[..., 0] ** 2 + self.wave_vector[..., 1] ** 2
        return (np.abs(self.amplitude) * (2.0 * math.pi) ** 2 * length).sum(axis=1)

    def relief(self, points: Array) -> tuple[Array, Array]:
        """Return height (N, M) [m] and gradient (N, M, 2) [1] under points (N, M, 2) [m]."""
        x, y = (self.wave_vector[..., axis].T[:, :, None] for axis in range(2))  # (K, N, 1)
        turns = x * points[..., 0] + y * points[..., 1] + self.phase.T[:, :, None]
        both = sine(np.stack([turns, turns + 0.25]))
        size = self.amplitude.T[:, :, None]
        rise, slope = size * both[0], (2.0 * math.pi) * size * both[1]
        height, east, north = rise[0], x[0] * slope[0], y[0] * slope[0]
        for k in range(1, len(size)):  # one after the other: a library's sum may choose another order
            height, east, north = height + rise[k], east + x[k] * slope[k], north + y[k] * slope[k]
        return height, np.stack([east, north], axis=-1)

    def nearest(self, centres: Array) -> tuple[Array, Array]:
        """Return the floor's points nearest to points above it and its normals there, (N, M, 3) each."""
        at = centres[..., :2]
        height, gradient = self.relief(at)
        for _ in range(NEAREST_ROUNDS):
            at = centres[..., :2] + (centres[..., 2] - height)[..., None] * gradient
            height, gradient = self.relief(at)
        x, y = gradient[..., 0], gradient[..., 1]
        length = np.sqrt(1.0 + x * x + y * y)
        normal = np.stack([-x / length, -y / length, 1.0 / length], axis=-1)
        return np.concatenate([at, height[..., None]], axis=-1), normal


def upright_to(normal: Array) -> Array:
    """Return the quaternions (…, 4) w, x, y, z of the shortest turn from vertical to unit normals (…, 3)."""
    w = 1.0 + normal[..., 2]
    x, y = -normal[..., 1], normal[..., 0]
    length = np.sqrt(w * w + x * x + y * y)
    return np.stack([w / length, x / length, y / length, np.zeros_like(w)], axis=-1)


def levelled(force: Array, normal: Array) -> Array:
    """Turn forces (…, 3) by the shortest turn from unit normals (…, 3) to vertical: z is the load then."""
    x, y, z = (normal[..., i] for i in range(3))
    fx, fy, fz = (force[..., i] for i in range(3))
    load = x * fx + y * fy + z * fz
    share = (x * fx + y * fy) / (1.0 + z)
    return np.stack([fx - x * (fz + share), fy - y * (fz + share), load], axis=-1)
