"""One run summed up: the first violation, and the bound on the position error beside the error."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from slipctl.guarantee.columns import HYPOTHESES, METRIC_UNITS
from slipctl.guarantee.evaluate import true_errors
from slipctl.guarantee.hypotheses import Hypotheses, demands
from slipctl.guarantee.path_time import in_path_time
from slipctl.theory import ultimate

TIME_CONSTANTS = 4
"""Of the surface JᵀPe = 0 that the transient lasts at least (assumed)."""


def verdict(
    columns: Mapping[str, NDArray], hypotheses: Hypotheses | None, world: int, last_row: int, tick: float
) -> dict[str, float | str | None]:
    """Return what the guarantee says of rows 0 … last_row of one world.

    The transient ends at `settling_time`: after four time constants of the error on the surface JᵀPe = 0, or
    as many more as it takes until V is within its tight level set, which the theorem then keeps it in. All
    else is about the rows from then on: `settled_error`, the supremum of the position error, beside the
    bounds that the theorem gives with the supremum of ρ: by the level set, the tight level set and the small
    gain (from the larger set on whose edge the state is, where it is not yet inside). Where every hypothesis
    held, `error_bound` is the smallest of them; elsewhere nothing is promised. All are None where V never
    gets there.

    `lyapunov_fraction` is the share of the ticks with ‖JᵀPe‖ ≥ ε on which V fell; `calm_tick` the smallest
    chatter threshold of the run; `alarm_time` when the monitor first spoke.

    Parameters
    ----------
    columns : mapping of (N, T) arrays
        As `with_guarantee` returns them.
    hypotheses : Hypotheses or None
        None for a law without a theorem.
    world, last_row : int
    tick : float
        [s].

    Returns
    -------
    dict
        `first_violation` and the keys of `METRIC_UNITS`; None where there is nothing to say.
    """
    told: dict[str, float | str | None] = {"first_violation": None} | dict.fromkeys(METRIC_UNITS)
    if hypotheses is None or last_row == 0:
        return told
    columns = in_path_time(columns)
    ticks = slice(0, last_row)
    told |= _first_violation(columns, hypotheses, world, ticks, tick)
    outside = _row(columns, "guarantee.weighted_error", world, ticks) >= hypotheses.boundary_layer[world]
    if outside.any():
        told["lyapunov_fraction"] = float(
            _row(columns, "guarantee.lyapunov_falls", world, ticks)[outside].mean()
        )
    if "guarantee.slip_rates_bounded" in columns:
        told["slip_rate_fraction"] = float(_row(columns, "guarantee.slip_rates_bounded", world, ticks).mean())
    told["calm_fraction"] = float(_row(columns, "guarantee.calm", world, ticks).mean())
    told["calm_tick"] = float(_row(columns, "guarantee.calm_tick", world, ticks).min())
    alarms = np.flatnonzero(_row(columns, "guarantee.alarm", world, ticks))
    if len(alarms):
        told["alarm_time"] = float(alarms[0] * tick)
    told |= _bounds(columns, hypotheses, world, last_row, tick)
    return {
        key: value if not isinstance(value, float) or math.isfinite(value) else None
        for key, value in told.items()
    }


def _first_violation(
    columns: Mapping[str, NDArray], hypotheses: Hypotheses, world: int, ticks: slice, tick: float
) -> dict[str, float | str | None]:
    broken = np.flatnonzero(~_row(columns, "guarantee.held", world, ticks))
    if len(broken) == 0:
        return {}
    k = int(broken[0])
    name = next(name for name in HYPOTHESES if not columns[f"guarantee.{name}"][world, k])
    here = {column: values[:, k : k + 1] for column, values in columns.items()}
    errors = true_errors(here, hypotheses.order)
    weights = hypotheses.weights[:, -1]
    weighted = sum(weights[:, i, None, None] * error for i, error in enumerate(errors))
    found = demands(here, hypotheses, here["guarantee.uncertainty"], np.asarray(weighted))
    return {
        "first_violation": name,
        "first_violation_time": k * tick,
        "first_violation_excess": float(found[name].excess[world, 0]),
    }


def _bounds(
    columns: Mapping[str, NDArray], hypotheses: Hypotheses, world: int, last_row: int, tick: float
) -> dict[str, float | str | None]:
    weights, gains = hypotheses.weights[world], hypotheses.gains[world]
    layer = float(hypotheses.boundary_layer[world])
    settled = _settled(columns, hypotheses, world, last_row, tick)
    if settled is None:
        return {}
    first, gain, tight = settled
    ticks = slice(first, last_row)
    errors = _row(columns, "error.position", world, slice(first, last_row + 1))
    bounds = {
        "error_bound_level_set": ultimate.level_set(weights, layer, gain),
        "error_bound_tight_level_set": tight,
    }
    bounds = {name: ultimate.position_bound(weights, level) for name, level in bounds.items()}
    if ultimate.small_gain(gains, weights) < 1.0:
        corner = float(weights[0, -1])
        reached = float(columns["guarantee.weighted_error"][world, first]) / corner
        bounds["error_bound_small_gain"] = max(layer / corner, reached, float(errors[0]))
    held = float(_row(columns, "guarantee.held", world, ticks).mean())
    found: dict[str, float | str | None] = {
        "settling_time": first * tick,
        "settled_guarantee_fraction": held,
        "settled_error": float(errors.max()),
        "lyapunov_level": tight,
        **bounds,
    }
    if held == 1.0:
        bound = min(bounds.values())
        found |= {"error_bound": bound, "error_bound_share": float(errors.max()) / bound}
    return found


def _settled(
    columns: Mapping[str, NDArray], hypotheses: Hypotheses, world: int, last_row: int, tick: float
) -> tuple[int, float, float] | None:
    """Return the row at which the transient ends, the supremum of ρ from there on, and the tight level."""
    weights, layer = hypotheses.weights[world], float(hypotheses.boundary_layer[world])
    constant = ultimate.time_constant(weights)
    passed = columns["reference.path_time"][world] if "decision.path_speed" in columns else None
    count = TIME_CONSTANTS
    while True:
        elapsed = count * constant - 1e-9
        first = math.ceil(elapsed / tick) if passed is None else int(np.searchsorted(passed, elapsed))
        if first >= last_row:
            return None
        gain = float(_row(columns, "decision.robust_gain", world, slice(first, last_row)).max())
        if not math.isfinite(gain):
            return None
        level = ultimate.tight_level_set(weights, layer, gain)
        if columns["guarantee.lyapunov"][world, first] <= level:
            return first, gain, level
        count += 1


def _row(columns: Mapping[str, NDArray], name: str, world: int, rows: slice) -> NDArray:
    # a contiguous slice of its own, so that sums round alike in every batch
    return np.ascontiguousarray(columns[name][world, rows])
