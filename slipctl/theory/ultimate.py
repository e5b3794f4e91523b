"""Ultimate bounds on the position error under (59) and (73), the appendix of the paper corrected.

All take Q = I, as the laws do, and one axis of P: the paper's matrix is it ⊗ I₂, and every bound below is
attained with x and y in one direction.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from slipctl.tick import Array

GRID = 201
ZOOMS = 4
BISECTIONS = 60


def level_set(weights: Array, boundary_layer: float, robust_gain: float) -> float:
    """Return the level c of V = eᵀPe that cannot be left, (99) corrected.

    The paper's R has ρ outside the root, and takes the ball of radius R for invariant; it is the smallest
    level set around it that is: c = λ_max(P) R² with R² = ερ/2.

    Parameters
    ----------
    weights : (order, order) array
        P of one axis.
    boundary_layer, robust_gain : float
        ε, and the supremum of ρ.
    """
    return _shape(weights.tobytes(), len(weights))[0] * boundary_layer * robust_gain / 2.0


def tight_level_set(weights: Array, boundary_layer: float, robust_gain: float) -> float:
    """Return the smallest level of V that the estimate of the appendix gives before it is simplified.

    V can grow only where eᵀe ≤ 2ρ(‖w‖ − ‖w‖²/ε), w = JᵀPe, ‖w‖ < ε; this is the largest V there (derived).
    For a given ‖w‖ that is a quadratic form over a circle, whose Lagrangian dual is exact, and from above
    wherever it is stopped.

    Parameters
    ----------
    weights, boundary_layer, robust_gain
        As in `level_set`.
    """
    return float(tight_level_sets(weights, np.array([boundary_layer]), np.array([robust_gain]))[0])


def tight_level_sets(weights: Array, boundary_layer: Array, robust_gain: Array) -> Array:
    """Return `tight_level_set` of many worlds (N,) that share their weights, each as if it were alone.

    Parameters
    ----------
    weights : (order, order) array
        P of one axis.
    boundary_layer, robust_gain : (N,) arrays
        ε, and the suprema of ρ, all finite.
    """
    own, form, slope, squared = _across(weights.tobytes(), len(weights))
    some = (boundary_layer > 0.0) & (robust_gain > 0.0)
    layer, gain = np.where(some, boundary_layer, 1.0)[:, None], robust_gain[:, None]

    def largest(length: Array) -> Array:
        allowed = 2.0 * gain * (length - length * length / layer)
        radius = np.sqrt(np.maximum(allowed - length * length / squared, 0.0))
        linear = slope[:, None, None] * length
        multiplier = _multiplier(form[:, None, None], linear, radius)
        gap = np.maximum(multiplier - form[:, None, None], 1e-300)
        rest = multiplier * radius**2 + np.sum(linear**2 / gap, axis=0)
        return np.where(radius > 0.0, own * length * length + rest, 0.0)

    worlds = np.arange(len(layer))
    lower, upper, best = np.zeros_like(layer), layer, np.zeros(len(layer))
    for _ in range(ZOOMS):
        lengths = np.arange(GRID) * ((upper - lower) / (GRID - 1)) + lower
        lengths[:, -1:] = upper
        values = largest(lengths)
        index = np.argmax(values, axis=1)
        best = np.maximum(best, values[worlds, index])
        lower = lengths[worlds, np.maximum(index - 1, 0)][:, None]
        upper = lengths[worlds, np.minimum(index + 1, GRID - 1)][:, None]
    return np.where(some, best, 0.0)


def _multiplier(form: Array, linear: Array, radius: Array) -> Array:
    """Return the Lagrange multiplier at which the pull has the length of the radius, from above.

    With one direction across there is nothing to search for.
    """
    high = form[-1] + np.sqrt(np.sum(linear * linear, axis=0)) / np.maximum(radius, 1e-12)
    if len(form) == 1:
        return high
    low, squared = np.full_like(high, form[-1].item()), radius**2
    for _ in range(BISECTIONS):
        middle = (low + high) / 2.0
        more = np.sum((linear / np.maximum(middle - form, 1e-300)) ** 2, axis=0) > squared
        low, high = np.where(more, middle, low), np.where(more, high, middle)
    return high


@lru_cache(maxsize=256)
def _across(weights: bytes, order: int) -> tuple[float, Array, Array, float]:
    """Return what P does to e = (‖w‖/|row|²) row + rest, where the rest lies across P's last row.

    That is the form of the first part, the eigenvalues of the form of the rest (order − 1,), the coupling of
    both in the same axes (order − 1,), and |row|².
    """
    matrix = np.frombuffer(weights).reshape(order, order)
    row = matrix[-1]
    squared = float(np.sum(row * row))
    across = np.linalg.svd(row[None, :])[2][1:]
    form, turned = np.linalg.eigh(across @ matrix @ across.T)
    slope = turned.T @ (across @ matrix @ row) / squared
    return float(row @ matrix @ row) / squared**2, form, slope, squared


@lru_cache(maxsize=256)
def _shape(weights: bytes, order: int) -> tuple[float, float, float]:
    """Return λ_max(P), (P⁻¹)₁₁ and the time constant of the surface JᵀPe = 0 [s]."""
    matrix = np.frombuffer(weights).reshape(order, order)
    slowest = float(np.max(np.roots(matrix[-1][::-1]).real))
    return float(np.linalg.eigvalsh(matrix)[-1]), float(np.linalg.inv(matrix)[0, 0]), 1.0 / -slowest


def position_bound(weights: Array, level: float) -> float:
    """Return the largest |e₁| [m] of a level set V ≤ `level`: √(level (P⁻¹)₁₁)."""
    return math.sqrt(level * _shape(weights.tobytes(), len(weights))[1])


def small_gain(gains: Array, weights: Array) -> float:
    """Return the loop gain between ‖w‖ and P₁₂|e₁| outside the boundary layer of the kinematic law.

    Outside the layer and with ‖η‖ ≤ ρ, d‖w‖/dt ≤ −a‖w‖ + b|e₁| with a = K₂ − P₁₂/P₂₂ and
    b = |K₂P₁₂ − P₁₂²/P₂₂ − K₁P₂₂|, and d|e₁|/dt ≤ (‖w‖ − P₁₂|e₁|)/P₂₂. Where b/(aP₁₂) < 1, no set
    max(‖w‖, P₁₂|e₁|) ≤ s with s ≥ ε can be left, and all above ε shrink, so that limsup |e₁| ≤ ε/P₁₂
    whatever ρ is (derived).

    Parameters
    ----------
    gains : (2,) array
        K₁ [1/s²], K₂ [1/s].
    weights : (2, 2) array
        P of one axis.

    Returns
    -------
    float
        Below 1 the bound holds: for equal poles p, where it is ((|p| − 1/|p|)/2)², from 0.42 to 2.41 1/s.
        Infinite for other orders: the same step gives 1.95 for the dynamic law.
    """
    if len(gains) != 2:
        return math.inf
    corner, last = float(weights[0, 1]), float(weights[1, 1])
    damping = float(gains[1]) - corner / last
    coupling = abs(float(gains[1]) * corner - corner * corner / last - float(gains[0]) * last)
    return coupling / (damping * corner) if damping > 0.0 and corner > 0.0 else math.inf


def time_constant(weights: Array) -> float:
    """Return the time constant of the error on the surface JᵀPe = 0, where the robust law holds it [s].

    Its roots are those of P₁ₙ + … + Pₙₙsⁿ⁻¹: 1.25 s for the kinematic law with poles −0.5, 1.40 s for the
    dynamic one.

    Parameters
    ----------
    weights : (order, order) array
        P of one axis.
    """
    return _shape(weights.tobytes(), len(weights))[2]
