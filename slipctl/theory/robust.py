"""Nominal feedback, corrective term and uncertainty bounds of the robust kinematic law, (42)–(60).

Symbols as in the paper, with every departure confessed at its function. Nothing here rounds differently for
another number of worlds: no matrix products, norms as square roots of sums.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_continuous_lyapunov

from slipctl.tick import Array


def norm(vector: Array) -> Array:
    """Return the Euclidean norm over the last axis of an (..., 2) array."""
    squared = vector * vector
    return np.sqrt(squared[..., 0] + squared[..., 1])


def chain_gains(pole: Array, order: int) -> Array:
    """Return gains that put every root of a chain of integrators at `pole`.

    Parameters
    ----------
    pole : (N,) array
        Negative [1/s].
    order : int
        Length of the chain, 2 for the kinematic model.

    Returns
    -------
    (N, order) array
        K₁ … K_order as scalars (the paper's diagonal matrices are multiples of the identity): −0.5 gives
        0.25 and 1, as in Section V-A.
    """
    rate = -np.asarray(pole, dtype=float)
    return np.stack([math.comb(order, k) * rate ** (order - k) for k in range(order)], axis=-1)


def lyapunov_matrix(gains: Array) -> Array:
    """Solve ĀᵀP + PĀ + Q = 0 with Q = I, (48) and (60), for one axis.

    x and y do not couple, so the paper's matrix is this one ⊗ I₂.

    Parameters
    ----------
    gains : (order,) array
        K₁ … of one world.

    Returns
    -------
    (order, order) array
        Symmetric, positive definite.
    """
    return _solved(*(float(gain) for gain in gains)).copy()


@lru_cache(maxsize=256)
def _solved(*gains: float) -> Array:
    order = len(gains)
    closed_loop = np.eye(order, k=1)
    closed_loop[-1] = -np.array(gains)
    solution = solve_continuous_lyapunov(closed_loop.T, -np.eye(order))
    return (solution + solution.T) / 2.0


def corrective_input(weighted_error: Array, robust_gain: Array, boundary_layer: Array) -> Array:
    """Return Δv: the continuous law (59), or the discontinuous law (47) where the boundary layer is 0.

    Parameters
    ----------
    weighted_error : (N, 2) array
        JᵀPe.
    robust_gain, boundary_layer : (N,) arrays
        ρ [m/s²] and ε ≥ 0. (The printed conditions of (47) speak of an ε that (47) does not contain.)

    Returns
    -------
    (N, 2) array
        [m/s²]; zero where JᵀPe = 0.
    """
    divisor = np.maximum(norm(weighted_error), boundary_layer)
    if np.count_nonzero(divisor) == divisor.size:
        scale = robust_gain / divisor
    else:
        scale = np.divide(robust_gain, divisor, out=np.zeros(divisor.shape), where=divisor > 0.0)
    return -scale[:, None] * weighted_error


UncertaintyBound = Callable[[Array, Array, Array, Array], Array]
"""(α, v, norm of the nominal input, its forward component), all (N,), to ρ (N,) [m/s²]."""


def paper_bound(slip_bound: Array, forward_speed: Array, nominal: Array, nominal_forward: Array) -> Array:
    """Return ρ of (58) with the paper-like Φ; needs α < 1/2.

    The paper bounds the slip rates by the nominal input, but the true v̇_t = αū₁ contains Δv. What saves the
    bound is slack in (51): it is never below `independent_bound` (derived), so it holds wherever that does.
    The paper does not print Φ; assumed
    Φ = α|v||w_s| + 2α|û₁| + (1+α)|v||w_s| with |w_s| = α|v| and û₁ = t·v̂.

    Parameters
    ----------
    slip_bound, forward_speed, nominal, nominal_forward : (N,) arrays
        α [1], v [m/s], ‖v̂‖ and t·v̂ [m/s²].
    """
    a = np.asarray(slip_bound, dtype=np.float64)
    twice_a, less_twice_a, more_a = _of_paper_bound(a.tobytes(), a.shape)
    speed = np.abs(forward_speed)
    turn = speed * (slip_bound * speed)
    rest = slip_bound * turn + twice_a * np.abs(nominal_forward) + more_a * turn
    return (twice_a * nominal + rest) / less_twice_a


@lru_cache(maxsize=256)
def _of_paper_bound(slip_bound: bytes, shape: tuple[int, ...]) -> tuple[Array, Array, Array]:
    """Return 2α, 1 − 2α and 1 + α, which stay the same from tick to tick."""
    a = np.frombuffer(slip_bound).reshape(shape)
    return 2.0 * a, 1.0 - 2.0 * a, 1.0 + a


def independent_bound(
    slip_bound: Array, forward_speed: Array, nominal: Array, nominal_forward: Array
) -> Array:
    """Return the rigorous ρ for slip components that vary independently; needs α < 1/2.

    Holds for |v_t|, |v_s| ≤ α|v|, |w_s| ≤ α|v|, |v̇_t|, |v̇_s| ≤ α|ū₁|, where ū₁ contains Δv (derived; the
    corrected form of (53)–(58)). Parameters as in `paper_bound`; `nominal_forward` plays no part.
    """
    return _small_gain(2.0, slip_bound, forward_speed, nominal)


def slip_ratio_bound(
    slip_bound: Array, forward_speed: Array, nominal: Array, nominal_forward: Array
) -> Array:
    """Return the rigorous ρ for a constant complex slip ratio; needs α < 1/√2.

    Holds for v_t = ±αv, v_s = ±αv with constant fractions and |w_s| ≤ α|v| (derived). It is not valid where
    the slip rates are independent of the slip. Parameters as in `paper_bound`.
    """
    return _small_gain(math.sqrt(2.0), slip_bound, forward_speed, nominal)


def _small_gain(factor: float, slip_bound: Array, forward_speed: Array, nominal: Array) -> Array:
    """Return (q‖v̂‖ + Φ₀)/(1 − q) with q = factor·α and Φ₀ = αv² √(α² + (1 + α)²)."""
    a = np.asarray(slip_bound, dtype=np.float64)
    gain, less_gain, share = _of_slip_bound(factor, a.tobytes(), a.shape)
    rest = slip_bound * forward_speed * forward_speed * share
    return (gain * nominal + rest) / less_gain


@lru_cache(maxsize=256)
def _of_slip_bound(factor: float, slip_bound: bytes, shape: tuple[int, ...]) -> tuple[Array, Array, Array]:
    """Return q, 1 − q and √(α² + (1 + α)²), which stay the same from tick to tick."""
    a = np.frombuffer(slip_bound).reshape(shape)
    gain = factor * a
    return gain, 1.0 - gain, np.sqrt(a * a + (1.0 + a) * (1.0 + a))


@dataclass(frozen=True)
class Uncertainty:
    """One form of the uncertainty bound.

    Attributes
    ----------
    bound : UncertaintyBound
        ρ as a function.
    largest_slip_bound : float
        α must stay below this.
    """

    bound: UncertaintyBound
    largest_slip_bound: float


UNCERTAINTIES = {
    "paper": Uncertainty(paper_bound, 0.5),
    "independent": Uncertainty(independent_bound, 0.5),
    "slip_ratio": Uncertainty(slip_ratio_bound, 1.0 / math.sqrt(2.0)),
}


def largest_calm_tick(
    boundary_layer: Array, robust_gain: Array, lyapunov_corner: Array, slip: NDArray[np.complex128]
) -> Array:
    """Return the tick above which the boundary layer chatters under a zero-order hold.

    h_max = 2 Re(1+σ)/|1+σ|² · ε/(P₂₂ρ) (derived; not in the paper).

    Parameters
    ----------
    boundary_layer, robust_gain, lyapunov_corner : arrays
        ε, ρ [m/s²], P₂₂.
    slip : complex array
        σ = (v_t − i v_s)/v.

    Returns
    -------
    array
        [s]; infinite where ρ = 0.
    """
    gain = 1.0 + slip
    with np.errstate(divide="ignore", invalid="ignore"):
        return (
            2.0 * gain.real / (gain.real**2 + gain.imag**2) * boundary_layer / (lyapunov_corner * robust_gain)
        )
