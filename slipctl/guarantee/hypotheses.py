"""What the theorems behind the robust laws assume, each as a measured value and its limit."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from slipctl.tick import Array

SLACK = 1e-9
"""Relative: the paper's own slip meets its bounds with equality (83)."""

LEAST_SPEED = 0.05
"""Keeps slip ratios finite at standstill [m/s], as in `slip.ratio`."""


@dataclass(frozen=True)
class Hypotheses:
    """What a robust law assumes.

    Attributes
    ----------
    slip_bound : (N,) array
        α [1].
    speed_floor : (N,) array
        The speed below which v counts as zero [m/s].
    uncertainty : str
        Name of the bound ρ; it decides how α limits the slip.
    boundary_layer : (N,) array
        ε.
    gains : (N, order) array
        K₁ … of one axis; order 2 for a kinematic law, 3 for a dynamic one.
    weights : (N, order, order) array
        P of one axis.
    yaw_slip_bound, lateral_slip_bound : (N,) arrays or None
        ξ₁ [rad/s] and ξ₂ [m/s] of Assumption 4.6; None where α|v| stands for them.
    """

    slip_bound: Array
    speed_floor: Array
    uncertainty: str
    boundary_layer: Array
    gains: Array
    weights: Array
    yaw_slip_bound: Array | None = None
    lateral_slip_bound: Array | None = None

    @property
    def order(self) -> int:
        """Length of the chain of integrators, 2 or 3."""
        return self.weights.shape[-1]

    def of(self, worlds: slice | NDArray[np.intp]) -> Hypotheses:
        """Return what is assumed for some of the worlds."""
        some = {
            field.name: value[worlds]
            for field in fields(self)
            if isinstance(value := getattr(self, field.name), np.ndarray)
        }
        return replace(self, **some)

    def ratio_bound(self, speed: Array) -> Array:
        """Return q, the bound on |σ| = √(v_t² + v_s²)/|v| that follows at speeds |v| (N, T).

        (N, 1) where it is the same at every speed, else (N, T).
        """
        alpha = self.slip_bound[:, None]
        if self.lateral_slip_bound is not None:
            lateral = self.lateral_slip_bound[:, None] / np.maximum(speed, LEAST_SPEED)
            return np.sqrt(alpha * alpha + lateral * lateral)
        factor = 2.0 if self.uncertainty == "paper" and self.order == 2 else math.sqrt(2.0)
        return factor * alpha


@dataclass(frozen=True)
class WeightedError:
    """JᵀPe of the true error.

    Attributes
    ----------
    x, y : (N, T) arrays
    """

    x: Array
    y: Array

    @cached_property
    def length(self) -> Array:
        """‖JᵀPe‖ (N, T)."""
        return _length(self.x, self.y)


@dataclass(frozen=True)
class Demand:
    """One hypothesis on every tick.

    Attributes
    ----------
    held : (N, T) bool array
    beyond : callable
        Returns by how much the measured value is beyond its limit (N, T); negative where it is within.
    scale : array
        What that is counted in: the limit, unless there is another measure.
    """

    held: NDArray[np.bool_]
    beyond: Callable[[], Array]
    scale: Array

    @property
    def excess(self) -> Array:
        """By which share of the scale the measured value is beyond its limit (N, T); few ask for it."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return self.beyond() / self.scale


def at_most(value: Array, limit: Array, scale: Array | None = None) -> Demand:
    """Demand value ≤ limit; the excess counts in shares of `scale`, or else of the limit."""
    held = value <= limit * (1.0 + SLACK)
    return Demand(held, lambda: value - limit, limit if scale is None else scale)


def at_least(value: Array, limit: Array) -> Demand:
    """Demand value ≥ limit; the excess is the missing share of the limit."""
    return Demand(value >= limit * (1.0 - SLACK), lambda: limit - value, limit)


def demands(
    columns: Mapping[str, NDArray],
    hypotheses: Hypotheses,
    uncertainty: Array,
    weighted: WeightedError,
) -> dict[str, Demand]:
    """Return every hypothesis, by its name in `slipctl.guarantee.columns.HYPOTHESES`.

    * `speed_above_floor`: v away from zero, where B has no inverse;
    * `slip_bounded`: Assumption 4.1 with ≤, as the paper's own simulation needs it: on |v_t| + |v_s| for the
      bound `paper`, on √(v_t² + v_s²) for `slip_ratio`, else on both apart. For dynamic laws Assumption 4.5
      and the bound on v_s of 4.6;
    * `yaw_slip_bounded`: |w_s| of Assumptions 4.2 and 4.6;
    * `feedback_exact`: Δv is (59) or (73) of the *true* error; it is not where a sensor errs or is late;
    * `uncertainty_covered`: ‖η‖ ≤ ρ, condition (iii) of the theorems. The bounds on slip *rates* of
      Assumptions 4.2 and 4.6 are means to this end and nothing else, and here they are measured, together
      with servo, sampling and saturation. See `slip_rates_bounded` for them alone.

    Parameters
    ----------
    columns : mapping of (N, T) arrays
    hypotheses : Hypotheses
    uncertainty : (N, T) array
        ‖η‖.
    weighted : WeightedError
    """
    alpha, layer = hypotheses.slip_bound[:, None], hypotheses.boundary_layer[:, None]
    speed = np.abs(columns["motion.forward_speed"])
    along, across = np.abs(columns["slip.longitudinal"]), np.abs(columns["slip.lateral"])
    allowed = alpha * speed
    yaw_allowed = _or_else(hypotheses.yaw_slip_bound, allowed)
    if hypotheses.order == 2 and hypotheses.uncertainty == "paper":
        along += across
        slip = at_most(along, 2.0 * allowed)
    elif hypotheses.uncertainty == "slip_ratio":
        slip = at_most(np.sqrt(along * along + across * across), math.sqrt(2.0) * allowed)
    else:
        sideways = _or_else(hypotheses.lateral_slip_bound, allowed)
        worse = across * allowed > along * sideways
        slip = at_most(np.where(worse, across, along), np.where(worse, sideways, allowed))
    off = _length(
        columns["decision.weighted_error.x"] - weighted.x,
        columns["decision.weighted_error.y"] - weighted.y,
    )
    tolerance = layer + weighted.length
    tolerance *= SLACK
    tolerance += 1e-12
    return {
        "speed_above_floor": at_least(speed, hypotheses.speed_floor[:, None]),
        "slip_bounded": slip,
        "yaw_slip_bounded": at_most(np.abs(columns["slip.yaw"]), yaw_allowed),
        "feedback_exact": at_most(off, tolerance, scale=layer),
        "uncertainty_covered": at_most(uncertainty, columns["decision.robust_gain"]),
    }


def slip_rates_bounded(columns: Mapping[str, NDArray], hypotheses: Hypotheses) -> NDArray[np.bool_] | None:
    """Return whether measured slip changed within its bounds over each tick, (N, T - 1).

    |Δv_t|, |Δv_s| ≤ α|Δv| for the kinematic bounds `paper` and `independent` (ζ₂, ζ₃ of Assumption 4.2 with
    ū₁ as it really was). No part of `guarantee.held`: differences over a tick on contacts are mostly jitter,
    and what a jitter does is in ‖η‖.

    Returns
    -------
    array or None
        None for bounds that need constant slip fractions and for dynamic laws, whose ξ₃ and ξ₄ are bounds on
        rates of rates.
    """
    if hypotheses.order != 2 or hypotheses.uncertainty == "slip_ratio":
        return None
    speed = columns["motion.forward_speed"]
    # differences of rounded numbers: the paper's slip meets the bound with equality
    rounding = np.abs(speed[:, 1:])
    rounding *= 16.0 * np.finfo(float).eps
    allowed = _change(speed)
    allowed *= hypotheses.slip_bound[:, None]
    allowed *= 1.0 + SLACK
    allowed += rounding
    bounded = _change(columns["slip.longitudinal"]) <= allowed
    bounded &= _change(columns["slip.lateral"]) <= allowed
    return bounded


def _change(values: Array) -> Array:
    change = values[:, 1:] - values[:, :-1]
    return np.abs(change, out=change)


def _or_else(bound: Array | None, otherwise: Array) -> Array:
    return otherwise if bound is None else bound[:, None] * np.ones_like(otherwise)


def _length(x: Array, y: Array) -> Array:
    squares = x * x
    squares += y * y
    return np.sqrt(squares, out=squares)
