"""What the terminal says of the theorem behind a law: did its hypotheses hold, and what did that promise."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from slipctl.guarantee import HYPOTHESES
from slipctl.guarantee.words import percent
from slipctl.guarantee.words import sentence as sentence_of


def sentence(label: str, runs: Sequence[Mapping[str, Any]], spans: str = "") -> str | None:
    """Say what became of the theorem of one controller, or return None where it has none.

    Parameters
    ----------
    label
        The controller.
    runs
        Its runs, one per world, as in the JSON output.
    spans
        Values of the varied key at which every hypothesis held, for instance ``ground.friction 0.2 to 0.8``.
    """
    judged = [
        run for run in runs if run["metrics"].get("guarantee_fraction") is not None and "guarantee" in run
    ]
    if not judged:
        return None
    first = judged[0]
    parts = [
        sentence_of(first["metrics"]["guarantee_fraction"], first["guarantee"])
        if len(judged) == 1
        else _many(judged, spans)
    ]
    parts += _warnings(judged)
    return f"{label}: " + "; ".join(parts)


def holds(run: Mapping[str, Any]) -> bool:
    """Whether every hypothesis held on every tick of a run."""
    return run["metrics"].get("guarantee_fraction") == 1.0


def _many(runs: Sequence[Mapping[str, Any]], spans: str) -> str:
    kept = [run for run in runs if holds(run)]
    text = f"every hypothesis of its theorem holds in {len(kept)} of {len(runs)} worlds"
    if spans and kept:
        text += f": {spans}"
    shares = [run["guarantee"]["error_bound_share"] for run in runs]
    shares = [share for share in shares if share is not None]
    if shares:
        text += f"; errors reach {percent(max(shares))} of their bound"
    names = Counter(run["guarantee"]["first_violation"] for run in runs if not holds(run))
    broken = [f"{HYPOTHESES[name]} ({count})" for name, count in names.most_common()]
    return text + (f"; violated first: {', '.join(broken)}" if broken else "")


def _warnings(runs: Sequence[Mapping[str, Any]]) -> list[str]:
    told = [run["guarantee"] for run in runs]
    parts = []
    # a law that has lost its hypotheses has other troubles
    rough = [one for one in told if one["calm_fraction"] < 1.0 and one["first_violation"] is None]
    if rough:
        least = min(one["calm_tick"] for one in rough)
        share = percent(1.0 - min(one["calm_fraction"] for one in rough))
        where = f"on {share} of the ticks"
        if len(runs) > 1:
            where = f"in {len(rough)} worlds, on up to {share} of the ticks"
        worst = f"{1e3 * least:.3g} ms at worst" if least > 0.0 else "no tick is short enough"
        parts.append(f"the tick is above its chatter threshold {where} ({worst})")
    falls = [run["guarantee"]["lyapunov_fraction"] for run in runs if holds(run)]
    grew = 1.0 - min((share for share in falls if share is not None), default=1.0)
    if grew > 0.0:
        parts.append(
            f"V = eᵀPe all the same grew on up to {percent(grew)} of the ticks on which it should fall"
        )
    alarms = [one["alarm_time"] for one in told if one["alarm_time"] is not None]
    if alarms and len(runs) == 1:
        parts.append(f"slip alarm at {alarms[0]:.2f} s")
    elif alarms:
        parts.append(f"slip alarm in {len(alarms)} of them")
    return parts
