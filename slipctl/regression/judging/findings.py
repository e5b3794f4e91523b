"""Compare runs with a baseline: pure functions from two sets of numbers to findings."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from enum import StrEnum
from typing import Any

from slipctl.metrics import UNITS
from slipctl.regression.baseline.file import Baseline, Number, RunBaseline, run_key
from slipctl.regression.baseline.gated import LARGER_IS_BETTER


class Verdict(StrEnum):
    """What became of one number, one status, one run or one claim."""

    SAME = "same"
    BETTER = "better"
    WORSE = "worse"
    STATUS_CHANGED = "status_changed"
    MISSING = "missing"
    """The baseline holds this run, the scenario no longer makes it."""
    EXTRA = "extra"
    """The scenario makes this run, the baseline does not hold it."""
    UNJUDGED = "unjudged"
    """There was nothing sound to compare with."""
    CHAOTIC = "chaotic"
    """The number moved, but it says nothing: the run is gated on its status and on the scenario's claims."""
    CLAIM_HELD = "claim_held"
    CLAIM_FAILED = "claim_failed"
    CLAIM_OPEN = "claim_open"
    """The interval holds the required value, or there is no run to judge the claim on."""

    @property
    def failed(self) -> bool:
        """Whether this closes the gate."""
        return self in (Verdict.WORSE, Verdict.STATUS_CHANGED, Verdict.CLAIM_FAILED)

    @property
    def judged(self) -> bool:
        """Whether the comparison could be made at all."""
        return self not in (Verdict.MISSING, Verdict.EXTRA, Verdict.UNJUDGED, Verdict.CLAIM_OPEN)


@dataclass(frozen=True)
class Finding:
    """One comparison.

    Attributes
    ----------
    scenario, controller, varied, seed
        Which run; controller None where the whole scenario is meant.
    metric
        Name of the metric, or ``status``; None where the whole run is meant.
    baseline, current
        The two values in `unit`, or statuses. For a claim, what it requires and what was measured.
    tolerance
        In `unit`; None for a status and for a claim.
    verdict
        The outcome.
    note
        What a reader should know besides.
    claim
        Text of the claim that was judged; None for a number and a status.
    interval
        Interval that holds the measured value or difference, in `unit`; None where there is only one run.
    unit
        Of the values, as in `slipctl.metrics.UNITS`; None for a status.
    """

    scenario: str
    controller: str | None
    varied: Mapping[str, Any]
    seed: int | None
    metric: str | None
    baseline: float | str | None
    current: float | str | None
    tolerance: float | None
    verdict: Verdict
    note: str = ""
    claim: str | None = None
    interval: tuple[float, float] | None = None
    unit: str | None = None

    def json(self) -> dict[str, Any]:
        """Give the finding as the contract's JSON object."""
        entry = {field.name: getattr(self, field.name) for field in fields(self)}
        interval = None if self.interval is None else list(self.interval)
        return {**entry, "varied": dict(self.varied), "verdict": str(self.verdict), "interval": interval}


def unjudged(scenario: str, why: str) -> Finding:
    """Give the finding that a scenario could not be judged as a whole, and why."""
    return Finding(scenario, None, {}, None, None, None, None, None, Verdict.UNJUDGED, why)


def judge(baseline: Baseline, payload: Mapping[str, Any], elsewhere: bool = False) -> list[Finding]:
    """Compare a result with its baseline.

    Parameters
    ----------
    baseline
        What was recorded.
    payload
        The JSON output of a run of the same scenario.
    elsewhere
        Whether it ran on another engine or family of processor than the baseline.

    Returns
    -------
    list of Finding
        Per run of the baseline its status and, where that is the same, its numbers, or one finding that it is
        missing; then the runs that the baseline does not hold.
    """
    name = payload["scenario"]
    current = {run_key(run["controller"], run["varied"], run["seed"]): run for run in payload["runs"]}
    findings: list[Finding] = []
    for recorded in baseline.runs:
        run = current.pop(run_key(recorded.controller, recorded.varied, recorded.seed), None)
        findings += _judge_run(name, recorded, run, elsewhere)
    for run in current.values():
        findings.append(
            Finding(
                name, run["controller"], run["varied"], run["seed"], None, None, None, None, Verdict.EXTRA,
                "not in the baseline",
            )
        )  # fmt: skip
    return findings


def _judge_run(
    name: str, recorded: RunBaseline, run: Mapping[str, Any] | None, elsewhere: bool
) -> list[Finding]:
    which = (name, recorded.controller, recorded.varied, recorded.seed)
    if run is None:
        return [Finding(*which, None, None, None, None, Verdict.MISSING, "in the baseline, not in this run")]
    status = run["status"]
    if status != recorded.status:
        # The metrics of a run that ended at another time are other quantities: comparing them says nothing.
        note = "runs beside the recorded one ended so, too" if status in recorded.statuses_seen else ""
        return [Finding(*which, "status", recorded.status, status, None, Verdict.STATUS_CHANGED, note)]
    findings = [Finding(*which, "status", recorded.status, status, None, Verdict.SAME)]
    for metric, number in recorded.metrics.items():
        value = run["metrics"].get(metric)
        tolerance = number.tolerance_elsewhere if elsewhere else number.tolerance
        verdict = judge_number(metric, number, value, tolerance)
        note = GATED_ON if number.gate == "verdict" else ""
        if not verdict.judged:
            note = NO_NUMBER
        findings.append(
            Finding(*which, metric, number.value, value, tolerance, verdict, note, unit=UNITS[metric])
        )
    return findings


GATED_ON = "chaotic: gated on its status and the scenario's claims only"
NO_NUMBER = "there is no number to compare with"


def judge_number(metric: str, number: Number, value: float | None, tolerance: float) -> Verdict:
    """Judge one number against its recorded value.

    Parameters
    ----------
    metric
        Says which way is worse.
    number
        What was recorded.
    value
        What there is now; one that is not finite is worst. Where a recorded number is not finite, or the law
        had no theorem and now has one, there is nothing to compare with.
    tolerance
        How far it may be worse; a chaotic number that moves further is reported as such and never fails.
    """
    verdict = _judge(metric, number.value, value, tolerance)
    if number.gate == "verdict" and verdict not in (Verdict.SAME, Verdict.UNJUDGED):
        return Verdict.CHAOTIC
    return verdict


def _judge(metric: str, recorded: float | None, value: float | None, tolerance: float) -> Verdict:
    if recorded is not None and not math.isfinite(recorded):
        return Verdict.UNJUDGED
    if value is not None and not math.isfinite(value):
        value = None
    if recorded is None or value is None:
        if recorded is None and value is None:
            return Verdict.SAME
        if value is None:
            return Verdict.WORSE
        # an error that was not finite now is; a guarantee may have been cut out of the file
        return Verdict.UNJUDGED if metric in LARGER_IS_BETTER else Verdict.BETTER
    worse_by = recorded - value if metric in LARGER_IS_BETTER else value - recorded
    if worse_by > tolerance:
        return Verdict.WORSE
    return Verdict.BETTER if worse_by < -tolerance else Verdict.SAME
