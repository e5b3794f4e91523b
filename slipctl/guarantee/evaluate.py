"""Hypotheses, Lyapunov function, chatter and monitor, tick by tick."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from slipctl.guarantee.hypotheses import Hypotheses, demands, slip_rates_bounded
from slipctl.guarantee.monitor import MARGIN, low_pass, measured_ratio
from slipctl.guarantee.path_time import in_path_time, moves, steps
from slipctl.theory.robust import largest_calm_tick
from slipctl.theory.robust_dynamic import largest_calm_dynamic_tick
from slipctl.tick import Array

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
    weights = hypotheses.weights[:, None, :, :, None]
    weighted = _sum([weights[:, :, -1, i] * errors[i] for i in range(order)])
    lyapunov = _sum(
        [weights[:, :, i, j, 0] * _dot(errors[i], errors[j]) for i in range(order) for j in range(order)]
    )
    length = np.sqrt(_dot(weighted, weighted))
    found = demands(columns, hypotheses, uncertainty, weighted)
    added["guarantee.held"] = np.logical_and.reduce([demand.held for demand in found.values()])
    added |= {f"guarantee.{name}": demand.held for name, demand in found.items()}
    rates = slip_rates_bounded(columns, hypotheses)
    if rates is not None:
        added["guarantee.slip_rates_bounded"] = np.pad(rates, ((0, 0), (0, 1)))
    layer = hypotheses.boundary_layer[:, None]
    falls = length < layer
    falls[:, :-1] |= (lyapunov[:, 1:] < lyapunov[:, :-1]) | ~moves(columns)
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
    added["guarantee.monitor_limit"] = limit
    added["guarantee.alarm"] = seen > limit
    return added


def true_errors(columns: Mapping[str, NDArray], order: int) -> list[Array]:
    """Return e₁ … of the true motion, (N, T, 2) each."""
    return [_pair(columns, f"motion.{name}") - _pair(columns, f"reference.{name}") for name in CHAIN[:order]]


def _uncertainty(columns: Mapping[str, NDArray], derived: str, tick: float) -> Array:
    rate = _pair(columns, f"motion.{derived}")
    flat_input = _pair(columns, "decision.nominal_input") + _pair(columns, "decision.robust_input")
    told, step = moves(columns), steps(columns, tick)
    size = np.zeros(rate.shape[:2])
    if not isinstance(step, float):
        step = np.where(told, step, 1.0)[..., None]
    eta = (rate[:, 1:] - rate[:, :-1]) / step - flat_input[:, :-1]
    size[:, :-1] = np.where(told, np.sqrt(_dot(eta, eta)), 0.0)
    return size


def _calm_tick(columns: Mapping[str, NDArray], hypotheses: Hypotheses) -> Array:
    with np.errstate(divide="ignore", invalid="ignore"):
        slip = (columns["slip.longitudinal"] - 1j * columns["slip.lateral"]) / columns["motion.forward_speed"]
    largest = largest_calm_tick if hypotheses.order == 2 else largest_calm_dynamic_tick
    threshold = largest(
        hypotheses.boundary_layer[:, None],
        columns["decision.robust_gain"],
        hypotheses.weights[:, None, -1, -1],
        slip,
    )
    # at v = 0, and where slip turns the input around, no tick is short enough
    return np.where(threshold > 0.0, threshold, 0.0)


def _pair(columns: Mapping[str, NDArray], stem: str) -> Array:
    return np.stack([columns[f"{stem}.x"], columns[f"{stem}.y"]], axis=-1)


def _dot(a: Array, b: Array) -> Array:
    return a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1]


def _sum(terms: list[Array]) -> Array:
    total = terms[0]
    for term in terms[1:]:
        total = total + term
    return total
