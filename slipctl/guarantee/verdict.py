"""Runs summed up: the first violation, and the bound on the position error beside the error."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from slipctl.guarantee.columns import HYPOTHESES, METRIC_UNITS
from slipctl.guarantee.evaluate import true_errors, weighted_error
from slipctl.guarantee.hypotheses import Hypotheses, demands
from slipctl.guarantee.path_time import in_path_time
from slipctl.theory import ultimate

Told = dict[str, float | str | None]

TIME_CONSTANTS = 4
"""Of the surface JᵀPe = 0 that the transient lasts at least (assumed)."""


def verdict(
    columns: Mapping[str, NDArray], hypotheses: Hypotheses | None, world: int, last_row: int, tick: float
) -> Told:
    """Return what the guarantee says of rows 0 … last_row of one world; see `verdicts`."""
    alone = slice(world, world + 1)
    columns = {name: values[alone] for name, values in columns.items()}
    return verdicts(columns, None if hypotheses is None else hypotheses.of(alone), [last_row], tick)[0]


def verdicts(
    columns: Mapping[str, NDArray], hypotheses: Hypotheses | None, last_rows: Sequence[int], tick: float
) -> list[Told]:
    """Return what the guarantee says of rows 0 … last_row of every world, whatever the company.

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
    last_rows : sequence of int
        The last row that counts, of every world.
    tick : float
        [s].

    Returns
    -------
    list of dict
        `first_violation` and the keys of `METRIC_UNITS`; None where there is nothing to say.
    """
    told: list[Told] = [{"first_violation": None} | dict.fromkeys(METRIC_UNITS) for _ in last_rows]
    if hypotheses is None:
        return told
    columns = in_path_time(columns)
    moved = {world: last for world, last in enumerate(last_rows) if last > 0}
    for world, last in moved.items():
        told[world] |= _fractions(columns, hypotheses, world, last, tick)
    for world, found in _first_violations(columns, hypotheses, moved, tick).items():
        told[world] |= found
    for world, settled in _settled(columns, hypotheses, moved, tick).items():
        told[world] |= _bounds(columns, hypotheses, world, moved[world], settled, tick)
    return [
        {
            key: value if not isinstance(value, float) or math.isfinite(value) else None
            for key, value in one.items()
        }
        for one in told
    ]


def _fractions(
    columns: Mapping[str, NDArray], hypotheses: Hypotheses, world: int, last_row: int, tick: float
) -> Told:
    """Return what is a share of the ticks of one world, or a time in them."""

    def ticks(name: str) -> NDArray:
        return columns[f"guarantee.{name}"][world, :last_row]

    found: Told = {}
    outside = ticks("weighted_error") >= hypotheses.boundary_layer[world]
    count = np.count_nonzero(outside)
    if count:
        found["lyapunov_fraction"] = np.count_nonzero(ticks("lyapunov_falls") & outside) / count
    if "guarantee.slip_rates_bounded" in columns:
        found["slip_rate_fraction"] = np.count_nonzero(ticks("slip_rates_bounded")) / last_row
    found["calm_fraction"] = np.count_nonzero(ticks("calm")) / last_row
    found["calm_tick"] = float(ticks("calm_tick").min())
    alarm = ticks("alarm")
    first = int(alarm.argmax())
    if alarm[first]:
        found["alarm_time"] = float(first * tick)
    return found


def _first_violations(
    columns: Mapping[str, NDArray], hypotheses: Hypotheses, last_rows: Mapping[int, int], tick: float
) -> dict[int, Told]:
    """Return the first violation of every world that has one."""
    held = columns["guarantee.held"]
    firsts = {world: int(held[world, :last].argmin()) for world, last in last_rows.items()}
    broken = {world: k for world, k in firsts.items() if not held[world, k]}
    if not broken:
        return {}
    worlds, rows = np.array(list(broken)), np.array(list(broken.values()))
    here = {name: values[worlds, rows][:, None] for name, values in columns.items()}
    chosen = hypotheses.of(worlds)
    weighted = weighted_error(true_errors(here, chosen.order), chosen.weights)
    found = demands(here, chosen, here["guarantee.uncertainty"], weighted)
    told: dict[int, Told] = {}
    for index, (world, k) in enumerate(broken.items()):
        name = next(name for name in HYPOTHESES if not here[f"guarantee.{name}"][index, 0])
        told[world] = {
            "first_violation": name,
            "first_violation_time": k * tick,
            "first_violation_excess": float(found[name].excess[index, 0]),
        }
    return told


def _bounds(
    columns: Mapping[str, NDArray],
    hypotheses: Hypotheses,
    world: int,
    last_row: int,
    settled: tuple[int, float, float],
    tick: float,
) -> Told:
    weights, gains = hypotheses.weights[world], hypotheses.gains[world]
    layer = float(hypotheses.boundary_layer[world])
    first, gain, tight = settled
    error = columns["error.position"][world, first : last_row + 1]
    largest = float(error.max())
    bounds = {
        "error_bound_level_set": ultimate.level_set(weights, layer, gain),
        "error_bound_tight_level_set": tight,
    }
    bounds = {name: ultimate.position_bound(weights, level) for name, level in bounds.items()}
    if ultimate.small_gain(gains, weights) < 1.0:
        corner = float(weights[0, -1])
        reached = float(columns["guarantee.weighted_error"][world, first]) / corner
        bounds["error_bound_small_gain"] = max(layer / corner, reached, float(error[0]))
    held = np.count_nonzero(columns["guarantee.held"][world, first:last_row]) / (last_row - first)
    found: Told = {
        "settling_time": first * tick,
        "settled_guarantee_fraction": held,
        "settled_error": largest,
        "lyapunov_level": tight,
        **bounds,
    }
    if held == 1.0:
        bound = min(bounds.values())
        found |= {"error_bound": bound, "error_bound_share": largest / bound}
    return found


def _settled(
    columns: Mapping[str, NDArray], hypotheses: Hypotheses, last_rows: Mapping[int, int], tick: float
) -> dict[int, tuple[int, float, float]]:
    """Return the row at which the transient ends, the supremum of ρ from there on, and the tight level."""
    settled: dict[int, tuple[int, float, float]] = {}
    waiting, count = list(last_rows), TIME_CONSTANTS
    while waiting:
        from_there = {}
        for world in waiting:
            elapsed = count * ultimate.time_constant(hypotheses.weights[world]) - 1e-9
            first = _row_after(columns, world, elapsed, tick)
            if first < last_rows[world]:
                gain = float(columns["decision.robust_gain"][world, first : last_rows[world]].max())
                if math.isfinite(gain):
                    from_there[world] = first, gain
        levels = _tight_levels(hypotheses, {world: gain for world, (_, gain) in from_there.items()})
        waiting, count = [], count + 1
        for world, (first, gain) in from_there.items():
            if columns["guarantee.lyapunov"][world, first] <= levels[world]:
                settled[world] = first, gain, levels[world]
            else:
                waiting.append(world)
    return settled


def _row_after(columns: Mapping[str, NDArray], world: int, elapsed: float, tick: float) -> int:
    """Return the first row at which so much of the law's time [s] has passed."""
    if "decision.path_speed" not in columns:
        return math.ceil(elapsed / tick)
    return int(np.searchsorted(columns["reference.path_time"][world], elapsed))


def _tight_levels(hypotheses: Hypotheses, gains: Mapping[int, float]) -> dict[int, float]:
    """Return the tight level set of some worlds, those of equal weights at once."""
    alike: dict[bytes, list[int]] = {}
    for world in gains:
        alike.setdefault(hypotheses.weights[world].tobytes(), []).append(world)
    levels = {}
    for worlds in alike.values():
        found = ultimate.tight_level_sets(
            hypotheses.weights[worlds[0]],
            hypotheses.boundary_layer[worlds],
            np.array([gains[world] for world in worlds]),
        )
        levels |= dict(zip(worlds, found.tolist(), strict=True))
    return levels
