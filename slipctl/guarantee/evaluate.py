"""Hypotheses, Lyapunov function, chatter and monitor, tick by tick."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from slipctl.guarantee.hypotheses import Hypotheses, WeightedError, demands, slip_rates_bounded
from slipctl.guarantee.monitor import MARGIN, low_pass, measured_ratio
from slipctl.guarantee.path_time import in_path_time, moves, steps
from slipctl.theory.robust import largest_calm_tick
from slipctl.theory.robust_dynamic import largest_calm_dynamic_tick
from slipctl.tick import Array

Pair = tuple[Array, Array]
"""x and y of a vector, apart: numpy takes half as long for them as for pairs."""

CHAIN = ("position", "velocity", "acceleration")
"""What e₁, e₂, e₃ compare."""


def with_guarantee(
    columns: Mapping[str, NDArray], hypotheses: Hypotheses | None, tick: float
) -> dict[str, NDArray]:
    """Add ‖η_k‖ and, for a law with a theorem, all other columns of the guarantee.

    η_k = (Ḟ_{k+1} − Ḟ_k)/tick − v_k, for a dynamic law (F̈_{k+1} − F̈_k)/tick − v_k, is what the closed loop
    really did beyond the flat input, whatever the reason: slip, servo, sampling or saturation. For a law in
    the path's own time everything is per path time, and nothing is judged where that hardly passes.

    `guarantee.held` says whether every hypothesis held over tick k, each of which has a column of its own.
    Not among them, because they follow or because the theorem is about continuous time: `lyapunov_falls`,
    V_{k+1} < V_k wherever ‖JᵀPe‖ ≥ ε, and `calm`, a tick below the threshold above which the boundary layer
    chatters. `alarm` is the monitor: the low-passed slip ratio is above its bound.

    Parameters
    ----------
    columns : mapping of (N, T) arrays
    hypotheses : Hypotheses or None
        None for a law without a theorem.
    tick : float
        [s].

    Returns
    -------
    dict of (N, T) arrays
        The last row has no tick, and holds nothing where a tick is needed.
    """
    added = dict(columns)
    columns = in_path_time(columns)
    order = 3 if "decision.acceleration" in columns else 2
    uncertainty = _uncertainty(columns, CHAIN[order - 1], tick)
    added["guarantee.uncertainty"] = uncertainty
    if hypotheses is None:
        return added
    errors = true_errors(columns, order)
    weighted = weighted_error(errors, hypotheses.weights)
    lyapunov, length = _lyapunov(errors, hypotheses.weights), weighted.length
    found = demands(columns, hypotheses, uncertainty, weighted)
    added |= {f"guarantee.{name}": demand.held for name, demand in found.items()}
    held = np.ones(length.shape, dtype=bool)
    for demand in found.values():
        held &= demand.held
    added["guarantee.held"] = held
    rates = slip_rates_bounded(columns, hypotheses)
    if rates is not None:
        bounded = np.zeros_like(held)
        bounded[:, :-1] = rates
        added["guarantee.slip_rates_bounded"] = bounded
    falls = length < hypotheses.boundary_layer[:, None]
    falls[:, :-1] |= lyapunov[:, 1:] < lyapunov[:, :-1]
    told = moves(columns)
    if told is not None:
        falls[:, :-1] |= ~told
    added["guarantee.weighted_error"] = length
    added["guarantee.lyapunov"] = lyapunov
    added["guarantee.lyapunov_falls"] = falls
    calm_tick = _calm_tick(columns, hypotheses)
    added["guarantee.calm_tick"] = calm_tick
    calm = np.ones_like(falls)
    calm[:, :-1] = steps(columns, tick) <= calm_tick[:, :-1]
    added["guarantee.calm"] = calm
    seen = low_pass(measured_ratio(columns), tick)
    limit = hypotheses.ratio_bound(np.abs(columns["motion.forward_speed"])) + MARGIN
    added["guarantee.monitored_slip"] = seen
    added["guarantee.monitor_limit"] = np.broadcast_to(limit, seen.shape)
    added["guarantee.alarm"] = seen > limit
    return added


def true_errors(columns: Mapping[str, NDArray], order: int) -> list[Pair]:
    """Return e₁ … of the true motion, x and y (N, T) of each."""
    return [
        (
            columns[f"motion.{name}.x"] - columns[f"reference.{name}.x"],
            columns[f"motion.{name}.y"] - columns[f"reference.{name}.y"],
        )
        for name in CHAIN[:order]
    ]


def weighted_error(errors: list[Pair], weights: Array) -> WeightedError:
    """Return JᵀPe (N, T) of errors and weights (N, order, order)."""
    last = weights[:, -1, :, None]
    x, y = last[:, 0] * errors[0][0], last[:, 0] * errors[0][1]
    for i, error in enumerate(errors[1:], 1):
        x += last[:, i] * error[0]
        y += last[:, i] * error[1]
    return WeightedError(x, y)


def _lyapunov(errors: list[Pair], weights: Array) -> Array:
    """Return V = eᵀPe (N, T)."""
    order = range(len(errors))
    products = {(i, j): _dot(errors[i], errors[j]) for i in order for j in order if i <= j}
    total = np.zeros(errors[0][0].shape)
    for i in order:
        for j in order:
            total += weights[:, i, j, None] * products[min(i, j), max(i, j)]
    return total


def _uncertainty(columns: Mapping[str, NDArray], derived: str, tick: float) -> Array:
    told, step = moves(columns), steps(columns, tick)
    if told is not None:
        step = np.where(told, step, 1.0)
    eta = (_beyond(columns, derived, "x", step), _beyond(columns, derived, "y", step))
    size = np.empty(columns["motion.forward_speed"].shape)
    np.sqrt(_dot(eta, eta), out=size[:, :-1])
    size[:, -1] = 0.0
    if told is not None:
        size[:, :-1][~told] = 0.0
    return size


def _beyond(columns: Mapping[str, NDArray], derived: str, axis: str, step: Array | float) -> Array:
    """Return one component of η (N, T - 1)."""
    rate = columns[f"motion.{derived}.{axis}"]
    eta = rate[:, 1:] - rate[:, :-1]
    eta /= step
    nominal, robust = columns[f"decision.nominal_input.{axis}"], columns[f"decision.robust_input.{axis}"]
    eta -= nominal[:, :-1] + robust[:, :-1]
    return eta


def _calm_tick(columns: Mapping[str, NDArray], hypotheses: Hypotheses) -> Array:
    speed = columns["motion.forward_speed"]
    slip: NDArray[np.complex128] = np.empty(speed.shape, dtype=np.complex128)
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        # (v_t − i v_s)/v; numpy's complex division multiplies by the inverse, too, in ten times as long
        inverse = 1.0 / speed
        np.multiply(columns["slip.longitudinal"], inverse, out=slip.real)
        np.multiply(columns["slip.lateral"], -inverse, out=slip.imag)
    largest = largest_calm_tick if hypotheses.order == 2 else largest_calm_dynamic_tick
    threshold = largest(
        hypotheses.boundary_layer[:, None],
        columns["decision.robust_gain"],
        hypotheses.weights[:, None, -1, -1],
        slip,
    )
    # at v = 0, and where slip turns the input around, no tick is short enough
    np.copyto(threshold, 0.0, where=~(threshold > 0.0))
    return threshold


def _dot(a: Pair, b: Pair) -> Array:
    total = a[0] * b[0]
    total += a[1] * b[1]
    return total
