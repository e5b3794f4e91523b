"""Differential flatness of the kinematic model without slip, (6)–(14).

The flat output is the position F of the axle midpoint. Symbols as in the paper; t = (cos θ, sin θ) points
forward, n = (−sin θ, cos θ) to the left.
"""

from __future__ import annotations

import numpy as np

from slipctl.tick import Array


def flat_to_state(velocity: Array, acceleration: Array) -> tuple[Array, Array, Array, Array]:
    """Map derivatives of the flat output to state and inputs, (9) and (10).

    The printed (9) has tan⁻¹, which loses the quadrant: here atan2, on the branch v > 0.

    Parameters
    ----------
    velocity, acceleration : (..., 2) arrays
        Ḟ [m/s] and F̈ [m/s²].

    Returns
    -------
    forward_speed, heading, forward_acceleration, yaw_rate : arrays of shape (...)
        v [m/s], θ [rad], ū₁ [m/s²], ū₂ [rad/s]. ū₁ and ū₂ are not finite where v = 0 (the singularity).
    """
    x1, y1 = velocity[..., 0], velocity[..., 1]
    x2, y2 = acceleration[..., 0], acceleration[..., 1]
    squared = x1 * x1 + y1 * y1
    speed = np.sqrt(squared)
    with np.errstate(invalid="ignore", divide="ignore"):
        return speed, np.arctan2(y1, x1), (x1 * x2 + y1 * y2) / speed, (x1 * y2 - x2 * y1) / squared


def state_to_flat(
    forward_speed: Array, heading: Array, forward_acceleration: Array, yaw_rate: Array
) -> tuple[Array, Array]:
    """Map state and inputs to the derivatives of the flat output, (6), (7) and (11).

    Parameters
    ----------
    forward_speed, heading, forward_acceleration, yaw_rate : arrays of one shape (...)
        v [m/s], θ [rad], ū₁ [m/s²], ū₂ [rad/s].

    Returns
    -------
    velocity, acceleration : (..., 2) arrays
        Ḟ [m/s] and F̈ [m/s²].
    """
    cosine, sine = np.cos(heading), np.sin(heading)
    velocity = np.stack([forward_speed * cosine, forward_speed * sine], axis=-1)
    return velocity, apply_decoupling(forward_speed, cosine, sine, forward_acceleration, yaw_rate)


def apply_decoupling(
    forward_speed: Array, cosine: Array, sine: Array, forward_acceleration: Array, yaw_rate: Array
) -> Array:
    """Return B (ū₁, ū₂), the right-hand side of (11) with B of (12), as (..., 2) [m/s²]."""
    turn = forward_speed * yaw_rate
    return np.stack(
        [cosine * forward_acceleration - sine * turn, sine * forward_acceleration + cosine * turn], axis=-1
    )


def invert_decoupling(
    forward_speed: Array, cosine: Array, sine: Array, flat_input: Array
) -> tuple[Array, Array]:
    """Return (ū₁, ū₂) = B⁻¹ v, (13).

    Parameters
    ----------
    forward_speed, cosine, sine : arrays of shape (...)
        v [m/s], away from zero, and the heading vector.
    flat_input : (..., 2) array
        The transformed input v of (14) [m/s²].

    Returns
    -------
    forward_acceleration, yaw_rate : arrays of shape (...)
        [m/s²], [rad/s].
    """
    v1, v2 = flat_input[..., 0], flat_input[..., 1]
    return cosine * v1 + sine * v2, (cosine * v2 - sine * v1) / forward_speed
