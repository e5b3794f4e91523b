"""Judge what a scenario claims of its runs, on paired worlds and with intervals over seeds."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from slipctl.metrics import UNITS
from slipctl.regression.claims.bootstrap import Estimate, mean, mean_ratio
from slipctl.regression.claims.worlds import (
    World,
    ended_early,
    groups,
    how_it_ended,
    values,
    without_seed,
    worlds,
)
from slipctl.regression.judging.findings import Finding, Verdict
from slipctl.scenario import Below, BelowBound, Better, Claim, Guarantee, Scenario, StatusIs

SLACK = 1e-9
"""Relative: a value at its limit holds, rounding aside."""


def judge_claims(scenario: Scenario, payload: Mapping[str, Any]) -> list[Finding]:
    """Judge every claim of a scenario.

    Worlds that differ only in the seed are judged together: `better` by the geometric mean of the paired
    ratios and `below` by the mean, each with its interval (see `slipctl.regression.claims.bootstrap.mean`).
    Such a claim holds where the whole interval satisfies it, fails where no part does, and is open between.
    `guarantee`, `below_bound` and `status` are about every world: one that contradicts them is enough. A run
    that ended early fails every claim about it but a `status`.

    Parameters
    ----------
    scenario
        What was run, with its claims.
    payload
        The JSON output of the run.

    Returns
    -------
    list of Finding
        In the order of the claims, one or more per group of worlds. A claim that no run can be judged by is
        open. `baseline` is what the claim requires, `current` what was measured.
    """
    name, found = str(payload["scenario"]), worlds(payload["runs"])
    return [finding for claim in scenario.expect for finding in _judge(name, claim, found)]


def _judge(name: str, claim: Claim, grid: Sequence[World]) -> list[Finding]:
    absent = [label for label in _labels(claim) if not any(label in world.runs for world in grid)]
    meant = [world for world in grid if _is_meant(claim, world)]
    able = [world for world in meant if _is_able(claim, world)]
    if absent or not able:
        return [_open(name, claim, absent, meant)]
    note = "" if len(able) == len(meant) else f"judged on {len(able)} of {len(meant)} worlds"
    judge = _JUDGES[type(claim)]
    return [
        _finding(name, claim, group, outcome, note)
        for group in groups(able)
        for outcome in judge(claim, group)
    ]


def _labels(claim: Claim) -> list[str]:
    """Labels of the laws that a claim names."""
    if isinstance(claim, Better):
        return [claim.controller, claim.than]
    return [] if claim.controller is None else [claim.controller]


def _is_meant(claim: Claim, world: World) -> bool:
    """Whether the claim is about this world by its `where`."""
    conditions = all(
        condition.key in world.varied and condition.holds(world.varied[condition.key])
        for condition in claim.where
    )
    return conditions and all(label in world.runs for label in _labels(claim))


def _is_able(claim: Claim, world: World) -> bool:
    """Whether the hypotheses of the claim hold in this world."""
    if claim.controller is None:
        return True
    run = world.runs[claim.controller]
    if claim.only_where_guaranteed:
        fraction = run["metrics"]["guarantee_fraction"]
        if fraction is None or fraction < 1.0 - SLACK:
            return False
    return (
        not isinstance(claim, BelowBound) or ended_early(run) or run["guarantee"]["error_bound"] is not None
    )


def _open(name: str, claim: Claim, absent: Sequence[str], meant: Sequence[World]) -> Finding:
    if absent:
        note = f"no run of {' and '.join(absent)}"
    elif not meant:
        note = "no such world was run"
    elif isinstance(claim, BelowBound):
        note = "the theorem promises no bound in any of these worlds"
    else:
        note = f"the guarantee of {claim.controller} holds throughout in none of these worlds"
    return Finding(
        name, claim.controller, {}, None, None, None, None, None, Verdict.CLAIM_OPEN, note, str(claim)
    )


@dataclass(frozen=True)
class _Outcome:
    """What became of a claim in one group of worlds."""

    controller: str
    metric: str
    required: float | str
    measured: float | str | None
    verdict: Verdict
    note: str = ""
    interval: tuple[float, float] | None = None
    unit: str | None = None
    seed: int | None = None
    """The seed of the run that decided, where a single one did."""


def _finding(name: str, claim: Claim, group: Sequence[World], outcome: _Outcome, note: str) -> Finding:
    alone = len(group) == 1
    return Finding(
        scenario=name,
        controller=outcome.controller,
        varied=group[0].varied if alone else without_seed(group[0]),
        seed=group[0].seed if alone else outcome.seed,
        metric=outcome.metric,
        baseline=outcome.required,
        current=outcome.measured,
        tolerance=None,
        verdict=outcome.verdict,
        note="; ".join(text for text in (outcome.note, note) if text),
        claim=str(claim),
        interval=outcome.interval,
        unit=outcome.unit,
    )


def _better(claim: Better, group: Sequence[World]) -> Iterator[_Outcome]:
    wanted = [(claim.metric, claim.factor, True)]
    if claim.command_variation_factor is not None:
        wanted.append(("command_variation", claim.command_variation_factor, False))
    for metric, required, at_least in wanted:
        own, other = values(group, claim.controller, metric), values(group, claim.than, metric)
        if isinstance(own, str) or isinstance(other, str):
            trouble = own if isinstance(own, str) else str(other)
            yield _Outcome(claim.controller, metric, required, None, Verdict.CLAIM_FAILED, trouble, unit="1")
            continue
        ratio = mean_ratio(other, own) if at_least else mean_ratio(own, other)
        names = f"{claim.than} / {claim.controller}" if at_least else f"{claim.controller} / {claim.than}"
        note = f"{names}, {'at least' if at_least else 'at most'}{_seeds(group)}"
        verdict = _by_interval(ratio, required, at_least)
        yield _Outcome(
            claim.controller, metric, required, ratio.value, verdict, note, ratio.interval, unit="1"
        )


def _below(claim: Below, group: Sequence[World]) -> Iterator[_Outcome]:
    errors, unit = values(group, claim.controller, claim.metric), UNITS[claim.metric]
    if isinstance(errors, str):
        yield _Outcome(
            claim.controller, claim.metric, claim.limit, None, Verdict.CLAIM_FAILED, errors, unit=unit
        )
        return
    found = mean(errors)
    verdict = _by_interval(found, claim.limit, at_least=False)
    note = f"at most{_seeds(group)}"
    yield _Outcome(
        claim.controller, claim.metric, claim.limit, found.value, verdict, note, found.interval, unit
    )


def _below_bound(claim: BelowBound, group: Sequence[World]) -> Iterator[_Outcome]:
    def outcome(world: World, verdict: Verdict, note: str) -> _Outcome:
        told = world.runs[claim.controller]["guarantee"]
        bound, error = told["error_bound"], told["settled_error"]
        return _Outcome(
            claim.controller, "settled_error", bound, error, verdict, note, unit="m", seed=world.seed
        )

    for world in group:
        if ended_early(world.runs[claim.controller]):
            yield outcome(world, Verdict.CLAIM_FAILED, how_it_ended(world, claim.controller))
            return
    shares = [_share(world.runs[claim.controller]["guarantee"]) for world in group]
    worst = max(range(len(group)), key=shares.__getitem__)
    held = shares[worst] <= 1.0 + SLACK
    most = ", the most of all seeds" if len(group) > 1 else ""
    note = f"{100.0 * shares[worst]:.3g} % of the bound{most}"
    yield outcome(group[worst], Verdict.CLAIM_HELD if held else Verdict.CLAIM_FAILED, note)


def _share(told: Mapping[str, Any]) -> float:
    """Settled error as a share of the bound."""
    bound, error = told["error_bound"], told["settled_error"]
    if error is None:
        return float("inf")
    return error / bound if bound > 0 else (0.0 if error <= 0 else float("inf"))


def _guarantee(claim: Guarantee, group: Sequence[World]) -> Iterator[_Outcome]:
    fractions = values(group, claim.controller, metric := "guarantee_fraction")
    if isinstance(fractions, str):
        yield _Outcome(
            claim.controller, metric, claim.fraction, None, Verdict.CLAIM_FAILED, fractions, unit="1"
        )
        return
    worst = min(range(len(group)), key=fractions.__getitem__)
    held = fractions[worst] >= claim.fraction * (1.0 - SLACK)
    violation = group[worst].runs[claim.controller]["guarantee"]["first_violation"]
    note = f"first broken: {violation}" if violation is not None and not held else ""
    yield _Outcome(
        claim.controller,
        metric,
        claim.fraction,
        fractions[worst],
        Verdict.CLAIM_HELD if held else Verdict.CLAIM_FAILED,
        note,
        unit="1",
        seed=group[worst].seed,
    )


def _status(claim: StatusIs, group: Sequence[World]) -> Iterator[_Outcome]:
    labels = list(group[0].runs) if claim.controller is None else [claim.controller]
    for label in labels:
        found = [(world.runs[label]["status"], world.seed) for world in group if label in world.runs]
        status, seed = next(((status, seed) for status, seed in found if status != claim.status), found[0])
        held = status == claim.status
        verdict = Verdict.CLAIM_HELD if held else Verdict.CLAIM_FAILED
        yield _Outcome(label, "status", claim.status, status, verdict, seed=None if held else seed)


_JUDGES: dict[type, Callable[[Any, Sequence[World]], Iterator[_Outcome]]] = {
    Better: _better,
    Below: _below,
    BelowBound: _below_bound,
    Guarantee: _guarantee,
    StatusIs: _status,
}


def _seeds(group: Sequence[World]) -> str:
    return f", over {len(group)} seeds" if len(group) > 1 else ""


def _by_interval(found: Estimate, required: float, at_least: bool) -> Verdict:
    """Hold a claim where the whole interval satisfies it, fail it where no part of it does."""
    low, high = found.interval or (found.value, found.value)
    if not at_least:  # the mirror image
        low, high, required = -high, -low, -required
    slack = SLACK * abs(required)
    if low >= required - slack:
        return Verdict.CLAIM_HELD
    return Verdict.CLAIM_FAILED if high < required - slack else Verdict.CLAIM_OPEN
