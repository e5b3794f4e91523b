"""Every verdict, from numbers alone."""

import pytest

from slipctl.regression import Number, Verdict, judge
from slipctl.regression.baseline import GATED
from slipctl.regression.judge import judge_number
from tests.fakes import baseline_of, payload, run_entry


def test_the_same_result_is_the_same_everywhere():
    content = payload([run_entry("a"), run_entry("b", 0.1)])
    findings = judge(baseline_of(content), content)
    assert [finding.verdict for finding in findings] == [Verdict.SAME] * 6
    assert {finding.metric for finding in findings} == set(GATED)


@pytest.mark.parametrize(
    ("value", "verdict"),
    [
        (0.01009, Verdict.SAME), (0.01011, Verdict.WORSE), (0.00991, Verdict.SAME), (0.00989, Verdict.BETTER),
        (None, Verdict.WORSE),
    ],
)  # fmt: skip
def test_a_number_is_judged_by_its_tolerance(value, verdict):
    assert judge_number(Number(value=0.01, tolerance=1e-4, why=""), value) is verdict


@pytest.mark.parametrize(
    ("value", "verdict"),
    [
        (0.31, Verdict.BETTER),
        (0.34, Verdict.SAME),
        (4.9, Verdict.SAME),
        (5.1, Verdict.WORSE),
        (None, Verdict.WORSE),
    ],
)
def test_a_chaotic_number_is_judged_by_its_order_of_magnitude(value, verdict):
    assert judge_number(Number(value=1.0, tolerance=4.0, why="", chaotic=True), value) is verdict


def test_a_value_that_was_never_finite_may_stay_so_or_get_better():
    number = Number(value=None, tolerance=0.0, why="")
    assert judge_number(number, None) is Verdict.SAME
    assert judge_number(number, 0.1) is Verdict.BETTER


def test_runs_are_told_apart_by_controller_world_and_seed():
    before = payload(
        [run_entry("a", 0.1), run_entry("a", 0.8), run_entry("b", 0.1), run_entry("a", 0.1, seed=2)]
    )
    after = payload([*before["runs"][:3], run_entry("a", 0.1, rms=0.5, seed=2)])
    worse = [finding for finding in judge(baseline_of(before), after) if finding.verdict is Verdict.WORSE]
    assert {(f.controller, f.varied["ground.friction"], f.seed) for f in worse} == {("a", 0.1, 2)}
    assert len(worse) == 3


def test_the_order_of_the_runs_does_not_matter():
    content = payload([run_entry("a"), run_entry("b")])
    turned = payload(content["runs"][::-1])
    assert all(finding.verdict is Verdict.SAME for finding in judge(baseline_of(content), turned))


@pytest.mark.parametrize("status", ["diverged", "tipped", "left_the_arena"])
def test_any_other_status_fails_even_with_better_numbers(status):
    before, after = payload([run_entry("a", rms=0.5)]), payload([run_entry("a", rms=0.1, status=status)])
    (finding,) = judge(baseline_of(before), after)
    assert (finding.metric, finding.baseline, finding.current) == ("status", "completed", status)
    assert finding.verdict.failed
    (back,) = judge(baseline_of(after), before)
    assert back.verdict is Verdict.STATUS_CHANGED


def test_a_status_that_a_nudged_start_gave_is_accepted():
    before, after = payload([run_entry("a")]), payload([run_entry("a", status="tipped")])
    baseline = baseline_of(before)
    run = baseline.runs[0].model_copy(update={"nudged_statuses": ["tipped"]})
    findings = judge(baseline.model_copy(update={"runs": [run]}), after)
    assert all(finding.verdict is Verdict.SAME for finding in findings)


def test_runs_on_one_side_only_cannot_be_judged():
    before, after = payload([run_entry("a"), run_entry("b")]), payload([run_entry("a"), run_entry("c")])
    odd = {f.controller: f.verdict for f in judge(baseline_of(before), after) if not f.verdict.judged}
    assert odd == {"b": Verdict.MISSING, "c": Verdict.EXTRA}


def test_a_finding_has_the_keys_of_the_contract():
    content = payload([run_entry("a")])
    entry = judge(baseline_of(content), content)[0].json()
    assert entry.keys() >= {
        "scenario",
        "controller",
        "varied",
        "metric",
        "baseline",
        "current",
        "tolerance",
        "verdict",
    }
    assert entry["verdict"] == "same"
