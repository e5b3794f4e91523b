"""Every verdict, from numbers alone."""

import json
import math
from typing import Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipctl.metrics import UNITS
from slipctl.regression import Finding, Number, Verdict, judge
from slipctl.regression.baseline.gated import GATED, LARGER_IS_BETTER
from slipctl.regression.judging.findings import judge_number, unjudged
from tests.fakes import baseline_of, payload, run_entry

MOVED_WITH_RMS = {"rms_position_error", "max_position_error", "final_position_error", "rms_cross_track_error"}
"""What `run_entry` makes from the RMS that it is told."""

ERROR = "rms_position_error"


def number(value, tolerance=1e-4, gate: Literal["number", "verdict"] = "number"):
    return Number(value=value, tolerance=tolerance, tolerance_elsewhere=tolerance, gate=gate, why="")


def verdict(recorded, value, tolerance=1e-4, metric=ERROR, gate: Literal["number", "verdict"] = "number"):
    return judge_number(metric, number(recorded, tolerance, gate), value, tolerance)


def test_the_same_result_is_the_same_everywhere():
    content = payload([run_entry("a"), run_entry("b", 0.1)])
    findings = judge(baseline_of(content), content)
    assert {finding.verdict for finding in findings} == {Verdict.SAME}
    assert {finding.note for finding in findings} == {""}
    assert {finding.scenario for finding in findings} == {content["scenario"]}
    assert [(f.controller, f.metric) for f in findings] == [
        (name, metric) for name in "ab" for metric in ("status", *GATED)
    ]


def test_each_number_is_said_in_its_unit():
    content = payload([run_entry("a")])
    status, *numbers = judge(baseline_of(content), content)
    assert status.unit is None
    assert {finding.metric: finding.unit for finding in numbers} == {name: UNITS[name] for name in GATED}


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (0.01009, Verdict.SAME), (0.01011, Verdict.WORSE), (0.00991, Verdict.SAME), (0.00989, Verdict.BETTER),
        (None, Verdict.WORSE),
    ],
)  # fmt: skip
def test_a_number_is_judged_by_its_tolerance(value, expected):
    assert verdict(0.01, value) is expected


@pytest.mark.parametrize(
    ("value", "expected"),
    [(0.89, Verdict.WORSE), (0.92, Verdict.SAME), (0.98, Verdict.SAME), (1.0, Verdict.BETTER)],
)
def test_of_the_guarantee_more_is_better(value, expected):
    assert verdict(0.95, value, 0.04, "guarantee_fraction") is expected


def test_a_finding_holds_both_numbers_and_each_metric_its_own_way():
    """All errors half as large, and the guarantee half as long: only that is worse."""
    before, after = run_entry("a", rms=0.02), run_entry("a", rms=0.01)
    after["metrics"] = {name: value / 2.0 for name, value in before["metrics"].items()}
    status, *numbers = judge(baseline_of(payload([before])), payload([after]))
    assert (status.baseline, status.current, status.tolerance) == ("completed", "completed", None)
    for finding in numbers:
        worse = finding.metric == "guarantee_fraction"
        assert finding.verdict is (Verdict.WORSE if worse else Verdict.BETTER)
        assert finding.baseline == before["metrics"][finding.metric]
        assert finding.current == after["metrics"][finding.metric]


@pytest.mark.parametrize("metric", [ERROR, "guarantee_fraction"])
@pytest.mark.parametrize("value", [-0.25, 0.25])
def test_a_number_just_at_its_tolerance_is_the_same(metric, value):
    assert verdict(0.0, value, 0.25, metric) is Verdict.SAME
    assert verdict(0.0, math.nextafter(value, 2.0 * value), 0.25, metric) is not Verdict.SAME


FINITE = st.floats(min_value=-1e6, max_value=1e6)
SIZE = st.floats(min_value=0.0, max_value=1e3)
MIRRORED = {Verdict.WORSE: Verdict.BETTER, Verdict.BETTER: Verdict.WORSE, Verdict.SAME: Verdict.SAME}


@given(FINITE, FINITE, SIZE, st.sampled_from(GATED))
def test_worse_one_way_is_better_the_other_way(before, after, tolerance, metric):
    forth, back = (
        verdict(one, other, tolerance, metric) for one, other in ((before, after), (after, before))
    )
    assert back is MIRRORED[forth]


@given(FINITE, FINITE, SIZE)
def test_an_error_is_worse_exactly_where_a_share_is_better(before, after, tolerance):
    error, share = (verdict(before, after, tolerance, name) for name in (ERROR, "guarantee_fraction"))
    assert share is MIRRORED[error]
    assert "guarantee_fraction" in LARGER_IS_BETTER


@given(FINITE, FINITE, SIZE, SIZE)
def test_a_wider_tolerance_never_turns_the_same_into_something_else(before, after, tolerance, wider):
    if verdict(before, after, tolerance) is Verdict.SAME:
        assert verdict(before, after, tolerance + wider) is Verdict.SAME


@given(FINITE, st.one_of(st.none(), FINITE), SIZE, st.sampled_from(GATED))
def test_a_chaotic_number_never_fails_and_is_always_judged(before, after, tolerance, metric):
    found = verdict(before, after, tolerance, metric, gate="verdict")
    assert found in (Verdict.SAME, Verdict.CHAOTIC)
    assert found.judged
    assert not found.failed
    assert (found is Verdict.SAME) == (verdict(before, after, tolerance, metric) is Verdict.SAME)


def test_a_chaotic_number_says_so():
    content = payload([run_entry("a")])
    baseline = baseline_of(content)
    chaotic = Number(
        value=0.001, tolerance=1e-5, tolerance_elsewhere=1e-5, spread=0.01, gate="verdict", why=""
    )
    metrics = baseline.runs[0].metrics | {ERROR: chaotic}
    run = baseline.runs[0].model_copy(update={"metrics": metrics})
    (finding,) = (
        f
        for f in judge(baseline.model_copy(update={"runs": [run]}), payload([run_entry("a", rms=0.5)]))
        if f.metric == ERROR
    )
    assert finding.verdict is Verdict.CHAOTIC
    assert finding.note == "chaotic: gated on its status and the scenario's claims only"


def test_a_value_that_was_never_finite_may_stay_so_or_get_better():
    assert verdict(None, None, 0.0) is Verdict.SAME
    assert verdict(None, 0.1, 0.0) is Verdict.BETTER


@pytest.mark.parametrize(("elsewhere", "expected"), [(False, Verdict.WORSE), (True, Verdict.SAME)])
def test_elsewhere_the_tolerance_for_elsewhere_counts(elsewhere, expected):
    before = payload([run_entry("a", rms=0.001)])
    after = payload([run_entry("a", rms=0.00115)])
    (finding,) = (f for f in judge(baseline_of(before), after, elsewhere) if f.metric == ERROR)
    assert finding.verdict is expected
    assert finding.tolerance == (2e-4 if elsewhere else 1e-4)


def test_runs_are_told_apart_by_controller_world_and_seed():
    before = payload(
        [run_entry("a", 0.1), run_entry("a", 0.8), run_entry("b", 0.1), run_entry("a", 0.1, seed=2)]
    )
    after = payload([*before["runs"][:3], run_entry("a", 0.1, rms=0.5, seed=2)])
    worse = [finding for finding in judge(baseline_of(before), after) if finding.verdict is Verdict.WORSE]
    assert {(f.controller, f.varied["ground.friction"], f.seed) for f in worse} == {("a", 0.1, 2)}
    assert {f.metric for f in worse} == MOVED_WITH_RMS


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


def test_a_status_that_a_run_beside_it_gave_is_said_and_fails_all_the_same():
    before, after = payload([run_entry("a")]), payload([run_entry("a", status="tipped")])
    baseline = baseline_of(before)
    run = baseline.runs[0].model_copy(update={"statuses_seen": ["tipped"]})
    (finding,) = judge(baseline.model_copy(update={"runs": [run]}), after)
    assert finding.verdict is Verdict.STATUS_CHANGED
    assert (finding.baseline, finding.current) == ("completed", "tipped")
    assert finding.note == "runs beside the recorded one ended so, too"


@pytest.mark.parametrize("gate", ["number", "verdict"])
@pytest.mark.parametrize("odd", [math.nan, math.inf, -math.inf])
def test_a_number_that_is_not_finite_is_never_the_same(odd, gate):
    unchecked = Number.model_construct(value=odd, tolerance=1.0, tolerance_elsewhere=1.0, gate=gate, why="")
    for metric in GATED:
        assert judge_number(metric, unchecked, 0.1, 1.0) is Verdict.UNJUDGED
        assert judge_number(metric, unchecked, odd, 1.0) is Verdict.UNJUDGED
        assert verdict(0.1, odd, 1.0, metric) is Verdict.WORSE


def test_a_guarantee_that_was_not_recorded_cannot_be_judged():
    before, after = payload([run_entry("a")]), payload([run_entry("a")])
    before["runs"][0]["metrics"]["guarantee_fraction"] = None
    (finding,) = (f for f in judge(baseline_of(before), after) if f.metric == "guarantee_fraction")
    assert finding.verdict is Verdict.UNJUDGED
    assert finding.note == "there is no number to compare with"
    (back,) = (f for f in judge(baseline_of(after), before) if f.metric == "guarantee_fraction")
    assert back.verdict is Verdict.WORSE


def test_runs_on_one_side_only_cannot_be_judged():
    before, after = payload([run_entry("a"), run_entry("b")]), payload([run_entry("a"), run_entry("c")])
    missing, extra = (finding for finding in judge(baseline_of(before), after) if not finding.verdict.judged)
    (_, gone), (_, new) = before["runs"], after["runs"]
    assert missing == Finding(
        before["scenario"], "b", gone["varied"], gone["seed"], None, None, None, None, Verdict.MISSING,
        "in the baseline, not in this run",
    )  # fmt: skip
    assert extra == Finding(
        after["scenario"], "c", new["varied"], new["seed"], None, None, None, None, Verdict.EXTRA,
        "not in the baseline",
    )  # fmt: skip


def test_a_scenario_as_a_whole_may_go_unjudged():
    finding = unjudged("ice", "no baseline")
    assert finding == Finding("ice", None, {}, None, None, None, None, None, Verdict.UNJUDGED, "no baseline")
    assert (finding.verdict.judged, finding.verdict.failed) == (False, False)


def test_every_verdict_is_sorted_into_failed_or_not_judged_or_neither():
    assert {v for v in Verdict if v.failed} == {
        Verdict.WORSE, Verdict.STATUS_CHANGED, Verdict.CLAIM_FAILED,
    }  # fmt: skip
    assert {v for v in Verdict if not v.judged} == {
        Verdict.MISSING, Verdict.EXTRA, Verdict.UNJUDGED, Verdict.CLAIM_OPEN,
    }  # fmt: skip


def test_a_finding_has_the_keys_of_the_contract():
    content = payload([run_entry("a")])
    entry = judge(baseline_of(content), content)[1].json()
    assert entry.keys() == {
        "scenario", "controller", "varied", "seed", "metric", "baseline", "current", "tolerance", "verdict",
        "note", "claim", "interval", "unit",
    }  # fmt: skip
    assert entry["verdict"] == "same"
    assert json.loads(json.dumps(entry)) == entry
    assert math.isclose(entry["tolerance"], 1e-4)
