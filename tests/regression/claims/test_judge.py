"""Claims judged on made-up runs, whose verdicts are known, and on real ones."""

import copy
import random
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipctl import experiment, shipped
from slipctl.metrics import UNITS
from slipctl.regression.check import check
from slipctl.regression.claims.bootstrap import mean_ratio
from slipctl.regression.claims.judge import judge_claims
from slipctl.regression.claims.worlds import groups, worlds
from slipctl.regression.judging.findings import Finding, Verdict
from slipctl.scenario import Scenario, dump, load, read
from tests.scenario.documents import PAPER

FRICTIONS = [0.1, 0.2, 0.4]
SEEDS = [0, 1, 2, 3, 4, 5]
BETTER = {"kind": "better", "controller": "robust", "than": "nominal_kinematic", "factor": 2.0}

Change = Callable[[dict[str, Any]], None]


def claiming(*claims: dict[str, Any], seeds: list[int] | None = None) -> Scenario:
    """Return a scenario of three slips, over some seeds, with these claims."""
    sweep: dict[str, Any] = {"slip.yaw": FRICTIONS}
    if seeds:
        sweep["seed"] = seeds
    return read({**PAPER, "sweep": sweep, "expect": list(claims)})


def run(label: str, varied: dict[str, Any], seed: int, error: float) -> dict[str, Any]:
    """Return one run of the JSON output: all errors the same, the guarantee held."""
    robust = label == "robust"
    guarantee = {"error_bound": 0.01, "settled_error": error / 2, "first_violation": None}
    numbers = dict.fromkeys(UNITS, error) | {"command_variation": 3.0 if robust else 1.0}
    return {
        "controller": label,
        "varied": varied,
        "seed": seed,
        "status": "completed",
        "metrics": numbers | {"guarantee_fraction": 1.0 if robust else None},
        "guarantee": guarantee if robust else dict.fromkeys(guarantee),
        "recording": None,
    }


def payload(
    scenario: Scenario, nominal: Callable[..., float] = lambda *_: 0.008, change: Change | None = None
) -> dict[str, Any]:
    """Return the JSON output of a made-up run: the robust law errs 2 mm, the nominal one as told."""
    seeded = any(axis.key == "seed" for axis in scenario.sweep)
    runs = []
    for friction in FRICTIONS:
        for seed in SEEDS if seeded else [0]:
            varied = {"slip.yaw": friction} | ({"seed": seed} if seeded else {})
            runs.append(run("nominal_kinematic", varied, seed, nominal(friction, seed)))
            runs.append(run("robust", varied, seed, 0.002))
    for entry in runs:
        if change is not None:
            change(entry)
    return {"scenario": scenario.name, "runs": runs}


def verdicts(findings: list[Finding]) -> list[str]:
    return [str(finding.verdict) for finding in findings]


def only(scenario: Scenario, result: dict[str, Any]) -> Finding:
    (finding,) = judge_claims(scenario, result)
    return finding


def robust_only(change: Change, friction: float | None = None, seed: int | None = None) -> Change:
    """Apply a change to the robust law's runs of one world."""

    def changed(entry: dict[str, Any]) -> None:
        here = friction is None or entry["varied"]["slip.yaw"] == friction
        if entry["controller"] == "robust" and here and (seed is None or entry["seed"] == seed):
            change(entry)

    return changed


def test_better_is_judged_world_by_world():
    scenario = claiming(BETTER)
    findings = judge_claims(scenario, payload(scenario, lambda friction, _: 0.02 * friction))
    assert verdicts(findings) == ["claim_failed", "claim_held", "claim_held"]  # 2, 4 and 8 mm over 2 mm
    for finding, friction, ratio in zip(findings, FRICTIONS, (1.0, 2.0, 4.0), strict=True):
        assert finding.varied == {"slip.yaw": friction}
        assert (finding.controller, finding.metric) == ("robust", "rms_position_error")
        assert finding.current == pytest.approx(ratio)
        assert (finding.baseline, finding.unit, finding.interval, finding.seed) == (2.0, "1", None, 0)
        assert finding.claim == str(scenario.expect[0])
        assert finding.tolerance is None


@given(st.floats(1.0, 50.0), st.floats(1e-4, 1.0))
def test_a_benefit_just_at_its_factor_holds_and_a_lost_one_fails(factor, error):
    scenario = claiming({**BETTER, "factor": factor, "where": {"slip.yaw": 0.1}})

    def exactly(share: float) -> dict[str, Any]:
        result = payload(scenario, lambda *_: share * factor * error)
        for entry in result["runs"]:
            if entry["controller"] == "robust":
                entry["metrics"]["rms_position_error"] = error
        return result

    assert only(scenario, exactly(1.0)).verdict is Verdict.CLAIM_HELD
    assert only(scenario, exactly(1.0 - 1e-6)).verdict is Verdict.CLAIM_FAILED


def test_the_price_of_a_benefit_is_a_claim_of_its_own():
    scenario = claiming({**BETTER, "where": {"slip.yaw": 0.2}, "command_variation_factor": 2.5})
    error, variation = judge_claims(scenario, payload(scenario))
    assert error.verdict is Verdict.CLAIM_HELD
    assert variation.verdict is Verdict.CLAIM_FAILED
    assert (variation.metric, variation.baseline, variation.current) == ("command_variation", 2.5, 3.0)
    dearer = claiming({**BETTER, "where": {"slip.yaw": 0.2}, "command_variation_factor": 3.0})
    assert verdicts(judge_claims(dearer, payload(dearer))) == ["claim_held", "claim_held"]


def test_seeds_give_an_interval_and_decide_together():
    scenario = claiming(BETTER, seeds=SEEDS)
    spread = {0: 0.0030, 1: 0.0046, 2: 0.0038, 3: 0.0060, 4: 0.0042, 5: 0.0050}

    def nominal(friction, seed):
        return {0.1: 0.5, 0.2: 1.0, 0.4: 2.0}[friction] * spread[seed]

    findings = judge_claims(scenario, payload(scenario, nominal))
    assert verdicts(findings) == ["claim_failed", "claim_open", "claim_held"]
    for finding, factor in zip(findings, (0.5, 1.0, 2.0), strict=True):
        expected = mean_ratio([factor * error for error in spread.values()], [0.002] * 6)
        assert finding.current == pytest.approx(expected.value)
        assert finding.interval == pytest.approx(expected.interval)
        assert finding.seed is None
        assert set(finding.varied) == {"slip.yaw"}
        assert "over 6 seeds" in finding.note
    assert not findings[1].verdict.failed
    assert not findings[1].verdict.judged


@given(st.randoms(), st.lists(st.floats(1e-4, 1e-1), min_size=6, max_size=6))
def test_the_order_of_seeds_and_of_runs_means_nothing(order, errors):
    scenario = claiming(
        BETTER, {"kind": "below", "controller": "nominal_kinematic", "limit": 0.01}, seeds=SEEDS
    )
    result = payload(scenario, lambda _, seed: errors[seed])
    mixed = copy.deepcopy(result)
    order.shuffle(mixed["runs"])
    permuted = payload(scenario, lambda _, seed: errors[5 - seed])

    def told(findings: list[Finding]) -> set[tuple]:
        return {(f.claim, str(f.varied), f.metric, f.current, f.interval, str(f.verdict)) for f in findings}

    assert told(judge_claims(scenario, mixed)) == told(judge_claims(scenario, result))
    assert told(judge_claims(scenario, permuted)) == told(judge_claims(scenario, result))


def test_pairing_is_by_world_and_seed():
    scenario = claiming(BETTER, seeds=SEEDS)
    hard = payload(scenario, lambda friction, seed: 0.0044 * 10.0**seed * friction)
    for entry in hard["runs"]:
        if entry["controller"] == "robust":
            entry["metrics"]["rms_position_error"] = (
                0.002 * 10.0 ** entry["seed"] * entry["varied"]["slip.yaw"]
            )
    random.Random(1).shuffle(hard["runs"])
    for finding in judge_claims(scenario, hard):
        assert finding.interval == pytest.approx((2.2, 2.2))
        assert finding.verdict is Verdict.CLAIM_HELD


def test_worlds_are_told_apart_by_their_seed_also_where_it_is_not_swept():
    runs = [run("robust", {"slip.yaw": 0.1}, seed, 0.002) for seed in (1, 2)]
    assert [(world.seed, len(world.runs)) for world in worlds(runs)] == [(1, 1), (2, 1)]
    assert [len(group) for group in groups(worlds(runs))] == [2]


def test_where_restricts_the_worlds():
    scenario = claiming(
        {**BETTER, "where": {"slip.yaw": {"from": 0.2}}},
        {"kind": "status", "where": {"slip.yaw": [0.1, 0.4]}},
    )
    findings = judge_claims(scenario, payload(scenario))
    assert [f.varied["slip.yaw"] for f in findings if f.metric != "status"] == [0.2, 0.4]
    assert [f.varied["slip.yaw"] for f in findings if f.metric == "status"] == [0.1, 0.1, 0.4, 0.4]


def test_only_where_guaranteed_leaves_out_worlds_and_says_so():
    scenario = claiming({**BETTER, "only_where_guaranteed": True})

    def broken(entry):
        entry["metrics"]["guarantee_fraction"] = 0.999

    spoilt = payload(
        scenario, lambda friction, _: 0.0 if friction == 0.1 else 0.008, robust_only(broken, 0.1)
    )
    findings = judge_claims(scenario, spoilt)
    assert verdicts(findings) == ["claim_held", "claim_held"]
    assert all("2 of 3 worlds" in finding.note for finding in findings)
    lost = payload(scenario, lambda friction, _: 0.0 if friction == 0.2 else 0.008, robust_only(broken, 0.1))
    assert verdicts(judge_claims(scenario, lost)) == ["claim_failed", "claim_held"]
    nowhere = only(scenario, payload(scenario, change=robust_only(broken)))
    assert nowhere.verdict is Verdict.CLAIM_OPEN
    assert "none of these worlds" in nowhere.note


def test_below_is_judged_by_the_mean():
    scenario = claiming(
        {"kind": "below", "controller": "robust", "limit": 0.002, "metric": "max_position_error"}
    )
    held = judge_claims(scenario, payload(scenario))
    assert verdicts(held) == ["claim_held"] * 3
    assert {(f.metric, f.baseline, f.current, f.unit) for f in held} == {
        ("max_position_error", 0.002, 0.002, "m")
    }
    seeded = claiming({"kind": "below", "controller": "nominal_kinematic", "limit": 0.003}, seeds=SEEDS)
    findings = judge_claims(seeded, payload(seeded, lambda friction, seed: friction * (0.01 + 0.002 * seed)))
    assert verdicts(findings) == ["claim_held", "claim_open", "claim_failed"]  # means of 1.5, 3 and 6 mm


def test_every_world_must_keep_to_its_guarantee():
    scenario = claiming({"kind": "guarantee", "controller": "robust"}, seeds=SEEDS)
    assert verdicts(judge_claims(scenario, payload(scenario))) == ["claim_held"] * 3

    def once(entry):
        entry["metrics"]["guarantee_fraction"] = 0.9995
        entry["guarantee"]["first_violation"] = "slip_bounded"

    findings = judge_claims(scenario, payload(scenario, change=robust_only(once, 0.2, 4)))
    assert verdicts(findings) == ["claim_held", "claim_failed", "claim_held"]
    assert (findings[1].current, findings[1].seed) == (0.9995, 4)
    assert "slip_bounded" in findings[1].note
    looser = claiming({"kind": "guarantee", "controller": "robust", "fraction": 0.999}, seeds=SEEDS)
    assert (
        verdicts(judge_claims(looser, payload(looser, change=robust_only(once, 0.2, 4))))
        == ["claim_held"] * 3
    )


def test_the_bound_is_held_against_the_settled_error_where_there_is_one():
    scenario = claiming({"kind": "below_bound", "controller": "robust"}, seeds=SEEDS)

    def beyond(entry):
        entry["guarantee"]["settled_error"] = 0.0101

    def none(entry):
        entry["guarantee"]["error_bound"] = None

    findings = judge_claims(scenario, payload(scenario, change=robust_only(beyond, 0.4, 2)))
    assert verdicts(findings) == ["claim_held", "claim_held", "claim_failed"]
    assert (findings[0].baseline, findings[0].current, findings[0].unit) == (0.01, 0.001, "m")
    assert (findings[2].current, findings[2].seed) == (0.0101, 2)
    assert "101 % of the bound" in findings[2].note
    some = judge_claims(scenario, payload(scenario, change=robust_only(none, 0.1)))
    assert [finding.varied["slip.yaw"] for finding in some] == [0.2, 0.4]
    assert all("12 of 18 worlds" in finding.note for finding in some)
    nothing = only(scenario, payload(scenario, change=robust_only(none)))
    assert nothing.verdict is Verdict.CLAIM_OPEN
    assert "promises no bound" in nothing.note


def test_a_status_is_claimed_of_one_law_or_of_all():
    def tips(entry):
        entry["status"] = "tipped"

    scenario = claiming({"kind": "status"}, seeds=SEEDS)
    findings = judge_claims(scenario, payload(scenario, change=robust_only(tips, 0.2, 5)))
    assert [(f.controller, str(f.verdict)) for f in findings if f.varied["slip.yaw"] == 0.2] == [
        ("nominal_kinematic", "claim_held"),
        ("robust", "claim_failed"),
    ]
    assert verdicts(findings).count("claim_failed") == 1
    assert {finding.seed for finding in findings if not finding.verdict.failed} == {None}
    failed = next(finding for finding in findings if finding.verdict.failed)
    assert (failed.metric, failed.baseline, failed.current, failed.seed) == (
        "status",
        "completed",
        "tipped",
        5,
    )
    other = claiming({"kind": "status", "controller": "robust", "status": "tipped"})
    assert verdicts(judge_claims(other, payload(other, change=robust_only(tips)))) == ["claim_held"] * 3


@pytest.mark.parametrize(
    "claim",
    [
        BETTER,
        {**BETTER, "controller": "nominal_kinematic", "than": "robust", "factor": 1.0},
        {"kind": "below", "controller": "robust", "limit": 1.0},
        {"kind": "guarantee", "controller": "robust"},
        {"kind": "below_bound", "controller": "robust"},
    ],
)
def test_a_run_that_ended_early_fails_what_is_claimed_of_it(claim):
    scenario = claiming(claim)

    def tips(entry):
        entry["status"] = "tipped"
        entry["guarantee"]["error_bound"] = None

    findings = judge_claims(scenario, payload(scenario, lambda *_: 0.002, robust_only(tips, 0.2)))
    here = [finding for finding in findings if finding.varied["slip.yaw"] == 0.2]
    assert verdicts(here) == ["claim_failed"]
    assert "robust ended early: tipped" in here[0].note


@pytest.mark.parametrize("claim", [BETTER, {"kind": "below", "controller": "robust", "limit": 1.0}])
def test_a_number_that_is_not_finite_fails_what_is_claimed_of_it(claim):
    scenario = claiming({**claim, "where": {"slip.yaw": 0.1}})

    def breaks(entry):
        entry["metrics"]["rms_position_error"] = None

    finding = only(scenario, payload(scenario, change=robust_only(breaks, 0.1)))
    assert (finding.verdict, finding.current) == (Verdict.CLAIM_FAILED, None)
    assert "no rms_position_error" in finding.note


HELD, FAILED = Verdict.CLAIM_HELD, Verdict.CLAIM_FAILED
BELOW = {"kind": "below", "controller": "robust", "limit": 0.5}
GUARANTEE = {"kind": "guarantee", "controller": "robust"}
BOUND = {"kind": "below_bound", "controller": "robust"}
STATUS = {"kind": "status", "controller": "robust"}
RMS = "rms_position_error"
TIPPED = "robust ended early: tipped (seed 4)"


def spoilt(entry):
    entry["metrics"] |= {RMS: None, "guarantee_fraction": None}


def tipped(entry):
    entry["status"] = "tipped"


@pytest.mark.parametrize(
    ("claim", "change", "expected"),
    [
        (
            BETTER,
            None,
            (None, RMS, 2.0, 4.0, HELD, "nominal_kinematic / robust, at least, over 6 seeds", 4.0, "1"),
        ),
        (BETTER, spoilt, (None, RMS, 2.0, None, FAILED, f"robust has no {RMS} (seed 4)", None, "1")),
        (BETTER, tipped, (None, RMS, 2.0, None, FAILED, TIPPED, None, "1")),
        (BELOW, None, (None, RMS, 0.5, 0.002, HELD, "at most, over 6 seeds", 0.002, "m")),
        (BELOW, spoilt, (None, RMS, 0.5, None, FAILED, f"robust has no {RMS} (seed 4)", None, "m")),
        (BELOW, tipped, (None, RMS, 0.5, None, FAILED, TIPPED, None, "m")),
        (GUARANTEE, None, (0, "guarantee_fraction", 1.0, 1.0, HELD, "", None, "1")),
        (
            GUARANTEE,
            spoilt,
            (
                None,
                "guarantee_fraction",
                1.0,
                None,
                FAILED,
                "robust has no guarantee_fraction (seed 4)",
                None,
                "1",
            ),
        ),
        (GUARANTEE, tipped, (None, "guarantee_fraction", 1.0, None, FAILED, TIPPED, None, "1")),
        (
            BOUND,
            None,
            (0, "settled_error", 0.01, 0.001, HELD, "10 % of the bound, the most of all seeds", None, "m"),
        ),
        (BOUND, tipped, (4, "settled_error", 0.01, 0.001, FAILED, TIPPED, None, "m")),
        (STATUS, None, (None, "status", "completed", "completed", HELD, "", None, None)),
        (STATUS, tipped, (4, "status", "completed", "tipped", FAILED, "", None, None)),
    ],
)
def test_a_finding_says_what_was_required_measured_and_found(claim, change, expected):
    scenario = claiming({**claim, "where": {"slip.yaw": 0.2}}, seeds=SEEDS)
    finding = only(scenario, payload(scenario, change=change and robust_only(change, 0.2, 4)))
    seed, metric, required, measured, verdict, note, ends, unit = expected
    assert (finding.scenario, finding.controller, finding.varied) == ("paper", "robust", {"slip.yaw": 0.2})
    assert (finding.seed, finding.metric, finding.baseline, finding.tolerance) == (
        seed,
        metric,
        required,
        None,
    )
    assert finding.current == (pytest.approx(measured) if isinstance(measured, float) else measured)
    assert (finding.verdict, finding.note, finding.unit) == (verdict, note, unit)
    assert finding.interval == (None if ends is None else pytest.approx((ends, ends)))
    assert finding.claim == str(scenario.expect[0])


@pytest.mark.parametrize(
    ("bound", "error", "verdict", "share"),
    [
        (0.01, 0.01, HELD, "100 %"),
        (0.01, 0.0, HELD, "0 %"),
        (0.0, 0.0, HELD, "0 %"),
        (0.0, 1e-9, FAILED, "inf %"),
        (0.01, None, FAILED, "inf %"),
        (2.0, 1.0, HELD, "50 %"),
        (0.5, 1.0, FAILED, "200 %"),
    ],
)
def test_a_settled_error_is_a_share_of_the_bound(bound, error, verdict, share):
    scenario = claiming({**BOUND, "where": {"slip.yaw": 0.2}})

    def told(entry):
        entry["guarantee"] |= {"error_bound": bound, "settled_error": error}

    finding = only(scenario, payload(scenario, change=robust_only(told)))
    assert (finding.verdict, finding.note) == (verdict, f"{share} of the bound")


def test_an_open_claim_says_why():
    claims = [
        {**BETTER, "only_where_guaranteed": True},
        BOUND,
        {**STATUS, "where": {"slip.yaw": 0.4}},
        {"kind": "status", "where": {"slip.yaw": 0.4}},
    ]
    scenario = claiming(*claims)

    def promise_nothing(entry):
        entry["metrics"]["guarantee_fraction"] = 0.5
        entry["guarantee"]["error_bound"] = None

    result = payload(scenario, change=robust_only(promise_nothing))
    some = [entry for entry in result["runs"] if entry["varied"]["slip.yaw"] < 0.4]
    found = judge_claims(scenario, {**result, "runs": some})
    assert [(finding.controller, finding.note) for finding in found] == [
        ("robust", "the guarantee of robust holds throughout in none of these worlds"),
        ("robust", "the theorem promises no bound in any of these worlds"),
        ("robust", "no such world was run"),
        (None, "no such world was run"),
    ]
    for finding, claim in zip(found, scenario.expect, strict=True):
        assert finding == Finding(
            "paper", finding.controller, {}, None, None, None, None, None, Verdict.CLAIM_OPEN,
            finding.note, str(claim),
        )  # fmt: skip
    nobody = only(claiming(BETTER), {"scenario": "paper", "runs": []})
    assert nobody.note == "no run of robust and nominal_kinematic"


def test_a_benefit_that_cannot_be_told_leaves_its_price_to_be_told():
    price = {**BETTER, "where": {"slip.yaw": 0.2}, "command_variation_factor": 3.0}
    scenario = claiming(price)
    findings = judge_claims(scenario, payload(scenario, change=robust_only(spoilt)))
    assert [(finding.metric, finding.verdict) for finding in findings] == [
        (RMS, FAILED),
        ("command_variation", HELD),
    ]


def test_a_world_alone_keeps_its_seed():
    scenario = claiming({**BETTER, "where": {"slip.yaw": 0.2}}, seeds=SEEDS)
    result = payload(scenario)
    alone = [entry for entry in result["runs"] if entry["seed"] == 4]
    finding = only(scenario, {**result, "runs": alone})
    assert (finding.varied, finding.seed, finding.interval) == ({"slip.yaw": 0.2, "seed": 4}, 4, None)
    assert finding.note == "nominal_kinematic / robust, at least"


def test_two_seeds_are_seeds():
    scenario = claiming(
        {**BETTER, "where": {"slip.yaw": 0.2}}, {**BOUND, "where": {"slip.yaw": 0.2}}, seeds=SEEDS
    )
    result = payload(scenario)
    better, bound = judge_claims(scenario, {**result, "runs": [e for e in result["runs"] if e["seed"] < 2]})
    assert better.note == "nominal_kinematic / robust, at least, over 2 seeds"
    assert bound.note == "10 % of the bound, the most of all seeds"


def test_what_was_said_and_what_was_left_out_are_joined():
    scenario = claiming({**BETTER, "only_where_guaranteed": True}, seeds=SEEDS)
    findings = judge_claims(scenario, payload(scenario, change=robust_only(spoilt, 0.1)))
    assert {finding.note for finding in findings} == {
        "nominal_kinematic / robust, at least, over 6 seeds; judged on 12 of 18 worlds"
    }


@pytest.mark.parametrize("claim", [BELOW, GUARANTEE, BOUND, STATUS])
def test_a_law_that_was_not_run_is_named(claim):
    scenario = claiming(claim)
    result = payload(scenario)
    others = [entry for entry in result["runs"] if entry["controller"] != "robust"]
    finding = only(scenario, {**result, "runs": others})
    assert (finding.verdict, finding.note) == (Verdict.CLAIM_OPEN, "no run of robust")


@pytest.mark.parametrize("limit", [1e-6, 1.0, 1e6])
def test_slack_is_relative_to_the_limit(limit):
    scenario = claiming({**BELOW, "limit": limit, "where": {"slip.yaw": 0.2}})

    def found(share):
        def errs(entry):
            entry["metrics"][RMS] = share * limit

        return only(scenario, payload(scenario, change=robust_only(errs))).verdict

    assert [found(1.0 + share) for share in (-1e-6, 0.0, 0.5e-9, 2e-9, 1e-6)] == [HELD] * 3 + [FAILED] * 2


def test_an_interval_that_ends_at_the_limit_from_the_wrong_side_is_open():
    """Slack helps a claim to hold, and to stay open; it never makes one fail."""
    scenario = claiming({**BELOW, "limit": 1.0, "where": {"slip.yaw": 0.2}}, seeds=SEEDS)

    def found(low):
        def errs(entry):
            entry["metrics"][RMS] = low if entry["seed"] == 0 else 2.0

        some = payload(scenario, change=robust_only(errs))
        pair = [entry for entry in some["runs"] if entry["seed"] < 2]
        return only(scenario, {**some, "runs": pair}).verdict

    assert [found(low) for low in (0.9, 1.0, 1.0 + 0.5e-9, 1.0 + 2e-9)] == [Verdict.CLAIM_OPEN] * 3 + [FAILED]


def test_the_price_of_a_benefit_is_said_the_other_way_round():
    scenario = claiming({**BETTER, "where": {"slip.yaw": 0.2}, "command_variation_factor": 2.5}, seeds=SEEDS)
    _, price = judge_claims(scenario, payload(scenario))
    assert price.note == "robust / nominal_kinematic, at most, over 6 seeds"
    assert price.interval == pytest.approx((3.0, 3.0))
    assert (price.controller, price.unit, price.seed) == ("robust", "1", None)


def test_a_claim_about_runs_that_there_are_not_is_open():
    scenario = claiming(BETTER, {"kind": "status"})
    result = payload(scenario)
    result["runs"] = [entry for entry in result["runs"] if entry["controller"] != "robust"]
    better, *statuses = judge_claims(scenario, result)
    assert better.verdict is Verdict.CLAIM_OPEN
    assert better.note == "no run of robust"
    assert verdicts(statuses) == ["claim_held"] * 3
    assert verdicts(judge_claims(scenario, {**result, "runs": []})) == ["claim_open", "claim_open"]


def test_without_claims_there_is_nothing_to_judge():
    scenario = claiming()
    assert judge_claims(scenario, payload(scenario)) == []


def test_findings_of_claims_go_into_json():
    scenario = claiming(BETTER, seeds=SEEDS)
    entry = judge_claims(scenario, payload(scenario))[0].json()
    assert entry["claim"] == str(scenario.expect[0])
    assert entry["interval"] == pytest.approx([4.0, 4.0])
    assert entry["verdict"] == "claim_held"


def test_a_benefit_that_disappears_fails_on_real_runs():
    tables = dump(load("paper-kinematic"))
    tables |= {"tick": 0.01, "expect": [{**BETTER, "controller": "robust_kinematic", "factor": 10.0}]}
    scenario = read(tables)
    held = only(scenario, experiment.run(scenario, out=None, record="none", threads=1).json())
    assert held.verdict is Verdict.CLAIM_HELD
    # without the robust term's bound on the slip the robust law is the nominal one
    tables["controller"][1]["slip_bound"] = 0.0
    scenario = read(tables)
    lost = only(scenario, experiment.run(scenario, out=None, record="none", threads=1).json())
    assert lost.verdict is Verdict.CLAIM_FAILED
    assert lost.current == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize(("slip_bound", "verdict"), [(0.4, Verdict.CLAIM_HELD), (0.0, Verdict.CLAIM_FAILED)])
def test_claims_are_judged_without_a_baseline_too(tmp_path, slip_bound, verdict):
    path = tmp_path / "mine.toml"
    text = shipped.scenario_path("paper-kinematic").read_text(encoding="utf-8")
    text = text.partition("\n# Claims")[0].replace("tick = 0.001", "tick = 0.01")
    text = text.replace("slip_bound = 0.4", f"slip_bound = {slip_bound}").replace("paper-kinematic", "mine")
    laws = 'controller = "robust_kinematic"\nthan = "nominal_kinematic"'
    claim = f'[[expect]]\nkind = "better"\n{laws}\nfactor = 5.0\n'
    path.write_text(f"{text}\n{claim}", encoding="utf-8")
    report = check(str(path))
    assert [finding.verdict for finding in report.findings] == [Verdict.UNJUDGED, verdict]
    assert not report.judged
    assert report.failed == (verdict is Verdict.CLAIM_FAILED)
    # without claims there is nothing to run for
    path.write_text(text, encoding="utf-8")
    assert [finding.verdict for finding in check(str(path)).findings] == [Verdict.UNJUDGED]
