"""What slip adds to the flat form of the kinematic model, (33) and (34)."""

from __future__ import annotations

import numpy as np

from slipctl.tick import Array, Slip


def slip_terms(
    forward_speed: Array,
    slip: Slip,
    longitudinal_rate: Array,
    lateral_rate: Array,
    cosine: Array,
    sine: Array,
) -> tuple[Array, Array]:
    """Return the matrices C and D of (33) and (34).

    Parameters
    ----------
    forward_speed : (N,) array
        v [m/s].
    slip : Slip
    longitudinal_rate, lateral_rate : (N,) arrays
        v̇_t and v̇_s [m/s²].
    cosine, sine : (N,) arrays
        The heading vector.

    Returns
    -------
    C : (N, 2) array
        [m/s²].
    D : (N, 2, 2) array
        Multiplies (ū₁, ū₂).
    """
    v_t, v_s, w_s = slip.longitudinal, slip.lateral, slip.yaw
    along = v_s * w_s + longitudinal_rate
    across = forward_speed * w_s + v_t * w_s - lateral_rate
    c_matrix = np.stack([along * cosine - across * sine, along * sine + across * cosine], axis=-1)
    zero = np.zeros_like(cosine)
    d_matrix = np.stack(
        [
            np.stack([zero, -v_t * sine + v_s * cosine], axis=-1),
            np.stack([zero, v_t * cosine + v_s * sine], axis=-1),
        ],
        axis=-2,
    )
    return c_matrix, d_matrix
