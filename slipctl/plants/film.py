"""A film under one wheel and none under the other: a viscous force of its own in place of the contact's.

MuJoCo's friction can be softened into a film only for both wheels at once, because ``impratio`` is one for
the whole world. Where patches make the wheels differ, the contact of a wheel on a film keeps the least
friction that MuJoCo allows, and the film's force is computed here from the wheel's slip at the beginning of
every physics step: −C·(slip velocity), at most μN with the load N of the step before.
"""

from __future__ import annotations

import numpy as np

from slipctl.tick import Array, Motion

LEAST_FRICTION = 1e-5
"""MuJoCo's smallest friction coefficient [1]."""

LARGEST_SHARE = 0.5
"""Share of its slip that a film may take from a wheel in one physics step; beyond 1 it would swing."""


def contact_slip(motion: Motion, tilt_rate: Array, wheel_radius: Array, half_track: float) -> Array:
    """Return the velocity of the wheels' contact points over the floor, (N, 2 wheels, 2) [m/s].

    Parameters
    ----------
    motion : Motion
    tilt_rate : (N, 2) array
        Body rates about its forward and left axis [rad/s].
    wheel_radius : (N, 2) array
        Rolling radii under the present load [m].
    half_track : float
        [m].

    Returns
    -------
    (N, 2, 2) array
        Along the body's forward and **left** axes.
    """
    cosine, sine = motion.heading_vector[:, 0], motion.heading_vector[:, 1]
    forward = cosine * motion.velocity[:, 0] + sine * motion.velocity[:, 1]
    left = cosine * motion.velocity[:, 1] - sine * motion.velocity[:, 0]
    turning = np.stack([-half_track * motion.heading_rate, half_track * motion.heading_rate], axis=-1)
    rolling = wheel_radius * (motion.wheel_rate + tilt_rate[:, 1, None])
    along = forward[:, None] + turning - rolling
    return np.stack([along, left[:, None] + wheel_radius * tilt_rate[:, 0, None]], axis=-1)


def film_force(slip: Array, heading_vector: Array, film: Array, limit: Array) -> Array:
    """Return the film's force on the wheels in world x, y, (N, 2 wheels, 2) [N].

    Parameters
    ----------
    slip : (N, 2, 2) array
        As of `contact_slip`.
    heading_vector : (N, 2) array
    film : (N, 2) array
        C [N·s/m]; NaN for none.
    limit : (N, 2) array
        μN [N].
    """
    speed = np.sqrt(slip[..., 0] * slip[..., 0] + slip[..., 1] * slip[..., 1])
    size = np.where(np.isnan(film), 0.0, film)
    wanted = size * speed
    held = np.where(wanted > limit, limit / np.where(speed > 0.0, speed, 1.0), size)
    along, left = -held * slip[..., 0], -held * slip[..., 1]
    cosine, sine = heading_vector[:, 0, None], heading_vector[:, 1, None]
    return np.stack([cosine * along - sine * left, sine * along + cosine * left], axis=-1)
