"""Findings as the JSON output holds them, for the tests of what is made of them."""

from __future__ import annotations

from typing import Any


def finding(**changes: Any) -> dict[str, Any]:
    """One number that got worse, with some fields changed."""
    entry = {
        "scenario": "ice",
        "controller": "robust",
        "varied": {"ground.friction": 0.16},
        "seed": 1,
        "metric": "rms_position_error",
        "baseline": 0.0123,
        "current": 0.0145,
        "tolerance": 1e-5,
        "verdict": "worse",
        "note": "",
        "claim": None,
        "interval": None,
        "unit": "m",
    }
    assert set(changes) <= set(entry)
    return entry | changes


def claim(verdict: str, **changes: Any) -> dict[str, Any]:
    """A claim that a law is three times better."""
    told = {
        "claim": "robust better than nominal by a factor 3",
        "baseline": 3.0,
        "current": 2.1,
        "interval": [1.9, 2.3],
        "tolerance": None,
        "unit": "1",
    }
    return finding(verdict=verdict, **told | changes)


STATUS = finding(
    metric="status",
    baseline="completed",
    current="left_the_arena",
    tolerance=None,
    verdict="status_changed",
    unit=None,
)
NO_BASELINE = finding(
    controller=None,
    varied={},
    seed=None,
    metric=None,
    baseline=None,
    current=None,
    tolerance=None,
    verdict="unjudged",
    note="no baseline",
    unit=None,
)
EXTRA = finding(
    metric=None,
    baseline=None,
    current=None,
    tolerance=None,
    verdict="extra",
    note="not in the baseline",
    unit=None,
)
EVERY_VERDICT = (
    finding(),
    finding(verdict="same", current=0.0123),
    finding(verdict="better", current=0.01),
    finding(verdict="chaotic", note="it says nothing"),
    STATUS,
    NO_BASELINE,
    EXTRA,
    EXTRA | {"verdict": "missing", "seed": 2},
    claim("claim_held", current=4.0),
    claim("claim_failed", seed=2),
    claim("claim_open", seed=3),
)
