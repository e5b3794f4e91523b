"""What people read of a verdict."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from slipctl.guarantee.columns import HYPOTHESES


def sentence(fraction: float, told: Mapping[str, Any]) -> str:
    """Say of one run whether its theorem held, what broke it, and what it promised.

    Parameters
    ----------
    fraction : float
        Share of the ticks on which every hypothesis held.
    told : mapping
        As of `slipctl.guarantee.verdict`.
    """
    promised = promise(told)
    if fraction == 1.0:
        kept = "every hypothesis of its theorem holds"
        return kept if promised is None else f"{kept}, {promised}"
    text = f"the hypotheses of its theorem hold on {percent(fraction)} of the ticks; {violation(told)}"
    return text if promised is None else f"{text}; {promised}"


def violation(told: Mapping[str, Any]) -> str:
    """Say the first violation: what, when, by how much."""
    excess = told["first_violation_excess"]
    beyond = "" if excess is None else f", by {percent(excess)}"
    if excess is not None and excess >= 9.5:
        beyond = f", by {excess:.0f} times its limit"
    name, time = HYPOTHESES[told["first_violation"]], told["first_violation_time"]
    return f"violated first: {name}, at {time:.2f} s{beyond}"


def promise(told: Mapping[str, Any]) -> str | None:
    """Say the error beside its bound, or None where nothing is promised."""
    if told["error_bound"] is None:
        return None
    return (
        f"from {told['settling_time']:.1f} s on the error stays below {millimetres(told['settled_error'])}, "
        f"promised are {millimetres(told['error_bound'])}"
    )


def percent(share: float) -> str:
    """Write a share in per cent; one below 1 is never written as 100."""
    percents = 100.0 * share
    if 99.5 <= percents < 100.0:
        return f"{min(percents, 99.9):.1f} %"
    return f"{percents:.0f} %" if percents >= 9.5 else f"{percents:.2g} %"


def millimetres(length: float) -> str:
    """Write a length [m] in millimetres."""
    return f"{1e3 * length:.3g} mm"
