"""How much a number may move: measured by moving the start, not guessed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from slipctl.regression.baseline import CHAOTIC_FACTOR, GATED, Number, RunBaseline, run_key

NUDGE = 1e-9
"""The start is moved by this much [m], to either side: far below what anybody could set up, far above
rounding. Another processor or engine build differs by less; what grows from it is the size of a difference
that means nothing."""

RELATIVE = 0.01
"""Share of the value always allowed."""

SPREADS = 10.0
"""Multiples of the spread seen always allowed: two runs show the size of a spread, not its end."""

FLOOR = 2e-5
"""Always allowed [m]: 0.02 mm, below which no difference matters to a robot."""

CHAOTIC = 0.2
"""A spread above this share of the value means that the value says only its order of magnitude."""


def measure(payload: Mapping[str, Any], nudged: Sequence[Mapping[str, Any]]) -> list[RunBaseline]:
    """Turn a result into what a baseline holds of its runs.

    Parameters
    ----------
    payload
        The JSON output of a run.
    nudged
        The same of runs whose start was moved by `NUDGE`.
    """
    others = [
        {run_key(run["controller"], run["varied"], run["seed"]): run for run in other["runs"]}
        for other in nudged
    ]
    runs = []
    for run in payload["runs"]:
        key = run_key(run["controller"], run["varied"], run["seed"])
        same = [other[key] for other in others if key in other]
        runs.append(
            RunBaseline(
                controller=run["controller"],
                varied=dict(run["varied"]),
                seed=run["seed"],
                status=run["status"],
                nudged_statuses=sorted({other["status"] for other in same} - {run["status"]}),
                metrics={
                    metric: number(run["metrics"][metric], [other["metrics"][metric] for other in same])
                    for metric in GATED
                },
            )
        )
    return runs


def number(value: float | None, nudged: Sequence[float | None]) -> Number:
    """Give a value its tolerance.

    Parameters
    ----------
    value
        The metric [m], None where it was not finite.
    nudged
        The metric of the runs from a moved start.
    """
    finite = [other for other in nudged if other is not None]
    if value is None:
        return Number(value=None, tolerance=0.0, why="not finite", chaotic=False)
    spread = max((abs(other - value) for other in finite), default=0.0)
    seen = f"spread {spread:.1e} m from a start moved by {NUDGE:g} m"
    if len(finite) < len(nudged) or (spread > CHAOTIC * value and SPREADS * spread > FLOOR):
        highest = CHAOTIC_FACTOR * max(value, *finite)
        why = f"chaotic: {seen}, over {CHAOTIC:.0%}; gated at {CHAOTIC_FACTOR:g} times the largest seen"
        return Number(value=value, tolerance=highest - value, why=why, chaotic=True)
    reasons = {
        f"{RELATIVE:.0%} of the value": RELATIVE * value,
        f"{SPREADS:g} spreads": SPREADS * spread,
        "the floor of 0.02 mm": FLOOR,
    }
    why, tolerance = max(reasons.items(), key=lambda item: item[1])
    return Number(value=value, tolerance=tolerance, why=f"{why}; {seen}")
