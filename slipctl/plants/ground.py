"""The ground of every world, and what it means in MuJoCo's numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from mujoco.batch import Batch
from numpy.typing import NDArray

from slipctl.plants.patches import Change, Patch, changed, patched
from slipctl.plants.standstill import Tyre
from slipctl.plants.terrain import Terrain
from slipctl.theory.robot import GRAVITY
from slipctl.tick import WHEELS, Array, Slip

LEAST_CREEP_SPEED = 0.05
"""Wheel speed below which creep grows no stiffer, so that it stays finite at standstill [m/s] (assumed)."""

CURVE_ERROR = 0.0135
"""Error of the lateral slip on a film in steady turning that is let be [1]."""

STIFFEST = 3.0
"""How much larger than the model's b_t may get. A wheel that slides faster than N·R/(μ·b_t) hops, because its
slip adds to the normal force: 2 m/s at μ = 0.8 for the Magellan Pro and the factor 3, 6 m/s for 1."""


@dataclass(frozen=True)
class Ground:
    """What the wheels stand on, per world.

    Attributes
    ----------
    friction : (N, 2) array
        Coulomb coefficient under the left and right wheel [1].
    film : (N,) array
        Viscous film per wheel [N·s/m]; NaN for none.
    creep_stiffness : (N,) array
        Force per unit slip ratio and wheel [N]; NaN for none. Not together with a film.
    slope : (N,) array
        Angle of the ground [rad].
    downhill : (N,) array
        World direction of gravity's part along the ground [rad].
    patches : tuple of Patch
        Later ones lie on top of earlier ones.
    changes : tuple of Change
        Of the floor beside the patches, in the order of time.
    terrain : Terrain or None
        None for a level floor.
    """

    friction: Array
    film: Array
    creep_stiffness: Array
    slope: Array
    downhill: Array
    patches: tuple[Patch, ...] = ()
    changes: tuple[Change, ...] = ()
    terrain: Terrain | None = None

    @cached_property
    def creeps(self) -> bool:
        """Whether the tyres of any world creep."""
        return not np.isnan(self.creep_stiffness).all()

    @property
    def varies(self) -> bool:
        """Whether place or time decide what is under a wheel."""
        return bool(self.patches or self.changes)

    def wet_in_places(self) -> NDArray[np.bool_]:
        """Return which worlds (N,) have patches and a film somewhere: it may be under one wheel only."""
        wet = ~np.isnan(self.film)
        for part in (*self.patches, *self.changes):
            wet = wet | ~np.isnan(part.film)
        return wet & bool(self.patches)

    def under(self, points: Array, time: float) -> tuple[Array, Array]:
        """Return friction and film (NaN for none), (N, 2), under contact points (N, 2, 2) at a time [s]."""
        film = np.broadcast_to(self.film[:, None], self.friction.shape)
        return patched(self.patches, points, *changed(self.changes, time, self.friction, film))

    @classmethod
    def flat(cls, friction: float | Array, count: int = 1) -> Ground:
        """Return flat dry ground of one friction, or of friction (N,) or (N, 2), for `count` worlds."""
        value = np.asarray(friction, dtype=np.float64)
        if value.ndim == 1:
            value = value[:, None]
        pair = np.array(np.broadcast_to(value, (len(value) if value.ndim else count, 2)))
        none = np.full(len(pair), np.nan)
        zero = np.zeros(len(pair))
        return cls(friction=pair, film=none, creep_stiffness=none, slope=zero, downhill=zero)


def gravity(ground: Ground) -> Array:
    """Return gravity (N, 3) in the frame of the ground [m/s²]: the floor stays level, gravity tilts."""
    rows = [
        (
            GRAVITY * math.sin(slope) * math.cos(downhill),
            GRAVITY * math.sin(slope) * math.sin(downhill),
            -GRAVITY * math.cos(slope),
        )
        for slope, downhill in zip(ground.slope.tolist(), ground.downhill.tolist(), strict=True)
    ]
    return np.array(rows)


@dataclass(frozen=True)
class Grip:
    """How friction gives way below its limit, in MuJoCo's terms.

    Attributes
    ----------
    impratio : (N,) array
        Ratio of frictional to normal impedance, one for both wheels [1].
    rate : (N, 2) array
        b_t of the left and right wheel [1/s].
    """

    impratio: Array
    rate: Array

    def solreffriction(self, tyre: Tyre) -> Array:
        """Return MuJoCo's ``solreffriction`` (N, 2 wheels, 2), in its direct format."""
        pair = np.empty((*self.rate.shape, 2))
        pair[..., 0] = -1e-9  # ignored, but it must be negative for the second number to be taken as damping
        pair[..., 1] = -self.rate * tyre.impedance
        return pair


def viscosity(ground: Ground, wheel_speed: Array) -> Array:
    """Return the friction force per slip velocity below the limit.

    Parameters
    ----------
    ground : Ground
    wheel_speed : (N, 2) array
        r·ω of the wheels [m/s].

    Returns
    -------
    (N, 2) array
        C [N·s/m]: the film; for tyre creep F = C_κ·κ with κ = (slip velocity)/|r ω|, so C = C_κ/|r ω|; NaN
        where the ground has neither.
    """
    creep = ground.creep_stiffness[:, None] / np.maximum(np.abs(wheel_speed), LEAST_CREEP_SPEED)
    film = ground.film[:, None]
    return np.where(np.isnan(film), creep, film)


def grip(tyre: Tyre, viscosity: Array) -> Grip:
    """Return the contact parameters that make the friction of stick a damper.

    From C = b_t·impratio/R (`Tyre`): impratio takes up what b_t does not. MuJoCo leaves J̇v out of a contact's
    acceleration, so steady turning adds v·w/b_t to the lateral slip, a share A·C/b_t of what the force of the
    curve causes. A smaller b_t than the model's would make that worse; a stiff film gets a larger one, up to
    `STIFFEST`, to keep the share at `CURVE_ERROR`.

    Parameters
    ----------
    tyre : Tyre
    viscosity : (N, 2) array
        C per wheel [N·s/m]; NaN for plain grip.
    """
    wanted = viscosity * tyre.softness
    none = np.isnan(wanted[:, 0])
    stiffer = np.maximum(wanted[:, 0], wanted[:, 1])
    share = stiffer * tyre.impedance / (1.0 - tyre.impedance) / tyre.rate
    largest_rate = tyre.rate * np.clip(share / CURVE_ERROR, 1.0, STIFFEST)
    impratio = np.where(none, tyre.impratio, stiffer / largest_rate)
    rate = np.where(none[:, None], tyre.rate, wanted / impratio[:, None])
    return Grip(impratio=impratio, rate=rate)


def floor_motion(slip: Slip, position: Array, heading_vector: Array) -> Array:
    """Return the surface velocity that gives a robot in grip a prescribed slip.

    Parameters
    ----------
    slip : Slip
        v_t, v_s (to the right), w_s, (N,) each.
    position : (N, 2) array
        Axle midpoint [m]: w_s turns the surface about it.
    heading_vector : (N, 2) array
        Cosine and sine of the heading.

    Returns
    -------
    (N, 6) array
        MuJoCo's ``surfacevel``: velocity at the world's origin [m/s], then angular velocity [rad/s].
    """
    cosine, sine = heading_vector[:, 0], heading_vector[:, 1]
    surface = np.zeros((len(position), 6))
    surface[:, 0] = slip.longitudinal * cosine + slip.lateral * sine + slip.yaw * position[:, 1]
    surface[:, 1] = slip.longitudinal * sine - slip.lateral * cosine - slip.yaw * position[:, 0]
    surface[:, 5] = slip.yaw
    return surface


def _tyre_pairs(batch: Batch) -> list[int]:
    # by name: compiled pairs are sorted, not in file order
    return [batch.model.pair(f"{side}_tyre").id for side in WHEELS]


def soften(batch: Batch, viscosity: Array, tyre: Tyre, worlds: NDArray[np.bool_] | None = None) -> None:
    """Write into every world, or some, how friction gives way: viscosity (N, 2) [N·s/m], NaN for grip."""
    contact = grip(tyre, viscosity)
    some = np.ones(len(viscosity), dtype=bool) if worlds is None else worlds
    batch.expand("opt.impratio")[some] = contact.impratio[some]
    pairs = batch.expand("pair_solreffriction")
    for wheel, pair in enumerate(_tyre_pairs(batch)):
        pairs[some, pair] = contact.solreffriction(tyre)[some, wheel]


def rub(batch: Batch, friction: Array) -> None:
    """Write the friction (N, 2) under the wheels into every world."""
    batch.expand("pair_friction")[:, _tyre_pairs(batch), :2] = friction[:, :, None]


def lay(batch: Batch, ground: Ground, tyre: Tyre) -> None:
    """Write into every world what of its ground does not change during a run.

    Parameters
    ----------
    batch : mujoco.batch.Batch
        Of the N worlds of `ground`.
    ground : Ground
    tyre : Tyre
        Of the compiled model.
    """
    rub(batch, ground.friction)
    if (ground.slope != 0.0).any():
        batch.expand("opt.gravity")[...] = gravity(ground)
    if not np.isnan(ground.film).all() and not ground.varies:
        soften(batch, viscosity(ground, np.zeros_like(ground.friction)), tyre)
