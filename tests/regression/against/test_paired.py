"""Mean differences over worlds: closed forms, and no verdict that no run supports."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipctl.regression import Finding, Verdict
from slipctl.regression.against.paired import paired_differences

METRIC = "rms_position_error"


def change(finding):
    entry = finding.json()
    return entry["current"] - entry["baseline"]


def number(before, after, tolerance=1e-4, controller="a", metric=METRIC, verdict=Verdict.SAME):
    return Finding("ice", controller, {"seed": 1}, 1, metric, before, after, tolerance, verdict, unit="m")


def test_a_constant_shift_is_the_difference_and_its_whole_interval():
    befores = [0.010, 0.020, 0.035, 0.050, 0.055, 0.070]
    (mean,) = paired_differences([number(before, before + 0.003) for before in befores])
    assert mean.interval == pytest.approx((0.003, 0.003), rel=1e-9)
    assert mean.baseline == pytest.approx(0.04, rel=1e-12)
    assert mean.current == pytest.approx(0.043, rel=1e-12)
    assert mean.tolerance == pytest.approx(1e-4, rel=1e-12)
    assert mean.verdict is Verdict.WORSE
    assert (mean.scenario, mean.controller) == ("ice", "a")
    assert (mean.varied, mean.seed, mean.metric) == ({}, None, METRIC)
    assert mean.unit == "m"
    assert mean.note.startswith("mean of 6 runs")


@pytest.mark.parametrize(
    ("metric", "shift", "verdict"),
    [
        (METRIC, 2e-4, Verdict.WORSE),
        (METRIC, 0.5e-4, Verdict.SAME),
        (METRIC, -0.5e-4, Verdict.SAME),
        (METRIC, -2e-4, Verdict.BETTER),
        ("guarantee_fraction", 2e-4, Verdict.BETTER),
        ("guarantee_fraction", -2e-4, Verdict.WORSE),
    ],
)
def test_which_way_is_worse_and_from_where_on(metric, shift, verdict):
    pairs = [number(value, value + shift, metric=metric) for value in (0.25, 0.5)]
    assert paired_differences(pairs)[0].verdict is verdict


def test_nothing_is_a_number_too():
    (mean,) = paired_differences([number(0.0, 0.0, 0.0), number(0.0, 0.0, 0.0)])
    assert (mean.baseline, mean.current, mean.tolerance, mean.interval) == (0.0, 0.0, 0.0, (0.0, 0.0))


@pytest.mark.parametrize("shift", [-0.25, 0.25])
def test_a_mean_just_at_its_tolerance_is_the_same(shift):
    pairs = [number(value, value + shift, 0.25) for value in (1.0, 2.0)]
    assert paired_differences(pairs)[0].verdict is Verdict.SAME


def test_worse_in_one_world_and_better_in_another_is_no_mean_verdict():
    (mean,) = paired_differences([number(0.01, 0.02), number(0.02, 0.01)])
    assert mean.verdict is Verdict.SAME
    assert mean.interval == pytest.approx((-0.01, 0.01))


def test_controllers_and_metrics_are_kept_apart():
    findings = [
        number(0.01, 0.01 + shift, controller=controller, metric=metric)
        for controller, metric, shift in [
            ("a", METRIC, 0.1),
            ("b", METRIC, 0.2),
            ("a", "max_position_error", 0.3),
        ]
        for _ in range(2)
    ]
    means = {(mean.controller, mean.metric): change(mean) for mean in paired_differences(findings)}
    expected = {("a", METRIC): 0.1, ("b", METRIC): 0.2, ("a", "max_position_error"): 0.3}
    assert means == pytest.approx(expected)


def test_one_run_has_no_mean():
    assert paired_differences([number(0.01, 0.02)]) == []


@pytest.mark.parametrize(
    "odd",
    [
        number(None, 0.01),
        number(0.01, None),
        number(0.01, 5.0, verdict=Verdict.CHAOTIC),
        Finding("ice", "a", {}, 1, "status", "completed", "completed", None, Verdict.SAME),
        Finding("ice", "a", {}, 1, None, None, None, None, Verdict.MISSING),
    ],
)
def test_what_is_no_number_or_chaotic_is_left_out(odd):
    (mean,) = paired_differences([number(0.01, 0.01), odd, number(0.03, 0.03)])
    assert mean.note.startswith("mean of 2 runs")
    assert mean.current == pytest.approx(0.02)


values = st.floats(0.0, 10.0)


@given(st.lists(st.tuples(values, st.floats(-1.0, 1.0), st.floats(1e-6, 1.0)), min_size=2, max_size=12))
def test_a_mean_is_never_worse_where_no_run_is(drawn):
    findings = [number(before, before + share * 0.99 * tol, tol) for before, share, tol in drawn]
    (mean,) = paired_differences(findings)
    assert mean.verdict is Verdict.SAME
    low, high = mean.json()["interval"]
    difference = math.fsum(map(change, findings)) / len(findings)
    assert low - 1e-12 <= difference <= high + 1e-12


@given(st.lists(st.tuples(values, values), min_size=2, max_size=12), st.randoms())
def test_the_order_of_the_runs_does_not_matter(drawn, random):
    findings = [number(before, after) for before, after in drawn]
    turned = list(findings)
    random.shuffle(turned)
    assert paired_differences(findings) == paired_differences(turned)
